#include "server/net/stream_socket.h"

#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <vector>

namespace enamel::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using Io = StreamSocket::Io;

asio::awaitable<void> ReadAll(StreamSocket& socket, bool keep, size_t all, size_t& read) {
  std::vector<uint8_t> space(4096);
  for (Io io = Io::kDone; io != Io::kEnded && read < all;) {
    size_t n = 0;
    io = keep ? socket.Read(space, n) : socket.Discard(n);
    if (io == Io::kDone) read += n;
    if (io > Io::kEnded) co_await socket.Wait(io);
  }
}

TEST(StreamSocketTest, APeerThatSendsWithoutAnEndIsReadInTurnWithOthers) {
  for (const bool keep : {true, false}) {
    asio::io_context io;
    tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
    tcp::socket loud(io);
    loud.connect(acceptor.local_endpoint());
    tcp::socket accepted = acceptor.accept();
    accepted.non_blocking(true);
    StreamSocket socket(std::move(accepted), nullptr);
    loud.non_blocking(true);
    const std::vector<uint8_t> bytes(1 << 20);
    boost::system::error_code full;
    size_t sent = 0;
    while (!full) sent += loud.write_some(asio::buffer(bytes), full);
    ASSERT_GT(sent, 3 * StreamSocket::kTurnBytes);
    size_t read = 0, when_another_ran = sent;
    asio::co_spawn(io, ReadAll(socket, keep, sent, read), asio::detached);
    asio::post(io, [&] { when_another_ran = read; });
    io.run();
    EXPECT_LE(when_another_ran, 2 * StreamSocket::kTurnBytes);
    EXPECT_EQ(read, sent);
  }
}

}  // namespace
}  // namespace enamel::server
