#include "common/net/frame_client.h"

#include <linux/sockios.h>
#include <sys/ioctl.h>

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <charconv>
#include <optional>

#include "common/protocol/frame.h"

namespace enamel::net {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using asio::ip::tcp;
using boost::system::error_code;

// The findings of the certificate check, for the message.
struct Pin {
  Sha256 expected;
  std::optional<Sha256> found;
};

// Replaces OpenSSL's whole verification: the leaf's fingerprint decides alone. It is of the whole
// certificate and not of its key, so stations must get the fingerprint of a renewed certificate
// (schemas/wire/README.md, "Transport").
int CheckPin(X509_STORE_CTX* store, void* arg) {
  Pin& pin = *static_cast<Pin*>(arg);
  Sha256 found;
  unsigned int size = 0;
  X509* leaf = X509_STORE_CTX_get0_cert(store);
  if (leaf == nullptr || X509_digest(leaf, EVP_sha256(), found.bytes.data(), &size) != 1) return 0;
  pin.found = found;
  if (found == pin.expected) return 1;
  X509_STORE_CTX_set_error(store, X509_V_ERR_CERT_UNTRUSTED);
  return 0;
}

Status Cancelled() {
  return Status(Code::kUnavailable, "the station link is shutting down", kCancelled);
}

Status NotConnected() { return Status(Code::kUnavailable, "not connected to a server"); }

Status Timeout(const std::string& what, FrameClient::Duration timeout) {
  return Status(Code::kUnavailable, what + " within " + std::to_string(timeout.count()) + " ms",
                "timeout");
}

Status Broken(const Endpoint& server, const error_code& error) {
  bool closed = error == asio::error::eof || error == ssl::error::stream_truncated ||
                error == asio::error::connection_reset || error == asio::error::broken_pipe;
  return Status(Code::kUnavailable,
                closed ? "the server " + server.Text() + " closed the connection"
                       : "connection to " + server.Text() + " failed: " + error.message());
}

Status ConnectFailed(const Endpoint& server, const error_code& error) {
  std::string what = "cannot reach " + server.Text() + ": " + error.message();
  if (error == asio::error::connection_refused) {
    what += "; nothing listens there: is enamel-server running, and is this its station port?";
  } else if (error == asio::error::host_not_found ||
             error == asio::error::host_not_found_try_again) {
    what += "; check the name of the server";
  }
  return Status(Code::kUnavailable, what);
}

Status HandshakeFailed(const Endpoint& server, const Pin& pin, const error_code& error) {
  if (pin.found && *pin.found != pin.expected) {
    return Status(Code::kUnauthenticated,
                  server.Text() +
                      " is not the server this station was enrolled with: expected the certificate "
                      "with SHA-256 fingerprint " +
                      pin.expected.Hex() + ", found " + pin.found->Hex() +
                      "; if the server's certificate was renewed, enrol the station again",
                  "fingerprint");
  }
  if (ERR_GET_LIB(static_cast<unsigned long>(error.value())) == ERR_LIB_SSL &&
      error.category() == asio::error::get_ssl_category()) {
    return Status(Code::kVersion, server.Text() + " does not speak TLS 1.3 as a station expects (" +
                                      error.message() + "); is this the server's station port?");
  }
  return Broken(server, error);
}

}  // namespace

std::string Endpoint::Text() const {
  bool v6 = host.find(':') != std::string::npos;
  return (v6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Result<Endpoint> ParseEndpoint(std::string_view text) {
  Status bad(
      Code::kInvalidInput,
      "server address: expected host:port (or [ipv6]:port) with a port of 1 to 65535, found \"" +
          std::string(text.substr(0, 128)) + "\"",
      "server");
  size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return bad;
  std::string_view host = text.substr(0, colon), digits = text.substr(colon + 1);
  bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  if (host.empty() || (!bracketed && host.find_first_of(":[] /") != std::string_view::npos))
    return bad;
  Endpoint out{std::string(host), 0};
  auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), out.port);
  if (error != std::errc() || end != digits.data() + digits.size() || out.port == 0) return bad;
  return out;
}

