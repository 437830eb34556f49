#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "common/cutting/volume.h"

namespace enamel::station::render {

struct BrickUpdate {
  int32_t brick;
  cutting::BrickPhi phi;
};

// Carries changed bricks from the thread that cuts to the thread that meshes. The producer keeps a
// set of dirty bricks, first in first out, each at most once, and copies them into a bounded ring
// when there is room. Nothing is lost: a full ring leaves bricks dirty, and a brick is copied in
// its state at that time. Only distances are sent; a cut changes no labels. Thread safety: one
// producer thread, one consumer thread. Real-time: the producer's methods are safe and wait-free;
// construction allocates.
class BrickFeed {
 public:
  BrickFeed(int64_t brick_count, size_t capacity);

  // --- producer ---
  ENAMEL_REALTIME void Mark(std::span<const int32_t> bricks) noexcept;
  // Copies at most `most` dirty bricks of `volume` into the ring; returns the number.
  ENAMEL_REALTIME size_t Send(const cutting::Volume& volume, size_t most) noexcept;
  size_t dirty_count() const noexcept { return dirty_count_; }

  // --- consumer ---
  // Calls take(const BrickUpdate&) for each waiting update; returns the number.
  template <typename Take>
  size_t Drain(Take&& take) {
    size_t head = head_.load(std::memory_order_acquire), taken = 0;
    for (; tail_ != head; ++tail_, ++taken) take(ring_[tail_ % ring_.size()]);
    released_.store(tail_, std::memory_order_release);
    return taken;
  }

  // --- any thread ---
  // Updates sent since the start.
  size_t sent() const noexcept { return head_.load(std::memory_order_acquire); }

 private:
  std::vector<BrickUpdate> ring_;
  // Owned by the producer.
  std::vector<int32_t> dirty_;  // circular, one place per brick
  std::vector<uint8_t> is_dirty_;
  size_t dirty_head_ = 0, dirty_count_ = 0;
  // Owned by the consumer.
  size_t tail_ = 0;
  // Shared.
  alignas(64) std::atomic<size_t> head_{0};
  alignas(64) std::atomic<size_t> released_{0};
};

}  // namespace enamel::station::render
