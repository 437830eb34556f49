#pragma once

#include <openssl/ssl.h>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <span>

#include "common/base/bytes.h"

namespace enamel::server {

// The server's end of a TCP connection, with TLS or without. It has no buffers of its own: OpenSSL
// reads and writes the socket, and an operation that cannot finish at once returns the event to
// wait for. An idle connection therefore holds neither a record buffer nor a BIO pair
// (boost::asio::ssl::stream keeps 68 KiB of them), and bytes that have arrived are read without a
// turn through the scheduler.
//
//   size_t n; Io io;
//   while ((io = socket.Read(space, n)) > Io::kEnded) co_await socket.Wait(io);
//
// Both links use this one type, so Asio's stream templates are compiled for neither. Thread safety:
// the socket's strand.
class StreamSocket {
 public:
  // kDone: something was done. kEnded: the connection is over, for whatever reason. The others:
  // wait.
  enum class Io { kDone, kEnded, kWantRead, kWantWrite };

  // Keeps `tls` as long as it lives; null: plain TCP.
  StreamSocket(boost::asio::ip::tcp::socket socket, SSL_CTX* tls);

  // With plain TCP Handshake and Shutdown have nothing to do and return kDone.
  Io Handshake();
  // A peer that sends without an end gets its turn among others: after kTurnBytes Read and Discard ask
  // to wait, and Wait lets the others of the executor go first.
  static constexpr size_t kTurnBytes = size_t{64} << 10;
  // `n`: bytes read or written, at least one with kDone. Requires: not empty. After Write has asked
  // to wait, the next Write must be given the same bytes.
  Io Read(std::span<uint8_t> space, size_t& n);
  Io Write(ByteView bytes, size_t& n);
  // Tells the peer that nothing more will be sent.
  Io Shutdown();

  // Returns when it is worth trying again, and when the socket was cancelled or closed.
  boost::asio::awaitable<void> Wait(Io what);
  // Writes all of `bytes`, which must stay as they are until then. False: the connection ended.
  boost::asio::awaitable<bool> WriteAll(ByteView bytes);

  // Reads and drops the peer's remaining bytes, without TLS: their meaning no longer matters.
  Io Discard(size_t& n);

  boost::asio::ip::tcp::socket& socket() { return socket_; }
  void Close();

 private:
  bool TurnIsOver();
  struct FreeSsl {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  Io Outcome(int rc) const;

  boost::asio::ip::tcp::socket socket_;
  const bool plain_;
  std::unique_ptr<SSL, FreeSsl> ssl_;
  size_t turn_bytes_ = 0;   // read since the last wait
  bool turn_over_ = false;  // Wait only lets others go first
};

}  // namespace enamel::server
