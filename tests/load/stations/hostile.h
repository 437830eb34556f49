#pragma once

#include <cstdint>
#include <random>

#include "tests/load/stations/link.h"

namespace enamel::load {

enum class HostileKind {
  kHalfOpen,    // connects, shakes hands and never says a word
  kSlowDrip,    // a frame's bytes one at a time
  kSlowReader,  // asks and asks, and never reads an answer
  kOversized,   // a length beyond every limit
  kGarbage,     // frames of random bytes
};
inline constexpr int kHostileKinds = 5;

// A peer without an enrolment that wastes the server's resources, and returns whenever it is
// disconnected. Same thread rules as Station.
class Hostile {
 public:
  Hostile(const LinkTarget& target, int epoll, uint64_t tag, HostileKind kind)
      : link_(target, epoll, tag), kind_(kind), random_(static_cast<uint32_t>(tag)) {}

  void Advance(double now);
  uint64_t thrown_out() const { return thrown_out_; }

 private:
  void Misbehave(double now);

  Link link_;
  const HostileKind kind_;
  std::mt19937 random_;
  double again_s_ = 0, dripped_s_ = 0;
  bool was_open_ = false, done_ = false;
  uint64_t thrown_out_ = 0;
};

}  // namespace enamel::load
