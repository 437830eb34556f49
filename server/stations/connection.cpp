#include "server/stations/connection.h"

#include <spdlog/spdlog.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

namespace enamel::server::stations {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds kGoodbye{2'000};

std::string PeerAddress(const asio::ip::tcp::socket& socket) {
  error_code error;
  auto endpoint = socket.remote_endpoint(error);
  return error ? std::string("unknown") : endpoint.address().to_string();
}

}  // namespace

Connection::Connection(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> tls,
                       const LinkDeadlines& deadlines, Services& services, StorePool& pool)
    : tls_(std::move(tls)),
      deadlines_(deadlines),
      pool_(pool),
      stream_(std::move(socket), *tls_),
      deadline_(stream_.get_executor()),
      reader_(protocol::kMaxFrameBytesBeforeHello),
      session_(services, PeerAddress(stream_.next_layer())) {}

void Connection::Run(std::function<void()> on_end) {
  auto self = shared_from_this();
  Allow(deadlines_.introduction);
  asio::co_spawn(stream_.get_executor(), Watch(), [self](std::exception_ptr) {});
  asio::co_spawn(stream_.get_executor(), Serve(), [self, on_end](std::exception_ptr failure) {
    if (failure) spdlog::error("station link: a connection ended by an exception");
    self->ended_ = true;
    self->CloseSocket();
    self->deadline_.cancel();
    on_end();
  });
}

void Connection::BeginStop() {
  asio::post(stream_.get_executor(), [self = shared_from_this()] {
    self->stopping_ = true;
    error_code ignored;
    if (self->waiting_for_frame_) self->stream_.next_layer().cancel(ignored);
  });
}

void Connection::Close() {
  asio::post(stream_.get_executor(), [self = shared_from_this()] { self->CloseSocket(); });
}

void Connection::CloseSocket() {
  error_code ignored;
  stream_.next_layer().close(ignored);
}

// Moving the deadline cancels the wait with an error; only a wait that ran out closes the socket.
asio::awaitable<void> Connection::Watch() {
  while (!ended_) {
    error_code moved;
    co_await deadline_.async_wait(asio::redirect_error(asio::use_awaitable, moved));
    if (!moved && deadline_.expiry() <= std::chrono::steady_clock::now()) {
      CloseSocket();
      co_return;
    }
  }
}

asio::awaitable<void> Connection::Serve() {
  error_code error;
  co_await stream_.async_handshake(Stream::server,
                                   asio::redirect_error(asio::use_awaitable, error));
  if (error) co_return;
  co_await ServeRequests();
  Allow(deadlines_.work);
  co_await pool_.Run([this] {
    session_.End();
    return true;
  });
  Allow(kGoodbye);
  co_await stream_.async_shutdown(asio::redirect_error(asio::use_awaitable, error));
}

asio::awaitable<void> Connection::ServeRequests() {
  for (;;) {
    auto frame = co_await ReadFrame();
    if (stopping_) {
      co_await Refuse(Status(Code::kUnavailable, "the server is shutting down; come back later"));
      co_return;
    }
    if (!frame.ok()) {
      if (frame.status().code() == Code::kTooLarge) co_await Refuse(frame.status());
      co_return;
    }
    auto request = protocol::ParseRequest(*frame);
    if (!request.ok()) {
      co_await Refuse(request.status());
      co_return;
    }
    introduced_ = true;
    Answer answer = co_await Carry(*request);
    if (session_.welcomed()) reader_.set_limit(protocol::kMaxFrameBytes);
    if (answer.reply && !co_await Write(std::move(*answer.reply))) co_return;
    if (answer.close) co_return;
  }
}

asio::awaitable<Answer> Connection::Carry(const wire::Request& request) {
  Allow(deadlines_.work);
  if (auto who = session_.SignInWanted(request)) {
    auto signed_in = co_await session_.authenticator().SignIn(std::move(*who));
    co_return co_await pool_.Run([&] { return session_.FinishSignIn(request, signed_in); });
  }
  co_return co_await pool_.Run([&] { return session_.Handle(request); });
}

// kUnavailable: the connection ended. kTooLarge: the frame is over the limit.
asio::awaitable<Result<Bytes>> Connection::ReadFrame() {
  if (introduced_) Allow(deadlines_.idle);
  while (!reader_.done()) {
    auto space = reader_.Prepare();
    waiting_for_frame_ = reader_.at_boundary();
    if (stopping_ && waiting_for_frame_) co_return Status(Code::kUnavailable, "stopping");
    error_code error;
    size_t n = co_await stream_.async_read_some(asio::buffer(space.data(), space.size()),
                                                asio::redirect_error(asio::use_awaitable, error));
    bool first_bytes = waiting_for_frame_;
    waiting_for_frame_ = false;
    if (error) co_return Status(Code::kUnavailable, "connection ended");
    if (Status status = reader_.Resume(n); !status.ok()) co_return status;
    if (first_bytes && introduced_) Allow(deadlines_.frame);
  }
  co_return reader_.Take();
}

asio::awaitable<bool> Connection::Write(wire::Reply reply) {
  auto frame = protocol::EncodeFrame(protocol::Serialize(reply));
  if (!frame.ok()) {
    spdlog::error("station link: a reply could not be framed: {}", frame.status().message());
    co_return false;
  }
  Allow(deadlines_.write);
  error_code error;
  co_await asio::async_write(stream_, asio::buffer(*frame),
                             asio::redirect_error(asio::use_awaitable, error));
  co_return !error;
}

asio::awaitable<void> Connection::Refuse(Status status) {
  wire::Reply reply;
  *reply.mutable_error() = protocol::ToError(status);
  co_await Write(std::move(reply));
}

}  // namespace enamel::server::stations
