#pragma once

#include <atomic>
#include <map>
#include <string>
#include <thread>

#include "common/net/frame_client.h"

namespace enamel::load {

// Gives the calling thread nice 19.
void GiveWay();

// Peers of the page that nobody knows: each announces a body of 1 MiB, sends all but its last byte,
// and comes back whenever it is cut off. One thread at nice 19.
class Strangers {
 public:
  Strangers(net::Endpoint page, size_t count) : page_(std::move(page)), count_(count) {}
  ~Strangers() { Stop(); }
  Strangers(const Strangers&) = delete;
  Strangers& operator=(const Strangers&) = delete;

  void Begin();
  void Stop();
  uint64_t opened() const { return opened_; }
  // After Stop: answers by their first line and message.
  const std::map<std::string, uint64_t>& answers() const { return answers_; }

 private:
  void Run(const std::stop_token& stop);

  const net::Endpoint page_;
  const size_t count_;
  std::atomic<uint64_t> opened_{0};
  std::map<std::string, uint64_t> answers_;
  std::jthread thread_;
};

// Opens `path` as a stream on a connection of its own. Its status; 0: no answer. `fd`: the caller
// closes it; -1: closed.
struct Opened {
  int fd = -1, status = 0;
  std::string text;
};
Opened OpenStream(const net::Endpoint& page, const std::string& path, const std::string& cookie);

}  // namespace enamel::load
