#include "server/storage/people/session_rows.h"

#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"

// Sessions of people.
namespace enamel::server {
namespace {

// As audited: a station by its name, as tickets are.
std::string WhereOf(const SessionRow& session) {
  const bool at_station = session.via == "station" && !session.device.empty();
  return at_station ? session.via + " " + session.device : session.via;
}

// The token itself is never stored: somebody who reads the database cannot sign in with its
// content.
constexpr char kSessionSelect[] =
    "SELECT token_hash, person, created_ms, last_used_ms, expires_ms, via, id, confirmed_ms, "
    "address, device FROM sessions WHERE tenant = ?1 AND ";

Result<SessionRow> FindSessionByToken(Db& db, const Sha256& token_hash) {
  Query q(db, std::string(kSessionSelect) + "token_hash = ?2");
  return q.Bind(token_hash).One<SessionRow>("no such session");
}

Result<SessionRow> FindSessionById(Db& db, const Uuid& id) {
  Query q(db, std::string(kSessionSelect) + "id = ?2");
  return q.Bind(id).One<SessionRow>("no such session");
}

}  // namespace

Status DeleteSessions(Db& db, const Uuid& person) {
  return Query(db, "DELETE FROM sessions WHERE tenant = ?1 AND person = ?2").Bind(person).Run();
}

Status SessionRows::CreateSession(const SessionRow& session) {
  const Uuid id = session.id.IsZero() ? Uuid::New() : session.id;
  return rows_.Write([&](Db& db) -> Status {
    // The only sweep there is: every sign-in drops what ended.
    ENAMEL_RETURN_IF_ERROR(Query(db, "DELETE FROM sessions WHERE tenant = ?1 AND expires_ms < ?2")
                               .Bind(session.created_ms)
                               .Run());
    ENAMEL_RETURN_IF_ERROR(
        Insert(db, "sessions", "token_hash", session.token_hash, "person", session.person,
               "created_ms", session.created_ms, "last_used_ms", session.last_used_ms, "expires_ms",
               session.expires_ms, "via", session.via, "id", id, "confirmed_ms",
               session.confirmed_ms != 0 ? session.confirmed_ms : session.created_ms, "address",
               session.address, "device", session.device));
    return WriteAuditAbout(db, SubjectOf("session", id.Text()),
                           Actor{session.person, WhereOf(session)}, "session.begin",
                           session.person.Text(), "{}",
                           session.address.empty() ? "{}" : JsonOf({{"address", session.address}}));
  });
}

Result<SessionRow> SessionRows::FindSession(const Sha256& token_hash) {
  return rows_.Read([&](Db& db) { return FindSessionByToken(db, token_hash); });
}

Result<SessionRow> SessionRows::SessionById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindSessionById(db, id); });
}

Result<std::vector<SessionRow>> SessionRows::SessionsOf(const Uuid& person) {
  return rows_.Read([&](Db& db) -> Result<std::vector<SessionRow>> {
    Query q(db, std::string(kSessionSelect) + "person = ?2 ORDER BY created_ms DESC, id");
    return q.Bind(person).All<SessionRow>();
  });
}

// Whoever only reads is not to wait for it: the next request is in time too.
Status SessionRows::TouchSession(const Sha256& token_hash, UnixMs now_ms) {
  if (look_.ChangesWait()) return Status::Ok();
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "UPDATE sessions SET last_used_ms = ?3 WHERE tenant = ?1 AND token_hash = ?2");
    return q.Bind(token_hash, now_ms).Run();
  });
}

Status SessionRows::ConfirmSession(const Sha256& token_hash, UnixMs now_ms) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "UPDATE sessions SET confirmed_ms = ?3 WHERE tenant = ?1 AND token_hash = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(token_hash, now_ms).Run());
    ENAMEL_RETURN_IF_ERROR(MustHaveChanged(db, "such session"));
    ENAMEL_ASSIGN_OR_RETURN(const auto session, FindSessionByToken(db, token_hash));
    return WriteAuditAbout(db, SubjectOf("session", session.id.Text()),
                           Actor{session.person, WhereOf(session)}, "session.confirm",
                           session.person.Text(), "{}", "{}");
  });
}

Status SessionRows::EndSession(const Sha256& token_hash) {
  return rows_.Write([&](Db& db) -> Status {
    return Query(db, "DELETE FROM sessions WHERE tenant = ?1 AND token_hash = ?2")
        .Bind(token_hash)
        .Run();
  });
}

// By id, which a list may show, unlike what the token is found by.
Status SessionRows::EndSessionById(const Uuid& id, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto session, FindSessionById(db, id));
    ENAMEL_RETURN_IF_ERROR(
        Query(db, "DELETE FROM sessions WHERE tenant = ?1 AND id = ?2").Bind(id).Run());
    return WriteAudit(db, by, "session.end", session.person.Text(), "{}", "{}");
  });
}

Result<size_t> SessionRows::EndSessionsOf(const Uuid& person, const Actor& by) {
  size_t ended = 0;
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(DeleteSessions(db, person));
    ended = static_cast<size_t>(db.Changes());
    if (ended == 0) return Status::Ok();
    return WriteAudit(db, by, "session.end", person.Text(), "{}",
                      JsonOf({{"sessions", std::to_string(ended)}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return ended;
}

}  // namespace enamel::server
