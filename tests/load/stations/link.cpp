#include "tests/load/stations/link.h"

#include <netdb.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/x509.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace enamel::load {
namespace {

bool HasFingerprint(SSL* ssl, const Sha256& expected) {
  std::unique_ptr<X509, decltype(&X509_free)> leaf(SSL_get1_peer_certificate(ssl), X509_free);
  Sha256 found;
  unsigned size = 0;
  return leaf && X509_digest(leaf.get(), EVP_sha256(), found.bytes.data(), &size) == 1 &&
         found == expected;
}

}  // namespace

Result<LinkTarget> TargetOf(const net::Endpoint& server, const Sha256& fingerprint) {
  LinkTarget out;
  addrinfo* found = nullptr;
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  int error =
      ::getaddrinfo(server.host.c_str(), std::to_string(server.port).c_str(), &hints, &found);
  if (error != 0) {
    return Status(Code::kUnavailable,
                  "cannot find " + server.Text() + ": " + ::gai_strerror(error));
  }
  std::memcpy(&out.address, found->ai_addr, found->ai_addrlen);
  out.address_size = found->ai_addrlen;
  ::freeaddrinfo(found);
  out.fingerprint = fingerprint;
  out.tls = std::shared_ptr<SSL_CTX>(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  SSL_CTX_set_min_proto_version(out.tls.get(), TLS1_3_VERSION);
  SSL_CTX_set_mode(out.tls.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_RELEASE_BUFFERS |
                                      SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_session_cache_mode(out.tls.get(), SSL_SESS_CACHE_OFF);
  return out;
}

void Link::Open() {
  Close();
  problem_.clear();
  reader_ = protocol::FrameReader();
  socket_ = ::socket(target_.address.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) return Fail(std::strerror(errno));
  int on = 1;
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  int rc =
      ::connect(socket_, reinterpret_cast<const sockaddr*>(&target_.address), target_.address_size);
  if (rc != 0 && errno != EINPROGRESS) return Fail(std::strerror(errno));
  ssl_.reset(SSL_new(target_.tls.get()));
  SSL_set_fd(ssl_.get(), socket_);
  SSL_set_connect_state(ssl_.get());
  state_ = State::kOpening;
  epoll_event event{};
  event.events = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET;
  event.data.u64 = tag_;
  if (::epoll_ctl(epoll_, EPOLL_CTL_ADD, socket_, &event) != 0) Fail(std::strerror(errno));
}

void Link::Advance() {
  if (state_ == State::kOpening) ShakeHands();
  if (state_ == State::kOpen) Flush();
}

void Link::ShakeHands() {
  ERR_clear_error();
  int rc = SSL_do_handshake(ssl_.get());
  if (rc != 1) {
    int why = SSL_get_error(ssl_.get(), rc);
    if (why != SSL_ERROR_WANT_READ && why != SSL_ERROR_WANT_WRITE) Fail("no TLS with the server");
    return;
  }
  if (!HasFingerprint(ssl_.get(), target_.fingerprint)) return Fail("another certificate");
  state_ = State::kOpen;
}

void Link::Send(ByteView message) {
  auto frame = protocol::EncodeFrame(message);
  if (frame.ok()) SendRaw(*frame);
}

void Link::SendRaw(ByteView bytes) {
  if (state_ != State::kOpen) return;
  queued_ += bytes.size();
  out_.insert(out_.end(), bytes.begin(), bytes.end());
  Flush();
}

void Link::Flush() {
  while (out_at_ < out_.size()) {
    ERR_clear_error();
    int n = SSL_write(ssl_.get(), out_.data() + out_at_, static_cast<int>(out_.size() - out_at_));
    if (n <= 0) {
      int why = SSL_get_error(ssl_.get(), n);
      if (why != SSL_ERROR_WANT_READ && why != SSL_ERROR_WANT_WRITE) Fail("connection lost");
      return;
    }
    out_at_ += static_cast<size_t>(n);
    written_ += static_cast<uint64_t>(n);
  }
  out_.clear();
  out_at_ = 0;
}

bool Link::NextMessage(Bytes& message) {
  while (state_ == State::kOpen && !reader_.done()) {
    auto space = reader_.Prepare();
    ERR_clear_error();
    int n = SSL_read(ssl_.get(), space.data(), static_cast<int>(space.size()));
    if (n <= 0) {
      int why = SSL_get_error(ssl_.get(), n);
      if (why != SSL_ERROR_WANT_READ && why != SSL_ERROR_WANT_WRITE) Fail("connection ended");
      return false;
    }
    if (!reader_.Resume(static_cast<size_t>(n)).ok()) Fail("frame over the limit");
  }
  if (state_ != State::kOpen) return false;
  message = reader_.Take();
  return true;
}

void Link::Fail(const std::string& why) {
  Close(true);
  problem_ = why;
}

void Link::Close(bool reset) {
  state_ = State::kClosed;
  if (socket_ >= 0) {
    if (reset) {
      linger at_once{1, 0};
      ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    } else if (ssl_ && SSL_is_init_finished(ssl_.get())) {
      ERR_clear_error();
      SSL_shutdown(ssl_.get());
    }
    ::close(socket_);
  }
  socket_ = -1;
  ssl_.reset();
  out_.clear();
  out_at_ = 0;
  queued_ = written_ = 0;
}

}  // namespace enamel::load
