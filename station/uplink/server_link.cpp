#include "station/uplink/server_link.h"

#include <algorithm>

#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "common/core/params.h"
#include "common/protocol/release.h"

namespace enamel::station {
namespace {

using net::IsTimeout;

// A volume of a whole tooth takes some megabytes; this limit only keeps a wrong `total` from using
// up memory.
constexpr uint64_t kMaxBlob = uint64_t{2} << 30;

constexpr size_t kMaxCardRemark = 200;  // as ExerciseRef.last_remark

constexpr std::chrono::milliseconds kLook{500};  // for silence

Status Unexpected(const char* wanted) {
  return Status(Code::kVersion, std::string("the server answered with another message than ") +
                                    wanted + ": it speaks another version of the protocol");
}

std::vector<protocol::Remark> ReadRemarks(
    const google::protobuf::RepeatedPtrField<wire::Remark>& messages) {
  std::vector<protocol::Remark> out;
  for (const wire::Remark& message : messages) {
    if (out.size() < protocol::kMaxRemarks) out.push_back(protocol::ReadRemark(message));
  }
  return out;
}

// A newer server's value is unknown here; that server checks it itself.
HandsAllowed HandsIn(const std::string& name) {
  return HandsAllowedFromName(name).value_or(HandsAllowed::kAny);
}

}  // namespace

std::string SoftwareName() { return "enamel-station " + std::string(protocol::ThisRelease()); }

Status ServerLink::Send(wire::Request& request) {
  request.set_id(++last_id_);
  return client_.Send(protocol::Serialize(request));
}

// Its answer would come later and be mistaken for another's.
Status ServerLink::LeaveSilent() {
  const auto silence = client_.silence();
  if (silence <= silence_) return Status::Ok();
  client_.Close();
  return Status(Code::kUnavailable,
                "the server has not answered for " + std::to_string(silence.count() / 1000) +
                    " s, although it owes an answer; the station connects again");
}

// The reply to `reply_to`.
Result<wire::Reply> ServerLink::Receive(uint32_t reply_to) {
  while (true) {
    auto frame = client_.Receive(std::min<std::chrono::milliseconds>(silence_, kLook));
    if (IsTimeout(frame.status())) {
      ENAMEL_RETURN_IF_ERROR(LeaveSilent());
      continue;
    }
    if (!frame.ok()) {
      client_.Close();
      return frame.status();
    }
    auto reply = protocol::ParseReply(*frame);
    if (!reply.ok()) {
      client_.Close();
      return reply.status();
    }
    // Acknowledgements of chunks may arrive before the reply. An error without a request (reply_to
    // 0) ends the connection and answers whatever was asked.
    if (reply->has_still_waiting()) continue;
    if (reply->reply_to() != reply_to && reply->reply_to() != 0) continue;
    if (reply->has_error()) return protocol::ToStatus(reply->error());
    if (reply->reply_to() == reply_to) return reply;
  }
}

Result<wire::Reply> ServerLink::Call(wire::Request& request) {
  ENAMEL_RETURN_IF_ERROR(Send(request));
  return Receive(request.id());
}

Result<Credentials> ServerLink::Enrol(const net::Endpoint& server, const EnrolCode& code,
                                      const std::string& name,
                                      const std::optional<Credentials>& before) {
  ServerLink link;
  ENAMEL_RETURN_IF_ERROR(link.client_.Connect(server, code.fingerprint, kTimeout));
  // The old key with the old id: tickets and chunks signed for it stay valid on a server that has
  // lost the station (schemas/wire/README.md, "Two acknowledgements").
  trace::KeyPair keys =
      before ? trace::KeyPair{before->public_key(), before->secret_key} : trace::NewKeyPair();
  wire::Request request;
  auto* enrol = request.mutable_enrol();
  enrol->set_protocol_version(protocol::kProtocolVersion);
  enrol->set_code(code.code);
  const std::string& called = before && name.empty() ? before->name : name;
  enrol->set_name(called);
  if (before) enrol->set_station_id(protocol::ToField(before->station.view()));
  enrol->set_public_key(protocol::ToField(keys.public_key));
  enrol->set_software(SoftwareName());
  enrol->set_release(std::string(protocol::ThisRelease()));
  ENAMEL_ASSIGN_OR_RETURN(auto reply, link.Call(request));
  if (!reply.has_enrolled()) return Unexpected("Enrolled");
  auto station = protocol::ReadUuid(reply.enrolled().station_id(), "station_id");
  auto credential = protocol::ReadKey(reply.enrolled().credential(), "credential");
  auto ticket_key = protocol::ReadKey(reply.enrolled().ticket_key(), "ticket_key");
  ENAMEL_RETURN_IF_ERROR(station.status());
  ENAMEL_RETURN_IF_ERROR(credential.status());
  ENAMEL_RETURN_IF_ERROR(ticket_key.status());
  Credentials out;
  out.server = server;
  out.fingerprint = code.fingerprint;
  out.station = *station;
  out.credential = *credential;
  out.name = called;
  out.ticket_key = *ticket_key;
  out.secret_key = keys.secret_key;
  return out;
}

Status ServerLink::Connect(const Credentials& credentials) {
  ENAMEL_RETURN_IF_ERROR(client_.Connect(credentials.server, credentials.fingerprint, kTimeout));
  wire::Request request;
  auto* hello = request.mutable_hello();
  hello->set_protocol_version(protocol::kProtocolVersion);
  hello->set_station_id(protocol::ToField(credentials.station.view()));
  hello->set_credential(protocol::ToField(credentials.credential));
  hello->set_core_version(core::kCoreVersion);
  hello->set_software(SoftwareName());
  hello->set_release(std::string(protocol::ThisRelease()));
  hello->set_shows_remarks(true);
  // As in NTP: half of the round trip counts as the way back, with an error of at most that half.
  int64_t asked_ms = UnixMs();
  auto reply = Call(request);
  if (!reply.ok()) {
    client_.Close();
    return reply.status();
  }
  if (!reply->has_welcome()) return Unexpected("Welcome");
  server_ahead_ms_ = reply->welcome().server_unix_ms() - (asked_ms + UnixMs()) / 2;
  may_begin_ = reply->welcome().core_version() == core::kCoreVersion;
  // People type it elsewhere, so anything but a plain address is ignored.
  const std::string& page_url = reply->welcome().page_url();
  page_url_ = protocol::IsPageUrl(page_url) ? page_url : "";
  policy_ = reply->welcome().policy();
  return Status::Ok();
}

Result<Person> ServerLink::SignIn(const std::string& login, const std::string& password) {
  wire::Request request;
  request.mutable_sign_in()->set_login(login);
  request.mutable_sign_in()->set_password(password);
  return CallForPerson(request);
}

Result<Person> ServerLink::ChoosePassword(const Person& person, const std::string& one_time,
                                          const std::string& chosen) {
  wire::Request request;
  auto* choose = request.mutable_choose_password();
  choose->set_session(person.session);
  choose->set_old_password(one_time);
  choose->set_new_password(chosen);
  return CallForPerson(request);
}

Result<Person> ServerLink::CallForPerson(wire::Request& request) {
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_signed_in()) return Unexpected("SignedIn");
  const wire::SignedIn& in = reply.signed_in();
  ENAMEL_ASSIGN_OR_RETURN(auto id, protocol::ReadUuid(in.person_id(), "person_id"));
  return Person{id, in.display_name(), in.role(), in.session(), in.must_change_password()};
}

