#pragma once

#include <chrono>
#include <random>

namespace enamel::station {

// Wait before connecting again (schemas/wire/README.md, "Coming back"): 0.5 s, doubled up to 30 s;
// after a refusal of the whole station 1 min, up to 15 min. Each wait is shortened by a random part
// of up to a half, so that forty stations of a room do not return all at once after a switch
// restarts. Thread safety: none.
class Backoff {
 public:
  using Duration = std::chrono::milliseconds;
  static constexpr Duration kFirst{500}, kLongest{30'000};

  static constexpr Duration kRefusedFirst{60'000}, kRefusedLongest{900'000};

  explicit Backoff(uint32_t seed = std::random_device{}()) : random_(seed) {}
  Backoff(Duration first, Duration longest, uint32_t seed = std::random_device{}())
      : first_(first), longest_(longest), random_(seed) {}
  // After one more failure.
  Duration Next();
  // The server was reached.
  void Reset() { next_ = first_; }

 private:
  const Duration first_ = kFirst, longest_ = kLongest;
  std::minstd_rand random_;
  Duration next_ = first_;
};

}  // namespace enamel::station
