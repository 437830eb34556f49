#include "tests/load/stations/station.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/unix_time.h"
#include "tests/support/wire_seal.h"

namespace enamel::load {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kPing_s = 20;  // schemas/wire/README.md, "Deadlines"
constexpr double kReplyWithin_s = 5;
constexpr double kLongestPause_s = 2;
constexpr size_t kWindow = 8;  // requests without an answer; the link allows 32

}  // namespace

Station::Station(const LinkTarget& target, int epoll, uint64_t tag, StationPlan plan,
                 StreamFigures& figures)
    : plan_(std::move(plan)),
      figures_(figures),
      link_(target, epoll, tag),
      random_(static_cast<uint32_t>(tag)) {}

void Station::Prepare(std::vector<Payload> payloads, uint32_t chunks) {
  recording_ =
      std::make_unique<Recording>(*plan_.school, ticket_, keys_, std::move(payloads), chunks);
  last_chunk_ = chunks;
}

uint32_t Station::Due(double now) const {
  double chunk_s = static_cast<double>(plan_.chunk_ticks) / recording_->rate_hz();
  double due = std::floor((now - start_s_) / chunk_s);
  return static_cast<uint32_t>(std::clamp(due, 0.0, static_cast<double>(last_chunk_)));
}

void Station::EndAt(double now) {
  if (recording_) last_chunk_ = std::max({Due(now), sent_, 1u});
}

bool Station::Reached() const {
  switch (goal_) {
    case Goal::kTicket:
      return plan_.ticketed ? !ticket_.empty() : !credential_.empty();
    case Goal::kOpen:
      return connected() && (!recording_ || opened_);
    case Goal::kStream:
      return !recording_ || committed_ >= last_chunk_;
    case Goal::kSeal:
      return !recording_ || sealed_;
  }
  return true;
}

double Station::Advance(double now) {
  if (!problem_.empty()) return kNever;
  // Closed by the other side since the last time.
  if (link_.state() == Link::State::kClosed && up_) Lost(now);
  if (link_.state() == Link::State::kClosed) {
    // Reached goals need no connection; streams and idle stations keep theirs.
    if (Reached() && goal_ != Goal::kOpen) return kNever;
    if (now < again_s_) return again_s_;
    link_.Open();
    up_ = true;
    asked_s_ = now;
  }
  link_.Advance();
  NoteWritten(now);
  Read(now);
  if (link_.state() == Link::State::kOpen) {
    if (!said_hello_) SayHello();
    if (greeted_ && !asked_) AskNext();
    Pump(now);
    SendLive(now);
    if (greeted_ && now - ping_s_ > kPing_s && !asked_ && in_flight_.empty()) {
      ping_s_ = now;
      wire::Request ping;
      ping.mutable_ping()->set_nonce(1);
      Ask(std::move(ping));
    }
  }
  if (link_.state() == Link::State::kClosed && up_) Lost(now);
  return NextWake(now);
}

double Station::NextWake(double now) const {
  if (!problem_.empty()) return kNever;
  if (link_.state() == Link::State::kClosed) {
    return Reached() && goal_ != Goal::kOpen ? kNever : again_s_;
  }
  double wake = ping_s_ + kPing_s + 0.5;
  if (goal_ == Goal::kStream && opened_ && next_ < last_chunk_ && in_flight_.size() < kWindow) {
    double chunk_s = static_cast<double>(plan_.chunk_ticks) / recording_->rate_hz();
    wake = std::min(wake, start_s_ + (next_ + 1) * chunk_s);
  }
  if (goal_ == Goal::kStream && opened_ && plan_.disturbances.live_hz > 0) {
    wake = std::min(wake, live_s_ + 1 / plan_.disturbances.live_hz);
  }
  return std::max(wake, now + 0.001);
}

void Station::Cut() {
  if (link_.state() == Link::State::kClosed) return;
  ++figures_.cuts;
  link_.Close(true);
}

void Station::Lost(double now) {
  bool was_up = greeted_;
  up_ = said_hello_ = greeted_ = asked_ = opened_ = false;
  in_flight_.clear();
  session_.clear();
  next_ = committed_;
  // Enrolment ends its connection in order.
  if (was_up) ++figures_.reconnects;
  pause_s_ = was_up ? 0.1 : std::min(2 * pause_s_, kLongestPause_s);
  again_s_ = now + pause_s_ * std::uniform_real_distribution<>(0.5, 1)(random_);
}

