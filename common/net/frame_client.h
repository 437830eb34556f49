#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"

namespace enamel::net {

// Field of the errors of what was ended by Cancel.
inline constexpr char kCancelled[] = "cancelled";

struct Endpoint {
  std::string host;  // name or numeric address, IPv6 without brackets
  uint16_t port = 0;

  std::string Text() const;  // "host:port", "[::1]:7443"
};
// "host:port" or "[v6]:port". Errors: kInvalidInput.
Result<Endpoint> ParseEndpoint(std::string_view text);

// A station's end of the link: whole messages over TLS 1.3 to a server known by the fingerprint of
// its certificate. Blocking with deadlines; for the uplink thread and for commands.
//
// The fingerprint is all that is checked: neither names nor dates nor an authority. TLS proves that
// the server has the certificate's key. Thread safety: one thread uses it; only Cancel may be
// called from another. Real-time: never.
class FrameClient {
 public:
  using Duration = std::chrono::milliseconds;

  FrameClient();
  ~FrameClient();
  FrameClient(const FrameClient&) = delete;
  FrameClient& operator=(const FrameClient&) = delete;

  // Resolves, connects and shakes hands within `timeout` in all. An open connection is closed
  // first. Errors: kUnavailable (name not known, refused, timeout: later may help),
  // kUnauthenticated (another certificate; message with both fingerprints: trying again does not
  // help), kVersion (no TLS 1.3 there).
  Status Connect(const Endpoint& server, const Sha256& fingerprint, Duration timeout);

  // Sends one message as a frame. When it could not be handed to the system within `timeout` the
  // connection is closed. Errors: kUnavailable, kTooLarge over protocol::kMaxFrameBytes (still
  // open).
  // `answered`: the server owes an answer to it, so silence() counts from zero again.
  Status Send(ByteView message, Duration timeout = std::chrono::seconds(10), bool answered = true);

  // The next message. With a timeout of zero: a message already received, else one that can be read
  // without waiting. A timeout leaves the connection usable, even in the middle of a message: the
  // next Receive continues there. Errors: kUnavailable "timeout" (field() == "timeout"),
  // kUnavailable (closed or broken), kTooLarge (then closed).
  Result<Bytes> Receive(Duration timeout);

  // How long no byte has come since all that is answered has left this machine. On a slow line that
  // is long after Send.
  Duration silence();

  // Ends the connection: TLS close_notify if it can be sent at once, then the socket. Idempotent.
  void Close();
  bool connected() const;

  // From any thread: the call in progress and all later ones return kUnavailable. For shutting
  // down.
  void Cancel();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A Receive that found nothing in time, as opposed to a broken connection.
inline bool IsTimeout(const Status& status) {
  return status.code() == Code::kUnavailable && status.field() == "timeout";
}

}  // namespace enamel::net
