#include "server/training/roster.h"

#include <algorithm>
#include <string_view>

#include "server/training/names.h"

namespace enamel::server {
namespace {

// The spelling of a cohort: as first read, or as it exists already.
struct Spelling {
  std::string name, where;
};
using Spellings = std::map<std::string, Spelling>;  // by NameKey

Spellings SpellingsOf(const std::vector<RosterRow>& rows, const RosterFacts& facts) {
  Spellings out;
  // First those that are there: a spelling in use wins over the file's.
  for (const auto& [name, cohort] : facts.cohorts) {
    out.try_emplace(NameKey(name), Spelling{name, "which is there"});
  }
  for (const RosterRow& row : rows) {
    out.try_emplace(NameKey(row.cohort),
                    Spelling{row.cohort, "as in row " + std::to_string(row.row)});
  }
  return out;
}

// New beside one that people take for the same.
bool IsMisspelt(const RosterRow& row, const RosterFacts& facts, const Spellings& spellings) {
  return !row.cohort.empty() && !facts.cohorts.contains(row.cohort) &&
         spellings.at(NameKey(row.cohort)).name != row.cohort;
}

// Of a person who comes more than once.
using RowsByLogin = std::map<std::string, std::vector<const RosterRow*>>;

// Against a further row of one person, or empty: it may only name a further cohort.
std::vector<RosterProblem> ProblemsOfAgain(const RosterRow& row,
                                           const std::vector<const RosterRow*>& rows) {
  const RosterRow& first = *rows.front();
  if (first.row == row.row) return {};
  std::vector<RosterProblem> out;
  const std::string where = " row " + std::to_string(first.row);
  auto before = std::ranges::find_if(
      rows, [&](const RosterRow* each) { return NameKey(each->cohort) == NameKey(row.cohort); });
  if (row.cohort.empty() || (*before)->row != row.row) {
    const uint32_t same = row.cohort.empty() ? first.row : (*before)->row;
    out.push_back({row.row, "login",
                   "\"" + row.login + "\", which row " + std::to_string(same) + " has already",
                   "each person once in each cohort"});
  }
  if (first.role != row.role) {
    out.push_back({row.row, "role", RoleName(row.role),
                   std::string(RoleName(first.role)) + " as in" + where});
  }
  if (!row.display_name.empty() && row.display_name != first.display_name) {
    out.push_back({row.row, "display_name", "\"" + row.display_name + "\"",
                   "\"" + first.display_name + "\" as in" + where + ", or nothing"});
  }
  return out;
}

// Against the row, or empty.
std::vector<RosterProblem> ProblemsOf(const RosterRow& row, const RosterFacts& facts,
                                      const RowsByLogin& by_login, const Spellings& spellings) {
  std::vector<RosterProblem> out = ProblemsOfAgain(row, by_login.at(row.login));
  auto person = facts.people.find(row.login);
  // A list from an office must not make a student an instructor, nor the other way round.
  if (person != facts.people.end() && person->second.role != row.role) {
    out.push_back({row.row, "role", RoleName(row.role),
                   std::string(RoleName(person->second.role)) + ", which \"" + row.login +
                       "\" is here; a roster changes no roles, edit the person instead"});
  }
  auto cohort = facts.cohorts.find(row.cohort);
  if (cohort != facts.cohorts.end() && cohort->second.archived_ms != 0) {
    out.push_back({row.row, "cohort", "\"" + row.cohort + "\", which is archived",
                   "a cohort that is in use; open it again or name another"});
  }
  if (IsMisspelt(row, facts, spellings)) {
    const Spelling& before = spellings.at(NameKey(row.cohort));
    out.push_back({row.row, "cohort", "\"" + row.cohort + "\"",
                   "\"" + before.name + "\", " + before.where +
                       ", or a name that differs by more than case and spaces"});
  }
  return out;
}

RosterStep StepFor(const RosterRow& row, const RosterFacts& facts, bool again) {
  RosterStep step;
  step.row = row;
  step.again = again;
  auto person = facts.people.find(row.login);
  auto cohort = facts.cohorts.find(row.cohort);
  if (person == facts.people.end()) {
    step.change = again ? RosterStep::Change::kUpdate : RosterStep::Change::kCreate;
    step.joins = !row.cohort.empty();
    return step;
  }
  step.before = person->second;
  // An empty name says nothing about the name; the password, and whether somebody is disabled, are
  // never a roster's.
  step.renames =
      !again && !row.display_name.empty() && row.display_name != person->second.display_name;
  bool member = cohort != facts.cohorts.end() &&
                facts.members.contains({cohort->second.id, person->second.id});
  step.joins = !row.cohort.empty() && !member;
  if (step.renames || step.joins) step.change = RosterStep::Change::kUpdate;
  if (person->second.disabled) step.note = "is disabled and stays so";
  return step;
}

using CohortsByPerson = std::map<Uuid, std::vector<std::string>>;  // in use

CohortsByPerson CohortsOfPeople(const RosterFacts& facts) {
  std::map<Uuid, std::string> names;
  for (const auto& [name, cohort] : facts.cohorts) {
    if (cohort.archived_ms == 0) names[cohort.id] = name;
  }
  CohortsByPerson out;
  for (const auto& [cohort, person] : facts.members) {
    if (auto name = names.find(cohort); name != names.end()) out[person].push_back(name->second);
  }
  return out;
}

// The cohorts of somebody that none of their rows names.
std::vector<std::string> Others(const Uuid& person, const std::vector<const RosterRow*>& rows,
                                const CohortsByPerson& in) {
  const auto all = in.find(person);
  if (all == in.end()) return {};
  std::vector<std::string> out;
  for (const std::string& name : all->second) {
    if (std::ranges::find(rows, name, &RosterRow::cohort) == rows.end()) out.push_back(name);
  }
  std::ranges::sort(out);
  return out;
}

}  // namespace

size_t RosterPlan::Count(RosterStep::Change change) const {
  std::map<std::string_view, RosterStep::Change> people;
  for (const RosterStep& step : steps) {
    const auto at = people.try_emplace(step.row.login, step.change).first;
    // In the order of the enumeration: a creation outweighs an update.
    at->second = std::min(at->second, step.change);
  }
  return static_cast<size_t>(std::ranges::count(
      people, change, &std::pair<const std::string_view, RosterStep::Change>::second));
}

RosterPlan PlanRoster(const std::vector<RosterRow>& rows, const RosterFacts& facts) {
  RosterPlan plan;
  RowsByLogin by_login;
  for (const RosterRow& row : rows) by_login[row.login].push_back(&row);
  const Spellings spellings = SpellingsOf(rows, facts);
  const CohortsByPerson in = CohortsOfPeople(facts);
  std::set<std::string> made, asked;
  for (const RosterRow& row : rows) {
    auto problems = ProblemsOf(row, facts, by_login, spellings);
    plan.problems.insert(plan.problems.end(), problems.begin(), problems.end());
    // Also for a row with a problem: the plan is shown whole, and carried out only when there is
    // none.
    RosterStep step = StepFor(row, facts, by_login.at(row.login).front() != &row);
    if (step.joins && step.before && row.role == Role::kStudent && asked.insert(row.login).second) {
      step.others = Others(step.before->id, by_login.at(row.login), in);
    }
    plan.steps.push_back(std::move(step));
    bool is_new = !row.cohort.empty() && !facts.cohorts.contains(row.cohort);
    if (is_new && made.insert(row.cohort).second) plan.new_cohorts.push_back(row.cohort);
  }
  return plan;
}

const char* RosterChangeName(RosterStep::Change change) {
  switch (change) {
    case RosterStep::Change::kCreate:
      return "create";
    case RosterStep::Change::kUpdate:
      return "update";
    case RosterStep::Change::kUnchanged:
      return "unchanged";
  }
  return "unchanged";
}

}  // namespace enamel::server