Result<Catalogue> ServerLink::ListExercises(const Person& person) {
  wire::Request request;
  request.mutable_list_exercises()->set_session(person.session);
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_exercises()) return Unexpected("Exercises");
  Catalogue out;
  for (const auto& e : reply.exercises().exercises()) {
    auto exercise = protocol::ReadSha256(e.exercise(), "exercise");
    auto scene = protocol::ReadSha256(e.scene(), "scene");
    auto volume = protocol::ReadSha256(e.volume(), "volume");
    ENAMEL_RETURN_IF_ERROR(exercise.status());
    ENAMEL_RETURN_IF_ERROR(scene.status());
    ENAMEL_RETURN_IF_ERROR(volume.status());
    Uuid assignment;
    if (!e.assignment().empty()) {
      ENAMEL_ASSIGN_OR_RETURN(auto id, protocol::ReadUuid(e.assignment(), "assignment"));
      assignment = id;
    }
    out.exercises.push_back({e.name(), e.title(), *exercise, *scene, *volume, assignment,
                             e.due_unix_ms(), e.late_allowed(), e.attempt_limit(),
                             e.attempts_left(), e.exam(), HandsIn(e.hands()),
                             e.has_refusal() ? protocol::ToStatus(e.refusal()) : Status::Ok()});
    out.exercises.back().sign_off = e.sign_off();
    out.exercises.back().opens_unix_ms = e.opens_unix_ms();
    out.exercises.back().stations = Printable(e.stations());
    if (e.has_best_score()) out.exercises.back().best_score = e.best_score();
    out.exercises.back().last_remark = ShortenedText(e.last_remark(), kMaxCardRemark);
  }
  for (const auto& p : reply.exercises().profiles()) {
    ENAMEL_ASSIGN_OR_RETURN(auto profile, protocol::ReadSha256(p.profile(), "profile"));
    out.profiles.push_back({p.name(), p.title(), profile});
  }
  return out;
}

