#include "tests/load/stations/motion.h"

#include "common/base/check.h"
#include "common/base/file.h"
#include "station/lab/cutting/attempt.h"
#include "tests/load/stations/chunk_layout.h"

namespace enamel::load {
namespace {

constexpr int32_t kVoxel_nm = 200'000;
// Coprime to any relevant length of motion, so that the stations' starts are spread over all of it.
constexpr size_t kStationStride = 7919;
constexpr int32_t kAnchorUnit_nm = 100;  // schemas/trace_format.md, column 10

Status TakeTicks(const std::vector<Bytes>& chunks, Motion& motion) {
  for (const Bytes& bytes : chunks) {
    ENAMEL_ASSIGN_OR_RETURN(auto chunk, trace::DecodeChunk(bytes));
    motion.ticks.insert(motion.ticks.end(), chunk.ticks.begin(), chunk.ticks.end());
  }
  if (!motion.ticks.empty()) return Status::Ok();
  return Status(Code::kInvalidInput, "expected a recording with at least one tick, found none");
}

// Counts and anchor move together, so that the bur stays beside its anchor in the recording.
trace::Tick Shifted(trace::Tick tick, int32_t cells, const std::array<int32_t, 3>& resolution_nm) {
  for (size_t axis = 0; axis < 3; ++axis) {
    tick.input.counts[axis] += cells;
    tick.witness.anchor_100nm[axis] += cells * (resolution_nm[axis] / kAnchorUnit_nm);
  }
  return tick;
}

}  // namespace

Result<Motion> SimulatedMotion(uint64_t ticks, const std::function<void(double)>& progress) {
  station::lab::AttemptOptions options;
  options.voxel_nm = kVoxel_nm;
  options.ticks = ticks;
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, station::lab::RecordAttempt(options, progress));
  Motion motion;
  motion.resolution_nm = attempt.header.params.resolution_nm;
  ENAMEL_RETURN_IF_ERROR(TakeTicks(attempt.chunks, motion));
  return motion;
}

Result<Motion> ReadMotion(const std::filesystem::path& file) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, ReadFile(file));
  auto trace = trace::DecodeTraceFile(bytes);
  if (!trace.ok()) return trace.status();
  ENAMEL_ASSIGN_OR_RETURN(auto header, trace::DecodeHeader(trace->header));
  Motion motion;
  motion.resolution_nm = header.params.resolution_nm;
  ENAMEL_RETURN_IF_ERROR(TakeTicks(trace->chunks, motion));
  return motion;
}

std::vector<Payload> StreamOf(const Motion& motion, size_t station, size_t chunk_ticks,
                              size_t chunks) {
  ENAMEL_CHECK(!motion.ticks.empty());
  std::vector<Payload> out;
  std::vector<trace::Tick> ticks(chunk_ticks);
  size_t at = station * kStationStride;
  auto cells = static_cast<int32_t>(1 + station % 20'000);
  for (size_t i = 0; i < chunks; ++i) {
    for (trace::Tick& tick : ticks) {
      tick = Shifted(motion.ticks[at++ % motion.ticks.size()], cells, motion.resolution_nm);
    }
    out.push_back(PayloadOf(trace::EncodeChunk({}, ticks, trace::SecretKey{})));
  }
  return out;
}

}  // namespace enamel::load
