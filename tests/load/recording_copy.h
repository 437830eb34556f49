#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "server/storage/store.h"
#include "server/training/types.h"

namespace enamel::load {

struct CopyKeys {
  trace::KeyPair ticket;   // the server's
  trace::KeyPair station;  // of the row's station
};

// A new attempt `row` with the ticks of a recording, chained and signed as its station would.
// Afterwards the store has everything except the seal, which is returned. `received_ms`: when the
// chunks arrived. Errors: those of the store.
Result<trace::Seal> CopyRecording(server::Store& store, const CopyKeys& keys,
                                  const server::AttemptRow& row, trace::Header header,
                                  const std::vector<Bytes>& chunks, server::UnixMs received_ms);

// Runs `work` for 0 … count-1 on at most `threads` threads; the first error.
Status InParallel(size_t count, size_t threads, const std::function<Status(size_t)>& work);

}  // namespace enamel::load
