#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
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

 private:
  void EndPatience(const std::stop_token& ended);

  boost::asio::signal_set signals_;
  std::jthread patience_;
};

}  // namespace enamel::server::app
