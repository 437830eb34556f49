#include "common/base/log_request.h"
#include "server/stations/session.h"

// Recordings that a station still has and this server may have lost, and returned tickets.
namespace enamel::server::stations {
namespace {

constexpr int kMaxOffered = 1024;

}  // namespace

Result<wire::Reply> Session::Do(const wire::OfferAttempts& request) {
  if (request.attempts_size() > kMaxOffered || request.tickets_size() > kMaxOffered) {
    return Status(
        Code::kTooLarge,
        "at most " + std::to_string(kMaxOffered) + " attempts and as many tickets at once",
        "attempts");
  }
  wire::Reply reply;
  wire::AttemptsWanted& wanted = *reply.mutable_attempts_wanted();
  for (const wire::HeldAttempt& held : request.attempts()) {
    ENAMEL_ASSIGN_OR_RETURN(auto lacks, Lacks(held));
    if (lacks) wanted.add_attempts(held.attempt());
  }
  for (const std::string& ticket : request.tickets()) {
    ENAMEL_ASSIGN_OR_RETURN(auto attempt, protocol::ReadUuid(ticket, "tickets"));
    ENAMEL_ASSIGN_OR_RETURN(auto revoked, Revoked(attempt));
    if (revoked) wanted.add_revoked(ticket);
  }
  return reply;
}

Result<bool> Session::Lacks(const wire::HeldAttempt& held) {
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, protocol::ReadUuid(held.attempt(), "attempts.attempt"));
  auto row = services_.store.attempts.AttemptById(attempt);
  if (row.status().code() == Code::kNotFound) return true;
  ENAMEL_RETURN_IF_ERROR(row.status());
  // Another station's counts as complete: the offering station keeps it and learns nothing.
  if (row->station != station_->id) return false;
  if (row->state == AttemptState::kTicketed || row->state == AttemptState::kRecording) return true;
  // What has a row may still have lost its recording.
  const auto whole = services_.store.recordings.IsWhole(attempt);
  // Not known now: it is offered again with the next connection.
  return whole.ok() && !*whole;
}

Result<bool> Session::Revoked(const Uuid& attempt) {
  auto row = services_.store.attempts.AttemptById(attempt);
  // Issued before a restore: its signature says that it was.
  if (row.status().code() == Code::kNotFound) return false;
  ENAMEL_RETURN_IF_ERROR(row.status());
  bool open = row->state == AttemptState::kTicketed && (row->flags & kReturned) == 0;
  if (row->station != station_->id || !open) return true;
  auto person = services_.store.people.PersonById(row->person);
  if (person.status().code() == Code::kNotFound) return true;
  ENAMEL_RETURN_IF_ERROR(person.status());
  return person->disabled;
}

Result<wire::Reply> Session::Do(const wire::ReturnTicket& request) {
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, protocol::ReadUuid(request.attempt(), "attempt"));
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(attempt));
  const LogAttempt logged(attempt);
  ENAMEL_RETURN_IF_ERROR(
      services_.store.tickets.ReturnTicket(attempt, Actor{{}, "station " + station_->name}));
  wire::Reply reply;
  reply.mutable_ticket_returned()->set_attempt(request.attempt());
  return reply;
}

}  // namespace enamel::server::stations
