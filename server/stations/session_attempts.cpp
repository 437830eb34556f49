#include <sodium.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/log_request.h"
#include "common/base/utf8.h"
#include "common/protocol/refusals.h"
#include "common/scene/attempt_documents.h"
#include "common/scene/json/json.h"
#include "server/live/chunk_moments.h"
#include "server/stations/session.h"
#include "server/training/access.h"

// Tickets and recordings.
namespace enamel::server::stations {
namespace {

// Attempts of this station remembered per connection; more are looked up again.
constexpr size_t kMaxRemembered = 256;

Status NotOurs(const Uuid& attempt) {
  return Status(Code::kNotFound, "no attempt " + attempt.Text() + " of this station", "attempt");
}

}  // namespace

Status Session::MustBeOurs(const Uuid& attempt) {
  if (!ours_.contains(attempt)) {
    auto row = services_.store.attempts.AttemptById(attempt);
    if (!row.ok()) return row.status().code() == Code::kNotFound ? NotOurs(attempt) : row.status();
    if (row->station != station_->id) return NotOurs(attempt);
    if (ours_.size() >= kMaxRemembered) ours_.clear();
    ours_.insert(attempt);
  }
  about_ = attempt;
  return Status::Ok();
}

Status Session::SetTiming(AttemptRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, services_.store.blobs.GetBlob(row.exercise_content));
  ENAMEL_ASSIGN_OR_RETURN(auto document, scene::ExerciseFromJson(AsText(text)));
  row.rate_hz = document.rate_hz;
  row.limit_ticks =
      static_cast<uint64_t>(document.time_limit_s) * static_cast<uint64_t>(document.rate_hz);
  return Status::Ok();
}

Result<std::optional<AssignedRow>> Session::AssignmentFor(const Person& person,
                                                          const ExerciseRow& exercise,
                                                          const wire::RequestTicket& request) {
  Status not_assigned(
      Code::kForbidden,
      "exercise \"" + exercise.name + "\" in this version is not assigned to " + person.login,
      "exercise");
  if (person.role != Role::kStudent) {
    ENAMEL_ASSIGN_OR_RETURN(auto offered, ExercisesOf(person));
    auto found = std::ranges::find(offered, exercise.content, &ExerciseRow::content);
    if (found == offered.end()) return not_assigned;
    return std::optional<AssignedRow>();
  }
  std::optional<Uuid> wanted;
  if (!request.assignment().empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, protocol::ReadUuid(request.assignment(), "assignment"));
    wanted = id;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto rows, services_.store.assignments.AssignmentsFor(person.id));
  UnixMs now_ms = services_.clock();
  const AssignedRow* assigned =
      PickAssignment(rows, exercise.content, wanted, now_ms, station_->id);
  if (!assigned) return not_assigned;
  ENAMEL_ASSIGN_OR_RETURN(auto stations, StationsText(assigned->assignment));
  ENAMEL_RETURN_IF_ERROR(MayBegin(*assigned, now_ms, station_->id, stations));
  ENAMEL_RETURN_IF_ERROR(MayBeginByClock(*assigned, now_ms, request.station_unix_ms()));
  if (request.for_later() && assigned->assignment.exam) {
    return Status(Code::kForbidden,
                  "an exam begins while the server is there: its ticket cannot be taken in advance",
                  "for_later");
  }
  ENAMEL_RETURN_IF_ERROR(HandMayTake(*assigned, request));
  return std::optional(*assigned);
}

// A ticket for later may not name a hand yet; OpenAttempt checks the hand of every attempt again.
Status Session::HandMayTake(const AssignedRow& assigned, const wire::RequestTicket& request) {
  if (request.for_later() && !request.has_hand()) return Status::Ok();
  const Hand hand = protocol::ReadHand(request.hand());
  ENAMEL_ASSIGN_OR_RETURN(const bool listed, services_.store.devices.IsListed(hand));
  return MayHold(HandsFor(assigned), hand, listed);
}

