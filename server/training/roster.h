#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/training/types.h"

// Bringing the people of a school in line with a roster (schemas/roster.md): what would change, and
// what stands against it. Pure; RosterRows::ImportRoster makes the plan and carries it out in one
// transaction.
namespace enamel::server {

// One line, checked by itself already.
struct RosterRow {
  uint32_t row = 0;  // as a spreadsheet counts, the header is row 1
  std::string login;
  std::string display_name;  // empty: not told; a new person is then called by the login
  Role role = Role::kStudent;
  std::string cohort;  // empty: none
  // The one-time password's, should the person be new; only in the first row of the person.
  std::string verifier;
};

// Something that keeps the whole roster from being imported.
struct RosterProblem {
  uint32_t row = 0;
  std::string column;  // "login", "role", …; empty: the row as such
  std::string found, expected;
};

// What there is: read in the transaction that will change it.
struct RosterFacts {
  std::map<std::string, Person> people;     // by login
  std::map<std::string, Cohort> cohorts;    // by name
  std::set<std::pair<Uuid, Uuid>> members;  // cohort, person
};

struct RosterStep {
  enum class Change { kCreate, kUpdate, kUnchanged };
  RosterRow row;
  Change change = Change::kUnchanged;
  std::optional<Person> before;  // none: a new person
  bool again = false;  // a row before has the same person: this one names a further cohort
  bool renames = false, joins = false;
  // The other cohorts of a student who was here before and joins this row's cohort: cohorts in use
  // that no row names for the student. Set in the student's first row that joins.
  std::vector<std::string> others;
  std::string note;  // worth knowing, and no obstacle
};

// Problems and steps in the order of the rows; with problems nothing may be carried out.
struct RosterPlan {
  std::vector<RosterStep> steps;
  std::vector<std::string> new_cohorts;
  std::vector<RosterProblem> problems;

  // People, not rows: somebody whose rows differ counts as created or updated.
  size_t Count(RosterStep::Change change) const;
};

// Creates new people. Existing people keep role and password, take the roster's name if it has one
// and join the roster's cohort. The caller decides whether a student leaves `others`. Nobody
// else is removed. Somebody in several
// cohorts has a row for each: the first makes the person. Problems: another role, an archived
// cohort, a person twice in one cohort, and rows of one person that differ in name or role.
RosterPlan PlanRoster(const std::vector<RosterRow>& rows, const RosterFacts& facts);

const char* RosterChangeName(RosterStep::Change change);  // "create", "update", "unchanged"

}  // namespace enamel::server
