#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>

namespace enamel {

// Counts durations in fixed steps from 0.5 ms to 10 s. Thread safety: any thread, no lock.
class Histogram {
 public:
  static constexpr std::array<double, 14> kUpToS = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
                                                    0.1,    0.25,  0.5,    1,     2.5,  5,     10};
  void Add(std::chrono::nanoseconds duration);

  struct Counts {
    std::array<uint64_t, kUpToS.size() + 1> each{};  // not cumulative; the last: longer
    double sum_s = 0;
  };
  Counts counts() const;

 private:
  std::array<std::atomic<uint64_t>, kUpToS.size() + 1> counts_{};
  std::atomic<uint64_t> sum_ns_{0};
};

}  // namespace enamel