Result<wire::Reply> Session::Do(const wire::RequestTicket& request) {
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonOf(request.session()));
  ENAMEL_ASSIGN_OR_RETURN(auto content, protocol::ReadSha256(request.exercise(), "exercise"));
  ENAMEL_ASSIGN_OR_RETURN(auto profile, protocol::ReadSha256(request.profile(), "profile"));
  // Asked before an attempt and not at Hello: a station of an older version still gets rid of its
  // recordings.
  if (station_core_version_ != core::kCoreVersion) {
    return Status(Code::kVersion, "the station's core has version " +
                                      std::to_string(station_core_version_) + ", this server's " +
                                      std::to_string(core::kCoreVersion) +
                                      "; install matching versions to begin attempts");
  }
  if (request.as_reference() && !CanRecordReference(person)) {
    return Status(Code::kForbidden, "only instructors and admins record reference cuts",
                  "as_reference");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, services_.store.exercises.ExerciseByContent(content));
  ENAMEL_ASSIGN_OR_RETURN(auto assigned, AssignmentFor(person, exercise, request));
  ENAMEL_ASSIGN_OR_RETURN(auto profiles, services_.store.profiles.Profiles());
  if (std::ranges::find(profiles, profile, &ProfileRow::content) == profiles.end()) {
    return Status(Code::kNotFound, "this server has no device profile " + profile.Hex(), "profile");
  }

  trace::Ticket ticket;
  ticket.attempt = Uuid::New();
  randombytes_buf(ticket.nonce.data(), ticket.nonce.size());
  ticket.person = person.id;
  ticket.station = station_->id;
  ticket.exercise = content;
  ticket.profile = profile;
  ticket.issued_unix_ms = services_.clock();
  ticket.expires_unix_ms = TicketEnd(assigned, ticket.issued_unix_ms);
  trace::SignTicket(ticket, services_.ticket_key.secret_key);
  Bytes encoded = trace::EncodeTicket(ticket);

  AttemptRow row;
  row.id = ticket.attempt;
  row.person = person.id;
  row.station = station_->id;
  row.exercise = exercise.id;
  row.exercise_content = content;
  row.profile_content = profile;
  row.as_reference = request.as_reference();
  row.ticketed_ms = ticket.issued_unix_ms;
  ENAMEL_RETURN_IF_ERROR(SetTiming(row));
  SetTerms(assigned, row);
  // Two versions may say the same: what counts is the one that was assigned, with its reference.
  if (assigned) row.exercise = assigned->exercise.id;
  ENAMEL_RETURN_IF_ERROR(services_.store.tickets.CreateAttempt(
      row, encoded, Actor{person.id, "station " + station_->name}));
  ours_.insert(ticket.attempt);
  wire::Reply reply;
  wire::TicketIssued& issued = *reply.mutable_ticket_issued();
  issued.set_ticket(protocol::ToField(encoded));
  issued.set_exam(row.exam);
  issued.set_late((row.flags & kLate) != 0);
  issued.set_due_unix_ms(row.due_ms);
  if (row.assignment) issued.set_assignment(protocol::ToField(row.assignment->view()));
  issued.set_hands(HandsAllowedName(row.hands));
  issued.set_sign_off(row.sign_off);
  issued.set_outline(ShowsOutline(assigned, exercise));
  return reply;
}

// The core's parameters follow from exercise, scene and profile; a header that names others would
// be scored as something it was not.
Status Session::CheckParams(const trace::Header& header) {
  auto documents =
      scene::ReadDocuments(header.ticket.exercise, header.ticket.profile,
                           [&](const Sha256& hash) { return services_.store.blobs.GetBlob(hash); });
  ENAMEL_RETURN_IF_ERROR(documents.status());
  return scene::CheckMadeOf(*documents, header.scene, header.volume, header.params);
}

Status Session::CheckHeader(const trace::Header& header) {
  const trace::Ticket& ticket = header.ticket;
  if (!trace::VerifyTicket(ticket, services_.ticket_key.public_key)) {
    return Status(Code::kForbidden, "the ticket is not signed by this server; ask for one here",
                  "ticket");
  }
  if (ticket.station != station_->id) {
    return Status(Code::kForbidden, "the ticket was issued to another station", "ticket");
  }
  return Status::Ok();
}

Status Session::MayStillBegin(const trace::Ticket& ticket) const {
  if (services_.clock() <= ticket.expires_unix_ms + kLateUploadMs) return Status::Ok();
  return Status(Code::kConflict, "the ticket ran out too long ago; ask for a new one", "ticket");
}

