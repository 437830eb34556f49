#pragma once

#include <openssl/ssl.h>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <span>

#include "common/base/bytes.h"

namespace enamel::server::stations {

// The server's end of TLS on a socket, without buffers of its own between the two: OpenSSL reads
// and writes the socket, and what cannot be done at once says what to wait for. While nothing
// happens a connection holds neither a record buffer nor a BIO pair (boost::asio::ssl::stream keeps
// 68 KiB of them), and a frame that has arrived is read without a turn through the scheduler.
//
//   size_t n; Io io;
//   while ((io = socket.Read(space, n)) > Io::kEnded) co_await socket.Wait(io);
//
// Thread safety: the socket's strand.
class TlsSocket {
 public:
  // kDone: something was done. kEnded: the connection is over, in whatever way. The others: wait.
  enum class Io { kDone, kEnded, kWantRead, kWantWrite };

  // `context` outlives it.
  TlsSocket(boost::asio::ip::tcp::socket socket, SSL_CTX* context);

  Io Handshake();
  // `n`: bytes read or written, at least one with kDone. Requires: not empty.
  Io Read(std::span<uint8_t> space, size_t& n);
  Io Write(ByteView bytes, size_t& n);
  // Says that nothing more will be sent.
  Io Shutdown();

  // Returns when it is worth trying again, and when the socket was cancelled or closed.
  boost::asio::awaitable<void> Wait(Io what);

  boost::asio::ip::tcp::socket& socket() { return socket_; }

 private:
  struct FreeSsl {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  Io Outcome(int rc) const;

  boost::asio::ip::tcp::socket socket_;
  std::unique_ptr<SSL, FreeSsl> ssl_;
};

}  // namespace enamel::server::stations
