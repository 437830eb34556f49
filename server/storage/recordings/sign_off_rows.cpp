#include "server/storage/recordings/sign_off_rows.h"

#include <optional>
#include <string>

#include "common/protocol/refusals.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/training/ticket_rules.h"

namespace enamel::server {
namespace {

Result<std::optional<Uuid>> SignerOf(Db& db, const Uuid& attempt, SignedAt at) {
  Query q(db, "SELECT signer FROM sign_offs WHERE tenant = ?1 AND attempt = ?2 AND stage = ?3");
  const bool found = q.Bind(attempt, SignedAtName(at)).Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  return found ? std::optional(q.Id(0)) : std::nullopt;
}

Status MayBeSignedNow(const AttemptRow& row, SignedAt at, UnixMs now_ms) {
  auto conflict = [](const char* why, const char* field) {
    return Status(Code::kConflict, why, field);
  };
  if (!row.sign_off) {
    return conflict("this attempt needs no signature at the chair", protocol::kNotToSign);
  }
  const bool opened = row.state != AttemptState::kTicketed;
  if (at == SignedAt::kStart) {
    if (opened || (row.flags & kReturned) != 0) {
      return conflict(
          "the start of this attempt can no longer be signed: it was begun, or its ticket was "
          "given back",
          protocol::kStartAgain);
    }
    // The signer saw who begins now, and not who began an hour later.
    if (now_ms > row.ticketed_ms + kExamTicketValidMs) {
      return conflict(
          "the ticket of this attempt ran out after 10 minutes; go back and start again",
          protocol::kStartAgain);
    }
    return Status::Ok();
  }
  if (!opened) {
    return conflict("this attempt has not arrived at the server yet; try again",
                    protocol::kNotArrived);
  }
  if (row.sealed_ms == 0) return Status::Ok();
  return conflict("this attempt is handed in, so its end can no longer be signed",
                  protocol::kNotToSign);
}

}  // namespace

Status SignOffRows::Sign(const Uuid& attempt, SignedAt at, UnixMs now_ms, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindAttempt(db, attempt));
    ENAMEL_ASSIGN_OR_RETURN(const auto signer, SignerOf(db, attempt, at));
    if (signer == by.person) return Status::Ok();
    if (signer) {
      return Status(Code::kConflict, "somebody else has signed this already",
                    protocol::kSignedAlready);
    }
    ENAMEL_RETURN_IF_ERROR(MayBeSignedNow(row, at, now_ms));
    ENAMEL_RETURN_IF_ERROR(Insert(db, "sign_offs", "attempt", attempt, "stage", SignedAtName(at),
                                  "signer", by.person, "signed_ms", now_ms));
    return WriteAudit(db, by, "attempt.sign_off", attempt.Text(), "{}",
                      JsonOf({{"at", SignedAtName(at)}}));
  });
}

Result<std::vector<SignOffRow>> SignOffRows::SignOffsOf(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<std::vector<SignOffRow>> {
    Query q(db,
            "SELECT s.stage, s.signer, coalesce(p.display_name, ''), s.signed_ms FROM sign_offs s "
            "LEFT JOIN people p ON p.tenant = s.tenant AND p.id = s.signer WHERE s.tenant = ?1 AND "
            "s.attempt = ?2 ORDER BY s.stage DESC");
    std::vector<SignOffRow> out;
    for (q.Bind(attempt); q.Next();) {
      const auto at = SignedAtFromName(q.Text(0));
      if (at) out.push_back({*at, q.Id(1), q.Text(2), q.Int(3)});
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
    return out;
  });
}

Status StartMustBeSigned(Db& db, const Uuid& attempt) {
  bool required = false;
  {
    Query q(db, "SELECT sign_off FROM attempts WHERE tenant = ?1 AND id = ?2");
    required = q.Bind(attempt).Next() && q.Int(0) != 0;
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  if (!required) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const auto signer, SignerOf(db, attempt, SignedAt::kStart));
  if (signer) return Status::Ok();
  return Status(Code::kForbidden,
                "this exam needs the signature of a second person before it begins, and there is "
                "none: begin another attempt, with an instructor at the chair",
                "sign_off");
}

}  // namespace enamel::server
