#include "server/net/stream_socket.h"

#include <openssl/err.h>
#include <sys/socket.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cerrno>
#include <utility>

namespace enamel::server {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

StreamSocket::Io PlainOutcome(const error_code& error, StreamSocket::Io wait) {
  if (!error) return StreamSocket::Io::kDone;
  if (error == asio::error::would_block || error == asio::error::try_again) return wait;
  return StreamSocket::Io::kEnded;
}

}  // namespace

StreamSocket::StreamSocket(tcp::socket socket, SSL_CTX* tls)
    : socket_(std::move(socket)), plain_(tls == nullptr) {
  error_code ignored;
  socket_.non_blocking(true, ignored);
  if (plain_) return;
  ssl_.reset(SSL_new(tls));
  if (!ssl_) return;
  SSL_set_fd(ssl_.get(), socket_.native_handle());
  SSL_set_accept_state(ssl_.get());
}

StreamSocket::Io StreamSocket::Outcome(int rc) const {
  if (rc > 0) return Io::kDone;
  switch (SSL_get_error(ssl_.get(), rc)) {
    case SSL_ERROR_WANT_READ:
      return Io::kWantRead;
    case SSL_ERROR_WANT_WRITE:
      return Io::kWantWrite;
    default:
      return Io::kEnded;
  }
}

StreamSocket::Io StreamSocket::Handshake() {
  if (plain_) return Io::kDone;
  if (!ssl_ || !socket_.is_open()) return Io::kEnded;
  ERR_clear_error();
  return Outcome(SSL_do_handshake(ssl_.get()));
}

StreamSocket::Io StreamSocket::Read(std::span<uint8_t> space, size_t& n) {
  n = 0;
  if (!socket_.is_open()) return Io::kEnded;
  if (TurnIsOver()) return Io::kWantRead;
  Io io = Io::kDone;
  if (plain_) {
    error_code error;
    n = socket_.read_some(asio::buffer(space.data(), space.size()), error);
    io = PlainOutcome(error, Io::kWantRead);
  } else {
    ERR_clear_error();
    io = Outcome(SSL_read_ex(ssl_.get(), space.data(), space.size(), &n));
  }
  if (io == Io::kDone) turn_bytes_ += n;
  return io;
}

StreamSocket::Io StreamSocket::Write(ByteView bytes, size_t& n) {
  n = 0;
  if (!socket_.is_open()) return Io::kEnded;
  if (plain_) {
    error_code error;
    n = socket_.write_some(asio::buffer(bytes.data(), bytes.size()), error);
    return PlainOutcome(error, Io::kWantWrite);
  }
  ERR_clear_error();
  return Outcome(SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &n));
}

StreamSocket::Io StreamSocket::Shutdown() {
  if (plain_) return Io::kDone;
  if (!socket_.is_open()) return Io::kEnded;
  ERR_clear_error();
  // 0: our notice is out; the peer's is not waited for.
  int rc = SSL_shutdown(ssl_.get());
  return rc == 0 ? Io::kDone : Outcome(rc);
}

asio::awaitable<void> StreamSocket::Wait(Io what) {
  turn_bytes_ = 0;
  if (std::exchange(turn_over_, false)) {
    co_await asio::post(socket_.get_executor(), asio::use_awaitable);
    co_return;
  }
  error_code ended;
  auto side = what == Io::kWantWrite ? tcp::socket::wait_write : tcp::socket::wait_read;
  co_await socket_.async_wait(side, asio::redirect_error(asio::use_awaitable, ended));
}

asio::awaitable<bool> StreamSocket::WriteAll(ByteView bytes) {
  while (!bytes.empty()) {
    size_t n = 0;
    const Io io = Write(bytes, n);
    if (io == Io::kEnded) co_return false;
    if (io == Io::kDone) {
      bytes = bytes.subspan(n);
    } else {
      co_await Wait(io);
    }
  }
  co_return true;
}

StreamSocket::Io StreamSocket::Discard(size_t& n) {
  n = 0;
  if (!socket_.is_open()) return Io::kEnded;
  if (TurnIsOver()) return Io::kWantRead;
  // Without a copy (tcp(7), MSG_TRUNC).
  const ssize_t dropped =
      ::recv(socket_.native_handle(), nullptr, kTurnBytes, MSG_TRUNC | MSG_DONTWAIT);
  if (dropped > 0) {
    n = static_cast<size_t>(dropped);
    turn_bytes_ += n;
    return Io::kDone;
  }
  return dropped < 0 && (errno == EAGAIN || errno == EINTR) ? Io::kWantRead : Io::kEnded;
}

bool StreamSocket::TurnIsOver() {
  turn_over_ = turn_bytes_ >= kTurnBytes;
  return turn_over_;
}

void StreamSocket::Close() {
  error_code ignored;
  socket_.close(ignored);
}

}  // namespace enamel::server
