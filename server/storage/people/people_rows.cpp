#include "server/storage/people/people_rows.h"

#include <algorithm>
#include <boost/json.hpp>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/people/cohort_rows.h"
#include "server/storage/people/session_rows.h"
#include "server/training/names.h"

// People.
namespace enamel::server {
namespace {

Result<Person> OnePerson(Query& q, const std::string& what) {
  return q.One<Person>("no person " + what);
}

bool Admits(const Person& person) { return person.role == Role::kAdmin && !person.disabled; }

Status KeepAnAdmin(Db& db, const Person& before, const Person& after) {
  return Admits(after) ? Status::Ok() : MustNotBeTheOnlyAdmin(db, before);
}

// What of a person is edited, for the audit trail: name and rights only where they change.
std::string EditJson(const Person& person, const Person& other) {
  boost::json::object out;
  if (person.display_name != other.display_name) out["display_name"] = person.display_name;
  out["role"] = RoleName(person.role);
  out["disabled"] = person.disabled ? "yes" : "no";
  if (person.may_import_teeth != other.may_import_teeth)
    out["may_import_teeth"] = person.may_import_teeth ? "yes" : "no";
  return boost::json::serialize(out);
}

// A name in letters of another script that is drawn as another person's. Only these names are
// compared with all others: of two that look alike, one is not what it seems.
Status MustNotLookLikeAnother(Db& db, const Person& person) {
  if (!LooksLatin(person.display_name)) return Status::Ok();
  const std::string look = LookOf(person.display_name);
  Query q(db, "SELECT login, display_name FROM people WHERE tenant = ?1 AND id <> ?2");
  q.Bind(person.id);
  while (q.Next()) {
    for (const std::string& other : {q.Text(0), q.Text(1)}) {
      if (other == person.display_name || LookOf(other) != look) continue;
      return {Code::kConflict,
              "\"" + person.display_name + "\" looks like \"" + other +
                  "\", another person's, and is in letters of another script; write the name so "
                  "that people can tell the two apart",
              "display_name"};
    }
  }
  return q.status();
}

// Writes `after` over `before`. Nothing changed: nothing is written.
Status UpdatePerson(Db& db, const Person& before, Person& after, const char* action,
                    const Actor& by) {
  // A session belongs to the person's role at its start: with another role, or with none, it must
  // end. A new name does not change rights.
  bool ends_sessions = after.role != before.role || (after.disabled && !before.disabled);
  if (!ends_sessions && after.display_name == before.display_name &&
      after.disabled == before.disabled && after.may_import_teeth == before.may_import_teeth) {
    return Status::Ok();
  }
  ENAMEL_RETURN_IF_ERROR(KeepAnAdmin(db, before, after));
  if (after.display_name != before.display_name) {
    ENAMEL_RETURN_IF_ERROR(MustNotLookLikeAnother(db, after));
  }
  ++after.revision;
  {
    Query q(db,
            "UPDATE people SET display_name = ?3, role = ?4, disabled = ?5, revision = ?6, "
            "search_name = ?7, may_import_teeth = ?8 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(after.id, after.display_name, after.role, after.disabled,
                                  after.revision, SearchName(after.display_name),
                                  after.may_import_teeth)
                               .Run());
  }
  if (ends_sessions) ENAMEL_RETURN_IF_ERROR(DeleteSessions(db, after.id));
  return WriteAudit(db, by, action, after.id.Text(), EditJson(before, after),
                    EditJson(after, before));
}

}  // namespace

std::string NameHas(const std::string& word) {
  // A text that shrinks when the word is taken out holds the word. The databases share no function
  // that searches.
  const auto has = [&](const std::string& column) {
    return "replace(" + column + ", " + word + ", '') <> " + column;
  };
  return "(" + has("p.login") + " OR " + has("p.search_name") + ")";
}

Result<Person> FindPerson(Db& db, const Uuid& id) {
  Query q(db,
          std::string("SELECT ") + kPersonColumns + " FROM people p WHERE tenant = ?1 AND id = ?2");
  return OnePerson(q.Bind(id), id.Text());
}

// Somebody has to be able to let others in.
Status MustNotBeTheOnlyAdmin(Db& db, const Person& person) {
  if (!Admits(person)) return Status::Ok();
  Query q(db, "SELECT 1 FROM people WHERE tenant = ?1 AND role = " + Sql(Role::kAdmin) +
                  " AND disabled = 0 AND id <> ?2 LIMIT 1");
  if (q.Bind(person.id).Next()) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(q.status());
  return Status(Code::kConflict, "\"" + person.login +
                                     "\" is the only admin who may sign in; make somebody else an "
                                     "admin first");
}

