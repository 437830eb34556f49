#pragma once

#include <chrono>
#include <random>

namespace enamel::station {

// How long to wait before connecting again (schemas/wire/README.md, "Coming back"): 0.5 s, doubled
// up to 30 s, each shortened by a random part of up to a half, so that forty stations of a room do
// not come back at once after a switch was restarted. Thread safety: none.
class Backoff {
 public:
  using Duration = std::chrono::milliseconds;
  static constexpr Duration kFirst{500}, kLongest{30'000};

  explicit Backoff(uint32_t seed = std::random_device{}()) : random_(seed) {}
  // After one more failure.
  Duration Next();
  // The server was reached.
  void Reset() { next_ = kFirst; }

 private:
  std::minstd_rand random_;
  Duration next_ = kFirst;
};

}  // namespace enamel::station
