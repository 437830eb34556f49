#include "common/timeline/player.h"

#include <algorithm>
#include <string>

#include "common/base/check.h"
#include "common/scene/grid_blob.h"
#include "common/timeline/deflate.h"

namespace enamel::timeline {
namespace {

constexpr std::string_view kBlob = "surface timeline";
constexpr size_t kPoseBytes = 20;

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

}  // namespace

Result<Player> Player::Open(ByteView start_tooth, ByteView timeline) {
  Player out;
  ENAMEL_ASSIGN_OR_RETURN(out.start_, DecodeStartTooth(start_tooth));
  ENAMEL_ASSIGN_OR_RETURN(out.head_, DecodeHead(timeline));
  if (HashSha256(start_tooth) != out.head_.start || !(out.start_.spec == out.head_.spec)) {
    return Status(Code::kConflict, "surface timeline: expected the start tooth " +
                                       out.head_.start.Hex() + ", found " +
                                       HashSha256(start_tooth).Hex());
  }
  const uint64_t end = out.head_.file_bytes();
  if (end != timeline.size()) {
    return Malformed("expected " + std::to_string(end) + " bytes, found " +
                     std::to_string(timeline.size()));
  }
  out.file_.assign(timeline.begin(), timeline.end());
  const size_t bricks = out.start_.bricks.size();
  out.sample_slot_.assign(bricks, -1);
  out.label_slot_.assign(bricks, -1);
  int32_t samples = 0, labels = 0;
  for (size_t b = 0; b < bricks; ++b) {
    if (out.start_.bricks[b] & StartTooth::kSampled) out.sample_slot_[b] = samples++;
    if (out.start_.bricks[b] & StartTooth::kLabelled) out.label_slot_[b] = labels++;
  }
  out.slot_.assign(bricks, -1);
  return out;
}

void Player::Reset() {
  for (int32_t brick : owner_) slot_[static_cast<size_t>(brick)] = -1;
  owner_.clear();
  states_.clear();
}

Samples Player::BrickSamples(int brick) const {
  const auto b = static_cast<size_t>(brick);
  if (slot_[b] >= 0) return states_[static_cast<size_t>(slot_[b])];
  if (sample_slot_[b] >= 0) return start_.samples[static_cast<size_t>(sample_slot_[b])];
  Samples out;
  out.fill(start_.bricks[b] == 0 ? kFarOut : kDeep);
  return out;
}

Samples& Player::StateOf(int64_t brick) {
  const auto b = static_cast<size_t>(brick);
  if (slot_[b] < 0) {
    const Samples now = BrickSamples(static_cast<int>(brick));
    slot_[b] = static_cast<int32_t>(states_.size());
    owner_.push_back(static_cast<int32_t>(brick));
    states_.push_back(now);
  }
  return states_[static_cast<size_t>(slot_[b])];
}

ByteView Player::Part(size_t segment, int part) const {
  const Segment& s = head_.segments[segment];
  const size_t sizes[] = {s.pose_bytes, s.key_bytes, s.change_bytes};
  size_t at = static_cast<size_t>(s.offset);
  for (int i = 0; i < part; ++i) at += sizes[i];
  return ByteView(file_).subspan(at, sizes[part]);
}

Status Player::EnterSegment(size_t segment) {
  segment_ = SIZE_MAX;
  const Segment& s = head_.segments[segment];
  ENAMEL_ASSIGN_OR_RETURN(changes_.raw, Inflate(Part(segment, 2), s.change_size, kBlob, "changes"));
  ByteReader lengths(changes_.raw);
  const uint64_t heads = lengths.U32(), masks = lengths.U32();
  if (!lengths.ok() || 8 + heads + masks > changes_.raw.size()) {
    return Malformed("the changes of segment " + std::to_string(segment) + " end early");
  }
  changes_.head = 8;
  changes_.mask = changes_.head_end = 8 + heads;
  changes_.value = changes_.mask_end = 8 + heads + masks;
  Reset();
  // The nearest key frame that has a brick knows it.
  const size_t last = head_.segments.size() - 1;
  ENAMEL_RETURN_IF_ERROR(ReadKey(segment));
  for (size_t key = segment; key != last;) {
    key = KeyParent(key, last);
    ENAMEL_RETURN_IF_ERROR(ReadKey(key));
  }
  segment_ = segment;
  at_ = static_cast<uint32_t>(segment) * head_.segment_frames;
  return Status::Ok();
}

// Those of its bricks that are not known yet.
Status Player::ReadKey(size_t segment) {
  const Segment& s = head_.segments[segment];
  ENAMEL_ASSIGN_OR_RETURN(
      const Bytes key,
      Inflate(Part(segment, 1),
              size_t{s.key_bricks} * 4 + size_t{s.key_bricks - s.key_start} * cutting::kBrickVoxels,
              kBlob, "key frame"));
  ByteReader index(key);
  int64_t before = -1;
  size_t at = size_t{s.key_bricks} * 4;
  for (uint32_t i = 0; i < s.key_bricks; ++i) {
    const uint32_t entry = index.U32();
    const bool kept = (entry & kAsAtStart) == 0;
    const int64_t brick = entry & ~kAsAtStart;
    if (brick <= before || brick >= head_.spec.brick_count()) {
      return Malformed("brick " + std::to_string(brick) + " is out of order or outside the grid");
    }
    before = brick;
    const size_t from = at;
    if (kept) at += cutting::kBrickVoxels;
    if (at > key.size()) return Malformed("fewer bricks are as at the start than its head says");
    if (slot_[static_cast<size_t>(brick)] >= 0) continue;
    Samples& state = StateOf(brick);
    if (kept) {
      state = FromResiduals(ByteView(key).subspan(from, cutting::kBrickVoxels), CoarseIn(segment));
    }
  }
  if (at != key.size()) return Malformed("more bricks are as at the start than its head says");
  return Status::Ok();
}

Status Player::ApplyBrick(int64_t brick) {
  const auto early = [] { return Malformed("a brick's changes end early"); };
  Samples& state = StateOf(brick);
  const int coarse = CoarseIn(segment_);
  if (changes_.mask >= changes_.mask_end) return early();
  const uint8_t layers = changes_.raw[changes_.mask++];
  for (size_t z = 0; z < 8; ++z) {
    if ((layers >> z & 1) == 0) continue;
    if (changes_.mask >= changes_.mask_end) return early();
    const uint8_t rows = changes_.raw[changes_.mask++];
    for (size_t y = 0; y < 8; ++y) {
      if ((rows >> y & 1) == 0) continue;
      if (changes_.mask >= changes_.mask_end) return early();
      const uint8_t bits = changes_.raw[changes_.mask++];
      for (size_t x = 0; x < 8; ++x) {
        if ((bits >> x & 1) == 0) continue;
        if (changes_.value >= changes_.raw.size()) return early();
        const size_t i = z * 64 + y * 8 + x;
        state[i] = FromResidual(changes_.raw[changes_.value++], Predicted(state, i), coarse);
      }
    }
  }
  return Status::Ok();
}

Status Player::ApplyFrame() {
  ByteReader in(ByteView(changes_.raw).subspan(changes_.head, changes_.head_end - changes_.head));
  const uint64_t bricks = in.Varint();
  int64_t brick = -1;
  for (uint64_t i = 0; i < bricks && in.ok(); ++i) {
    const uint64_t gap = in.Varint();
    if (!in.ok() || gap >= static_cast<uint64_t>(head_.spec.brick_count() - brick - 1)) {
      return Malformed("a changed brick is outside the grid");
    }
    brick += 1 + static_cast<int64_t>(gap);
    ENAMEL_RETURN_IF_ERROR(ApplyBrick(brick));
  }
  if (!in.ok()) return Malformed("the changes of frame " + std::to_string(at_) + " end early");
  changes_.head += in.offset();
  ++at_;
  return Status::Ok();
}

Status Player::Seek(uint32_t frames) {
  ENAMEL_CHECK(frames <= head_.frames());
  if (frames == 0) {
    Reset();
    segment_ = SIZE_MAX;
    at_ = 0;
    return Status::Ok();
  }
  const size_t wanted = (frames - 1) / head_.segment_frames;
  if (segment_ != wanted || at_ > frames) ENAMEL_RETURN_IF_ERROR(EnterSegment(wanted));
  while (at_ < frames) ENAMEL_RETURN_IF_ERROR(ApplyFrame());
  return Status::Ok();
}

Result<std::vector<FramePose>> Player::Poses(size_t segment) const {
  const size_t n = head_.FramesIn(segment);
  ENAMEL_ASSIGN_OR_RETURN(const Bytes raw,
                          Inflate(Part(segment, 0), n * kPoseBytes, kBlob, "poses"));
  const ByteView all(raw);
  std::vector<FramePose> out(n);
  for (size_t axis = 0; axis < 3; ++axis) {
    uint32_t before = 0;
    for (size_t i = 0; i < n; ++i) {
      before += scene::Unzigzag(scene::FromPlanes(all.subspan(axis * 4 * n), n, i));
      out[i].tip_um[axis] = static_cast<int32_t>(before);
      out[i].axis[axis] = static_cast<int8_t>(raw[12 * n + axis * n + i]);
    }
  }
  for (size_t i = 0; i < n; ++i) {
    out[i].gap_ticks = scene::FromPlanes(all.subspan(15 * n), n, i);
    const uint8_t tool = raw[19 * n + i];
    out[i].turning = (tool & 1) != 0;
    out[i].bur = tool >> 1;
    if (out[i].bur > 0 && out[i].bur >= head_.outlines.size()) {
      return Malformed("a bur has no outline");
    }
  }
  return out;
}

cutting::Tissue Player::TissueAt(const ivec3& voxel) const {
  const ivec3 n = head_.spec.voxels();
  if (voxel.x < 0 || voxel.y < 0 || voxel.z < 0 || voxel.x >= n.x || voxel.y >= n.y ||
      voxel.z >= n.z) {
    return cutting::Tissue::kAir;
  }
  const auto b = static_cast<size_t>(head_.spec.BrickIndex(voxel / cutting::kBrickSide));
  if (label_slot_[b] < 0) {
    return static_cast<cutting::Tissue>(start_.bricks[b] & StartTooth::kTissue);
  }
  const ivec3 in = voxel % cutting::kBrickSide;
  return static_cast<cutting::Tissue>(
      start_.labels[static_cast<size_t>(label_slot_[b])]
          .tissue[static_cast<size_t>(in.z * 64 + in.y * 8 + in.x)]);
}

cutting::Volume Player::ToVolume() const {
  cutting::Volume out(head_.spec);
  for (size_t b = 0; b < start_.bricks.size(); ++b) {
    const uint8_t flags = start_.bricks[b];
    const auto tissue = static_cast<cutting::Tissue>(flags & StartTooth::kTissue);
    if (slot_[b] < 0 && sample_slot_[b] < 0 && label_slot_[b] < 0) {
      out.SetUniform(static_cast<int>(b), tissue);
      continue;
    }
    const Samples samples = BrickSamples(static_cast<int>(b));
    std::array<int16_t, cutting::kBrickVoxels> phi;
    for (size_t i = 0; i < phi.size(); ++i) phi[i] = PhiOf(samples[i]);
    std::span<const uint8_t> labels;
    if (label_slot_[b] >= 0) labels = start_.labels[static_cast<size_t>(label_slot_[b])].tissue;
    out.SetBrick(static_cast<int>(b), phi, labels, tissue);
  }
  return out;
}

}  // namespace enamel::timeline