Status InsertPerson(Db& db, const Person& person, const std::string& verifier, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(MustNotLookLikeAnother(db, person));
  ENAMEL_RETURN_IF_ERROR(
      Explain(Insert(db, "people", "id", person.id, "login", person.login, "display_name",
                     person.display_name, "role", person.role, "disabled", person.disabled,
                     "created_ms", person.created_ms != 0 ? person.created_ms : NowMs(), "verifier",
                     verifier, "must_change_password", person.must_change_password, "password_ms",
                     NowMs(), "search_name", SearchName(person.display_name)),
              "there is already a person with the login \"" + person.login + "\""));
  return WriteAudit(db, by, "person.create", person.id.Text(), "{}",
                    JsonOf({{"role", RoleName(person.role)}}));
}

Status RenamePerson(Db& db, const Person& before, const std::string& display_name,
                    const Actor& by) {
  Person after = before;
  after.display_name = display_name;
  return UpdatePerson(db, before, after, "person.edit", by);
}

Result<Uuid> PeopleRows::CreatePerson(const Person& person, const std::string& password_verifier,
                                      const std::vector<Uuid>& cohorts, const Actor& by) {
  Person row = person;
  if (row.id.IsZero()) row.id = Uuid::New();
  // Recordings that stations still hold under this id would be taken in again.
  ENAMEL_ASSIGN_OR_RETURN(const bool gone, keyring_.IsGone(row.id));
  if (gone) {
    return Status(Code::kConflict, "person " + row.id.Text() + " was erased and stays so", "id");
  }
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(InsertPerson(db, row, password_verifier, by));
    for (const Uuid& cohort : cohorts) {
      // In the same transaction: a person in half of the cohorts would miss exercises unnoticed.
      Status in = InsertMember(db, cohort, row.id, by);
      if (in.code() == Code::kNotFound) return {in.code(), "no cohort " + cohort.Text(), "cohorts"};
      ENAMEL_RETURN_IF_ERROR(in);
    }
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return row.id;
}

Result<Person> PeopleRows::PersonById(const Uuid& id) {
  return rows_.Read([&](Db& db) -> Result<Person> { return FindPerson(db, id); });
}

Result<Person> PeopleRows::PersonByLogin(const std::string& login) {
  return rows_.Read([&](Db& db) -> Result<Person> {
    Query q(db, std::string("SELECT ") + kPersonColumns +
                    " FROM people p WHERE tenant = ?1 AND login = ?2");
    return OnePerson(q.Bind(login), "with the login \"" + login + "\"");
  });
}

namespace {

Result<std::string> VerifierIn(Db& db, const char* sql, const Uuid& person) {
  Query q(db, sql);
  return q.Bind(person).One<std::string>("no person " + person.Text());
}

}  // namespace

Result<std::string> PeopleRows::PasswordVerifier(const Uuid& person) {
  return rows_.Read([&](Db& db) {
    return VerifierIn(db, "SELECT verifier FROM people WHERE tenant = ?1 AND id = ?2", person);
  });
}

Result<PeopleRows::PinTry> PeopleRows::TryPin(const Uuid& person) {
  PinTry out;
  Status counted = rows_.Write([&](Db& db) -> Status {
    out = {};
    {
      Query q(db,
              "UPDATE people SET wrong_pins = wrong_pins + 1 WHERE tenant = ?1 AND id = ?2 AND "
              "pin <> '' AND wrong_pins < ?3");
      ENAMEL_RETURN_IF_ERROR(q.Bind(person, kMaxWrongPins).Run());
    }
    const bool may = db.Changes() > 0;
    Query q(db, "SELECT pin, wrong_pins FROM people WHERE tenant = ?1 AND id = ?2");
    if (!q.Bind(person).Next()) {
      ENAMEL_RETURN_IF_ERROR(q.status());
      return Status(Code::kNotFound, "no person " + person.Text());
    }
    out.verifier = q.Text(0);
    out.locked = !may && !out.verifier.empty();
    out.last = may && q.Int(1) >= kMaxWrongPins;
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(counted);
  return out;
}

Status PeopleRows::PinWasRight(const Uuid& person) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "UPDATE people SET wrong_pins = 0 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(person).Run());
    return MustHaveChanged(db, "person " + person.Text());
  });
}

