#include "station/uplink/bandwidth.h"

#include <algorithm>

namespace enamel::station {
namespace {

using Seconds = std::chrono::duration<double>;

}  // namespace

void Bandwidth::Fill(Clock::time_point now) {
  if (filled_ == Clock::time_point{}) filled_ = now;
  if (now <= filled_) return;
  level_ = std::min(rate_, level_ + rate_ * Seconds(now - filled_).count());
  filled_ = now;
}

Bandwidth::Clock::duration Bandwidth::Take(size_t bytes, Clock::time_point now) {
  if (rate_ == 0) return {};
  Fill(now);
  const double size = static_cast<double>(bytes);
  const double missing = std::min(size, rate_) - level_;
  if (missing <= 0) {
    level_ -= size;
    return {};
  }
  // Rounded up, so that it is available at the next call.
  return std::chrono::duration_cast<Clock::duration>(Seconds(missing / rate_)) +
         std::chrono::microseconds(1);
}

bool Bandwidth::TakeSpare(size_t bytes, Clock::time_point now) {
  if (rate_ == 0) return true;
  Fill(now);
  const double size = static_cast<double>(bytes);
  if (level_ - size < rate_ / 2) return false;
  level_ -= size;
  return true;
}

}  // namespace enamel::station
