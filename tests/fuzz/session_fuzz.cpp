#include <sodium.h>

#include <algorithm>

#include "common/base/check.h"
#include "common/protocol/frame.h"
#include "server/stations/session.h"
#include "tests/server/stations/link_world.h"

namespace {

using namespace enamel;
using namespace enamel::server;
using namespace enamel::server::stations;
namespace world_of = enamel::server::stations::testing;

constexpr size_t kMaxMessages = 16;

// A server with one enrolled station that has opened an attempt and sent a chunk.
struct Target {
  Target() {
    world_of::ScriptedStation enrolling([this](const wire::Request& r) { return Carry(r); });
    ENAMEL_CHECK(enrolling.Enrol().has_enrolled());
    Restart();
    station = enrolling;
    ENAMEL_CHECK(station.Hello().has_welcome());
    ENAMEL_CHECK(station.SignIn("student").has_signed_in());
    auto first = station.RequestTicket(world.exercise.content, world.Profile("omega3"));
    unused = trace::DecodeTicket(world_of::TicketOf(first))->attempt;
    auto reply = station.RequestTicket(world.exercise.content, world.Profile("omega3"));
    world_of::Recording recording(world, world_of::TicketOf(reply), station.keys, 1);
    attempt = recording.seal.attempt;
    ENAMEL_CHECK(station.Open(recording.header).has_attempt_opened());
    ENAMEL_CHECK(station.Put(recording.chunks[0]).has_chunk_ack());
  }

  wire::Reply Carry(const wire::Request& request) {
    return world_of::CarryTo(*session, request).reply.value_or(wire::Reply());
  }

  void Restart() { session.emplace(world.services, "127.0.0.1"); }

  // Messages possible only with the station's key: its attempt, its signature.
  void MakeOurs(std::string& chunk) {
    constexpr size_t kAttemptAt = 6, kSignature = 64;
    constexpr std::string_view kDomain = "enamel.trace-chunk.v1";
    if (chunk.size() < 90 + kSignature) return;
    std::ranges::copy(attempt.bytes, chunk.begin() + kAttemptAt);
    std::string signed_part = chunk.substr(0, chunk.size() - kSignature);
    Bytes message(kDomain.begin(), kDomain.end());
    Sha256 hash = HashSha256(AsBytes(signed_part));
    message.insert(message.end(), hash.bytes.begin(), hash.bytes.end());
    auto* signature = reinterpret_cast<unsigned char*>(chunk.data() + signed_part.size());
    crypto_sign_detached(signature, nullptr, message.data(), message.size(),
                         station.keys.secret_key.data());
  }

  world_of::LinkWorld world;
  std::optional<Session> session{std::in_place, world.services, "127.0.0.1"};
  world_of::ScriptedStation station{[this](const wire::Request& r) { return Carry(r); }};
  Uuid attempt;
  Uuid unused;  // of a ticket that nothing is begun with
};

void Send(Target& target, wire::Request request) {
  // Sign-in is slow on purpose, to protect passwords; enrolment would need a fresh code each time.
  if (request.has_sign_in() || request.has_enrol() || request.has_request_ticket()) return;
  if (request.has_put_chunk() && request.id() % 2 == 1) {
    target.MakeOurs(*request.mutable_put_chunk()->mutable_chunk());
  }
  if (request.has_live_state() && request.id() % 2 == 1) {
    request.mutable_live_state()->set_attempt(protocol::ToField(target.attempt.view()));
  }
  if (request.has_return_ticket() && request.id() % 2 == 1) {
    const Uuid& of = request.id() % 4 == 1 ? target.attempt : target.unused;
    request.mutable_return_ticket()->set_attempt(protocol::ToField(of.view()));
  }
  Answer answer = target.session->Handle(request);
  ENAMEL_CHECK(answer.reply.has_value() != request.has_live_state());
  if (!answer.reply) return;
  ENAMEL_CHECK(answer.reply->reply_to() == request.id());
  ENAMEL_CHECK(!answer.reply->has_sealed());
  ENAMEL_CHECK(!answer.reply->has_ticket_returned() || answer.reply->ticket_returned().attempt() ==
                                                           protocol::ToField(target.unused.view()));
}

}  // namespace

// Any bytes from a station that said hello: every request is answered, or the connection ends;
// nothing is sealed, and the committed chunk does not change.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static Target target;
  target.Restart();
  ENAMEL_CHECK(target.station.Hello().has_welcome());
  protocol::FrameReader reader;
  ByteView stream(data, size);
  for (size_t messages = 0; !stream.empty() && messages < kMaxMessages;) {
    auto space = reader.Prepare();
    size_t n = std::min(space.size(), stream.size());
    std::copy_n(stream.begin(), n, space.begin());
    stream = stream.subspan(n);
    if (!reader.Resume(n).ok()) return 0;
    if (!reader.done()) continue;
    ++messages;
    auto request = protocol::ParseRequest(reader.Take());
    if (!request.ok()) return 0;
    Send(target, *std::move(request));
  }
  return 0;
}
