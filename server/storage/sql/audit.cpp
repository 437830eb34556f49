#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>

#include "server/storage/sql/decisions.h"
#include "server/storage/sql/sqlite_impl.h"

// The audit trail: read and added to, never changed (schemas/sql/0012_signed_trail.sql).
namespace enamel::server::sqlite {
namespace {

constexpr char kAuditSelect[] =
    "SELECT at_ms, actor, via, action, object, before_json, after_json, id FROM audit "
    "WHERE tenant = ?1";

// An actor without an id is a command line, a station or the server itself; `via` says which.
Result<std::vector<AuditRow>> AuditIn(
    Query& q, const std::function<bool(const Query&)>& wanted = [](const Query&) { return true; }) {
  std::vector<AuditRow> out;
  while (q.Next()) {
    if (!wanted(q)) continue;
    Uuid actor = q.Id(1);
    std::string who = actor.IsZero() ? q.Text(2) : actor.Text() + " (" + q.Text(2) + ")";
    out.push_back(AuditRow{q.Int(0), who, q.Text(3), q.Text(4), q.Text(5), q.Text(6), q.Id(7)});
  }
  if (!q.status().ok()) return q.status();
  return out;
}

}  // namespace

Json JsonOf(std::initializer_list<std::pair<const char*, std::string>> members) {
  boost::json::object object;
  for (const auto& [name, value] : members) object[name] = value;
  return boost::json::serialize(object);
}

namespace {

// Ids are in the order of time; the trail's order holds also where the clock has been set back.
Result<Uuid> NextAuditId(Db& db) {
  Uuid fresh = Uuid::New();
  Query q(db, "SELECT id FROM audit WHERE tenant = ?1 ORDER BY id DESC LIMIT 1");
  Uuid newest;
  if (q.Next()) newest = q.Id(0);
  if (!q.status().ok()) return q.status();
  if (newest.bytes < fresh.bytes) return fresh;
  for (size_t i = newest.bytes.size(); i-- > 0;) {
    if (++newest.bytes[i] != 0) break;
  }
  return newest;
}

}  // namespace

// In the transaction of what it tells of: neither is there without the other.
Status WriteAuditAbout(Db& db, const std::string& subject, const Actor& by, const char* action,
                       const std::string& object, const Json& before, const Json& after) {
  const auto* signer = dynamic_cast<const AuditSigner*>(db.companion());
  ENAMEL_CHECK(signer != nullptr);
  std::string state;
  if (!subject.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(state, StateOf(db, subject));
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto id, NextAuditId(db));
  const AuditSalt salt = NewAuditSalt();
  const AuditSeal seal{id,     NowMs(), by.person, by.via,
                       action, object,  subject,   AuditContentHash(salt, before, after, state)};
  Query q(db,
          "INSERT INTO audit (tenant, id, at_ms, actor, via, action, object, before_json, "
          "after_json, subject, state, salt, content_hash, signature) VALUES (?1, ?2, ?3, ?4, ?5, "
          "?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)");
  q.Bind(seal.id).Bind(seal.at_ms).Bind(seal.actor).Bind(seal.via).Bind(seal.action);
  q.Bind(seal.object).Bind(before).Bind(after).Bind(seal.subject).Bind(state);
  q.Bind(ByteView(salt)).Bind(seal.content);
  return q.Bind(ByteView(SignAuditSeal(seal, signer->key))).Run();
}

Status WriteAudit(Db& db, const Actor& by, const char* action, const std::string& object,
                  const Json& before, const Json& after) {
  return WriteAuditAbout(db, SubjectOfAction(action, object), by, action, object, before, after);
}

Result<Json> UnsignedRows(Db& db) {
  Query q(db,
          "SELECT id, at_ms, actor, via, action, object FROM audit WHERE tenant = ?1 AND signature "
          "IS NULL ORDER BY id");
  Sha256Stream hash;
  uint64_t rows = 0;
  for (; q.Next(); ++rows) {
    ByteWriter row;
    row.Raw(q.Id(0).view());
    row.I64(q.Int(1));
    row.Raw(q.Id(2).view());
    for (int i = 3; i < 6; ++i) row.Text(q.Text(i));
    hash.Update(row.bytes());
  }
  if (!q.status().ok()) return q.status();
  return JsonOf({{"rows", std::to_string(rows)}, {"sha256", hash.Finish().Hex()}});
}

namespace {

// An erasure finds what the trail tells of a person's attempts by the rows of their tickets. Where
// there is none, it is written now.
Status TellWhoseAttempt(Db& db, const std::string& attempt, const Actor& by) {
  Query told(db,
             "SELECT 1 FROM audit WHERE tenant = ?1 AND object = ?2 AND action = 'attempt.ticket'");
  if (told.Bind(attempt).Next() || !told.status().ok()) return told.status();
  ENAMEL_ASSIGN_OR_RETURN(const auto id, Uuid::Parse(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const auto row, FindAttempt(db, id));
  return WriteAuditAbout(db, "", by, "attempt.ticket", attempt, "{}",
                         JsonOf({{"person", row.person.Text()}}));
}

}  // namespace

Status BeginSignedTrail(Db& db) {
  const auto waits = [&]() -> Result<bool> {
    // Not where rows are signed: what was changed behind their back would be signed too.
    Query q(db,
            "SELECT 1 FROM audit_to_begin WHERE tenant = ?1 AND NOT EXISTS (SELECT 1 FROM audit a "
            "WHERE a.tenant = ?1 AND a.signature IS NOT NULL)");
    const bool found = q.Next();
    if (!q.status().ok()) return q.status();
    return found;
  };
  ENAMEL_ASSIGN_OR_RETURN(const bool look, waits());
  if (!look) return Status::Ok();
  sql::Transaction transaction(db);
  ENAMEL_RETURN_IF_ERROR(transaction.begun());
  // Another process may have been faster.
  ENAMEL_ASSIGN_OR_RETURN(const bool begin, waits());
  if (!begin) return Status::Ok();
  const Actor by{{}, "upgrade"};
  ENAMEL_ASSIGN_OR_RETURN(const auto before, UnsignedRows(db));
  ENAMEL_RETURN_IF_ERROR(WriteAudit(db, by, kAuditBegin, "", "{}", before));
  ENAMEL_ASSIGN_OR_RETURN(const auto present, PresentSubjects(db));
  for (const auto& [subject, object] : present) {
    const std::string kind = subject.substr(0, subject.find(' ')), action = kind + ".adopt";
    if (kind == "attempt") ENAMEL_RETURN_IF_ERROR(TellWhoseAttempt(db, object, by));
    ENAMEL_RETURN_IF_ERROR(WriteAuditAbout(db, subject, by, action.c_str(), object, "{}", "{}"));
  }
  ENAMEL_RETURN_IF_ERROR(Query(db, "DELETE FROM audit_to_begin WHERE tenant = ?1").Run());
  return transaction.Commit();
}

Result<std::vector<AuditRow>> SqliteStore::Audit(uint32_t limit) {
  AuditFilter filter;
  filter.limit = limit;
  return FindAudit(filter);
}

Result<std::vector<AuditRow>> SqliteStore::FindAudit(const AuditFilter& filter) {
  std::string sql = std::string(kAuditSelect) + " AND at_ms BETWEEN ?2 AND ?3";
  int places = 3;
  auto place = [&] { return "?" + std::to_string(++places); };
  bool kind = filter.action.ends_with('.');
  if (filter.actor) sql += " AND actor = " + place();
  if (!filter.action.empty()) {
    const std::string action = place();
    // Not LIKE, in which % and _ of the asker would mean something.
    sql += kind ? " AND substr(action, 1, length(" + action + ")) = " + action
                : " AND action = " + action;
  }
  if (!filter.object.empty()) sql += " AND object = " + place();
  if (filter.before) sql += " AND id < " + place();
  sql += " ORDER BY id DESC LIMIT " + place();
  return Read([&](Db& db) -> Result<std::vector<AuditRow>> {
    Query q(db, sql.c_str());
    q.Bind(filter.from_ms).Bind(filter.until_ms != 0 ? filter.until_ms : INT64_MAX);
    if (filter.actor) q.Bind(*filter.actor);
    if (!filter.action.empty()) q.Bind(filter.action);
    if (!filter.object.empty()) q.Bind(filter.object);
    if (filter.before) q.Bind(*filter.before);
    return AuditIn(q.Bind(int64_t{std::clamp<uint32_t>(filter.limit, 1, 1000)}));
  });
}

// Rows name an attempt by its id and not by its person, so the person's attempts are looked up
// first. All rows are read: this is asked once in a while, for one person's data.
Result<std::vector<AuditRow>> SqliteStore::AuditAbout(const Uuid& person) {
  return Read([&](Db& db) -> Result<std::vector<AuditRow>> {
    std::set<std::string> objects{person.Text()};
    {
      Query q(db, "SELECT id FROM attempts WHERE tenant = ?1 AND person = ?2");
      q.Bind(person);
      while (q.Next()) objects.insert(q.Id(0).Text());
      if (!q.status().ok()) return q.status();
    }
    static const std::string kSql = std::string(kAuditSelect) + " ORDER BY id";
    Query q(db, kSql.c_str());
    return AuditIn(
        q, [&](const Query& row) { return row.Id(1) == person || objects.contains(row.Text(4)); });
  });
}

Status SqliteStore::NoteAudit(const Actor& by, const std::string& action, const std::string& object,
                              const std::string& after_json) {
  return Write(
      [&](Db& db) { return WriteAudit(db, by, action.c_str(), object, "{}", after_json); });
}

}  // namespace enamel::server::sqlite
