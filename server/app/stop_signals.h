#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <functional>
#include <thread>

namespace enamel::server::app {

// SIGINT and SIGTERM of a program that runs until it is asked to stop. The first one asks, those
// within two seconds of it change nothing (a terminal's Ctrl-C reaches a whole process group, whose
// leader then asks once more: that is one wish, not two), later ones have their usual effect.
//
// Outlives what is stopped, so that a late one does not cut that short. Thread safety: OnFirst
// once, from the owner's thread; what it is given is called on a thread of `io`.
class StopSignals {
 public:
  explicit StopSignals(boost::asio::io_context& io);
  void OnFirst(std::function<void()> stop);

 private:
  void EndPatience(const std::stop_token& ended);

  boost::asio::signal_set signals_;
  std::jthread patience_;
};

}  // namespace enamel::server::app