struct FrameClient::Impl {
  using Stream = ssl::stream<tcp::socket>;
  using Outcome = std::shared_ptr<std::optional<error_code>>;

  static Outcome NewOutcome() { return std::make_shared<std::optional<error_code>>(); }

  // Runs the I/O until `ready`, the deadline, or Cancel. False: not ready.
  template <typename Ready>
  bool RunUntil(Ready ready, std::chrono::steady_clock::time_point deadline) {
    // A context that ran out of work stays stopped until it is restarted.
    io.restart();
    // Work that can be done at once is done even after the deadline.
    while (!cancelled && !ready() && io.poll_one() > 0) {
    }
    while (!cancelled && !ready()) {
      if (io.run_one_until(deadline) == 0) break;
    }
    return !cancelled && ready();
  }

  void Drop() {
    if (!stream) return;
    error_code ignored;
    stream->next_layer().close(ignored);
    // Operations in flight end with an error now; they must be gone before the stream is.
    io.restart();
    io.poll();
    stream.reset();
    reading = false;
  }

  void StartRead() {
    if (reading || reader.done() || read_error || !refusal.ok()) return;
    reading = true;
    // Never a byte of the next frame (frame.h): what Take leaves behind begins one.
    auto space = reader.Prepare();
    stream->async_read_some(asio::buffer(space.data(), space.size()),
                            [this](error_code error, size_t n) {
                              reading = false;
                              moved = std::chrono::steady_clock::now();
                              if (error) {
                                read_error = error;
                                return;
                              }
                              refusal = reader.Resume(n);
                              if (refusal.ok()) StartRead();
                            });
  }

  // Handlers own what they write to, so that a step may be given up while a name lookup still runs.
  Status Open(const Endpoint& to, Duration timeout) {
    auto deadline = std::chrono::steady_clock::now() + timeout;
    auto late = [&] {
      return cancelled ? Cancelled() : Timeout("no answer from " + to.Text(), timeout);
    };
    auto addresses = std::make_shared<tcp::resolver::results_type>();
    tcp::resolver resolver(io);
    Outcome looked_up = NewOutcome();
    resolver.async_resolve(
        to.host, std::to_string(to.port),
        [looked_up, addresses](error_code error, tcp::resolver::results_type found) {
          *addresses = std::move(found);
          *looked_up = error;
        });
    if (!RunUntil([&] { return looked_up->has_value(); }, deadline)) return late();
    if (**looked_up) return ConnectFailed(to, **looked_up);

    Outcome connected = NewOutcome();
    asio::async_connect(
        stream->next_layer(), *addresses,
        [connected, addresses](error_code error, const tcp::endpoint&) { *connected = error; });
    if (!RunUntil([&] { return connected->has_value(); }, deadline)) return late();
    if (**connected) return ConnectFailed(to, **connected);

    error_code ignored;
    // A request waits for its reply. Nagle's algorithm would hold a small frame back until what
    // went before it is acknowledged.
    stream->next_layer().set_option(tcp::no_delay(true), ignored);
    Outcome shaken = NewOutcome();
    stream->async_handshake(Stream::client, [shaken](error_code error) { *shaken = error; });
    if (!RunUntil([&] { return shaken->has_value(); }, deadline)) return late();
    if (**shaken) return HandshakeFailed(to, pin, **shaken);
    return Status::Ok();
  }

  asio::io_context io{1};
  ssl::context context{ssl::context::tls_client};
  std::optional<Stream> stream;
  Pin pin;
  Endpoint server;
  protocol::FrameReader reader;
  bool reading = false;
  std::chrono::steady_clock::time_point moved;  // the last byte
  bool leaving = false;                         // what is answered has not left this machine yet
  int unsent = 0;                               // when silence() looked last
  std::optional<error_code> read_error;
  Status refusal;
  std::atomic<bool> cancelled{false};
};

