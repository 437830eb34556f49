#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "common/base/check.h"

namespace enamel::station {

// Bounded queue of values from one producer thread to one consumer thread, in order.
// Thread safety: Push and Full by the producer, Pop by the consumer, size by either.
// Real-time: all methods but construction are safe (wait-free, no allocation).
template <typename T>
class SpscRing {
 public:
  explicit SpscRing(size_t capacity) : slots_(capacity + 1) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  size_t capacity() const noexcept { return slots_.size() - 1; }
  // A snapshot: the other side may be changing it.
  size_t size() const noexcept {
    size_t in = in_.load(std::memory_order_acquire), out = out_.load(std::memory_order_acquire);
    return in >= out ? in - out : in + slots_.size() - out;
  }
  // Producer: false stays false until the next Push.
  ENAMEL_REALTIME bool Full() const noexcept {
    return Next(in_.load(std::memory_order_relaxed)) == out_.load(std::memory_order_acquire);
  }
  // False when full: nothing was stored.
  ENAMEL_REALTIME bool Push(const T& value) noexcept {
    size_t in = in_.load(std::memory_order_relaxed);
    if (Next(in) == out_.load(std::memory_order_acquire)) return false;
    slots_[in] = value;
    in_.store(Next(in), std::memory_order_release);
    return true;
  }
  // False when empty: `value` is unchanged.
  ENAMEL_REALTIME bool Pop(T& value) noexcept {
    size_t out = out_.load(std::memory_order_relaxed);
    if (out == in_.load(std::memory_order_acquire)) return false;
    value = slots_[out];
    out_.store(Next(out), std::memory_order_release);
    return true;
  }

 private:
  size_t Next(size_t i) const noexcept { return i + 1 == slots_.size() ? 0 : i + 1; }

  std::vector<T> slots_;
  alignas(64) std::atomic<size_t> in_{0};
  alignas(64) std::atomic<size_t> out_{0};
};

}  // namespace enamel::station
