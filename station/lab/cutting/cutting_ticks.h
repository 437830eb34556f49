#pragma once

#include <cstdint>

namespace enamel::station::lab {

// Counts the ticks of a recording that cut: ticks less than 50 ms after a removal. (The core renews
// a cut only when it would leave a mark, so most ticks of a stroke remove nothing themselves.)
// Real-time: safe. Thread safety: none.
class CuttingTicks {
 public:
  explicit CuttingTicks(uint32_t rate_hz) : window_(rate_hz / 20) {}

  void Add(bool removed) {
    if (removed) left_ = window_;
    if (left_ == 0) return;
    --left_;
    ++cutting_;
  }
  uint64_t cutting() const { return cutting_; }

 private:
  const uint64_t window_;
  uint64_t left_ = 0, cutting_ = 0;
};

}  // namespace enamel::station::lab