Result<Bytes> ServerLink::FetchBlob(const Sha256& name, const BlobCache& cache) {
  if (auto cached = cache.Find(name)) return std::move(*cached);
  Bytes blob;
  uint64_t total = 0;
  do {
    wire::Request request;
    request.mutable_get_blob()->set_sha256(protocol::ToField(name.view()));
    request.mutable_get_blob()->set_offset(blob.size());
    ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
    if (!reply.has_blob_part()) return Unexpected("BlobPart");
    const wire::BlobPart& part = reply.blob_part();
    total = part.total();
    bool nothing = part.data().empty() && blob.size() < total;
    if (part.offset() != blob.size() || total > kMaxBlob || nothing ||
        blob.size() + part.data().size() > total) {
      return Status(Code::kConflict, "the server sent blob " + name.Hex() +
                                         " in parts that do not "
                                         "fit together");
    }
    ByteView data = AsBytes(part.data());
    blob.insert(blob.end(), data.begin(), data.end());
  } while (blob.size() < total);
  if (HashSha256(blob) != name) {
    return Status(Code::kConflict, "the server sent other bytes than blob " + name.Hex() +
                                       ": nothing was stored; tell its admin");
  }
  ENAMEL_RETURN_IF_ERROR(cache.Put(name, blob));
  return blob;
}

Result<IssuedTicket> ServerLink::RequestTicket(const Credentials& credentials, const Person& person,
                                               const TicketRequest& wanted) {
  wire::Request request;
  auto* ask = request.mutable_request_ticket();
  ask->set_session(person.session);
  ask->set_exercise(protocol::ToField(wanted.exercise.view()));
  ask->set_profile(protocol::ToField(wanted.profile.view()));
  ask->set_as_reference(wanted.as_reference);
  ask->set_for_later(wanted.for_later);
  ask->set_station_unix_ms(UnixMs());
  if (!wanted.assignment.IsZero()) {
    ask->set_assignment(protocol::ToField(wanted.assignment.view()));
  }
  if (wanted.hand.kind != HandKind::kNotTold) protocol::SetHand(wanted.hand, *ask->mutable_hand());
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_ticket_issued()) return Unexpected("TicketIssued");
  ENAMEL_ASSIGN_OR_RETURN(auto ticket,
                          trace::DecodeTicket(AsBytes(reply.ticket_issued().ticket())));
  bool ours = ticket.station == credentials.station && ticket.person == person.id &&
              ticket.exercise == wanted.exercise && ticket.profile == wanted.profile;
  if (!ours || !trace::VerifyTicket(ticket, credentials.ticket_key)) {
    return Status(Code::kConflict,
                  "the server issued a ticket for something else, or one it did not "
                  "sign: no attempt was begun; tell its admin");
  }
  const wire::TicketIssued& issued = reply.ticket_issued();
  return IssuedTicket{ticket, HandsIn(issued.hands()), {issued.sign_off(), issued.outline()}};
}

