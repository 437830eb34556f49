#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace enamel::station::render {

// Latest-value mailbox for one writer and one reader, in three buffers: each side owns one, the
// third is exchanged. Neither side ever waits or sees half a value. Thread safety: one thread
// writes, one reads. Real-time: safe, wait-free.
template <typename T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  void Write(const T& value) noexcept {
    slots_[write_] = value;
    write_ =
        shared_.exchange(static_cast<uint8_t>(write_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  // True when there is a value newer than the one last read; it is then copied to `out`.
  bool Read(T& out) noexcept {
    if (!(shared_.load(std::memory_order_relaxed) & kFresh)) return false;
    read_ = shared_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    out = slots_[read_];
    return true;
  }

 private:
  static constexpr uint8_t kIndex = 3, kFresh = 4;
  std::array<T, 3> slots_{};
  std::atomic<uint8_t> shared_{1};
  uint8_t write_ = 0;  // the writer's
  uint8_t read_ = 2;   // the reader's
};

}  // namespace enamel::station::render