// A ticket does not name its assignment. Takes the assignments under which the ticket would have
// the same end, and picks among them as for a new ticket. Neither its limit nor another exam is
// held against existing attempts. With none the attempt counts as graded (CanSeeScore). A ticket
// does not mark a reference cut either: any attempt that may be one is scored without a reference
// too, as it has to be before it becomes one.
Status Session::GuessTerms(const trace::Ticket& ticket, AttemptRow& row) {
  auto person = services_.store.people.PersonById(row.person);
  if (person.status().code() == Code::kNotFound) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(person.status());
  row.as_reference = CanRecordReference(*person);
  if (person->role != Role::kStudent) return Status::Ok();
  row.flags |= kReadmitted;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, services_.store.assignments.AssignmentsFor(row.person));
  std::erase_if(rows, [&](const AssignedRow& assigned) {
    return TicketEnd(assigned, ticket.issued_unix_ms) != ticket.expires_unix_ms;
  });
  for (AssignedRow& assigned : rows) assigned.attempts_used = 0;
  const AssignedRow* assigned =
      PickAssignment(rows, row.exercise_content, std::nullopt, row.ticketed_ms, row.station);
  if (assigned) {
    SetTerms(*assigned, row);
    row.exercise = assigned->exercise.id;
  }
  return Status::Ok();
}

Result<std::string> Session::ToldToAwait(const Uuid& attempt) {
  AuditFilter told;
  told.action = "attempt.awaits";
  told.object = attempt.Text();
  told.limit = 1;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, services_.store.audit.FindAudit(told));
  return rows.empty() ? std::string() : rows.front().after_json;
}

Status Session::Await(const trace::Ticket& ticket, const std::string& what,
                      const std::string& which) {
  ENAMEL_ASSIGN_OR_RETURN(auto before, ToldToAwait(ticket.attempt));
  std::string named = "{\"" + what + "\":\"" + which + "\"}";
  // Once for each thing that is missing: a station asks again every few minutes.
  if (before != named) {
    ENAMEL_RETURN_IF_ERROR(services_.store.audit.NoteAudit(
        Actor{{}, "station " + station_->name}, "attempt.awaits", ticket.attempt.Text(), named));
  }
  return Status(Code::kUnavailable,
                "the recording waits here: " + what + " " + which +
                    " is not at the server, which was restored from a backup; an admin has to "
                    "bring it back",
                protocol::kAwaited);
}

Result<AttemptRow> Session::Readmit(const trace::Ticket& ticket) {
  ENAMEL_ASSIGN_OR_RETURN(auto told, ToldToAwait(ticket.attempt));
  // A recording that had to wait may come as late as an admin takes to restore the missing thing.
  if (told.empty()) ENAMEL_RETURN_IF_ERROR(MayStillBegin(ticket));
  auto exercise = services_.store.exercises.ExerciseByContent(ticket.exercise);
  if (exercise.status().code() == Code::kNotFound) {
    return Await(ticket, "exercise", ticket.exercise.Hex());
  }
  ENAMEL_RETURN_IF_ERROR(exercise.status());
  if (!services_.store.blobs.HasBlob(ticket.profile)) {
    return Await(ticket, "profile", ticket.profile.Hex());
  }
  AttemptRow row;
  row.id = ticket.attempt;
  row.person = ticket.person;
  row.station = ticket.station;
  row.exercise = exercise->id;
  row.exercise_content = ticket.exercise;
  row.profile_content = ticket.profile;
  row.ticketed_ms = ticket.issued_unix_ms;
  ENAMEL_RETURN_IF_ERROR(SetTiming(row));
  ENAMEL_RETURN_IF_ERROR(GuessTerms(ticket, row));
  Status made = services_.store.tickets.CreateAttempt(
      row, trace::EncodeTicket(ticket),
      Actor{ticket.person, "station " + station_->name + ", ticket from before a restore"});
  if (made.code() == Code::kNotFound && made.field() == "person") {
    return Await(ticket, "person", ticket.person.Text());
  }
  ENAMEL_RETURN_IF_ERROR(made);
  return services_.store.attempts.AttemptById(ticket.attempt);
}

// Most facts are the same as the last ones: that costs no write.
Status Session::KeepFacts(const AttemptRow& row, const protocol::AttemptFacts& facts) {
  std::string told = protocol::FactsJson(facts);
  if (told == row.facts) return Status::Ok();
  return services_.store.tickets.KeepFacts(row.id, told);
}