FrameClient::FrameClient() : impl_(std::make_unique<Impl>()) {
  SSL_CTX* context = impl_->context.native_handle();
  ENAMEL_CHECK(SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION) == 1);
  // Without it OpenSSL continues the handshake whatever CheckPin returns.
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_cert_verify_callback(context, CheckPin, &impl_->pin);
}

FrameClient::~FrameClient() { Close(); }

Status FrameClient::Connect(const Endpoint& server, const Sha256& fingerprint, Duration timeout) {
  Close();
  if (impl_->cancelled) return Cancelled();
  impl_->server = server;
  impl_->pin = {fingerprint, std::nullopt};
  impl_->reader = protocol::FrameReader();
  impl_->read_error.reset();
  impl_->refusal = Status::Ok();
  impl_->stream.emplace(impl_->io, impl_->context);
  Status status = impl_->Open(server, timeout);
  impl_->moved = std::chrono::steady_clock::now();
  if (!status.ok()) impl_->Drop();
  return status;
}

Status FrameClient::Send(ByteView message, Duration timeout, bool answered) {
  if (impl_->cancelled) return Cancelled();
  if (!impl_->stream) return NotConnected();
  ENAMEL_ASSIGN_OR_RETURN(auto frame, protocol::EncodeFrame(message));
  auto sent = Impl::NewOutcome();
  asio::async_write(*impl_->stream, asio::buffer(frame),
                    [sent](error_code error, size_t) { *sent = error; });
  auto deadline = std::chrono::steady_clock::now() + timeout;
  bool done = impl_->RunUntil([&] { return sent->has_value(); }, deadline);
  if (answered) {
    impl_->leaving = true;
    impl_->moved = std::chrono::steady_clock::now();
  }
  if (done && !**sent) return Status::Ok();
  // Ends the write, which refers to the frame here.
  impl_->Drop();
  if (done) return Broken(impl_->server, **sent);
  if (impl_->cancelled) return Cancelled();
  return Timeout(
      "could not send " + std::to_string(message.size()) + " bytes to " + impl_->server.Text(),
      timeout);
}

Result<Bytes> FrameClient::Receive(Duration timeout) {
  if (impl_->cancelled) return Cancelled();
  if (!impl_->stream) return NotConnected();
  Impl& i = *impl_;
  i.StartRead();
  auto settled = [&] { return i.reader.done() || i.read_error || !i.refusal.ok(); };
  bool in_time = i.RunUntil(settled, std::chrono::steady_clock::now() + timeout);
  // Even after the deadline or Cancel: a whole message is not thrown away.
  if (i.reader.done()) return i.reader.Take();
  if (!in_time) {
    if (i.cancelled) return Cancelled();
    return Timeout("no message from " + i.server.Text(), timeout);
  }
  Status status = i.read_error ? Broken(i.server, *i.read_error) : i.refusal;
  i.Drop();
  return status;
}

FrameClient::Duration FrameClient::silence() {
  Impl& i = *impl_;
  const auto now = std::chrono::steady_clock::now();
  int unsent = 0;
  if (i.stream) ::ioctl(i.stream->next_layer().native_handle(), SIOCOUTQ, &unsent);
  if (i.leaving && unsent < i.unsent) i.moved = now;
  i.leaving = i.leaving && unsent > 0;
  i.unsent = unsent;
  return std::chrono::duration_cast<Duration>(now - i.moved);
}

void FrameClient::Close() {
  if (!impl_->stream) return;
  // One attempt without waiting: close_notify tells the server that this is an end, not a break.
  impl_->stream->async_shutdown([](error_code) {});
  impl_->io.restart();
  impl_->io.poll();
  impl_->Drop();
}

bool FrameClient::connected() const { return impl_->stream.has_value(); }

void FrameClient::Cancel() {
  impl_->cancelled = true;
  // Wakes the call in progress, which then looks at the flag. Not stop(): handlers must still be
  // run.
  asio::post(impl_->io, [] {});
}

}  // namespace enamel::net
