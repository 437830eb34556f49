#pragma once

#include <cstdint>
#include <string>

#include "common/base/result.h"
#include "server/storage/recordings/ingest_rows.h"
#include "server/storage/recordings/trace_rows.h"

// How much one recording may hold. A chair that somebody has taken over can sign whatever it likes;
// without a bound it would fill the disk of all, and numbers that no clock can reach would overflow
// the database's.
namespace enamel::server {

// The longest that anybody records: a working day at the fastest rate of an exercise.
inline constexpr int64_t kMaxTicks = int64_t{8} * 3600 * 8000;
// A tick of a real hand takes 2 to 4 bytes (`enamel-lab bench record`), one of noise 12.
inline constexpr int64_t kMaxBytesPerTick = 16;
inline constexpr int64_t kMaxTraceBytes = 1'300'000'000;
// Hands that are programs record faster than time. That is flagged (kFasterThanTime); so far ahead
// of the clock it is also taken.
inline constexpr int64_t kMaxAheadMs = 3'600'000;

// SQL that is true while an attempt's row may take another chunk: so many ticks, gap ticks, bytes,
// received at a time (parameters such as "?5").
std::string FitsSql(const std::string& ticks, const std::string& gap_ticks,
                    const std::string& bytes, const std::string& received_ms);
// The same of a row that was read, in words. Errors: kTooLarge with field "ticks" or "bytes".
Status MustFit(const Ingest& ingest, const ChunkPut& chunk);

}  // namespace enamel::server
