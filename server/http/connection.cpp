#include "server/http/connection.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <functional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "common/base/check.h"
#include "server/auth/address_block.h"
#include "server/http/request_reader.h"
#include "server/http/site.h"

namespace enamel::server::http {
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace bhttp = boost::beast::http;
using asio::ip::tcp;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

namespace {

constexpr auto kNoThrow = asio::as_tuple(asio::use_awaitable);
auto Into(beast::error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }
// A request of the page fits into one read; larger bodies take some more, bounded by their
// deadline.
constexpr size_t kReadBytes = 4096;
// A refused upload is read on for this much and this long, and no further.
constexpr size_t kMaxDrainBytes = 4 * kMaxBodyBytes;
constexpr std::chrono::milliseconds kDrain{1000};
// How often a viewer is shown what is new (all viewers at the same moments), and how long nothing
// may be sent. The system keeps little for a viewer who does not read.
constexpr std::chrono::milliseconds kEventPeriod{100};
constexpr std::chrono::seconds kEventSilence{15};
constexpr int kEventSendBuffer = 64 * 1024;
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";

std::string_view View(const beast::flat_buffer& buffer) {
  return {static_cast<const char*>(buffer.data().data()), buffer.size()};
}

// Empty when there is nothing to send yet.
std::string TextOf(const EventSource::Event& event, bool silent_for_long) {
  std::string text;
  if (event.data) text = "event: ticks\ndata: " + *event.data + "\n\n";
  if (event.last) text += "event: end\ndata: {}\n\n";
  return text.empty() && silent_for_long ? ":\n\n" : text;
}

// The next moment at which viewers are shown what is new: the same for all of them, so that fifty
// viewers wake the server ten times a second and not five hundred times.
std::chrono::steady_clock::time_point NextEventMoment() {
  auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::steady_clock::time_point((since / kEventPeriod + 1) * kEventPeriod);
}

// Status, headers and what every answer has; the body is the caller's.
template <typename Body>
bhttp::response<Body> HeadOf(Response& response, bool keep_alive, bool secure) {
  AddCommonHeaders(response, secure);
  bhttp::response<Body> message;
  message.version(11);
  message.result(static_cast<unsigned>(response.status));
  for (const auto& [name, value] : response.headers) message.insert(name, value);
  if (!response.content_type.empty()) {
    message.set(bhttp::field::content_type, response.content_type);
  }
  message.keep_alive(keep_alive);
  return message;
}

template <typename Stream>
class StreamConnection : public AcceptedConnection,
                         public std::enable_shared_from_this<StreamConnection<Stream>> {
 public:
  // `how`: what the stream is made of.
  template <typename... How>
  StreamConnection(std::string peer, Strand strand, std::shared_ptr<ServerContext> context,
                   How&&... how)
      : strand_(std::move(strand)),
        context_(std::move(context)),
        peer_(std::move(peer)),
        block_(auth::AddressBlock(peer_)),
        stream_(std::forward<How>(how)...) {}

  void Run(std::function<void()> on_end) override {
    asio::co_spawn(strand_, Serve(),
                   [self = this->shared_from_this(), on_end](const std::exception_ptr& failed) {
                     // Such as no memory. It ends this connection and no other.
                     if (failed) spdlog::error("http: a connection ended with an exception");
                     self->CloseStream();
                     on_end();
                   });
  }

  void BeginStop() override {
    asio::post(strand_, [self = this->shared_from_this()] {
      self->stopping_ = true;
      // One that is doing a request ends by itself after its answer (`keep_alive` looks at
      // `stopping_`).
      if (self->idle_) self->CloseStream();
    });
  }

  void Close() override {
    asio::post(strand_, [self = this->shared_from_this()] {
      self->stopping_ = true;
      self->CloseStream();
    });
  }

  GivesWay gives_way() const override { return gives_way_; }
  const std::string& block() const override { return block_; }

 private:
  using Step = RequestReader::Step;

  beast::tcp_stream& lowest() { return beast::get_lowest_layer(stream_); }
  const HttpDeadlines& deadlines() const { return context_->options.deadlines; }

  void CloseStream() {
    ENAMEL_CHECK(strand_.running_in_this_thread());
    lowest().close();
  }

  asio::awaitable<void> Serve() {
    if constexpr (std::is_same_v<Stream, TlsStream>) {
      lowest().expires_after(deadlines().handshake);
      auto [error] = co_await stream_.async_handshake(asio::ssl::stream_base::server, kNoThrow);
      if (error) co_return;
    }
    bool open = true;
    while (open && !stopping_) open = co_await ServeOne();
  }

  // One request and its answer. False: close the connection.
  asio::awaitable<bool> ServeOne() {
    ENAMEL_CHECK(strand_.running_in_this_thread());
    RequestReader reader;
    bool late = false;
    Step step = co_await ReadRequest(reader, late);
    if (late) context_->NoteRefusal(peer_, "408 a request did not arrive within its time");
    // From here a request is being done: it is not closed for another connection.
    gives_way_ = GivesWay::kNever;
    if (step == Step::kMore) co_return false;
    const bool head_only = reader.request().method == Method::kHead;
    Response response;
    bool keep_alive = false;
    if (step == Step::kRequest) {
      Request request = std::move(reader.request());
      // Before the request leaves the strand: address and TLS are facts of the connection, and
      // nothing the peer wrote may stand in for them.
      request.peer = peer_;
      request.tls = context_->options.tls.has_value();
      response = co_await context_->Answer(std::move(request));
      keep_alive = reader.keep_alive() && !stopping_;
    } else {
      response = std::move(reader.refusal());
      context_->NoteRefusal(peer_, std::to_string(response.status) + " " + response.body);
    }
    if (response.events && !head_only) {
      co_await WriteEvents(std::move(response));
      co_return false;
    }
    // A peer who does not take its answer holds a place; it goes when others need one, but after
    // those who have not even asked.
    gives_way_ = GivesWay::kAfterOthers;
    bool written = co_await Write(response, head_only, keep_alive);
    if (written && !keep_alive) co_await Drain();
    gives_way_ = GivesWay::kNever;
    if (!written) co_return false;
    co_return keep_alive;
  }

  // Reads until `reader` has a request or refuses it. kMore: the peer went away, or a deadline
  // passed (`late`).
  asio::awaitable<Step> ReadRequest(RequestReader& reader, bool& late) {
    // Bytes that came behind the request before are the beginning of the next one: that wait is
    // under the head's deadline at once.
    idle_ = buffer_.size() == 0;
    gives_way_ = GivesWay::kFirst;
    lowest().expires_after(idle_ ? deadlines().idle : deadlines().head);
    for (;;) {
      bool in_head = reader.in_head();
      size_t used = 0;
      Step step = reader.Feed(View(buffer_), used);
      buffer_.consume(used);
      if (step == Step::kRequest || step == Step::kRefused) co_return step;
      // Each part of a request has a deadline of its own and none is extended by a byte that
      // trickles in.
      if (in_head && !reader.in_head()) lowest().expires_after(deadlines().body);
      beast::error_code error;
      if (step == Step::kContinue) {
        co_await asio::async_write(stream_, asio::buffer(kContinue), Into(error));
        if (error) co_return Step::kMore;
      }
      size_t count = co_await stream_.async_read_some(
          buffer_.prepare(std::min(kReadBytes, buffer_.max_size() - buffer_.size())), Into(error));
      // A connection that was merely kept open has done nothing wrong when it is closed.
      late = !idle_ && error == beast::error::timeout;
      if (error) co_return Step::kMore;
      buffer_.commit(count);
      if (idle_) {
        idle_ = false;
        lowest().expires_after(deadlines().head);
      }
    }
  }

  asio::awaitable<bool> Write(Response& response, bool head_only, bool keep_alive) {
    using Body = bhttp::span_body<const char>;
    auto message = HeadOf<Body>(response, keep_alive, context_->secure());
    std::string_view body = response.Body();
    // RFC 9110, 8.6: none with 204, and with 304 it would have to be that of the 200.
    if (response.status != 204 && response.status != 304) message.content_length(body.size());
    if (!head_only) message.body() = {body.data(), body.size()};
    bhttp::response_serializer<Body> serializer(message);
    lowest().expires_after(deadlines().write);
    auto [error, count] = co_await bhttp::async_write(stream_, serializer, kNoThrow);
    co_return !error;
  }

  // Ends the sending side and reads what the peer still sends for a while, so that the answer is
  // not lost to a reset.
  asio::awaitable<void> Drain() {
    beast::error_code ignored;
    // Without TLS's own farewell: the length in the head has said where the answer ends.
    lowest().socket().shutdown(tcp::socket::shutdown_send, ignored);
    lowest().expires_after(kDrain);
    buffer_.clear();
    for (size_t drained = 0; drained < kMaxDrainBytes;) {
      auto [error, count] =
          co_await lowest().async_read_some(buffer_.prepare(kReadBytes), kNoThrow);
      if (error) break;
      drained += count;
    }
  }

  asio::awaitable<bool> WriteEventsHead(Response& response) {
    auto message = HeadOf<bhttp::empty_body>(response, false, context_->secure());
    bhttp::response_serializer<bhttp::empty_body> serializer(message);
    lowest().expires_after(deadlines().write);
    auto [error, count] = co_await bhttp::async_write_header(stream_, serializer, kNoThrow);
    co_return !error;
  }

  // The newest event whenever there is a new one, until either side has had enough.
  asio::awaitable<void> WriteEvents(Response response) {
    using Clock = std::chrono::steady_clock;
    beast::error_code ignored;
    // What a viewer has not read is stale: little of it is kept, and the newest event is taken when
    // there is room again.
    lowest().socket().set_option(asio::socket_base::send_buffer_size(kEventSendBuffer), ignored);
    bool open = co_await WriteEventsHead(response);
    idle_ = true;  // stopping does not wait for it
    asio::steady_timer pause(strand_);
    auto end = Clock::now() + deadlines().events;
    auto last_sent = Clock::now();
    auto last_allowed = Clock::now();
    const auto over = [&] {
      return stopping_ || (response.school_ended && *response.school_ended);
    };
    while (open && !over() && Clock::now() < end) {
      // Taken as late as possible, right before it is sent: what came in between has replaced it.
      EventSource::Event event = response.events->Take();
      std::string text = TextOf(event, Clock::now() - last_sent > kEventSilence);
      if (!text.empty()) {
        last_sent = Clock::now();
        lowest().expires_after(deadlines().event);
        auto [error, count] = co_await asio::async_write(stream_, asio::buffer(text), kNoThrow);
        open = !error && !event.last;
      }
      // Also after an event that was slow to send: the next moment is on the grid, missed ones are
      // left out.
      pause.expires_at(NextEventMoment());
      co_await pause.async_wait(kNoThrow);
      // Not with every event: each look asks the database for session, person, attempt and cohort.
      if (Clock::now() - last_allowed < deadlines().allowed) continue;
      bool allowed = co_await context_->api->StillAllowed(*response.events);
      if (!allowed) co_return;
      last_allowed = Clock::now();
    }
  }

  const Strand strand_;
  const std::shared_ptr<ServerContext> context_;
  const std::string peer_, block_;
  std::atomic<GivesWay> gives_way_{GivesWay::kFirst};

  // Owned by the strand.
  Stream stream_;
  beast::flat_buffer buffer_{kMaxHeadBytes + kReadBytes};
  bool idle_ = true;  // between requests
  bool stopping_ = false;
};

}  // namespace

std::shared_ptr<AcceptedConnection> MakeConnection(tcp::socket socket, std::string peer,
                                                   Strand strand,
                                                   std::shared_ptr<ServerContext> context) {
  ServerContext& its = *context;
  beast::tcp_stream plain(std::move(socket));
  if (!its.tls) {
    return std::make_shared<StreamConnection<beast::tcp_stream>>(
        std::move(peer), std::move(strand), std::move(context), std::move(plain));
  }
  return std::make_shared<StreamConnection<TlsStream>>(
      std::move(peer), std::move(strand), std::move(context), std::move(plain), *its.tls);
}

}  // namespace enamel::server::http
