#include "server/stations/tls_socket.h"

#include <openssl/err.h>

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace enamel::server::stations {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

TlsSocket::TlsSocket(tcp::socket socket, SSL_CTX* context)
    : socket_(std::move(socket)), ssl_(SSL_new(context)) {
  error_code ignored;
  socket_.native_non_blocking(true, ignored);
  if (!ssl_) return;
  SSL_set_fd(ssl_.get(), socket_.native_handle());
  SSL_set_accept_state(ssl_.get());
}

TlsSocket::Io TlsSocket::Outcome(int rc) const {
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

TlsSocket::Io TlsSocket::Handshake() {
  if (!ssl_ || !socket_.is_open()) return Io::kEnded;
  ERR_clear_error();
  return Outcome(SSL_do_handshake(ssl_.get()));
}

TlsSocket::Io TlsSocket::Read(std::span<uint8_t> space, size_t& n) {
  n = 0;
  if (!socket_.is_open()) return Io::kEnded;
  ERR_clear_error();
  return Outcome(SSL_read_ex(ssl_.get(), space.data(), space.size(), &n));
}

TlsSocket::Io TlsSocket::Write(ByteView bytes, size_t& n) {
  n = 0;
  if (!socket_.is_open()) return Io::kEnded;
  ERR_clear_error();
  return Outcome(SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &n));
}

TlsSocket::Io TlsSocket::Shutdown() {
  if (!socket_.is_open()) return Io::kEnded;
  ERR_clear_error();
  // 0: our notice is out; the peer's is not waited for.
  int rc = SSL_shutdown(ssl_.get());
  return rc == 0 ? Io::kDone : Outcome(rc);
}

asio::awaitable<void> TlsSocket::Wait(Io what) {
  error_code ended;
  auto side = what == Io::kWantWrite ? tcp::socket::wait_write : tcp::socket::wait_read;
  co_await socket_.async_wait(side, asio::redirect_error(asio::use_awaitable, ended));
}

}  // namespace enamel::server::stations
