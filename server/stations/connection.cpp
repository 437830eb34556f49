#include "server/stations/connection.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <limits>

#include "server/auth/address_block.h"

namespace enamel::server::stations {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds kGoodbye{2'000};
constexpr size_t kAsManyAsThere = std::numeric_limits<size_t>::max();
// A station is charged so much for a frame, for a handshake, and for a request in the store. A short
// request still takes the disk, and a long one may only have waited for others.
constexpr std::chrono::microseconds kFrameTime{100}, kLinkTime{2'000}, kMinTime{1'000},
    kMaxTime{100'000};
// Below this a timer costs more than it spares.
constexpr std::chrono::milliseconds kShortestRest{1};

// Then the message names files and tables, which are for the server's log alone.
bool IsOurFault(const wire::Error& error) {
  return error.code() == CodeName(Code::kStorage) || error.code() == CodeName(Code::kInternal);
}

}  // namespace

Connection::Connection(asio::ip::tcp::socket socket, Strand strand, std::string peer, SSL_CTX* tls,
                       const LinkDeadlines& deadlines, Services& services, OtherSchools* others,
                       StorePool& pool, LinkBudget& budget, ops::RepeatLog& refusals)
    : strand_(std::move(strand)),
      deadlines_(deadlines),
      pool_(pool),
      budget_(budget),
      refusals_(refusals),
      stream_(std::move(socket), tls),
      deadline_(strand_),
      // A peer that is nobody yet gets no 4 MiB of memory.
      reader_(protocol::kMaxFrameBytesBeforeHello),
      peer_(std::move(peer)),
      block_(auth::AddressBlock(peer_)),
      own_(services),
      others_(others),
      party_(block_) {}

void Connection::Run(std::function<void()> on_end) {
  auto self = shared_from_this();
  // One deadline for handshake and first message together: a peer cannot hold a place by being slow
  // in parts.
  deadline_.Allow(deadlines_.introduction);
  asio::co_spawn(strand_, deadline_.Watch(), [self](std::exception_ptr, bool passed) {
    if (passed) self->stream_.Close();
  });
  asio::co_spawn(strand_, Serve(), [self, on_end](std::exception_ptr failure) {
    if (failure) spdlog::error("station link: a connection ended by an exception");
    self->stream_.Close();
    // Watch then returns, and lets go of the connection.
    self->deadline_.End();
    on_end();
  });
}

void Connection::BeginStop() {
  asio::post(strand_, [self = shared_from_this()] {
    self->End(Status(Code::kUnavailable, "the server is shutting down; try again later"));
  });
}

void Connection::EndIfRevoked(std::shared_ptr<const std::set<StationOfSchool>> revoked) {
  asio::post(strand_, [self = shared_from_this(), revoked] {
    if (self->station_ && revoked->contains(*self->station_)) self->End(RevokedStation());
  });
}

void Connection::EndForNewer() {
  asio::post(strand_, [self = shared_from_this()] {
    self->End(ops::OverBudget(ops::kStationLinks, self->budget_.limits(),
                              "this station has opened as many newer connections as it may have"));
  });
}

void Connection::EndUnlessServed(std::shared_ptr<const std::set<const Services*>> served) {
  asio::post(strand_, [self = shared_from_this(), served] {
    if (!self->services_ || served->contains(self->services_.get())) return;
    self->End(
        Status(Code::kUnavailable, "this school is suspended; nothing is lost, try again later"));
  });
}

void Connection::End(Status why) {
  if (!ending_) ending_ = std::move(why);
  error_code ignored;
  // Only between frames: one that has begun to come is read and answered.
  if (waiting_for_frame_) stream_.socket().cancel(ignored);
}

void Connection::Close() {
  asio::post(strand_, [self = shared_from_this()] { self->stream_.Close(); });
}

asio::awaitable<void> Connection::Serve() {
  Io io = stream_.Handshake();
  while (io > Io::kEnded) {
    co_await stream_.Wait(io);
    io = stream_.Handshake();
  }
  if (io == Io::kEnded) co_return;
  co_await ServeRequests();
  // People's sessions end with the cable, and not by their idle time half an hour later.
  if (session_ && session_->has_sign_ins()) {
    deadline_.Allow(deadlines_.work);
    co_await pool_.Run([this] {
      const LogRequest logged(id_);
      session_->End();
      return true;
    });
  }
  // A peer that does not read would otherwise keep the socket: our last words are a courtesy.
  deadline_.Allow(kGoodbye);
  for (io = stream_.Shutdown(); io > Io::kEnded; io = stream_.Shutdown()) {
    co_await stream_.Wait(io);
  }
}

asio::awaitable<void> Connection::ServeRequests() {
  for (;;) {
    auto frame = co_await ReadFrame();
    if (ending_) {
      co_await Refuse(*ending_);
      co_return;
    }
    if (!frame.ok()) {
      // After any other failure no peer is left to answer.
      if (frame.status().code() == Code::kTooLarge || ops::IsOverBudget(frame.status())) {
        co_await Refuse(frame.status());
      }
      co_return;
    }
    auto request = protocol::ParseRequest(*frame);
    if (!request.ok()) {
      co_await Refuse(request.status());
      co_return;
    }
    // Before anything that needs the database or a thread of the pool: it is about these.
    if (request->has_measure() && own_.measure) {
      wire::Reply reply;
      reply.set_reply_to(request->id());
      *reply.mutable_measured() = own_.measure();
      co_await Write(std::move(reply));
      co_return;
    }
    if (peer_.empty()) {
      co_await Refuse(
          Status(Code::kInvalidInput,
                 "expected the PROXY protocol, version 2, from this address, found TLS; let the "
                 "proxy send it (send-proxy-v2), or connect from another address"));
      co_return;
    }
    // From here on the idle and frame deadlines hold; until here one deadline covered everything.
    introduced_ = true;
    if (!session_) {
      auto search = FindSchool(*request);
      const Status found = co_await Waited(request->id(), std::move(search));
      if (!found.ok()) {
        co_await Refuse(found);
        co_return;
      }
    }
    if (const Status fits = CountChunk(*request); !fits.ok()) {
      co_await Refuse(fits);
      co_return;
    }
    Answer answer;
    // Not in one expression: GCC 12 destroys an operand of ?: with co_await twice.
    if (session_->IsQuick(*request)) {
      answer = co_await Carry(*request);
    } else {
      auto work = Carry(*request);
      answer = co_await Waited(request->id(), std::move(work));
    }
    if (session_->welcomed() && !station_) {
      station_ = {services_ ? services_.get() : &own_, session_->station()->id};
      // With its school: stations of two schools may have one id.
      party_ = LinkBudget::PartyOf(*station_);
      welcomed_ = true;
      if (const auto oldest = budget_.Enter(*station_, shared_from_this())) oldest->EndForNewer();
      reader_.set_limit(protocol::kMaxFrameBytes);
      took_ += kLinkTime;
    }
    if (station_) co_await Rest();
    if (!answer.reply) continue;
    if (answer.reply->has_error()) NoteRefusal(*answer.reply->mutable_error(), answer.attempt);
    bool written = co_await Write(std::move(*answer.reply));
    if (!written || answer.close) co_return;
  }
}

// Before the answer is sent: a station that connects again for each request gains nothing.
asio::awaitable<void> Connection::Rest() {
  const auto now = Clock::now();
  const auto rest = budget_.Took(*station_, std::exchange(took_, {}) + kFrameTime, now);
  if (rest < kShortestRest) co_return;
  deadline_.Allow(deadlines_.work);
  asio::steady_timer until(strand_, now + rest);
  error_code ended;
  co_await until.async_wait(asio::redirect_error(asio::use_awaitable, ended));
}

// Only this coroutine writes to the stream, so that a reply never begins in the middle of another.
template <typename T>
asio::awaitable<T> Connection::Waited(uint32_t reply_to, asio::awaitable<T> work) {
  const auto until = Clock::now() + deadlines_.work;
  asio::steady_timer next(strand_);
  std::optional<T> out;
  std::exception_ptr failure;
  asio::co_spawn(strand_, std::move(work), [&](std::exception_ptr failed, T value) {
    failure = failed;
    out = std::move(value);
    next.cancel();
  });
  // The work refers to what is here, so this waits for it even if the station has gone.
  for (bool there = reply_to != 0; !out;) {
    next.expires_after(deadlines_.still_waiting);
    error_code ended;
    co_await next.async_wait(asio::redirect_error(asio::use_awaitable, ended));
    if (out || !there) continue;
    wire::Reply reply;
    reply.set_reply_to(reply_to);
    reply.mutable_still_waiting();
    there = co_await Write(std::move(reply));
    deadline_.Allow(std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()));
  }
  if (failure) std::rethrow_exception(failure);
  co_return std::move(*out);
}

template <typename Work>
auto Connection::InStore(Work work) {
  const size_t most = station_ ? LinkBudget::kMaxAtOnce : kAsManyAsThere;
  return pool_.Run(Turn(party_, Line::kUsual, most), [this, work = std::move(work)] {
    const LogRequest logged(id_);
    const auto begin = Clock::now();
    auto out = work();
    took_ += std::clamp<Clock::duration>(Clock::now() - begin, kMinTime, kMaxTime);
    return out;
  });
}

asio::awaitable<Status> Connection::FindSchool(const wire::Request& first) {
  if (others_ != nullptr) {
    deadline_.Allow(deadlines_.work);
    auto found = co_await InStore([&] { return others_->ServicesOf(first); });
    if (!found.ok()) co_return found.status();
    services_ = std::move(*found);
  }
  session_.emplace(services_ ? *services_ : own_, peer_);
  co_return Status::Ok();
}

asio::awaitable<Answer> Connection::Carry(const wire::Request& request) {
  deadline_.Allow(deadlines_.work);
  if (session_->IsQuick(request)) {
    // A turn for the other connections: quick requests could come without an end.
    co_await asio::post(strand_, asio::use_awaitable);
    co_return session_->Handle(request);
  }
  if (auto who = session_->SignInWanted(request)) {
    auto signed_in = co_await session_->authenticator().SignIn(std::move(*who));
    // Hashing has its own threads (Authenticator); what follows asks the database.
    co_return co_await InStore([&] { return session_->FinishSignIn(request, signed_in); });
  }
  if (session_->welcomed() && request.has_choose_password()) {
    auto wanted = co_await InStore([&] { return session_->PasswordWanted(request); });
    Result<auth::SignedIn> signed_in = Status(Code::kInternal, "no password was chosen");
    if (!wanted.ok()) {
      signed_in = wanted.status();
    } else {
      signed_in = co_await session_->authenticator().ChangePassword(std::move(wanted->identity),
                                                                    std::move(wanted->change));
    }
    co_return co_await InStore([&] { return session_->FinishSignIn(request, signed_in); });
  }
  if (auto who = session_->SignOffWanted(request)) {
    auto signer = co_await session_->authenticator().CheckPin(std::move(*who));
    co_return co_await InStore([&] { return session_->FinishSignOff(request, signer); });
  }
  const auto begin = Clock::now();
  Answer answer = co_await InStore([&] { return session_->Handle(request); });
  if (request.has_put_chunk())
    (services_ ? *services_ : own_).arrivals.Answered(Clock::now() - begin);
  co_return answer;
}

// kUnavailable: the connection ended. kTooLarge: the frame is over the limit.
asio::awaitable<Result<Bytes>> Connection::ReadFrame() {
  bool begun = false;  // the frame's own deadline runs
  if (introduced_) deadline_.Allow(deadlines_.idle);
  while (!reader_.done()) {
    size_t n = 0;
    Io io = stream_.Read(reader_.Prepare(), n);
    if (io == Io::kEnded) co_return Status(Code::kUnavailable, "connection ended");
    if (io == Io::kDone) {
      if (Status status = reader_.Resume(n); !status.ok()) co_return status;
      if (Status status = HoldFrame(); !status.ok()) co_return status;
      continue;
    }
    waiting_for_frame_ = reader_.at_boundary();
    if (waiting_for_frame_ && ending_) co_return *ending_;
    if (!waiting_for_frame_ && !begun && introduced_) {
      begun = true;
      deadline_.Allow(deadlines_.frame);
    }
    co_await stream_.Wait(io);
    waiting_for_frame_ = false;
    if (broken_off_) {
      reader_ = protocol::FrameReader();
      coming_.reset();
      co_return TooMuchComing();
    }
  }
  coming_.reset();
  co_return reader_.Take();
}

Status Connection::HoldFrame() {
  if (coming_ != nullptr || reader_.announced() <= LinkBudget::kSmallFrameBytes)
    return Status::Ok();
  coming_ = budget_.Coming(party_, this, reader_.announced());
  if (coming_ == nullptr) return TooMuchComing();
  coming_->OnGivenUp([weak = weak_from_this(), given_up = coming_.get()] {
    if (const auto self = weak.lock()) self->BreakOff(given_up);
  });
  return Status::Ok();
}

void Connection::BreakOff(const HeldBytes::Held* given_up) {
  asio::post(strand_, [self = shared_from_this(), given_up] {
    if (self->coming_.get() != given_up) return;  // it has arrived meanwhile
    self->broken_off_ = true;
    error_code ignored;
    self->stream_.socket().cancel(ignored);
  });
}

Status Connection::TooMuchComing() const {
  return ops::OverBudget(
      ops::kStationFrames, budget_.limits(),
      "too much that this station has begun to send has not arrived yet; try again");
}

Status Connection::CountChunk(const wire::Request& request) {
  if (!station_ || !request.has_put_chunk()) return Status::Ok();
  const UnixMs now_ms = (services_ ? *services_ : own_).clock();
  if (budget_.Recorded(*station_, request.put_chunk().chunk().size(), now_ms)) return Status::Ok();
  return ops::OverBudget(ops::kStationRecordings, budget_.limits(),
                         "this station has sent more recordings than it may within 24 h; the rest "
                         "waits there");
}

asio::awaitable<bool> Connection::Write(wire::Reply reply) {
  auto frame = protocol::EncodeFrame(protocol::Serialize(reply));
  if (!frame.ok()) {
    spdlog::error("station link: a reply could not be framed: {}", frame.status().message());
    co_return false;
  }
  deadline_.Allow(deadlines_.write);
  co_return co_await stream_.WriteAll(*frame);
}

void Connection::NoteRefusal(wire::Error& error, const Uuid& attempt) {
  std::string who = "a peer at " + peer_;
  if (session_ && !session_->name().empty())
    who = "station \"" + session_->name() + "\" at " + peer_;
  const LogRequest logged(id_);
  const LogAttempt of(attempt);
  // Each recording's own: one that is only counted with another could not be found.
  refusals_.Note(who + "\n" + error.code() + "\n" + error.field() + "\n" + attempt.Text(),
                 "station link: refused " + who + ": " + error.code() + ": " + error.message());
  if (IsOurFault(error)) {
    error.set_message("the server could not do this; its log says why; what was sent is not lost");
    error.clear_field();
  }
}

asio::awaitable<void> Connection::Refuse(Status status) {
  wire::Reply reply;
  *reply.mutable_error() = protocol::ToError(status);
  // A server that stops, or a disk that is full, is no fault of the peer.
  if (status.code() != Code::kUnavailable || ops::IsOverBudget(status))
    NoteRefusal(*reply.mutable_error());
  co_await Write(std::move(reply));
}

}  // namespace enamel::server::stations