Result<wire::Reply> Session::Do(const wire::OpenAttempt& request) {
  ENAMEL_RETURN_IF_ERROR(protocol::CheckFacts(request.facts()));
  ENAMEL_ASSIGN_OR_RETURN(auto header, trace::DecodeHeader(AsBytes(request.header())));
  ENAMEL_RETURN_IF_ERROR(CheckHeader(header));
  const Uuid& attempt = header.ticket.attempt;
  about_ = attempt;
  const LogAttempt logged(attempt);
  auto row = services_.store.attempts.AttemptById(attempt);
  const bool forgotten = row.status().code() == Code::kNotFound;
  if (forgotten) row = Readmit(header.ticket);
  ENAMEL_RETURN_IF_ERROR(row.status());
  // One that is open already had its documents compared when it was opened.
  if (row->state == AttemptState::kTicketed) {
    if (!forgotten) ENAMEL_RETURN_IF_ERROR(MayStillBegin(header.ticket));
    ENAMEL_RETURN_IF_ERROR(CheckParams(header));
  }
  ENAMEL_RETURN_IF_ERROR(services_.store.tickets.OpenAttempt(attempt, AsBytes(request.header())));
  const protocol::AttemptFacts facts = request.facts();
  ENAMEL_RETURN_IF_ERROR(KeepFacts(*row, facts));
  if (facts.resumed() > 0) {
    ENAMEL_RETURN_IF_ERROR(services_.store.judging.FlagAttempt(
        attempt, kResumed, "the station continued from its spool",
        Actor{row->person, "station " + station_->name}));
  }
  ours_.insert(attempt);
  ENAMEL_ASSIGN_OR_RETURN(const uint32_t next, services_.store.recordings.NextChunk(attempt));
  spdlog::info("station \"{}\" sends a recording from chunk {} on", station_->name, next);

  wire::Reply reply;
  reply.mutable_attempt_opened()->set_attempt(protocol::ToField(attempt.view()));
  // The server's position: after a break the station continues from here.
  reply.mutable_attempt_opened()->set_next_seq(next);
  reply.mutable_attempt_opened()->set_watched(services_.live.Watched(attempt));
  return reply;
}

// Why a chunk that this station's key does not fit is refused.
Status Session::NotSigned(ByteView chunk) {
  ENAMEL_ASSIGN_OR_RETURN(auto head, trace::DecodeChunkHead(chunk));
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(head.head.attempt));
  return Status(Code::kForbidden,
                "chunk " + std::to_string(head.head.seq) + " is not signed with this station's key",
                "chunk");
}

Result<wire::Reply> Session::Do(const wire::PutChunk& request) {
  ByteView bytes = AsBytes(request.chunk());
  if (bytes.size() > trace::kMaxChunkBytes) {
    return Status(Code::kTooLarge,
                  "a chunk has at most " + std::to_string(trace::kMaxChunkBytes) +
                      " bytes, this one has " + std::to_string(bytes.size()),
                  "chunk");
  }
  // Signature before content: what this station did not sign is never unpacked.
  trace::PublicKey key{};
  ENAMEL_CHECK(station_->public_key.size() == key.size());
  std::ranges::copy(station_->public_key, key.begin());
  if (!trace::VerifyChunk(bytes, key)) return NotSigned(bytes);
  ENAMEL_ASSIGN_OR_RETURN(auto chunk, trace::DecodeChunk(bytes));
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(chunk.head.attempt));
  const LogAttempt logged(chunk.head.attempt);
  ChunkPut put{chunk.head.attempt, chunk.head, chunk.hash, Bytes(bytes.begin(), bytes.end()),
               services_.clock()};
  ENAMEL_RETURN_IF_ERROR(services_.store.ingest.AppendChunk(put));
  spdlog::debug("chunk {} is stored", chunk.head.seq);
  services_.arrivals.Came(put.attempt, services_.clock());
  const bool watched = services_.live.Watched(put.attempt);
  // Half a second late, of stations that send no LiveState.
  if (watched) services_.live.Put(MomentsOf(chunk, station_->id, services_.clock()));

  wire::Reply reply;
  wire::ChunkAck& ack = *reply.mutable_chunk_ack();
  ack.set_attempt(protocol::ToField(chunk.head.attempt.view()));
  ack.set_seq(chunk.head.seq);
  ack.set_committed(true);
  ack.set_watched(watched);
  AddRemarks(put.attempt, request.shown_remark(), *ack.mutable_remarks());
  return reply;
}

