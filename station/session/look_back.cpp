#include "station/session/look_back.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/trace/moment.h"

namespace enamel::station {

LookBack::LookBack(PreparedAttempt prepared, trace::TraceFile file)
    : prepared_(std::move(prepared)),
      file_(std::move(file)),
      keyframes_(HashSha256(file_.header)) {}

Result<Stretch> LookBack::Take(uint64_t from, uint64_t to,
                               const std::function<bool(double)>& keep_going) {
  trace::MomentOptions how;
  how.to_tick = from;
  const core::CoreParams& params = prepared_.header.params;
  ENAMEL_ASSIGN_OR_RETURN(
      auto moment,
      trace::ReplayToMoment([&] { return std::make_unique<core::Core>(params, prepared_.volume); },
                            prepared_.header, file_.chunks, how, keyframes_, keep_going));
  if (!moment.report.witness_ok) {
    return Status(Code::kConflict, "the recording does not compute to what was recorded (tick " +
                                       std::to_string(moment.report.first_bad_tick) + ")");
  }
  Stretch out;
  out.core = std::move(moment.core);
  out.passed_ticks = moment.report.ticks + moment.report.gap_ticks;
  for (const Bytes& bytes : file_.chunks) {
    ENAMEL_ASSIGN_OR_RETURN(const auto head, trace::DecodeChunkHead(bytes));
    const uint64_t first = head.head.first_tick, end = first + head.head.count;
    if (end <= from || first >= to) continue;
    ENAMEL_ASSIGN_OR_RETURN(const auto chunk, trace::DecodeChunk(bytes));
    const auto begin = chunk.ticks.begin();
    out.ticks.insert(out.ticks.end(), begin + static_cast<int64_t>(std::max(from, first) - first),
                     begin + static_cast<int64_t>(std::min(to, end) - first));
  }
  return out;
}

}  // namespace enamel::station
