#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "common/base/check.h"

namespace enamel {

// The newest value from one writer thread to one reader thread; older ones are overwritten.
// Before the first Write the reader sees a default T. Neither side ever waits for the other.
// Real-time: both methods are safe. Requires: T is copied without allocating.
template <typename T>
class TripleBuffer {
 public:
  ENAMEL_REALTIME void Write(const T& value) noexcept {
    slots_[writer_] = value;
    writer_ = middle_.exchange(writer_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }
  // Valid until the next Read.
  ENAMEL_REALTIME const T& Read() noexcept {
    if (middle_.load(std::memory_order_relaxed) & kFresh) {
      reader_ = middle_.exchange(reader_, std::memory_order_acq_rel) & kIndex;
    }
    return slots_[reader_];
  }

 private:
  static constexpr uint32_t kIndex = 3, kFresh = 4;
  std::array<T, 3> slots_{};
  uint32_t writer_ = 0;  // owned by the writer
  std::atomic<uint32_t> middle_{1};
  uint32_t reader_ = 2;  // owned by the reader
};

}  // namespace enamel
