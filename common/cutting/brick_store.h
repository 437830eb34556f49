#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <utility>

namespace enamel::cutting {

// A growing row of bricks whose room is reserved at once and made resident piece by piece: a first
// touch of fresh memory costs a page fault, too much for a tick, and all of a tooth's room at once
// too much memory.
//
// Requires: Brick is a plain array of bytes or integers.
// Thread safety: as std::vector. Real-time: Append within the room, and Warm.
template <typename Brick>
class BrickStore {
 public:
  BrickStore() = default;
  // A copy has no room beyond what is stored: whoever cuts in it calls Reserve.
  BrickStore(const BrickStore& other) {
    if (other.size_ == 0) return;
    Reserve(other.size_);
    size_ = other.size_;
    std::memcpy(bricks_, other.bricks_, size_ * sizeof(Brick));
  }
  BrickStore(BrickStore&& other) noexcept { swap(other); }
  BrickStore& operator=(BrickStore other) noexcept {
    swap(other);
    return *this;
  }
  ~BrickStore() { Free(); }

  size_t size() const noexcept { return size_; }
  size_t capacity() const noexcept { return capacity_; }
  Brick& operator[](size_t i) noexcept { return bricks_[i]; }
  const Brick& operator[](size_t i) const noexcept { return bricks_[i]; }
  void Reserve(size_t capacity) {
    if (capacity <= capacity_) return;
    auto* room =
        static_cast<Brick*>(::operator new(capacity * sizeof(Brick), std::align_val_t(kPageBytes)));
    if (size_ > 0) std::memcpy(room, bricks_, size_ * sizeof(Brick));
    Free();
    bricks_ = room;
    capacity_ = capacity;
    warm_ = size_;
  }
  // Its content is not set. Requires, in real time: size() < capacity().
  Brick& Append() {
    if (size_ == capacity_) Reserve(capacity_ < 64 ? 64 : 2 * capacity_);
    return bricks_[size_++];
  }
  // Touches the room for `ahead` bricks after the last, at most `pages` of it that were not.
  void Warm(size_t ahead, size_t pages) noexcept {
    const size_t end = std::min(size_ + ahead, capacity_);
    for (warm_ = std::max(warm_, size_); warm_ < end && pages > 0; --pages) {
      // A write: reading would map the one page of zeros, and the first write still fault.
      std::memset(bricks_ + warm_, 0, 1);
      warm_ = std::min(end, warm_ + kPageBytes / sizeof(Brick));
    }
  }

 private:
  static constexpr size_t kPageBytes = 4096;

  void Free() noexcept { ::operator delete(bricks_, std::align_val_t(kPageBytes)); }
  void swap(BrickStore& other) noexcept {
    std::swap(bricks_, other.bricks_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    std::swap(warm_, other.warm_);
  }

  Brick* bricks_ = nullptr;
  size_t size_ = 0, capacity_ = 0, warm_ = 0;
};

}  // namespace enamel::cutting