Result<std::string> ServerLink::SignOff(const Uuid& attempt, SignedAt at, const std::string& login,
                                        const std::string& pin) {
  wire::Request request;
  auto* sign = request.mutable_sign_off();
  sign->set_attempt(protocol::ToField(attempt.view()));
  sign->set_at(at == SignedAt::kStart ? "start" : "end");
  sign->set_login(login);
  sign->set_pin(pin);
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_signed_off()) return Unexpected("SignedOff");
  return reply.signed_off().display_name();
}

Result<AttemptProgress> ServerLink::AttemptStatus(const Person& person, const Uuid& attempt) {
  wire::Request request;
  request.mutable_attempt_status()->set_session(person.session);
  request.mutable_attempt_status()->set_attempt(protocol::ToField(attempt.view()));
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_attempt_state()) return Unexpected("AttemptState");
  const wire::AttemptState& state = reply.attempt_state();
  AttemptProgress out{state.state(), state.progress(),
                      state.has_problem() ? protocol::ToStatus(state.problem()) : Status::Ok(),
                      state.result_json()};
  for (const wire::EarlierScore& earlier : state.scores()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto id, protocol::ReadUuid(earlier.attempt(), "attempt"));
    out.scores.push_back({id, earlier.score()});
  }
  return out;
}

Result<Bytes> ServerLink::Deviation(const Person& person, const Uuid& attempt) {
  wire::Request request;
  request.mutable_get_deviation()->set_session(person.session);
  request.mutable_get_deviation()->set_attempt(protocol::ToField(attempt.view()));
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_attempt_deviation()) return Unexpected("AttemptDeviation");
  const ByteView bytes = AsBytes(reply.attempt_deviation().deviation());
  return Bytes(bytes.begin(), bytes.end());
}

Status ServerLink::MarkReference(const Person& person, const Uuid& attempt,
                                 const std::string& dentist, bool consent,
                                 const std::string& anyway) {
  wire::Request request;
  auto* mark = request.mutable_mark_reference();
  mark->set_session(person.session);
  mark->set_attempt(protocol::ToField(attempt.view()));
  mark->set_dentist(dentist);
  mark->set_consent(consent);
  mark->set_anyway(anyway);
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  return reply.has_reference_marked() ? Status::Ok() : Unexpected("ReferenceMarked");
}

Result<std::vector<protocol::Remark>> ServerLink::Ping(const std::optional<Uuid>& attempt,
                                                       uint64_t shown) {
  wire::Request request;
  wire::Ping& ping = *request.mutable_ping();
  if (attempt) ping.set_attempt(protocol::ToField(attempt->view()));
  ping.set_shown_remark(shown);
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_pong()) return Unexpected("Pong");
  return ReadRemarks(reply.pong().remarks());
}

