#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/result.h"

namespace enamel::station::sdk {

// The client's end of a WebSocket that carries text. TCP sends a short message at once (TCP_NODELAY).
// Thread safety: one thread at a time. Real-time: not safe; a driver calls it on its own thread. The
// destructor closes the connection and does not wait for the server.
class WebSocket {
 public:
  // Connects to ws://host:port/. Errors: kUnavailable if no server answers within a second for each
  // of the connection and the handshake.
  static Result<std::unique_ptr<WebSocket>> Connect(const std::string& host,
                                                    const std::string& port);
  ~WebSocket();

  enum class Got { kMessage, kNothing, kClosed };
  // Waits up to `patience` for the next whole message and puts it into `out`. A message of which only
  // a part has come is kNothing; a later call returns it.
  Got Read(std::string& out, std::chrono::microseconds patience);
  // False: the connection is closed. A message is dropped if the previous one is still on its way.
  bool Write(std::string_view message);

 private:
  struct Stream;
  explicit WebSocket(std::unique_ptr<Stream> stream);
  const std::unique_ptr<Stream> stream_;
};

}  // namespace enamel::station::sdk
