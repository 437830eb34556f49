#include "server/storage/sqlite_impl.h"

// People, their sessions, cohorts.
namespace enamel::server::sqlite {
namespace {

constexpr char kPersonColumns[] = "id, login, display_name, role, disabled, created_ms";

Person PersonOf(const Query& q) {
  Person out;
  out.id = q.Id(0);
  out.login = q.Text(1);
  out.display_name = q.Text(2);
  out.role = static_cast<Role>(q.Int(3));
  out.disabled = q.Int(4) != 0;
  out.created_ms = q.Int(5);
  return out;
}

Cohort CohortOf(const Query& q) { return Cohort{q.Id(0), q.Text(1)}; }

Result<std::vector<Cohort>> CohortsIn(Query& q) {
  std::vector<Cohort> out;
  while (q.Next()) out.push_back(CohortOf(q));
  if (!q.status().ok()) return q.status();
  return out;
}

Result<std::vector<Person>> PeopleIn(Query& q) {
  std::vector<Person> out;
  while (q.Next()) out.push_back(PersonOf(q));
  if (!q.status().ok()) return q.status();
  return out;
}

Result<Person> OnePerson(Query& q, const std::string& what) {
  if (q.Next()) return PersonOf(q);
  if (!q.status().ok()) return q.status();
  return Status(Code::kNotFound, "no person " + what);
}

Status MustHaveChanged(Db& db, const std::string& what) {
  if (db.Changes() > 0) return Status::Ok();
  return Status(Code::kNotFound, "no " + what);
}

Status DeleteSessions(Db& db, const Uuid& person) {
  return Query(db, "DELETE FROM sessions WHERE tenant = ?1 AND person = ?2").Bind(person).Run();
}

}  // namespace

Result<Uuid> SqliteStore::CreatePerson(const Person& person, const std::string& password_verifier,
                                       const Actor& by) {
  Uuid id = person.id.IsZero() ? Uuid::New() : person.id;
  Status status = Write([&](Db& db) -> Status {
    Query q(db,
            "INSERT INTO people (tenant, id, login, display_name, role, disabled, created_ms, "
            "verifier) "
            "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)");
    q.Bind(id).Bind(person.login).Bind(person.display_name).Bind(static_cast<int64_t>(person.role));
    q.Bind(static_cast<int64_t>(person.disabled));
    q.Bind(person.created_ms != 0 ? person.created_ms : NowMs()).Bind(password_verifier);
    ENAMEL_RETURN_IF_ERROR(
        Explain(q.Run(), "there is already a person with the login \"" + person.login + "\""));
    return WriteAudit(db, by, "person.create", id.Text(), "{}",
                      JsonOf({{"role", RoleName(person.role)}}));
  });
  if (!status.ok()) return status;
  return id;
}

Result<Person> SqliteStore::PersonById(const Uuid& id) {
  return Read([&](Db& db) -> Result<Person> {
    static const std::string kSql =
        std::string("SELECT ") + kPersonColumns + " FROM people WHERE tenant = ?1 AND id = ?2";
    Query q(db, kSql.c_str());
    return OnePerson(q.Bind(id), id.Text());
  });
}

Result<Person> SqliteStore::PersonByLogin(const std::string& login) {
  return Read([&](Db& db) -> Result<Person> {
    static const std::string kSql =
        std::string("SELECT ") + kPersonColumns + " FROM people WHERE tenant = ?1 AND login = ?2";
    Query q(db, kSql.c_str());
    return OnePerson(q.Bind(login), "with the login \"" + login + "\"");
  });
}

Result<std::string> SqliteStore::PasswordVerifier(const Uuid& person) {
  return Read([&](Db& db) -> Result<std::string> {
    Query q(db, "SELECT verifier FROM people WHERE tenant = ?1 AND id = ?2");
    if (q.Bind(person).Next()) return q.Text(0);
    if (!q.status().ok()) return q.status();
    return Status(Code::kNotFound, "no person " + person.Text());
  });
}

Status SqliteStore::SetPassword(const Uuid& person, const std::string& verifier, const Actor& by) {
  return Write([&](Db& db) -> Status {
    Query q(db, "UPDATE people SET verifier = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(person).Bind(verifier).Run());
    ENAMEL_RETURN_IF_ERROR(MustHaveChanged(db, "person " + person.Text()));
    ENAMEL_RETURN_IF_ERROR(DeleteSessions(db, person));
    return WriteAudit(db, by, "person.password", person.Text(), "{}", "{}");
  });
}

Status SqliteStore::SetDisabled(const Uuid& person, bool disabled, const Actor& by) {
  return Write([&](Db& db) -> Status {
    Query q(db, "UPDATE people SET disabled = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(person).Bind(static_cast<int64_t>(disabled)).Run());
    ENAMEL_RETURN_IF_ERROR(MustHaveChanged(db, "person " + person.Text()));
    if (disabled) ENAMEL_RETURN_IF_ERROR(DeleteSessions(db, person));
    return WriteAudit(db, by, disabled ? "person.disable" : "person.enable", person.Text(), "{}",
                      "{}");
  });
}

Result<std::vector<Person>> SqliteStore::People() {
  return Read([&](Db& db) -> Result<std::vector<Person>> {
    static const std::string kSql =
        std::string("SELECT ") + kPersonColumns + " FROM people WHERE tenant = ?1 ORDER BY login";
    Query q(db, kSql.c_str());
    return PeopleIn(q);
  });
}

Status SqliteStore::CreateSession(const SessionRow& session) {
  return Write([&](Db& db) -> Status {
    // The only sweep there is: every sign-in drops what ended.
    ENAMEL_RETURN_IF_ERROR(Query(db, "DELETE FROM sessions WHERE tenant = ?1 AND expires_ms < ?2")
                               .Bind(session.created_ms)
                               .Run());
    Query q(db,
            "INSERT INTO sessions (tenant, token_hash, person, created_ms, last_used_ms, "
            "expires_ms, via) "
            "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
    q.Bind(session.token_hash).Bind(session.person).Bind(session.created_ms);
    ENAMEL_RETURN_IF_ERROR(
        q.Bind(session.last_used_ms).Bind(session.expires_ms).Bind(session.via).Run());
    return WriteAudit(db, Actor{session.person, session.via}, "session.begin",
                      session.person.Text(), "{}", "{}");
  });
}

Result<SessionRow> SqliteStore::FindSession(const Sha256& token_hash) {
  return Read([&](Db& db) -> Result<SessionRow> {
    Query q(db,
            "SELECT person, created_ms, last_used_ms, expires_ms, via FROM sessions "
            "WHERE tenant = ?1 AND token_hash = ?2");
    if (q.Bind(token_hash).Next()) {
      return SessionRow{token_hash, q.Id(0), q.Int(1), q.Int(2), q.Int(3), q.Text(4)};
    }
    if (!q.status().ok()) return q.status();
    return Status(Code::kNotFound, "no such session");
  });
}

Status SqliteStore::TouchSession(const Sha256& token_hash, UnixMs now_ms) {
  return Write([&](Db& db) -> Status {
    Query q(db, "UPDATE sessions SET last_used_ms = ?3 WHERE tenant = ?1 AND token_hash = ?2");
    return q.Bind(token_hash).Bind(now_ms).Run();
  });
}

Status SqliteStore::EndSession(const Sha256& token_hash) {
  return Write([&](Db& db) -> Status {
    return Query(db, "DELETE FROM sessions WHERE tenant = ?1 AND token_hash = ?2")
        .Bind(token_hash)
        .Run();
  });
}

Status SqliteStore::EndSessionsOf(const Uuid& person) {
  return Write([&](Db& db) -> Status { return DeleteSessions(db, person); });
}

Result<Uuid> SqliteStore::CreateCohort(const std::string& name, const Actor& by) {
  Uuid id = Uuid::New();
  Status status = Write([&](Db& db) -> Status {
    Query q(db, "INSERT INTO cohorts (tenant, id, name) VALUES (?1, ?2, ?3)");
    ENAMEL_RETURN_IF_ERROR(
        Explain(q.Bind(id).Bind(name).Run(), "there is already a cohort named \"" + name + "\""));
    return WriteAudit(db, by, "cohort.create", id.Text(), "{}", JsonOf({{"name", name}}));
  });
  if (!status.ok()) return status;
  return id;
}

Status SqliteStore::AddToCohort(const Uuid& cohort, const Uuid& person, const Actor& by) {
  return Write([&](Db& db) -> Status {
    Query q(db,
            "INSERT INTO cohort_members (tenant, cohort, person) VALUES (?1, ?2, ?3) "
            "ON CONFLICT DO NOTHING");
    Status status = q.Bind(cohort).Bind(person).Run();
    if (status.code() == Code::kConflict) {
      return Status(Code::kNotFound,
                    "no cohort " + cohort.Text() + " or no person " + person.Text());
    }
    ENAMEL_RETURN_IF_ERROR(status);
    if (db.Changes() == 0) return Status::Ok();
    return WriteAudit(db, by, "cohort.add", cohort.Text(), "{}",
                      JsonOf({{"person", person.Text()}}));
  });
}

Result<std::vector<Cohort>> SqliteStore::CohortsOf(const Uuid& person) {
  return Read([&](Db& db) -> Result<std::vector<Cohort>> {
    Query q(db,
            "SELECT c.id, c.name FROM cohort_members m JOIN cohorts c ON c.tenant = m.tenant AND "
            "c.id = m.cohort WHERE m.tenant = ?1 AND m.person = ?2 ORDER BY c.name");
    return CohortsIn(q.Bind(person));
  });
}

Result<std::vector<Cohort>> SqliteStore::Cohorts() {
  return Read([&](Db& db) -> Result<std::vector<Cohort>> {
    Query q(db, "SELECT id, name FROM cohorts WHERE tenant = ?1 ORDER BY name");
    return CohortsIn(q);
  });
}

Result<std::vector<Person>> SqliteStore::CohortMembers(const Uuid& cohort) {
  return Read([&](Db& db) -> Result<std::vector<Person>> {
    Query q(db,
            "SELECT p.id, p.login, p.display_name, p.role, p.disabled, p.created_ms FROM "
            "cohort_members m "
            "JOIN people p ON p.tenant = m.tenant AND p.id = m.person "
            "WHERE m.tenant = ?1 AND m.cohort = ?2 ORDER BY p.role DESC, p.display_name");
    return PeopleIn(q.Bind(cohort));
  });
}

Result<bool> SqliteStore::ShareCohort(const Uuid& a, const Uuid& b) {
  return Read([&](Db& db) -> Result<bool> {
    Query q(db,
            "SELECT 1 FROM cohort_members x JOIN cohort_members y ON x.tenant = y.tenant AND "
            "x.cohort = y.cohort WHERE x.tenant = ?1 AND x.person = ?2 AND y.person = ?3 LIMIT 1");
    bool found = q.Bind(a).Bind(b).Next();
    if (!q.status().ok()) return q.status();
    return found;
  });
}

}  // namespace enamel::server::sqlite
