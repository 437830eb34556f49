#pragma once

#include <vector>

#include "server/storage/recordings/recording_rows.h"

namespace enamel::server {

// A recording's chunks, all in memory.
inline Result<std::vector<Bytes>> AllChunks(RecordingRows& recordings, const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(const auto recording, recordings.Open(attempt));
  std::vector<Bytes> out;
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(auto chunk, recording.next());
    if (!chunk) return out;
    out.push_back(std::move(*chunk));
  }
}

}  // namespace enamel::server
