#include "server/jobs/tick_window.h"

#include <boost/json.hpp>
#include <cmath>

#include "common/core/core.h"
#include "common/haptics/coupling.h"
#include "common/trace/trace.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

// Newton, rounded as in the recording: 1 mN.
double SizeOf_n(const std::array<int32_t, 3>& force_mn) {
  double squares = 0;
  for (int32_t part : force_mn) squares += static_cast<double>(part) * part;
  return std::round(std::sqrt(squares)) * 1e-3;
}

}  // namespace

Result<std::string> TickWindowJson(const trace::NextChunk& next, uint64_t from, uint64_t to) {
  if (to <= from || to - from > kMaxWindowTicks) {
    return Status(Code::kInvalidInput,
                  "expected 1 to " + std::to_string(kMaxWindowTicks) +
                      " ticks after `from`, found " + std::to_string(from) + " to " +
                      std::to_string(to),
                  "to");
  }
  json::array time, sent, computed, late, limited;
  uint64_t now = 0;  // of the next tick, gaps included
  while (now < to) {
    ENAMEL_ASSIGN_OR_RETURN(const auto bytes, next());
    if (!bytes) break;
    ENAMEL_ASSIGN_OR_RETURN(const trace::Chunk head, trace::DecodeChunkHead(*bytes));
    const uint64_t after = now + head.head.count + head.head.gap_ticks;
    if (after <= from) {
      now = after;
      continue;
    }
    ENAMEL_ASSIGN_OR_RETURN(const trace::Chunk chunk, trace::DecodeChunk(*bytes));
    for (const trace::Tick& tick : chunk.ticks) {
      now += tick.input.gap_ticks;
      if (now >= from && now < to) {
        time.emplace_back(now);
        sent.emplace_back(SizeOf_n(core::PressedForce_mn(tick.witness)));
        computed.emplace_back(SizeOf_n(tick.witness.force_computed_mn));
        late.emplace_back((tick.input.flags & core::kLateTick) != 0 ? 1 : 0);
        limited.emplace_back((tick.witness.flags & haptics::kPeakBounded) != 0 ? 1 : 0);
      }
      ++now;
    }
  }
  return json::serialize(json::object{{"from", from},
                                      {"to", to},
                                      {"time_ticks", std::move(time)},
                                      {"force_n", std::move(sent)},
                                      {"computed_n", std::move(computed)},
                                      {"late", std::move(late)},
                                      {"limited", std::move(limited)}});
}

}  // namespace enamel::server
