#include <algorithm>

#include "common/base/pin.h"
#include "common/base/unix_time.h"
#include "station/session/workplace.h"

namespace enamel::station {

Status Workplace::Reserve(const PreparedAttempt& prepared, const std::string& pin) {
  ENAMEL_RETURN_IF_ERROR(CheckPin(pin));
  auto link = UseLink();
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*link));
  ENAMEL_ASSIGN_OR_RETURN(
      auto issued,
      link->RequestTicket(
          credentials_, who,
          {prepared.exercise_hash, prepared.profile_hash, prepared.assignment, false, true, {}}));
  LockedTicket names;
  names.person = who.display_name;
  names.exercise = prepared.exercise.name;
  names.title = prepared.exercise.title;
  names.profile = prepared.profile.name;
  names.hands = issued.hands;
  names.outline = issued.terms.outline;
  return safe_.Put(issued.ticket, names, pin);
}

Result<std::vector<ReservedAttempt>> Workplace::Reserved() {
  ENAMEL_ASSIGN_OR_RETURN(auto tickets, safe_.List());
  std::vector<ReservedAttempt> out;
  for (LockedTicket& t : tickets) {
    auto begun = spool_->Get(t.attempt);
    if (begun.ok() && begun->seal) {
      ENAMEL_RETURN_IF_ERROR(safe_.Remove(t.attempt));
    } else {
      out.push_back({std::move(t), begun.ok()});
    }
  }
  return out;
}

Result<HandedBack> Workplace::HandBackNow(const Uuid& attempt) {
  ENAMEL_RETURN_IF_ERROR(safe_.HandBack(attempt));
  auto link = UseLink();
  const bool connected = link->connected();
  // Giving back needs no sign-in, so it may have to connect first. That connection is not kept: a
  // person who signs in makes a new one.
  Status told = connected ? Status::Ok() : link->Connect(credentials_);
  if (told.ok()) told = TellReturned(*link);
  if (!connected) link->Close();
  if (told.ok()) return HandedBack::kAtServer;
  uploader_.Wake();
  return HandedBack::kLater;
}

Result<HandedBack> Workplace::GiveBack(const Uuid& attempt, const std::string& pin) {
  ENAMEL_RETURN_IF_ERROR(safe_.Open(attempt, pin).status());
  return HandBackNow(attempt);
}

// The server gives information on an attempt only to people who may see it.
Result<HandedBack> Workplace::GiveBack(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto progress, Progress(attempt));
  return HandBackNow(attempt);
}

// The server's later checks of the recording: better now than after the attempt.
Status Workplace::CheckTicket(const trace::Ticket& ticket) const {
  const std::string name = "the ticket of attempt " + ticket.attempt.Text();
  if (ticket.station != credentials_.station) {
    return Status(Code::kForbidden, name + " is for station " + ticket.station.Text() +
                                        ", this one is " + credentials_.station.Text() +
                                        ": make the attempt there, or take another ticket");
  }
  if (!trace::VerifyTicket(ticket, credentials_.ticket_key)) {
    return Status(Code::kForbidden,
                  name +
                      " was not signed by this station's server, or was changed since: take "
                      "another one");
  }
  if (ticket.expires_unix_ms > UnixMs()) return Status::Ok();
  return Status(Code::kForbidden, name + " has expired: take another one (they last 12 hours)");
}

Result<PreparedAttempt> Workplace::PrepareReserved(const Uuid& attempt, const std::string& pin) {
  if (spool_->Get(attempt).ok()) {
    return Status(Code::kConflict, "attempt " + attempt.Text() + " was begun already: resume it");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto ticket, safe_.Open(attempt, pin));
  ENAMEL_RETURN_IF_ERROR(CheckTicket(ticket));
  ENAMEL_ASSIGN_OR_RETURN(auto prepared, FromCache(ticket.exercise, ticket.profile));
  prepared.header.ticket = ticket;
  ENAMEL_ASSIGN_OR_RETURN(const auto locked, safe_.List());
  auto found = std::ranges::find(locked, attempt, &LockedTicket::attempt);
  if (found != locked.end()) {
    prepared.hands = found->hands;
    prepared.terms.outline = found->outline;
  }
  return prepared;
}

}  // namespace enamel::station