void Station::GiveUp(const std::string& why) {
  problem_ = why;
  link_.Close();
}

void Station::Ask(wire::Request request) {
  asked_ = true;
  request.set_id(++last_id_);
  link_.Send(protocol::Serialize(request));
}

void Station::SayHello() {
  said_hello_ = true;
  wire::Request request;
  if (credential_.empty()) {
    wire::Enrol& enrol = *request.mutable_enrol();
    enrol.set_protocol_version(protocol::kProtocolVersion);
    enrol.set_code(plan_.code);
    enrol.set_name(plan_.name);
    enrol.set_public_key(protocol::ToField(keys_.public_key));
  } else {
    wire::Hello& hello = *request.mutable_hello();
    hello.set_protocol_version(protocol::kProtocolVersion);
    hello.set_station_id(station_id_);
    hello.set_credential(credential_);
    hello.set_core_version(core::kCoreVersion);
    hello.set_software("enamel-loadgen");
  }
  Ask(std::move(request));
}

void Station::AskNext() {
  wire::Request request;
  if (plan_.ticketed && ticket_.empty() && session_.empty()) {
    request.mutable_sign_in()->set_login(plan_.school->login);
    request.mutable_sign_in()->set_password(plan_.school->password);
  } else if (plan_.ticketed && ticket_.empty()) {
    wire::RequestTicket& body = *request.mutable_request_ticket();
    body.set_station_unix_ms(UnixMs());
    body.set_session(session_);
    body.set_exercise(protocol::ToField(plan_.school->exercise.view()));
    body.set_profile(protocol::ToField(plan_.school->profile.view()));
  } else if (recording_ && goal_ != Goal::kTicket && !opened_) {
    request.mutable_open_attempt()->set_header(protocol::ToField(recording_->header()));
  } else if (recording_ && goal_ == Goal::kSeal && !sealed_ && in_flight_.empty()) {
    test::FillSeal(recording_->SealOf(last_chunk_), *request.mutable_seal_attempt());
  } else {
    return;
  }
  Ask(std::move(request));
}

void Station::Read(double now) {
  for (Bytes message; link_.NextMessage(message);) {
    asked_s_ = now;
    auto reply = protocol::ParseReply(message);
    if (!reply.ok()) return GiveUp("the server sent no message: " + reply.status().message());
    Take(*reply, now);
    if (!problem_.empty()) return;
  }
}

void Station::Take(const wire::Reply& reply, double now) {
  if (reply.has_still_waiting()) return;
  if (!in_flight_.empty() && in_flight_.front().id == reply.reply_to()) {
    return TakeChunkReply(reply, now);
  }
  asked_ = false;
  ping_s_ = now;
  switch (reply.body_case()) {
    case wire::Reply::kEnrolled:
      station_id_ = reply.enrolled().station_id();
      credential_ = reply.enrolled().credential();
      link_.Close();
      break;
    case wire::Reply::kWelcome:
      greeted_ = true;
      pause_s_ = 0.1;
      break;
    case wire::Reply::kSignedIn:
      session_ = reply.signed_in().session();
      break;
    case wire::Reply::kTicketIssued: {
      ByteView ticket = AsBytes(reply.ticket_issued().ticket());
      ticket_.assign(ticket.begin(), ticket.end());
      break;
    }
    case wire::Reply::kAttemptOpened: {
      opened_ = true;
      uint32_t stored = reply.attempt_opened().next_seq();
      for (uint32_t seq = stored; seq < committed_; ++seq) {
        figures_.ticks_taken_back += recording_->ticks(seq);
      }
      if (stored > committed_) Commit(stored);
      next_ = stored;
      break;
    }
    case wire::Reply::kSealed:
      sealed_ = true;
      break;
    case wire::Reply::kPong:
      break;
    case wire::Reply::kError:
      if (reply.error().code() == "unavailable" || reply.error().code() == "storage") {
        link_.Close();  // come back later
      } else {
        GiveUp(reply.error().code() + ": " + reply.error().message());
      }
      break;
    default:
      GiveUp("the server sent an answer of an unexpected kind");
  }
}

