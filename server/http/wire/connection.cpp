#include "server/http/wire/connection.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <functional>
#include <span>
#include <string_view>
#include <utility>

#include "common/base/check.h"
#include "server/auth/address_block.h"
#include "server/http/site.h"
#include "server/http/wire/request_reader.h"
#include "server/http/wire/response_head.h"
#include "server/net/deadline.h"
#include "server/net/stream_socket.h"

namespace enamel::server::http {
namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

// A request of the page fits into one read; larger bodies take some more, bounded by their
// deadline.
constexpr size_t kReadBytes = 4096;
// An answer of this size travels with its head in one packet or a few.
constexpr size_t kJoinedBytes = 16 * 1024;
// A refused upload is read on for this much and this long, and no further.
constexpr size_t kMaxDrainBytes = 4 * kMaxBodyBytes;
constexpr std::chrono::milliseconds kDrain{1000};
// How often viewers get new events (all at the same moments), and how long nothing may be sent. The
// system buffers little for a viewer who does not read.
constexpr std::chrono::milliseconds kEventPeriod{100};
constexpr std::chrono::seconds kEventSilence{15};
constexpr int kEventSendBuffer = 64 * 1024;
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";

ByteView BytesOf(std::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// Empty when there is nothing to send yet.
std::string TextOf(const EventSource::Event& event, bool silent_for_long) {
  std::string text;
  if (event.data) text = "event: ticks\ndata: " + *event.data + "\n\n";
  if (event.last) text += "event: end\ndata: {}\n\n";
  return text.empty() && silent_for_long ? ":\n\n" : text;
}

// The next moment at which viewers get new events: the same for all of them, so that fifty viewers
// wake the server ten times a second and not five hundred times.
std::chrono::steady_clock::time_point NextEventMoment() {
  auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::steady_clock::time_point((since / kEventPeriod + 1) * kEventPeriod);
}

class HttpConnection : public AcceptedConnection,
                       public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(tcp::socket socket, std::string peer, Strand strand,
                 std::shared_ptr<ServerContext> context)
      : strand_(std::move(strand)),
        context_(std::move(context)),
        peer_(std::move(peer)),
        block_(auth::AddressBlock(peer_)),
        stream_(std::move(socket), context_->tls ? context_->tls->Now().get() : nullptr),
        deadline_(strand_) {}

  void Run(std::function<void()> on_end) override {
    auto self = shared_from_this();
    asio::co_spawn(strand_, deadline_.Watch(), [self](const std::exception_ptr&, bool passed) {
      if (passed) self->stream_.Close();
    });
    asio::co_spawn(strand_, Serve(), [self, on_end](const std::exception_ptr& failed) {
      // Such as no memory. It ends this connection and no other.
      if (failed) spdlog::error("http: a connection ended with an exception");
      self->stream_.Close();
      // Watch then returns, and lets go of the connection.
      self->deadline_.End();
      on_end();
    });
  }

  void BeginStop() override {
    asio::post(strand_, [self = shared_from_this()] {
      self->stopping_ = true;
      // A connection with a request in progress ends by itself after its answer (`keep_alive`
      // checks `stopping_`).
      if (self->idle_) self->stream_.Close();
    });
  }

  void Close() override {
    asio::post(strand_, [self = shared_from_this()] {
      self->stopping_ = true;
      self->stream_.Close();
    });
  }

  GivesWay gives_way() const override { return gives_way_; }
  const std::string& block() const override { return block_; }

 private:
  using Step = RequestReader::Step;
  using Io = StreamSocket::Io;

  const HttpDeadlines& deadlines() const { return context_->options.deadlines; }

  asio::awaitable<void> Serve();
  asio::awaitable<bool> ServeOne();
  asio::awaitable<Step> ReadRequest(RequestReader& reader, bool& late);
  asio::awaitable<bool> ReadSome();
  bool HoldBody(RequestReader& reader);
  void BreakOff(const HeldBytes::Held* given_up);
  Status TooMuchComing() const;
  asio::awaitable<bool> Write(Response& response, bool head_only, bool keep_alive);
  asio::awaitable<bool> WritePieces(const BytePieces& body);
  asio::awaitable<void> Drain();
  asio::awaitable<void> WriteEvents(Response response);

  const Strand strand_;
  const std::shared_ptr<ServerContext> context_;
  const std::string peer_, block_;
  std::atomic<GivesWay> gives_way_{GivesWay::kFirst};

  // Owned by the strand.
  StreamSocket stream_;
  Deadline deadline_;
  std::string buffer_;  // arrived and not used yet, at most kMaxHeadBytes + kReadBytes
  std::shared_ptr<HeldBytes::Held> coming_;  // of a large body that has not arrived yet
  bool broken_off_ = false;                  // that body: others have less
  bool over_budget_ = false;                 // refused for it
  bool idle_ = true;                         // between requests
  bool stopping_ = false;
};

asio::awaitable<void> HttpConnection::Serve() {
  deadline_.Allow(deadlines().handshake);
  Io io = Io::kDone;
  while ((io = stream_.Handshake()) > Io::kEnded) co_await stream_.Wait(io);
  bool open = io == Io::kDone;
  while (open && !stopping_) open = co_await ServeOne();
}

// One request and its answer. False: close the connection.
asio::awaitable<bool> HttpConnection::ServeOne() {
  ENAMEL_CHECK(strand_.running_in_this_thread());
  RequestReader reader;
  bool late = false;
  Step step = co_await ReadRequest(reader, late);
  if (late) context_->NoteRefusal(peer_, "408 a request did not arrive within its time");
  coming_.reset();
  // From here a request is being done: it is not closed for another connection.
  gives_way_ = GivesWay::kNever;
  if (step == Step::kMore) co_return false;
  const bool head_only = reader.request().method == Method::kHead;
  Response response;
  bool keep_alive = false;
  if (step == Step::kRequest) {
    Request request = std::move(reader.request());
    // Before the request leaves the strand: address and TLS are facts of the connection, and
    // nothing from the peer may replace them.
    request.peer = peer_;
    request.tls = context_->options.tls.has_value();
    // How long an answer may take is Api's to say.
    deadline_.AllowAnyTime();
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
  // A peer that does not read its answer holds a place. It gives way when others need one, but
  // after peers that have not even sent a request.
  gives_way_ = GivesWay::kAfterOthers;
  bool written = co_await Write(response, head_only, keep_alive);
  if (written && !keep_alive) co_await Drain();
  gives_way_ = GivesWay::kNever;
  if (!written) co_return false;
  co_return keep_alive;
}

// Reads until `reader` has a request or refuses it. kMore: the peer went away, or a deadline
// passed (`late`).
asio::awaitable<RequestReader::Step> HttpConnection::ReadRequest(RequestReader& reader,
                                                                 bool& late) {
  // Bytes that came behind the request before are the beginning of the next one: that wait is
  // under the head's deadline at once.
  idle_ = buffer_.empty();
  gives_way_ = GivesWay::kFirst;
  deadline_.Allow(idle_ ? deadlines().idle : deadlines().head);
  for (;;) {
    const bool in_head = reader.in_head();
    size_t used = 0;
    const Step step = reader.Feed(buffer_, used);
    buffer_.erase(0, used);
    if (step == Step::kRequest || step == Step::kRefused) co_return step;
    // Each part of a request has a deadline of its own and none is extended by a byte that
    // trickles in.
    if (in_head && !reader.in_head()) {
      deadline_.Allow(deadlines().body);
      if (!HoldBody(reader)) co_return Step::kRefused;
    }
    if (step == Step::kContinue && !co_await stream_.WriteAll(BytesOf(kContinue))) {
      co_return Step::kMore;
    }
    // A body that is all there would keep this thread until its end, and each that comes with it
    // would too: /livez, say, gets its turn in between.
    if (!reader.in_head()) co_await asio::post(strand_, asio::use_awaitable);
    const bool read = co_await ReadSome();
    if (broken_off_) {
      coming_.reset();
      over_budget_ = true;
      reader.RefuseForNow(TooMuchComing());
      co_return Step::kRefused;
    }
    if (!read) {
      // A connection that was merely kept open has done nothing wrong when it is closed.
      late = !idle_ && deadline_.passed();
      co_return Step::kMore;
    }
    if (idle_) {
      idle_ = false;
      deadline_.Allow(deadlines().head);
    }
  }
}

// Memory for a body that has only begun to come. False: too much is held for this address already.
bool HttpConnection::HoldBody(RequestReader& reader) {
  // A small one takes no more than its head may.
  if (reader.expected_bytes() <= kMaxHeadBytes) return true;
  const std::string party = auth::AddressBlock(context_->PeerOf(reader.request(), peer_));
  coming_ = context_->coming->Add(party, this, reader.expected_bytes());
  if (coming_ == nullptr) {
    over_budget_ = true;
    reader.RefuseForNow(TooMuchComing());
    return false;
  }
  coming_->OnGivenUp([weak = weak_from_this(), given_up = coming_.get()] {
    if (const auto self = weak.lock()) self->BreakOff(given_up);
  });
  return true;
}

// From any thread.
void HttpConnection::BreakOff(const HeldBytes::Held* given_up) {
  asio::post(strand_, [self = shared_from_this(), given_up] {
    if (self->coming_.get() != given_up) return;  // it has arrived meanwhile
    self->broken_off_ = true;
    error_code ignored;
    self->stream_.socket().cancel(ignored);
  });
}

Status HttpConnection::TooMuchComing() const {
  return ops::OverBudget(ops::kBodies, context_->options.budgets,
                         "too much that your address has begun to send has not arrived yet; try "
                         "again in a few seconds");
}

// Appends what has arrived to `buffer_`. False: the connection ended.
asio::awaitable<bool> HttpConnection::ReadSome() {
  const size_t had = buffer_.size();
  buffer_.resize(std::min(had + kReadBytes, kMaxHeadBytes + kReadBytes));
  const std::span<uint8_t> space{reinterpret_cast<uint8_t*>(buffer_.data()) + had,
                                 buffer_.size() - had};
  size_t n = 0;
  Io io = Io::kDone;
  while (!broken_off_ && (io = stream_.Read(space, n)) > Io::kEnded) co_await stream_.Wait(io);
  buffer_.resize(had + n);
  co_return io == Io::kDone;
}

asio::awaitable<bool> HttpConnection::Write(Response& response, bool head_only, bool keep_alive) {
  AddCommonHeaders(response, context_->secure());
  const std::string_view body = response.Body();
  // RFC 9110, 8.6: no length with 204, and with 304 it would have to be that of the 200.
  const bool sized = response.status != 204 && response.status != 304;
  std::string head =
      HeadText(response, keep_alive, sized ? std::optional(response.BodyBytes()) : std::nullopt);
  deadline_.Allow(deadlines().write);
  if (response.held) {
    response.held->OnGivenUp([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->Close();
    });
  }
  if (response.pieces && !head_only) {
    co_return co_await stream_.WriteAll(BytesOf(head)) && co_await WritePieces(*response.pieces);
  }
  if (head_only || body.empty()) co_return co_await stream_.WriteAll(BytesOf(head));
  if (body.size() <= kJoinedBytes) {
    head += body;
    co_return co_await stream_.WriteAll(BytesOf(head));
  }
  co_return co_await stream_.WriteAll(BytesOf(head)) && co_await stream_.WriteAll(BytesOf(body));
}

// Each piece has the time of a whole answer. False: the peer went away, or the body ended early. The
// peer sees an early end by the length in the head.
asio::awaitable<bool> HttpConnection::WritePieces(const BytePieces& body) {
  for (uint64_t left = body.size; left > 0;) {
    deadline_.AllowAnyTime();
    const Result<Bytes> piece = co_await context_->api->NextPiece(body);
    if (!piece.ok() || piece->empty() || piece->size() > left) {
      spdlog::error(
          "http: an answer ended {} bytes early: {}", left,
          piece.ok() ? "it is not as long as it was said to be" : piece.status().message());
      co_return false;
    }
    left -= piece->size();
    deadline_.Allow(deadlines().write);
    if (!co_await stream_.WriteAll(*piece)) co_return false;
  }
  co_return true;
}

// Ends the sending side and reads what the peer still sends for a while, so that the answer is
// not lost to a reset.
asio::awaitable<void> HttpConnection::Drain() {
  error_code ignored;
  // Without TLS's own farewell: the length in the head has said where the answer ends.
  stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
  deadline_.Allow(kDrain);
  // Whoever sends more than they may is not read on: that would cost others as much as taking it.
  if (over_budget_) {
    asio::steady_timer end(strand_, kDrain);
    co_await end.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    co_return;
  }
  for (size_t drained = 0; drained < kMaxDrainBytes;) {
    size_t n = 0;
    const Io io = stream_.Discard(n);
    if (io == Io::kEnded) break;
    drained += n;
    if (io != Io::kDone) co_await stream_.Wait(io);
  }
}

// The newest event whenever there is a new one, until either side has had enough.
asio::awaitable<void> HttpConnection::WriteEvents(Response response) {
  using Clock = std::chrono::steady_clock;
  error_code ignored;
  // Unread events are stale: the socket buffers few of them, and the newest event is sent when
  // there is room again.
  stream_.socket().set_option(asio::socket_base::send_buffer_size(kEventSendBuffer), ignored);
  AddCommonHeaders(response, context_->secure());
  const std::string head = HeadText(response, false, std::nullopt);
  deadline_.Allow(deadlines().write);
  bool open = co_await stream_.WriteAll(BytesOf(head));
  idle_ = true;  // stopping does not wait for it
  asio::steady_timer pause(strand_);
  auto end = Clock::now() + deadlines().events;
  auto last_sent = Clock::now();
  auto last_allowed = Clock::now();
  const auto over = [&] { return stopping_ || (response.school_ended && *response.school_ended); };
  while (open && !over() && Clock::now() < end) {
    // Taken as late as possible, right before it is sent: what came in between has replaced it.
    EventSource::Event event = response.events->Take();
    std::string text = TextOf(event, Clock::now() - last_sent > kEventSilence);
    if (!text.empty()) {
      last_sent = Clock::now();
      deadline_.Allow(deadlines().event);
      open = co_await stream_.WriteAll(BytesOf(text)) && !event.last;
    }
    deadline_.AllowAnyTime();
    // Also after an event that was slow to send: the next moment is on the grid, missed ones are
    // left out.
    pause.expires_at(NextEventMoment());
    co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    // Not with every event: each look asks the database for session, person, attempt and cohort.
    if (Clock::now() - last_allowed < deadlines().allowed) continue;
    bool allowed = co_await context_->api->StillAllowed(*response.events);
    if (!allowed) co_return;
    last_allowed = Clock::now();
  }
}

}  // namespace

std::shared_ptr<AcceptedConnection> MakeConnection(tcp::socket socket, std::string peer,
                                                   Strand strand,
                                                   std::shared_ptr<ServerContext> context) {
  return std::make_shared<HttpConnection>(std::move(socket), std::move(peer), std::move(strand),
                                          std::move(context));
}

}  // namespace enamel::server::http
