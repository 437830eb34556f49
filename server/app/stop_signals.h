#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <chrono>
#include <functional>
#include <thread>

namespace enamel::server::app {

// SIGINT and SIGTERM for a program that runs until it is asked to stop. The first signal asks.
// Further ones within two seconds change nothing: a terminal's Ctrl-C reaches a whole process
// group, whose leader then asks once more, and that is one wish, not two. Later ones have their
// usual effect.
//
// Outlives the parts it stops, so that a late signal does not cut that short. Thread safety:
// OnFirst once, from the owner's thread; its callback runs on a thread of `io`.
class StopSignals {
 public:
  explicit StopSignals(boost::asio::io_context& io);
  void OnFirst(std::function<void()> stop);
  static constexpr std::chrono::seconds kLongestStop{7};
  // From now on the program ends within `longest`: whatever still runs then, such as a COMMIT that
  // waits for a standby, is left, the log reports it, and the exit status is 1. As after a crash,
  // what was acknowledged is kept.
  void EndSoon(std::chrono::milliseconds longest = kLongestStop);
  // Every change is answered. A job that still runs at the end of that time is left too, but it
  // begins again after the next start, so the exit status is 0. Any thread.
  void OnlyJobsRemain() noexcept { only_jobs_ = true; }

 private:
  void EndPatience(const std::stop_token& ended);

  boost::asio::signal_set signals_;
  std::atomic<bool> only_jobs_ = false;
  std::jthread patience_, last_;
};

}  // namespace enamel::server::app
