#include "station/sdk/web_socket.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <optional>

#include "station/devices/trouble.h"

// The only source of the station that compiles Beast's WebSocket, which takes a compiler long.
namespace enamel::station::sdk {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using Error = boost::system::error_code;

constexpr std::chrono::seconds kConnect{1};
// An inventory has some kilobytes.
constexpr size_t kLargestMessage = size_t{1} << 20;
// A call that does not wait takes at most so many steps of reading and writing. The next call continues.
constexpr int kMaxSteps = 1'000;

}  // namespace

// Reads and writes are asynchronous and run only inside calls: one that a call leaves unfinished
// continues in the next.
struct WebSocket::Stream {
  asio::io_context context{1};
  beast::websocket::stream<beast::tcp_stream> socket{context};
  beast::flat_buffer in;
  std::string out;
  bool reading = false, writing = false, read = false;
  Error failed;
  std::optional<Error> step;  // of connecting

  auto Step() {
    step.reset();
    return [this](Error error, auto&&...) { step = error; };
  }
  bool IsStepDone() {
    context.restart();
    context.run_for(kConnect);
    return step && !*step;
  }
  void Poll() {
    if (!reading && !read && !failed) {
      reading = true;
      socket.async_read(in, [this](Error error, size_t) {
        reading = false;
        read = !error;
        if (error) failed = error;
      });
    }
    context.restart();
    // A peer that sends pings without end always has another step ready.
    for (int steps = 0; steps < kMaxSteps && context.poll_one() > 0; ++steps) {
    }
  }
};

WebSocket::WebSocket(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
WebSocket::~WebSocket() = default;

Result<std::unique_ptr<WebSocket>> WebSocket::Connect(const std::string& host,
                                                      const std::string& port) {
  auto made = std::make_unique<Stream>();
  Stream& s = *made;
  const auto refused = [&] {
    return Status(Code::kUnavailable,
                  "no answer from ws://" + host + ":" + port + " (" +
                      (s.step ? s.step->message() : "timed out") + ")",
                  trouble::kService);
  };
  Error error;
  tcp::resolver resolver(s.context);
  const auto ends = resolver.resolve(host, port, error);
  s.step = error;
  if (error) return refused();
  auto& tcp_stream = beast::get_lowest_layer(s.socket);
  tcp_stream.async_connect(ends, s.Step());
  if (!s.IsStepDone()) return refused();
  tcp_stream.socket().set_option(tcp::no_delay(true), error);
  using Timeout = beast::websocket::stream_base::timeout;
  s.socket.set_option(Timeout{kConnect, beast::websocket::stream_base::none(), false});
  s.socket.read_message_max(kLargestMessage);
  s.socket.async_handshake(host + ":" + port, "/", s.Step());
  if (!s.IsStepDone()) return refused();
  s.socket.text(true);
  return std::unique_ptr<WebSocket>(new WebSocket(std::move(made)));
}

WebSocket::Got WebSocket::Read(std::string& out, std::chrono::microseconds patience) {
  Stream& s = *stream_;
  const auto until = std::chrono::steady_clock::now() + patience;
  s.Poll();
  while (!s.read && !s.failed && std::chrono::steady_clock::now() < until) {
    s.context.restart();
    s.context.run_one_until(until);
  }
  if (s.read) {
    out = beast::buffers_to_string(s.in.data());
    s.in.consume(s.in.size());
    s.read = false;
    return Got::kMessage;
  }
  return s.failed ? Got::kClosed : Got::kNothing;
}

bool WebSocket::Write(std::string_view message) {
  Stream& s = *stream_;
  s.Poll();
  if (s.failed) return false;
  if (s.writing) return true;
  s.out = message;
  s.writing = true;
  s.socket.async_write(asio::buffer(s.out), [&s](Error error, size_t) {
    s.writing = false;
    if (error) s.failed = error;
  });
  s.Poll();
  return !s.failed;
}

}  // namespace enamel::station::sdk
