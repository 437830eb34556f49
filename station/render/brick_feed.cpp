#include "station/render/brick_feed.h"

namespace enamel::station::render {

BrickFeed::BrickFeed(int64_t brick_count, size_t capacity)
    : ring_(capacity),
      dirty_(static_cast<size_t>(brick_count)),
      is_dirty_(static_cast<size_t>(brick_count)) {}

void BrickFeed::Mark(std::span<const int32_t> bricks) noexcept {
  for (int32_t brick : bricks) {
    uint8_t& flag = is_dirty_[static_cast<size_t>(brick)];
    if (flag) continue;
    flag = 1;
    // Never full: a place for every brick, and each at most once.
    dirty_[(dirty_head_ + dirty_count_++) % dirty_.size()] = brick;
  }
}

size_t BrickFeed::Send(const cutting::Volume& volume, size_t most) noexcept {
  size_t head = head_.load(std::memory_order_relaxed);
  // Acquire: the consumer has read to the end what it has released.
  size_t room = ring_.size() - (head - released_.load(std::memory_order_acquire));
  size_t sent = 0;
  for (; sent < most && sent < room && dirty_count_ > 0; ++sent) {
    int32_t brick = dirty_[dirty_head_];
    dirty_head_ = (dirty_head_ + 1) % dirty_.size();
    --dirty_count_;
    is_dirty_[static_cast<size_t>(brick)] = 0;
    // A brick that was cut is stored explicitly.
    BrickUpdate& update = ring_[(head + sent) % ring_.size()];
    update.brick = brick;
    // In its current state: earlier changes need not be seen.
    update.phi = volume.Phi(brick);
  }
  head_.store(head + sent, std::memory_order_release);
  return sent;
}

}  // namespace enamel::station::render
