#include "common/trace/moment.h"

#include <chrono>

#include "common/trace/replay_run.h"

namespace enamel::trace {
namespace {

using Clock = std::chrono::steady_clock;

double Since(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

// Bricks whose samples are not those of the keyframe before: touched by a cut, or first stored.
class ChangedBricks {
 public:
  explicit ChangedBricks(const core::Core& core) : core_(core) { Forget(); }
  void Note() {
    for (int32_t brick : core_.touched()) changed_[static_cast<size_t>(brick)] = 1;
  }
  std::vector<int32_t> List() const {
    std::vector<int32_t> out;
    for (size_t b = 0; b < changed_.size(); ++b) {
      bool stored = core_.volume().IsStored(static_cast<int>(b));
      if (changed_[b] || stored != (stored_[b] != 0)) out.push_back(static_cast<int32_t>(b));
    }
    return out;
  }
  void Forget() {
    size_t count = static_cast<size_t>(core_.volume().spec().brick_count());
    changed_.assign(count, 0);
    stored_.resize(count);
    for (size_t b = 0; b < count; ++b) stored_[b] = core_.volume().IsStored(static_cast<int>(b));
  }

 private:
  const core::Core& core_;
  std::vector<uint8_t> changed_, stored_;
};

struct Journey {
  const Header& header;
  std::span<const Bytes> chunks;
  const MomentOptions& options;
  Keyframes& keyframes;
  const std::function<bool(double)>& keep_going;
};

// Tick after the chunk at `index`; only for chunks whose head can be read.
uint64_t EndOf(std::span<const Bytes> chunks, size_t index) {
  auto head = DecodeChunkHead(chunks[index]);
  return head.ok() ? head->head.first_tick + head->head.count : 0;
}

// The chunks up to the moment.
std::span<const Bytes> ChunksUpTo(std::span<const Bytes> chunks, uint64_t tick) {
  if (tick == UINT64_MAX) return chunks;
  size_t count = 0;
  while (count < chunks.size() && EndOf(chunks, count) < tick) ++count;
  return chunks.first(std::min(count + 1, chunks.size()));
}

// The last keyframe with a whole chunk between it and the moment; size() when there is none.
size_t KeyframeBefore(const Journey& j) {
  const Keyframes& k = j.keyframes;
  for (size_t i = k.size(); i-- > 0;) {
    size_t next = k.place(i).chunks;
    if (next >= j.chunks.size()) continue;
    if (k.place(i).ticks < j.options.to_tick && EndOf(j.chunks, next) <= j.options.to_tick)
      return i;
  }
  return k.size();
}

bool SamePlace(const KeyframePlace& place, const ReplayRun& run) {
  const ChainState& chain = run.chain();
  return place.chain == chain.head && place.ticks == chain.next_tick &&
         place.state_hash == chain.state_hash;
}

// Skips to keyframe i. Not ok: it does not fit this chain or this core, or the chain is broken.
Status GoTo(const Journey& j, size_t i, core::Core& core, ReplayRun& run) {
  const KeyframePlace& place = j.keyframes.place(i);
  for (size_t c = 0; c < place.chunks; ++c) ENAMEL_RETURN_IF_ERROR(run.Skip(j.chunks[c]));
  if (!SamePlace(place, run)) {
    return Status(Code::kConflict, "keyframes: made of other chunks than this recording's");
  }
  ENAMEL_RETURN_IF_ERROR(j.keyframes.Restore(i, core));
  run.StartAt(place.gap_ticks);
  return Status::Ok();
}

// Re-runs from where `run` stands to the moment, adding keyframes behind the last one there is.
// `next`: the first keyframe ahead.
Status Travel(const Journey& j, core::Core& core, ReplayRun& run, size_t next) {
  Keyframes& k = j.keyframes;
  ChangedBricks changed(core);
  auto last = Clock::now();
  auto note = [&](const Tick&, const core::TickOutput&) { changed.Note(); };
  while (run.report().chunks < j.chunks.size() && run.report().ticks < j.options.to_tick) {
    const uint32_t before = run.report().chunks;
    ENAMEL_RETURN_IF_ERROR(run.CheckKeepGoing(j.keep_going, j.chunks.size()));
    ENAMEL_RETURN_IF_ERROR(run.Run(j.chunks[before], j.options.to_tick, note));
    const ReplayReport& at = run.report();
    if (at.chunks == before || !at.witness_ok) continue;
    if (next < k.size() && k.place(next).chunks > at.chunks) continue;
    if (next < k.size() && !SamePlace(k.place(next), run)) k.Truncate(next);
    if (next == k.size()) {
      if (Since(last) < j.options.keyframe_every_s) continue;
      k.Add(core, {at.ticks, at.chunks, at.gap_ticks, run.chain().head, at.state_hash},
            changed.List());
    }
    // The next keyframe holds what changes from here on.
    next = k.size() > next ? next + 1 : next;
    changed.Forget();
    last = Clock::now();
  }
  return Status::Ok();
}

Result<Moment> FromStart(const Journey& j, std::unique_ptr<core::Core> core) {
  Moment out;
  ReplayRun run(*core, j.header);
  ENAMEL_RETURN_IF_ERROR(run.CheckCore());
  run.report().state_hash = core->state_hash();
  ENAMEL_RETURN_IF_ERROR(Travel(j, *core, run, 0));
  out.report = run.report();
  out.core = std::move(core);
  return out;
}

// Not ok, or a witness that disagrees: the keyframes are to blame until a replay from the start
// says otherwise.
Result<Moment> FromKeyframe(const Journey& j, size_t i, std::unique_ptr<core::Core> core) {
  Moment out;
  ReplayRun run(*core, j.header);
  ENAMEL_RETURN_IF_ERROR(run.CheckCore());
  ENAMEL_RETURN_IF_ERROR(GoTo(j, i, *core, run));
  out.from_tick = core->ticks();
  ENAMEL_RETURN_IF_ERROR(Travel(j, *core, run, i + 1));
  if (!run.report().witness_ok) {
    return Status(Code::kConflict, "the replay from keyframe " + std::to_string(i) +
                                       " disagrees with the recording at tick " +
                                       std::to_string(run.report().first_bad_tick));
  }
  out.report = run.report();
  out.core = std::move(core);
  return out;
}

}  // namespace

Result<Moment> ReplayToMoment(const std::function<std::unique_ptr<core::Core>()>& make_core,
                              const Header& header, std::span<const Bytes> chunks,
                              const MomentOptions& options, Keyframes& keyframes,
                              const std::function<bool(double)>& keep_going) {
  auto begin = Clock::now();
  Journey journey{header, ChunksUpTo(chunks, options.to_tick), options, keyframes, keep_going};
  std::string discarded;
  Result<Moment> moment = Status(Code::kNotFound, "no keyframe");
  size_t from = options.start_from_keyframe ? KeyframeBefore(journey) : keyframes.size();
  if (from < keyframes.size()) {
    moment = FromKeyframe(journey, from, make_core());
    if (!moment.ok() && moment.status().code() == Code::kUnavailable) return moment.status();
    if (!moment.ok()) discarded = moment.status().message();
  }
  if (!moment.ok()) {
    if (!discarded.empty()) keyframes.Truncate(0);
    moment = FromStart(journey, make_core());
    ENAMEL_RETURN_IF_ERROR(moment.status());
  }
  moment->whole = moment->report.chunks == chunks.size();
  moment->discarded = discarded;
  moment->report.seconds = Since(begin);
  return moment;
}

}  // namespace enamel::trace
