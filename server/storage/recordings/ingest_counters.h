#pragma once

#include <atomic>
#include <cstdint>

namespace enamel::server {

// Since the store was opened.
struct IngestCounters {
  std::atomic<uint64_t> chunks{0}, chunk_bytes{0}, sealed{0};
};

}  // namespace enamel::server
