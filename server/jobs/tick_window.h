#pragma once

#include <cstdint>
#include <string>

#include "common/base/result.h"
#include "common/trace/pieces.h"

// The recorded values of each tick in a short span, for a closer look than the series gives
// (series.h). Nothing is replayed. Thread safety: function, any thread. Not real-time.
namespace enamel::server {

inline constexpr uint64_t kMaxWindowTicks = 4000;

// The ticks of `next` (all chunks of an attempt) whose time, in ticks since the start with
// gaps, is from `from` to before `to`, as JSON text (schemas/api/openapi.yaml, Ticks). Forces to
// 1 mN, without touch cues. Chunks that lie before are not decoded.
// Errors: kInvalidInput with field "to" unless from < to <= from + kMaxWindowTicks; what
// `next` returns, trace::DecodeChunk's.
Result<std::string> TickWindowJson(const trace::NextChunk& next, uint64_t from, uint64_t to);

}  // namespace enamel::server
