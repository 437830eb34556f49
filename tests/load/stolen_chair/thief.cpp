#include "tests/load/stolen_chair/thief.h"

#include <sys/epoll.h>
#include <unistd.h>

#include <limits>

#include "common/base/unix_time.h"
#include "tests/load/engine.h"
#include "tests/load/stolen_chair/strangers.h"

namespace enamel::load {
namespace {

constexpr size_t kUnfinishedLinks = 150;
constexpr size_t kLinks = 8;
constexpr size_t kWindow = 32;  // requests without an answer, as many as the link allows
constexpr size_t kOffered = 1024;
constexpr double kPause_s = 0.05;
constexpr double kEnrolWithin_s = 20;

size_t LinksOf(Misuse misuse) { return misuse == Misuse::kUnfinished ? kUnfinishedLinks : kLinks; }

Bytes Unfinished() {
  Bytes out(4 + protocol::kMaxFrameBytes - 1);
  const auto size = static_cast<uint32_t>(protocol::kMaxFrameBytes);
  for (size_t i = 0; i < 4; ++i) out[i] = static_cast<uint8_t>(size >> (8 * i));
  return out;
}

wire::Request Offer() {
  wire::Request request;
  wire::OfferAttempts& offer = *request.mutable_offer_attempts();
  for (size_t i = 0; i < kOffered; ++i) {
    wire::HeldAttempt& held = *offer.add_attempts();
    held.set_attempt(protocol::ToField(Uuid::New().view()));
    held.set_chunks(7);
    offer.add_tickets(protocol::ToField(Uuid::New().view()));
  }
  return request;
}

// So that refusals of one kind are one.
std::string WithoutNumbers(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool digit = text[i] >= '0' && text[i] <= '9';
    const bool long_one = digit && i + 3 < text.size() && text[i + 1] >= '0' &&
                          text[i + 1] <= '9' && text[i + 2] >= '0' && text[i + 2] <= '9';
    if (!long_one) {
      out += text[i];
      continue;
    }
    while (i + 1 < text.size() && text[i + 1] >= '0' && text[i + 1] <= '9') ++i;
    out += '#';
  }
  return out;
}

}  // namespace

const char* NameOf(Misuse misuse) {
  constexpr const char* kNames[kMisuses] = {"unfinished", "small",  "chunks",   "reconnects",
                                            "tickets",    "offers", "downloads"};
  return kNames[static_cast<size_t>(misuse)];
}

void Thief::Ask(Line& line, wire::Request request) {
  request.set_id(++line.last_id);
  ++line.waiting;
  ++counts_.frames;
  line.link->Send(protocol::Serialize(request));
}

void Thief::SignIn(Line& line) {
  line.asked = true;
  wire::Request request;
  request.mutable_sign_in()->set_login(school_.instructor_login);
  request.mutable_sign_in()->set_password(school_.password);
  Ask(line, std::move(request));
}

void Thief::AskForTicket(Line& line) {
  line.asked = true;
  wire::Request request;
  wire::RequestTicket& body = *request.mutable_request_ticket();
  body.set_station_unix_ms(UnixMs());
  body.set_session(line.session);
  body.set_exercise(protocol::ToField(school_.exercise.view()));
  body.set_profile(protocol::ToField(school_.profile.view()));
  Ask(line, std::move(request));
}

Status Thief::Enrol() {
  const int epoll = ::epoll_create1(EPOLL_CLOEXEC);
  Line line;
  line.link = std::make_unique<Link>(target_, epoll, 0);
  const double until_s = NowS() + kEnrolWithin_s;
  while (ticket_.empty() && NowS() < until_s) {
    if (line.link->state() == Link::State::kClosed) {
      Line fresh;
      fresh.link = std::move(line.link);
      line = std::move(fresh);
      line.link->Open();
    }
    line.link->Advance();
    Read(line, Misuse::kTickets);
    if (line.link->state() == Link::State::kOpen) {
      if (!line.said_hello && credential_.empty()) {
        line.said_hello = true;
        wire::Request request;
        wire::Enrol& enrol = *request.mutable_enrol();
        enrol.set_protocol_version(protocol::kProtocolVersion);
        enrol.set_code(code_);
        enrol.set_name("stolen chair");
        enrol.set_public_key(protocol::ToField(keys_.public_key));
        Ask(line, std::move(request));
      } else {
        Step(line, Misuse::kTickets, NowS());
      }
    }
    epoll_event event;
    ::epoll_wait(epoll, &event, 1, 1);
  }
  line.link.reset();
  ::close(epoll);
  refusals_.clear();
  if (ticket_.empty()) return Status(Code::kUnavailable, "the chair got no ticket");
  trace::Header header;
  ENAMEL_ASSIGN_OR_RETURN(header.ticket, trace::DecodeTicket(ticket_));
  header.scene = school_.scene;
  header.volume = school_.volume;
  header.params = school_.params;
  header.station_software = "enamel-loadgen";
  header.hand.kind = HandKind::kProgram;
  header_ = trace::EncodeHeader(header);
  trace::ChunkHead head;
  head.attempt = header.ticket.attempt;
  head.previous = HashSha256(header_);
  std::vector<trace::Tick> ticks(1);
  ticks.front().input.gap_ticks = std::numeric_limits<uint32_t>::max();
  nonsense_ = trace::EncodeChunk(head, ticks, keys_.secret_key);
  return Status::Ok();
}

