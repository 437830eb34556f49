#include "common/timeline/recorder.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "common/base/check.h"
#include "common/scene/grid_blob.h"
#include "common/timeline/changing.h"
#include "common/timeline/deflate.h"

namespace enamel::timeline {
namespace {

constexpr int kOutlineSteps = 24;

int32_t Nanometres(double m) { return static_cast<int32_t>(std::lround(m * 1e9)); }

// By the distance alone, so that no shape has a rule of its own: the radius at which it is 0.
double RadiusAt_m(const cutting::Bur& bur, double z_m) {
  double inside = 0, outside = bur.radius_m * 1.01;
  for (int i = 0; i < 40; ++i) {
    const double middle = (inside + outside) / 2;
    (bur.Distance({middle, 0, z_m}) <= 0 ? inside : outside) = middle;
  }
  return inside;
}

std::vector<OutlinePoint> OutlineOf(const cutting::Bur& bur) {
  std::vector<OutlinePoint> out;
  const double height = bur.height_m();
  for (int i = 0; i <= kOutlineSteps; ++i) {
    // Denser at both ends, where round burs turn.
    const double s = static_cast<double>(i) / kOutlineSteps;
    const double z = height * s * s * (3 - 2 * s);
    out.push_back({Nanometres(z), Nanometres(RadiusAt_m(bur, z))});
  }
  if (bur.shank_radius_m > 0) {
    const double from = height + bur.neck_m, to = from + cutting::kShankLength_m;
    out.push_back({Nanometres(from), Nanometres(bur.shank_radius_m)});
    out.push_back({Nanometres(to), Nanometres(bur.shank_radius_m)});
  }
  return out;
}

FramePose PoseOf(const Recorder::Tick& tick) {
  FramePose out;
  const dvec3 axis = tick.bur.orientation.Matrix()[2];
  for (int i = 0; i < 3; ++i) {
    const auto n = static_cast<size_t>(i);
    out.tip_um[n] = static_cast<int32_t>(std::lround(tick.bur.tip_m[i] * 1e6));
    out.axis[n] = static_cast<int8_t>(std::lround(std::clamp(axis[i], -1.0, 1.0) * 127));
  }
  out.turning = tick.turning;
  out.bur = static_cast<uint8_t>(tick.which);
  return out;
}

Bytes PosesOf(const std::vector<FramePose>& poses) {
  Bytes out;
  std::vector<uint32_t> column(poses.size());
  for (size_t axis = 0; axis < 3; ++axis) {
    uint32_t before = 0;
    for (size_t i = 0; i < poses.size(); ++i) {
      const auto now = static_cast<uint32_t>(poses[i].tip_um[axis]);
      column[i] = scene::Zigzag(now - before);
      before = now;
    }
    scene::AppendPlanes(column, out);
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    for (const FramePose& pose : poses) out.push_back(static_cast<uint8_t>(pose.axis[axis]));
  }
  for (size_t i = 0; i < poses.size(); ++i) column[i] = poses[i].gap_ticks;
  scene::AppendPlanes(column, out);
  for (const FramePose& pose : poses) {
    out.push_back(static_cast<uint8_t>((pose.turning ? 1 : 0) | pose.bur << 1));
  }
  return out;
}

}  // namespace

Recorder::Recorder(const cutting::Volume& initial, const Sha256& start,
                   const RecorderOptions& options)
    : initial_(initial),
      detailed_(options.detailed),
      change_frames_(options.change_frames),
      slot_(static_cast<size_t>(initial.spec().brick_count()), -1),
      is_dirty_(slot_.size()) {
  head_.spec = initial.spec();
  head_.start = start;
  head_.rate_hz = options.rate_hz;
  head_.frame_ticks = options.frame_ticks;
  head_.segment_frames = options.segment_frames;
  last_segment_ = options.ticks == 0
                      ? 0
                      : static_cast<size_t>((options.ticks - 1) / (uint64_t{options.frame_ticks} *
                                                                   options.segment_frames));
  for (const cutting::Bur& bur : options.burs) head_.outlines.push_back(OutlineOf(bur));
  changed_in_.emplace_back();
}

int32_t Recorder::SlotOf(int32_t brick) {
  int32_t& slot = slot_[static_cast<size_t>(brick)];
  if (slot < 0) {
    slot = static_cast<int32_t>(states_.size());
    states_.push_back(QuantiseBrick(initial_, brick));
    versions_.emplace_back();
  }
  return slot;
}

Samples Recorder::StateAt(int32_t brick, size_t segment) const {
  const auto& versions = versions_[static_cast<size_t>(slot_[static_cast<size_t>(brick)])];
  const auto after = std::ranges::upper_bound(versions, segment, {}, &Version::segment);
  return after == versions.begin() ? QuantiseBrick(initial_, brick) : std::prev(after)->samples;
}

// In these segments, the last one left out.
std::vector<int32_t> Recorder::ChangedIn(size_t from, size_t to) const {
  std::vector<int32_t> out;
  for (size_t segment = from; segment < to; ++segment) {
    out.insert(out.end(), changed_in_[segment].begin(), changed_in_[segment].end());
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

void Recorder::Add(const cutting::Volume& volume, std::span<const int32_t> touched,
                   const Tick& tick) {
  for (int32_t brick : touched) {
    uint8_t& is_dirty = is_dirty_[static_cast<size_t>(brick)];
    if (is_dirty) continue;
    is_dirty = 1;
    dirty_.push_back(brick);
  }
  const uint32_t gaps = pose_.gap_ticks + tick.gap_ticks;
  ++head_.ticks;
  ++ticks_in_frame_;
  // Every tick's, as each may be the last.
  pose_ = PoseOf(tick);
  pose_.gap_ticks = gaps;
  if (ticks_in_frame_ == head_.frame_ticks) EndFrame(volume);
}

void Recorder::NoteChanges(int32_t brick, const Samples& before, const Samples& now) {
  const int coarse = CoarseIn(segments_.size());
  const auto found = read_.find(brick);
  Samples& state =
      found != read_.end()
          ? found->second
          : read_.emplace(brick, before == StateAt(brick, 0) ? before : Coarsened(before, coarse))
                .first->second;
  uint8_t layers = 0;
  ByteWriter rows;
  for (size_t z = 0; z < 8; ++z) {
    uint8_t row_mask = 0;
    ByteWriter bits;
    for (size_t y = 0; y < 8; ++y) {
      uint8_t mask = 0;
      for (size_t x = 0; x < 8; ++x) {
        const size_t i = z * 64 + y * 8 + x;
        if (now[i] >> coarse == state[i] >> coarse) continue;
        mask |= static_cast<uint8_t>(1u << x);
        state[i] = FromLevel(now[i] >> coarse, coarse);
        values_.U8(Residual(state[i], Predicted(state, i), coarse));
      }
      if (mask == 0) continue;
      row_mask |= static_cast<uint8_t>(1u << y);
      bits.U8(mask);
    }
    if (row_mask == 0) continue;
    layers |= static_cast<uint8_t>(1u << z);
    rows.U8(row_mask);
    rows.Raw(bits.bytes());
  }
  masks_.U8(layers);
  masks_.Raw(rows.bytes());
}

void Recorder::EndFrame(const cutting::Volume& volume) {
  poses_.push_back(pose_);
  pose_.gap_ticks = 0;
  ticks_in_frame_ = 0;
  ++unwritten_;
  const bool ends_segment = poses_.size() == head_.segment_frames;
  if (ends_segment || poses_.size() % change_frames_ == 0) WriteChanges(volume);
  if (ends_segment) EndSegment();
}

// Into the last of the frames that have none yet.
void Recorder::WriteChanges(const cutting::Volume& volume) {
  for (; unwritten_ > 1; --unwritten_) heads_.Varint(0);
  unwritten_ = 0;
  std::ranges::sort(dirty_);
  std::vector<std::pair<int32_t, Samples>> changed;
  for (int32_t brick : dirty_) {
    is_dirty_[static_cast<size_t>(brick)] = 0;
    const Samples now = QuantiseBrick(volume, brick);
    if (now != StateOf(brick)) changed.emplace_back(brick, now);
  }
  dirty_.clear();
  heads_.Varint(changed.size());
  std::vector<int32_t>& in_segment = changed_in_.back();
  int32_t before = -1;
  for (const auto& [brick, now] : changed) {
    heads_.Varint(static_cast<uint64_t>(brick - before - 1));
    before = brick;
    Samples& state = StateOf(brick);
    NoteChanges(brick, state, now);
    state = now;
    auto at = std::ranges::lower_bound(in_segment, brick);
    if (at == in_segment.end() || *at != brick) in_segment.insert(at, brick);
  }
}

void Recorder::EndSegment() {
  ByteWriter changes;
  changes.U32(static_cast<uint32_t>(heads_.size()));
  changes.U32(static_cast<uint32_t>(masks_.size()));
  changes.Raw(heads_.Take());
  changes.Raw(masks_.Take());
  changes.Raw(values_.Take());
  heads_ = masks_ = values_ = {};
  segments_.push_back({Deflate(PosesOf(poses_)), Deflate(changes.bytes())});
  Segment segment;
  segment.pose_bytes = static_cast<uint32_t>(segments_.back().poses.size());
  segment.change_bytes = static_cast<uint32_t>(segments_.back().changes.size());
  segment.change_size = static_cast<uint32_t>(changes.size());
  head_.segments.push_back(segment);
  poses_.clear();
  for (int32_t brick : changed_in_.back()) {
    const auto slot = static_cast<size_t>(SlotOf(brick));
    versions_[slot].push_back({segments_.size(), states_[slot]});
  }
  changed_in_.emplace_back();
  read_.clear();
}

// The last segment's is of all that was changed before; another one's only of what changes until the
// segment whose key it is read with (KeyParent).
Bytes Recorder::KeyOf(size_t segment) {
  const size_t last = segments_.size() - 1;
  const std::vector<int32_t> changed =
      segment == last ? ChangedIn(0, last) : ChangedIn(segment, KeyParent(segment, last));
  Segment& head = head_.segments[segment];
  const int coarse = CoarseIn(segment);
  ByteWriter numbers;
  Bytes residuals;
  for (int32_t brick : changed) {
    const Samples& state = StateAt(brick, segment);
    const bool as_at_start = state == StateAt(brick, 0);
    head.key_start += as_at_start;
    numbers.U32(static_cast<uint32_t>(brick) | (as_at_start ? kAsAtStart : 0));
    if (!as_at_start) AppendResiduals(Coarsened(state, coarse), residuals, coarse);
  }
  head.key_bricks = static_cast<uint32_t>(changed.size());
  Bytes raw = numbers.Take();
  raw.insert(raw.end(), residuals.begin(), residuals.end());
  return Deflate(raw);
}

Bytes Recorder::Finish(const cutting::Volume& volume, const KeepGoing& keep_going) {
  if (ticks_in_frame_ > 0) EndFrame(volume);
  if (unwritten_ > 0) WriteChanges(volume);
  if (!poses_.empty()) EndSegment();
  ENAMEL_CHECK(segments_.size() == last_segment_ + 1 || segments_.empty());
  const std::vector<int32_t> changed = ChangedIn(0, segments_.size());
  std::vector<uint8_t> changing(slot_.size());
  for (const std::vector<int32_t>* bricks : {&changed, &std::as_const(detailed_)}) {
    for (int32_t brick : *bricks) changing[static_cast<size_t>(brick)] = 1;
  }
  changing = WithNeighbours(changing, head_.spec.bricks);
  const cutting::Volume tooth = Quantised(volume);
  const PartMeshes meshes = MeshesOf(tooth, changing, keep_going);
  const Bytes parts[] = {EncodeMesh(meshes.end), EncodeMesh(meshes.still),
                         EncodeChanging(ChangingOf(initial_, changing))};
  head_.cut = CutBallOf(initial_, tooth, changed);
  head_.end_bytes = static_cast<uint32_t>(parts[0].size());
  head_.still_bytes = static_cast<uint32_t>(parts[1].size());
  head_.changing_bytes = static_cast<uint32_t>(parts[2].size());
  std::vector<Bytes> keys(segments_.size());
  for (size_t i = 0; i < keys.size(); ++i) {
    keys[i] = KeyOf(i);
    head_.segments[i].key_bytes = static_cast<uint32_t>(keys[i].size());
  }
  Bytes out = EncodeHead(head_);
  auto append = [&](const Bytes& part) { out.insert(out.end(), part.begin(), part.end()); };
  for (const Bytes& part : parts) append(part);
  // In the order in which a page needs them that begins with the end.
  for (size_t i = keys.size(); i-- > 0;) {
    append(segments_[i].poses);
    append(keys[i]);
    append(segments_[i].changes);
  }
  return out;
}

}  // namespace enamel::timeline
