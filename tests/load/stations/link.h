#pragma once

#include <openssl/ssl.h>
#include <sys/socket.h>

#include <memory>
#include <string>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/net/frame_client.h"
#include "common/protocol/frame.h"

namespace enamel::load {

// The target of all links of a load, resolved once. The server is identified by its certificate's
// fingerprint.
struct LinkTarget {
  sockaddr_storage address{};
  socklen_t address_size = 0;
  Sha256 fingerprint;
  std::shared_ptr<SSL_CTX> tls;
};
// Errors: kUnavailable for an unknown name.
Result<LinkTarget> TargetOf(const net::Endpoint& server, const Sha256& fingerprint);

// One station's TLS connection without its own threads or buffers: OpenSSL on a non-blocking socket
// that the caller's epoll watches, edge-triggered. Cheap, so that a thousand of them leave the
// processor to the server. Thread safety: none.
class Link {
 public:
  enum class State { kClosed, kOpening, kOpen };

  // `tag` comes back in epoll_event.data.u64.
  Link(const LinkTarget& target, int epoll, uint64_t tag)
      : target_(target), epoll_(epoll), tag_(tag) {}
  ~Link() { Close(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void Open();
  // Call on an epoll event: continues the handshake and writing. NextMessage reads.
  void Advance();
  // Frames it and writes as much as the system accepts; the rest at the next Advance.
  void Send(ByteView message);
  // Raw bytes without a frame: for messages no station would send.
  void SendRaw(ByteView bytes);
  // A whole message, if there is one; call until there is none.
  bool NextMessage(Bytes& message);
  // `reset`: ends it abruptly, like a pulled cable; else with close_notify.
  void Close(bool reset = false);

  State state() const { return state_; }
  // Bytes of frames passed to Send, and the part the system has accepted.
  uint64_t queued() const { return queued_; }
  uint64_t written() const { return written_; }
  const std::string& problem() const { return problem_; }  // why it closed, for people

 private:
  struct FreeSsl {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  void ShakeHands();
  void Flush();
  void Fail(const std::string& why);

  const LinkTarget& target_;
  const int epoll_;
  const uint64_t tag_;
  State state_ = State::kClosed;
  int socket_ = -1;
  std::unique_ptr<SSL, FreeSsl> ssl_;
  protocol::FrameReader reader_;
  Bytes out_;
  size_t out_at_ = 0;
  uint64_t queued_ = 0, written_ = 0;
  std::string problem_;
};

}  // namespace enamel::load
