#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "common/base/check.h"

namespace enamel::station {

// Durations or lateness over a whole attempt, in fixed memory: counts in buckets whose edges grow
// by powers of two, each split into 32, so a quantile is accurate to a 32nd of its value. From 0 ns
// to 2^40 ns (18 min); longer durations count as that.
//
// Thread safety: Add by one thread, everything else by any. Real-time: Add is safe (wait-free).
class DurationHistogram {
 public:
  static constexpr int kOctaves = 40, kSplit = 32;
  static constexpr size_t kBuckets = static_cast<size_t>(kOctaves) * kSplit;

  ENAMEL_REALTIME void Add(int64_t ns) noexcept {
    uint64_t value = ns > 0 ? static_cast<uint64_t>(ns) : 0;
    Increase(buckets_[BucketOf(value)], 1);
    Increase(count_, 1);
    Increase(sum_ns_, value);
    if (value > max_ns_.load(std::memory_order_relaxed)) {
      max_ns_.store(value, std::memory_order_relaxed);
    }
  }

  uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  uint64_t max_ns() const noexcept { return max_ns_.load(std::memory_order_relaxed); }
  double mean_ns() const noexcept {
    uint64_t n = count();
    return n == 0 ? 0
                  : static_cast<double>(sum_ns_.load(std::memory_order_relaxed)) /
                        static_cast<double>(n);
  }
  // The middle of the bucket that holds the given share of all values; 0 if there are none.
  double Quantile_ns(double share) const noexcept {
    uint64_t n = count(), seen = 0;
    auto wanted = static_cast<uint64_t>(share * static_cast<double>(n));
    for (size_t i = 0; i < kBuckets; ++i) {
      seen += InBucket(i);
      if (seen > wanted) {
        double middle = 0.5 * static_cast<double>(Floor_ns(i) + Floor_ns(i + 1));
        double most = static_cast<double>(max_ns());
        return middle < most ? middle : most;
      }
    }
    return static_cast<double>(max_ns());
  }

  uint64_t InBucket(size_t i) const noexcept { return buckets_[i].load(std::memory_order_relaxed); }
  // Lower edge of a bucket: the edges are 0..32 by one, then 32 to each doubling.
  static constexpr uint64_t Floor_ns(size_t i) noexcept {
    if (i < kSplit) return i;
    size_t octave = i / kSplit - 1;
    return (kSplit + i % kSplit) << octave;
  }
  static constexpr size_t BucketOf(uint64_t ns) noexcept {
    if (ns < kSplit) return static_cast<size_t>(ns);
    auto octave = static_cast<size_t>(std::bit_width(ns)) - 6;  // 32..63: 0
    size_t bucket = (octave + 1) * kSplit + static_cast<size_t>((ns >> octave) - kSplit);
    return bucket < kBuckets ? bucket : kBuckets - 1;
  }

 private:
  static void Increase(std::atomic<uint64_t>& counter, uint64_t by) noexcept {
    // One writer: a locked addition is not needed.
    counter.store(counter.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
  }

  std::array<std::atomic<uint64_t>, kBuckets> buckets_{};
  std::atomic<uint64_t> count_{0}, sum_ns_{0}, max_ns_{0};
};

}  // namespace enamel::station