void Thief::Begin() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Thief::Stop() {
  thread_ = {};  // asks it to stop and waits
}

void Thief::Run(const std::stop_token& stop) {
  GiveWay();
  const int epoll = ::epoll_create1(EPOLL_CLOEXEC);
  std::vector<Line> lines(kUnfinishedLinks);
  for (size_t i = 0; i < lines.size(); ++i)
    lines[i].link = std::make_unique<Link>(target_, epoll, i);
  const double begin_s = NowS();
  size_t before = 0;
  while (!stop.stop_requested()) {
    const double now = NowS();
    const auto turn = static_cast<size_t>((now - begin_s) / turn_s_);
    const auto misuse = misuses_[turn % misuses_.size()];
    // A single misuse keeps its links. On new ones it would have to send everything again.
    if (turn != before && misuses_.size() > 1) {
      for (Line& line : lines) line.link->Close(true);
      before = turn;
    }
    for (size_t i = 0; i < LinksOf(misuse); ++i) Step(lines[i], misuse, now);
    epoll_event events[64];
    ::epoll_wait(epoll, events, 64, 1);
  }
  lines.clear();
  ::close(epoll);
}

void Thief::Step(Line& line, Misuse misuse, double now) {
  Link& link = *line.link;
  if (link.state() == Link::State::kClosed) {
    if (now < line.again_s) return;
    Line fresh;
    fresh.link = std::move(line.link);
    fresh.again_s = misuse == Misuse::kReconnects ? 0 : now + kPause_s;
    line = std::move(fresh);
    ++counts_.links;
    line.link->Open();
  }
  line.link->Advance();
  if (line.link->state() != Link::State::kOpen) return;
  if (!line.said_hello) {
    line.said_hello = true;
    wire::Request request;
    wire::Hello& hello = *request.mutable_hello();
    hello.set_protocol_version(protocol::kProtocolVersion);
    hello.set_station_id(station_id_);
    hello.set_credential(credential_);
    hello.set_core_version(core::kCoreVersion);
    hello.set_software("enamel-loadgen");
    Ask(line, std::move(request));
  }
  Read(line, misuse);
  if (line.link->state() == Link::State::kOpen && line.greeted) Do(line, misuse);
}

void Thief::Read(Line& line, Misuse misuse) {
  for (Bytes message; line.link->NextMessage(message);) {
    ++counts_.replies;
    const auto reply = protocol::ParseReply(message);
    if (reply.ok()) Take(line, misuse, *reply);
  }
}

void Thief::Take(Line& line, Misuse misuse, const wire::Reply& reply) {
  if (reply.has_still_waiting()) return;
  if (line.waiting > 0) --line.waiting;
  switch (reply.body_case()) {
    case wire::Reply::kEnrolled:
      station_id_ = reply.enrolled().station_id();
      credential_ = reply.enrolled().credential();
      line.link->Close();
      break;
    case wire::Reply::kWelcome:
      line.greeted = true;
      if (misuse == Misuse::kReconnects) line.link->Close(true);
      break;
    case wire::Reply::kSignedIn:
      line.session = reply.signed_in().session();
      line.asked = false;
      break;
    case wire::Reply::kTicketIssued: {
      line.asked = false;
      const ByteView ticket = AsBytes(reply.ticket_issued().ticket());
      if (ticket_.empty()) ticket_.assign(ticket.begin(), ticket.end());
      break;
    }
    case wire::Reply::kAttemptOpened:
      line.opened = true;
      break;
    case wire::Reply::kError:
      line.asked = false;
      if (reply.error().message().find("(budget ") != std::string::npos) ++counts_.over_budget;
      ++refusals_[reply.error().code() + ": " + WithoutNumbers(reply.error().message())];
      break;
    default:
      break;
  }
}

void Thief::Do(Line& line, Misuse misuse) {
  static const Bytes kUnfinishedFrame = Unfinished();
  static const wire::Request kOffer = Offer();
  wire::Request request;
  switch (misuse) {
    case Misuse::kUnfinished:
      if (line.asked) return;
      line.asked = true;
      ++counts_.frames;
      return line.link->SendRaw(kUnfinishedFrame);
    case Misuse::kSmall:
      request.mutable_ping()->set_nonce(1);
      while (line.waiting < kWindow) Ask(line, request);
      return;
    case Misuse::kChunks:
      return SendNonsense(line);
    case Misuse::kReconnects:
      return;
    case Misuse::kTickets:
      if (line.asked) return;
      return line.session.empty() ? SignIn(line) : AskForTicket(line);
    case Misuse::kOffers:
      while (line.waiting < 2) Ask(line, kOffer);
      return;
    case Misuse::kDownloads:
      request.mutable_get_blob()->set_sha256(protocol::ToField(school_.volume.view()));
      while (line.waiting < kWindow) Ask(line, request);
      return;
  }
}

void Thief::SendNonsense(Line& line) {
  wire::Request request;
  if (!line.opened) {
    if (line.asked) return;
    line.asked = true;
    request.mutable_open_attempt()->set_header(protocol::ToField(header_));
    return Ask(line, std::move(request));
  }
  request.mutable_put_chunk()->set_chunk(nonsense_.data(), nonsense_.size());
  while (line.waiting < kWindow) Ask(line, request);
}

}  // namespace enamel::load
