#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>

#include "server/net/listener.h"

namespace enamel::server {

// The deadline of whatever a connection waits for at the moment. One timer serves the connection's
// whole life: a deadline that moves later leaves it alone, and Watch looks again when it wakes. A
// request that comes and is answered in time therefore touches no timer.
//
//   co_spawn(strand, deadline.Watch(), …);     // until End, or until the deadline has passed
//   deadline.Allow(10s); co_await …;
//
// Thread safety: the strand.
class Deadline {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Deadline(const Strand& strand) : timer_(strand) {}

  // From now on, instead of the previous deadline.
  void Allow(std::chrono::milliseconds time);
  // What follows has a deadline elsewhere.
  void AllowAnyTime() { at_ = Clock::time_point::max(); }
  // The deadline passed before End. It stays passed.
  bool passed() const { return passed_; }

  // Returns once the deadline has passed (true) or after End (false). Once.
  boost::asio::awaitable<bool> Watch();
  void End();

 private:
  boost::asio::steady_timer timer_;  // never later than the deadline
  Clock::time_point at_ = Clock::time_point::max();
  bool ended_ = false, passed_ = false;
};

}  // namespace enamel::server
