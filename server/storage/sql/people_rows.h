#pragma once

#include <string>

#include "server/storage/sql/sqlite_impl.h"

// Private to server/storage: rows of people and cohorts inside a transaction, shared by people.cpp,
// sessions.cpp, cohorts.cpp and roster.cpp.
namespace enamel::server::sqlite {

// Of the table as `p`.
inline constexpr char kPersonColumns[] =
    "p.id, p.login, p.display_name, p.role, p.disabled, p.created_ms, p.must_change_password, "
    "p.revision, p.password_ms, p.password_used, p.language";
Person PersonOf(const Query& q);
inline constexpr char kCohortColumns[] = "c.id, c.name, c.archived_ms, c.revision";
Cohort CohortOf(const Query& q);

Result<Person> FindPerson(Db& db, const Uuid& id);
// kNotFound "no WHAT" when the last statement changed nothing.
Status MustHaveChanged(Db& db, const std::string& what);
// kConflict with field kStale.
Status MustBeNewest(int32_t stored, int32_t given);

// Each leaves its audit row.
Status InsertPerson(Db& db, const Person& person, const std::string& verifier, const Actor& by);
Status RenamePerson(Db& db, const Person& before, const std::string& display_name, const Actor& by);
Result<Uuid> InsertCohort(Db& db, const std::string& name, const Actor& by);
Status InsertMember(Db& db, const Uuid& cohort, const Uuid& person, const Actor& by);

Status DeleteSessions(Db& db, const Uuid& person);

}  // namespace enamel::server::sqlite