Status PeopleRows::NotePinLocked(const Uuid& person, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const Person now, FindPerson(db, person));
    // A right PIN that was tried at the same time has unlocked it.
    if (!now.pin_locked) return Status::Ok();
    return WriteAudit(db, by, "person.pin_locked", person.Text(), "{}", "{}");
  });
}

Status PeopleRows::SetPin(const Uuid& person, const std::string& verifier, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "UPDATE people SET pin = ?3, wrong_pins = 0 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(person, verifier).Run());
    ENAMEL_RETURN_IF_ERROR(MustHaveChanged(db, "person " + person.Text()));
    return WriteAudit(db, by, "person.pin", person.Text(), "{}", "{}");
  });
}

Status PeopleRows::SetPassword(const Uuid& person, const std::string& verifier, bool for_one_use,
                               const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db,
            "UPDATE people SET verifier = ?3, must_change_password = ?4, password_ms = ?5 "
            "WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(person, verifier, for_one_use, NowMs()).Run());
    ENAMEL_RETURN_IF_ERROR(MustHaveChanged(db, "person " + person.Text()));
    // Whoever knew the old password may be signed in with it.
    ENAMEL_RETURN_IF_ERROR(DeleteSessions(db, person));
    return WriteAudit(db, by, "person.password", person.Text(), "{}",
                      JsonOf({{"for_one_use", for_one_use ? "yes" : "no"}}));
  });
}

Status PeopleRows::SetLanguage(const Uuid& person, const std::string& language) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "UPDATE people SET language = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(person, language).Run());
    return MustHaveChanged(db, "person " + person.Text());
  });
}

Status PeopleRows::SetDisabled(const Uuid& person, bool disabled, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto before, FindPerson(db, person));
    Person after = before;
    after.disabled = disabled;
    return UpdatePerson(db, before, after, disabled ? "person.disable" : "person.enable", by);
  });
}

Result<Person> PeopleRows::EditPerson(const Uuid& id, const PersonEdit& edit, int32_t revision,
                                      const Actor& by) {
  Person after;
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto before, FindPerson(db, id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(before.revision, revision));
    after = before;
    if (edit.display_name) after.display_name = *edit.display_name;
    if (edit.role) after.role = *edit.role;
    if (edit.disabled) after.disabled = *edit.disabled;
    if (edit.may_import_teeth) after.may_import_teeth = *edit.may_import_teeth;
    return UpdatePerson(db, before, after, "person.edit", by);
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return after;
}

Result<std::vector<Person>> PeopleRows::People() {
  return rows_.Read([&](Db& db) -> Result<std::vector<Person>> {
    Query q(db, std::string("SELECT ") + kPersonColumns +
                    " FROM people p WHERE tenant = ?1 ORDER BY login");
    return q.All<Person>();
  });
}

Result<std::vector<Person>> PeopleRows::FindPeople(const PeopleFilter& filter) {
  std::string sql =
      std::string("SELECT ") + kPersonColumns + " FROM people p WHERE tenant = ?1 AND login > ?2";
  const std::vector<std::string> words = SearchWords(filter.text);
  int at = 4;
  for (size_t i = 0; i < words.size(); ++i) sql += " AND " + NameHas("?" + std::to_string(at++));
  if (filter.role) sql += " AND role = " + Sql(*filter.role);
  if (filter.disabled) sql += *filter.disabled ? " AND disabled = 1" : " AND disabled = 0";
  if (filter.cohort) {
    // IN and not EXISTS: the planner then begins with the members.
    sql +=
        " AND p.id IN (SELECT m.person FROM cohort_members m WHERE m.tenant = ?1 AND m.cohort = ?" +
        std::to_string(at) + ")";
  }
  // By login and from the last one on: a page stays the same when people come and go before it.
  sql += " ORDER BY login LIMIT ?3";
  return rows_.Read([&](Db& db) -> Result<std::vector<Person>> {
    Query q(db, sql.c_str());
    q.Bind(filter.after_login, std::clamp<uint32_t>(filter.limit, 1, 1000));
    for (const std::string& word : words) q.Bind(word);
    if (filter.cohort) q.Bind(*filter.cohort);
    return q.All<Person>();
  });
}

}  // namespace enamel::server
