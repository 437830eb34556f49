#include "server/storage/recordings/recording_bounds.h"

#include <algorithm>
#include <string>

namespace enamel::server {

std::string FitsSql(const std::string& ticks, const std::string& gap_ticks,
                    const std::string& bytes, const std::string& received_ms) {
  const std::string all_ticks = "ticks + gap_ticks + " + ticks + " + " + gap_ticks;
  const std::string all_bytes = "trace_bytes + " + bytes;
  // A clock that was set back loses nobody's recording.
  const std::string since_ms = "CASE WHEN " + received_ms + " > ticketed_ms THEN " + received_ms +
                               " - ticketed_ms ELSE 0 END";
  const std::string most_ms =
      "rate_hz * ((" + since_ms + ") + " + std::to_string(kMaxAheadMs) + ")";
  return all_ticks + " <= " + std::to_string(kMaxTicks) + " AND " + all_bytes +
         " <= " + std::to_string(kMaxTraceBytes) + " AND (rate_hz = 0 OR (" + all_ticks +
         ") * 1000 <= " + most_ms + " AND (" + all_bytes +
         ") * 1000 <= " + std::to_string(kMaxBytesPerTick) + " * " + most_ms + ")";
}

Status MustFit(const Ingest& ingest, const ChunkPut& chunk) {
  const int64_t ticks = static_cast<int64_t>(ingest.ticks + ingest.gap_ticks) +
                        int64_t{chunk.head.count} + int64_t{chunk.head.gap_ticks};
  const int64_t bytes =
      static_cast<int64_t>(ingest.trace_bytes) + static_cast<int64_t>(chunk.bytes.size());
  int64_t most_ticks = kMaxTicks, most_bytes = kMaxTraceBytes;
  if (ingest.rate_hz > 0) {
    const int64_t by_time =
        ingest.rate_hz *
        (std::max<int64_t>(chunk.received_ms - ingest.ticketed_ms, 0) + kMaxAheadMs) / 1000;
    most_ticks = std::min(most_ticks, by_time);
    most_bytes = std::min(most_bytes, kMaxBytesPerTick * by_time);
  }
  const auto refuse = [&](const char* what, int64_t most, int64_t found) {
    return Status(Code::kTooLarge,
                  "this recording may have " + std::to_string(most) + " " + what +
                      " by now; with chunk " + std::to_string(chunk.head.seq) + " it would have " +
                      std::to_string(found),
                  what);
  };
  if (ticks > most_ticks) return refuse("ticks", most_ticks, ticks);
  if (bytes > most_bytes) return refuse("bytes", most_bytes, bytes);
  return Status::Ok();
}

}  // namespace enamel::server
