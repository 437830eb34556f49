#include "server/storage/recordings/ticket_rows.h"

#include <algorithm>
#include <string>

#include "server/storage/attempts/attempt_flags.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/people/device_rows.h"
#include "server/storage/recordings/sign_off_rows.h"
#include "server/storage/recordings/trace_rows.h"
#include "server/storage/teaching/assignment_rows.h"

namespace enamel::server {
namespace {

Result<bool> Is(Db& db, const char* sql, const Uuid& id) {
  Query q(db, sql);
  return q.Bind(id).Any();
}

// Names the missing thing: after a restore it may come back.
Status MustBeHere(Db& db, const AttemptRow& row) {
  const struct {
    const char* what;
    const char* sql;
    const Uuid& id;
  } things[] = {
      {"person", "SELECT 1 FROM people WHERE tenant = ?1 AND id = ?2", row.person},
      {"station", "SELECT 1 FROM stations WHERE tenant = ?1 AND id = ?2", row.station},
      {"exercise", "SELECT 1 FROM exercises WHERE tenant = ?1 AND id = ?2", row.exercise},
  };
  for (const auto& thing : things) {
    ENAMEL_ASSIGN_OR_RETURN(auto there, Is(db, thing.sql, thing.id));
    if (there) continue;
    std::string what = thing.what;
    return Status(Code::kNotFound, "there is no " + what + " " + thing.id.Text() + " here", what);
  }
  return Status::Ok();
}

// Copies the header's hand into columns, for lists. A hand that the terms do not admit is flagged
// and not refused: the recording is kept, and quarantined at its seal.
Status KeepHand(Db& db, const Uuid& attempt, ByteView header) {
  auto decoded = trace::DecodeHeader(header);
  // The caller of OpenAttempt has read the header; a header of another version names no hand.
  if (!decoded.ok()) return Status::Ok();
  const Hand& hand = decoded->hand;
  {
    Query q(db,
            "UPDATE attempts SET hand_kind = ?3, hand_device = ?4, hand_driver = ?5, hand_unit = "
            "?6 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, hand.kind, hand.device, hand.driver, hand.unit).Run());
  }
  Query terms(db, "SELECT hands FROM attempts WHERE tenant = ?1 AND id = ?2");
  const bool found = terms.Bind(attempt).Next();
  ENAMEL_RETURN_IF_ERROR(terms.status());
  if (!found) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const bool listed, IsListedIn(db, hand));
  Status may = MayHold(static_cast<HandsAllowed>(terms.Int(0)), hand, listed);
  if (may.ok()) return may;
  return SetFlags(db, attempt, kOtherHand, may.message(), Actor{{}, "station link"});
}

}  // namespace

Status TicketRows::CreateAttempt(const AttemptRow& row, ByteView ticket, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeHere(db, row));
    ENAMEL_RETURN_IF_ERROR(MayBeIssued(db, row));
    ENAMEL_RETURN_IF_ERROR(
        Explain(Insert(db, "attempts", "id", row.id, "person", row.person, "station", row.station,
                       "exercise", row.exercise, "profile_content", row.profile_content, "state",
                       AttemptState::kTicketed, "as_reference", row.as_reference, "ticketed_ms",
                       row.ticketed_ms, "ticket", ticket, "exam", row.exam, "due_ms", row.due_ms,
                       "rate_hz", row.rate_hz, "limit_ticks", row.limit_ticks, "flags", row.flags,
                       "assignment", row.assignment, "hands", row.hands, "sign_off", row.sign_off),
                "attempt " + row.id.Text() + " exists"));
    return WriteAudit(db, by, "attempt.ticket", row.id.Text(), "{}",
                      JsonOf({{"person", row.person.Text()},
                              {"exercise", row.exercise.Text()},
                              {"assignment", row.assignment ? row.assignment->Text() : ""},
                              {"exam", row.exam ? "yes" : "no"}}));
  });
  // Erased or never here: only the key ring knows, because both have no row. A station that was
  // away may still offer such a person's recordings.
  bool nobody = status.code() == Code::kNotFound && status.field() == "person";
  if (!nobody) return status;
  ENAMEL_ASSIGN_OR_RETURN(const bool gone, keyring_.IsGone(row.person));
  if (!gone) return status;
  return Status(Code::kConflict,
                "this person was erased; the server accepts nothing of theirs any more", "person");
}

// Twice is the same as once: the station tells it until it has an answer.
Status TicketRows::ReturnTicket(const Uuid& attempt, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
    if ((row.flags & kReturned) != 0) return Status::Ok();
    // Otherwise handing back would be a way to try until it goes well.
    if (row.state != AttemptState::kTicketed) {
      return Status(Code::kConflict,
                    "attempt " + attempt.Text() +
                        " was begun, so its ticket is used up; an instructor can excuse the "
                        "attempt so that it does not count",
                    "attempt");
    }
    Query q(db, "UPDATE attempts SET flags = flags | ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, kReturned).Run());
    return WriteAudit(db, by, "attempt.return", attempt.Text(),
                      JsonOf({{"state", AttemptStateName(row.state)}}),
                      JsonOf({{"returned", "yes"}}));
  });
}

Status TicketRows::OpenAttempt(const Uuid& attempt, ByteView header) {
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  const Status opened = rows_.WriteRow(Writer::Work([&](Db& db, bool& keep_anyway) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kToDecide));
    if (ingest.has_header) {
      ENAMEL_ASSIGN_OR_RETURN(auto stored, HeaderOf(db, attempt));
      // A station that lost the answer opens again; a ticket used twice brings another header.
      if (std::ranges::equal(stored, header)) return Status::Ok();
      keep_anyway = true;
      ENAMEL_RETURN_IF_ERROR(Contradicted(db, attempt,
                                          "a header came with another hash, " +
                                              HashSha256(header).Hex() + ", than the stored " +
                                              HashSha256(stored).Hex()));
      return Status(Code::kConflict,
                    "the ticket of attempt " + attempt.Text() +
                        " was used for another recording; get a new ticket",
                    "ticket");
    }
    if ((ingest.flags & kReturned) != 0) {
      return Status(
          Code::kConflict,
          "the ticket of attempt " + attempt.Text() +
              " was handed back, so nothing can be recorded with it; ask for a new ticket",
          "ticket");
    }
    // A ticket that a restore forgot has lost its signatures too; the recording may be the only
    // copy of an exam.
    if ((ingest.flags & kReadmitted) == 0) ENAMEL_RETURN_IF_ERROR(StartMustBeSigned(db, attempt));
    {
      Query q(db, "UPDATE attempts SET header = ?3, head_hash = ?4, state = " +
                      Sql(AttemptState::kRecording) +
                      ", trace_bytes = ?5 "
                      "WHERE tenant = ?1 AND id = ?2");
      ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, header, HashSha256(header), header.size()).Run());
    }
    return KeepHand(db, attempt, header);
  }));
  // So that the first chunk need not wait for a store of keys; it asks again.
  if (opened.ok()) (void)keys_.KeyOf(attempt);
  return opened;
}

Status TicketRows::KeepFacts(const Uuid& attempt, const std::string& facts) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "UPDATE attempts SET facts = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, facts).Run());
    ENAMEL_RETURN_IF_ERROR(MustHaveChanged(db, "attempt " + attempt.Text()));
    return WriteAudit(db, Actor{{}, "station link"}, "attempt.facts", attempt.Text(), "{}", "{}");
  });
}

}  // namespace enamel::server