Result<Wanted> ServerLink::OfferAttempts(const std::vector<HeldAttempt>& attempts,
                                         const std::vector<Uuid>& tickets) {
  wire::Request request;
  wire::OfferAttempts& offer = *request.mutable_offer_attempts();
  for (const HeldAttempt& held : attempts) {
    offer.add_attempts()->set_attempt(protocol::ToField(held.attempt.view()));
    offer.mutable_attempts(offer.attempts_size() - 1)->set_chunks(held.chunks);
  }
  for (const Uuid& ticket : tickets) offer.add_tickets(protocol::ToField(ticket.view()));
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_attempts_wanted()) return Unexpected("AttemptsWanted");
  Wanted out;
  for (const std::string& bytes : reply.attempts_wanted().attempts()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, protocol::ReadUuid(bytes, "attempts"));
    out.attempts.push_back(id);
  }
  for (const std::string& bytes : reply.attempts_wanted().revoked()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, protocol::ReadUuid(bytes, "revoked"));
    out.revoked.push_back(id);
  }
  return out;
}

Status ServerLink::ReturnTicket(const Uuid& attempt) {
  wire::Request request;
  request.mutable_return_ticket()->set_attempt(protocol::ToField(attempt.view()));
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  return reply.has_ticket_returned() ? Status::Ok() : Unexpected("TicketReturned");
}

Result<ServerLink::Opened> ServerLink::OpenAttempt(ByteView header,
                                                   const protocol::AttemptFacts& facts) {
  wire::Request request;
  request.mutable_open_attempt()->set_header(protocol::ToField(header));
  *request.mutable_open_attempt()->mutable_facts() = facts;
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  if (!reply.has_attempt_opened()) return Unexpected("AttemptOpened");
  return Opened{reply.attempt_opened().next_seq(), reply.attempt_opened().watched()};
}

Status ServerLink::SendChunk(ByteView chunk, uint64_t shown) {
  wire::Request request;
  request.mutable_put_chunk()->set_chunk(protocol::ToField(chunk));
  request.mutable_put_chunk()->set_shown_remark(shown);
  return Send(request);
}

Result<std::optional<ServerLink::Ack>> ServerLink::PollAck(std::chrono::milliseconds patience) {
  auto frame = client_.Receive(patience);
  if (IsTimeout(frame.status())) {
    ENAMEL_RETURN_IF_ERROR(LeaveSilent());
    return std::optional<Ack>();
  }
  auto reply = frame.ok() ? protocol::ParseReply(*frame) : Result<wire::Reply>(frame.status());
  if (!reply.ok()) {
    client_.Close();
    return reply.status();
  }
  if (reply->has_error()) return protocol::ToStatus(reply->error());
  if (reply->has_still_waiting()) return std::optional<Ack>();
  if (!reply->has_chunk_ack()) return Unexpected("ChunkAck");
  const wire::ChunkAck& ack = reply->chunk_ack();
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, protocol::ReadUuid(ack.attempt(), "attempt"));
  return std::optional<Ack>(
      Ack{attempt, ack.seq(), ack.committed(), ack.watched(), ReadRemarks(ack.remarks())});
}

Status ServerLink::SendLive(const Uuid& attempt, const LivePoint& point) {
  wire::Request request;
  wire::LiveState& live = *request.mutable_live_state();
  live.set_attempt(protocol::ToField(attempt.view()));
  live.set_tick(point.ticks - 1);
  for (int32_t v : point.anchor_um) live.add_anchor_um(v);
  for (int32_t v : point.force_mn) live.add_force_mn(v);
  live.set_flags(point.flags);
  return client_.Send(protocol::Serialize(request), kTimeout, /*answered=*/false);
}

Status ServerLink::Seal(const trace::Seal& seal) {
  wire::Request request;
  auto* message = request.mutable_seal_attempt();
  message->set_attempt(protocol::ToField(seal.attempt.view()));
  message->set_chunks(seal.chunks);
  message->set_ticks(seal.ticks);
  message->set_last_chunk(protocol::ToField(seal.last_chunk.view()));
  message->set_state_hash(seal.state_hash);
  ENAMEL_ASSIGN_OR_RETURN(auto reply, Call(request));
  return reply.has_sealed() ? Status::Ok() : Unexpected("Sealed");
}

}  // namespace enamel::station