void Station::TakeChunkReply(const wire::Reply& reply, double now) {
  InFlight chunk = in_flight_.front();
  in_flight_.pop_front();
  ping_s_ = now;
  if (reply.has_chunk_ack() && reply.chunk_ack().committed()) {
    if (chunk.disordered) return GiveUp("a chunk before its turn was committed");
    double out_s = chunk.out_s > 0 ? chunk.out_s : now;
    if (!chunk.repeat) figures_.commit_ms.push_back(static_cast<float>((now - out_s) * 1e3));
    if (chunk.seq == committed_) Commit(committed_ + 1);
    return;
  }
  const wire::Error& error = reply.error();
  if (chunk.disordered && error.code() == "conflict" && error.field() == "seq") return;
  ++figures_.refused;
  if (error.code() == "unavailable" || error.code() == "storage") return link_.Close();
  GiveUp("chunk " + std::to_string(chunk.seq) + ": " + error.code() + ": " + error.message());
}

void Station::Commit(uint32_t chunks) {
  for (; committed_ < chunks; ++committed_) {
    uint32_t ticks = recording_->ticks(committed_);
    figures_.ticks_committed += ticks;
    committed_ticks_ += ticks;
  }
}

void Station::Pump(double now) {
  if (goal_ != Goal::kStream || !opened_ || asked_) return;
  uint32_t due = Due(now);
  const Disturbances& disturb = plan_.disturbances;
  std::uniform_real_distribution<> share(0, 1);
  while (next_ < due && in_flight_.size() < kWindow && link_.state() == Link::State::kOpen) {
    if (disturb.disordered > 0 && next_ + 1 < last_chunk_ && share(random_) < disturb.disordered) {
      SendChunk(next_ + 1, now, false, true);
    }
    SendChunk(next_, now, false, false);
    if (disturb.repeated > 0 && share(random_) < disturb.repeated) {
      SendChunk(next_, now, true, false);
    }
    ++next_;
  }
}

void Station::SendChunk(uint32_t seq, double now, bool repeat, bool disordered) {
  Bytes bytes = recording_->Chunk(seq);
  wire::Request request;
  request.set_id(++last_id_);
  request.mutable_put_chunk()->set_chunk(bytes.data(), bytes.size());
  uint64_t before = link_.queued();
  link_.Send(protocol::Serialize(request));
  figures_.bytes_sent += link_.queued() - before;
  figures_.repeats += repeat;
  figures_.disorders += disordered;
  if (!repeat && !disordered && seq >= sent_) {
    double chunk_s = static_cast<double>(plan_.chunk_ticks) / recording_->rate_hz();
    double due_s = start_s_ + (seq + 1) * chunk_s;
    figures_.late_ms.push_back(static_cast<float>((now - due_s) * 1e3));
    figures_.ticks_sent += recording_->ticks(seq);
    figures_.chunk_bytes += bytes.size();
    sent_ = seq + 1;
  }
  in_flight_.push_back({last_id_, seq, link_.queued(), 0, repeat, disordered});
  if (in_flight_.size() == 1) asked_s_ = now;
  NoteWritten(now);
}

void Station::NoteWritten(double now) {
  for (InFlight& chunk : in_flight_) {
    if (chunk.out_s == 0 && link_.written() >= chunk.ends_at) chunk.out_s = now;
  }
  // A silent server is given up like a dead one.
  bool waiting = asked_ || !in_flight_.empty() || link_.state() == Link::State::kOpening;
  if (waiting && now - asked_s_ > kReplyWithin_s) link_.Close(true);
}

void Station::SendLive(double now) {
  double hz = plan_.disturbances.live_hz;
  if (hz <= 0 || goal_ != Goal::kStream || !opened_ || now < live_s_ + 1 / hz) return;
  live_s_ = now;
  wire::Request request;
  wire::LiveState& live = *request.mutable_live_state();
  live.set_attempt(protocol::ToField(recording_->attempt().view()));
  live.set_tick(static_cast<uint64_t>(std::max(0.0, now - start_s_) * recording_->rate_hz()));
  for (int axis = 0; axis < 3; ++axis) {
    live.add_anchor_um(static_cast<int32_t>(random_() % 10'000));
    live.add_force_mn(static_cast<int32_t>(random_() % 3'000));
  }
  link_.Send(protocol::Serialize(request));
  ++figures_.live_states;
}

}  // namespace enamel::load