void Session::AddRemarks(const Uuid& attempt, uint64_t shown,
                         google::protobuf::RepeatedPtrField<wire::Remark>& out) {
  if (services_.board == nullptr || !shows_remarks_) return;
  RemarkBoard& remarks = services_.board->remarks();
  remarks.Shown(attempt, shown, services_.clock());
  const std::vector<protocol::Remark> waiting = remarks.Take(attempt);
  for (const protocol::Remark& remark : waiting) {
    protocol::SetRemark(remark, *out.Add());
  }
}

Result<wire::Reply> Session::Do(const wire::Ping& ping) {
  wire::Reply reply;
  reply.mutable_pong()->set_nonce(ping.nonce());
  if (ping.attempt().empty()) return reply;
  ENAMEL_ASSIGN_OR_RETURN(const auto attempt, protocol::ReadUuid(ping.attempt(), "attempt"));
  // Only attempts known to be its own without the store, which a ping does not wait for (IsQuick).
  if (ours_.contains(attempt))
    AddRemarks(attempt, ping.shown_remark(), *reply.mutable_pong()->mutable_remarks());
  return reply;
}

Result<wire::Reply> Session::Do(const wire::SealAttempt& request) {
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, protocol::ReadUuid(request.attempt(), "attempt"));
  ENAMEL_ASSIGN_OR_RETURN(auto last, protocol::ReadSha256(request.last_chunk(), "last_chunk"));
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(attempt));
  const LogAttempt logged(attempt);
  trace::Seal seal{attempt, request.chunks(), request.ticks(), last, request.state_hash()};
  ENAMEL_RETURN_IF_ERROR(services_.store.seals.SealAttempt(seal, services_.clock()));
  spdlog::info("the recording is whole: {} chunks, {} ticks", seal.chunks, seal.ticks);
  // After it is on disk: a viewer who sees the end finds the attempt sealed.
  services_.live.Remove(attempt);
  services_.arrivals.Ended(attempt);
  if (services_.board != nullptr) services_.board->remarks().Remove(attempt);
  wire::Reply reply;
  reply.mutable_sealed()->set_attempt(request.attempt());
  return reply;
}

Result<wire::Reply> Session::Do(const wire::SignOff& request, const Person& signer) {
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, protocol::ReadUuid(request.attempt(), "attempt"));
  const auto at = SignedAtFromName(request.at());
  if (!at) {
    return Status(
        Code::kInvalidInput,
        "expected \"start\" or \"end\", found \"" + ShortenedText(request.at(), 16) + "\"", "at");
  }
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(attempt));
  const LogAttempt logged(attempt);
  ENAMEL_ASSIGN_OR_RETURN(const auto row, services_.store.attempts.AttemptById(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const bool teaches, services_.store.attempts.Teaches(signer.id, attempt));
  if (!CanSignOff(signer, row, teaches)) {
    return Status(Code::kForbidden,
                  "only instructors of this attempt's cohort and admins can sign this", "signer");
  }
  ENAMEL_RETURN_IF_ERROR(services_.store.sign_offs.Sign(
      attempt, *at, services_.clock(), Actor{signer.id, "station " + station_->name}));
  spdlog::info("person {} signs the {}", signer.id.Text(), SignedAtName(*at));
  wire::Reply reply;
  reply.mutable_signed_off()->set_attempt(request.attempt());
  reply.mutable_signed_off()->set_display_name(signer.display_name);
  return reply;
}

Result<Session::Seen> Session::SeenAttempt(const std::string& session_token,
                                           const std::string& field) {
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, protocol::ReadUuid(field, "attempt"));
  Seen seen;
  ENAMEL_ASSIGN_OR_RETURN(seen.person, PersonOf(session_token));
  ENAMEL_ASSIGN_OR_RETURN(seen.row, services_.store.attempts.AttemptById(attempt));
  ENAMEL_ASSIGN_OR_RETURN(seen.teaches, services_.store.attempts.Teaches(seen.person.id, attempt));
  if (CanSeeAttempt(seen.person, seen.row, seen.teaches)) {
    about_ = attempt;
    return seen;
  }
  return Status(Code::kNotFound, "no attempt " + attempt.Text(), "attempt");
}

}  // namespace enamel::server::stations
