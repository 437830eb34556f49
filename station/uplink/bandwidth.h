#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace enamel::station {

// Limits the rate of sending: a bucket that holds a second's worth and fills at the rate.
//
// A message is sent when the bucket holds it, or is full. A larger message leaves a debt that is
// paid off before the next. So over any time t at most rate * (t + 1 s) and one message are sent.
// The caller provides the time. Thread safety: none.
class Bandwidth {
 public:
  using Clock = std::chrono::steady_clock;

  // 0: no bound.
  explicit Bandwidth(uint64_t bytes_per_s)
      : rate_(static_cast<double>(bytes_per_s)), level_(rate_) {}

  // Takes `bytes` out and returns zero, or returns how long to wait before asking again.
  Clock::duration Take(size_t bytes, Clock::time_point now);
  // For data that may be dropped: takes only while half of the bucket remains for the rest.
  bool TakeSpare(size_t bytes, Clock::time_point now);

 private:
  void Fill(Clock::time_point now);

  const double rate_;  // bytes per second; also what the bucket holds
  double level_;       // below zero: a debt
  Clock::time_point filled_{};
};

}  // namespace enamel::station
