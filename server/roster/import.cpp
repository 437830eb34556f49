#include "server/roster/import.h"

#include <algorithm>
#include <boost/json.hpp>
#include <map>

#include "common/base/csv.h"
#include "server/auth/password.h"

namespace enamel::server::roster {
namespace json = boost::json;
namespace {

// Somebody mends a roster from the top; the count beside it says how many there are.
constexpr size_t kMaxListed = 200;

// A password for everybody who might be new: only the transaction knows who is. The first row makes
// a person, so it has the verifier; the further rows have none.
Result<std::map<std::string, std::string>> MakePasswords(std::vector<RosterRow>& rows) {
  std::map<std::string, std::string> out;
  for (RosterRow& row : rows) {
    if (out.contains(row.login)) continue;
    auth::OneTimePassword password = auth::MakeOneTimePassword();
    if (password.verifier.empty()) {
      return Status(Code::kUnavailable, "no memory for hashing passwords; try again later");
    }
    row.verifier = std::move(password.verifier);
    out[row.login] = std::move(password.text);
  }
  return out;
}

// The name that the person will have.
std::string NameOf(const RosterStep& step) {
  if (!step.row.display_name.empty()) return step.row.display_name;
  return step.before ? step.before->display_name : step.row.login;
}

std::vector<NewPassword> PasswordsOf(const RosterPlan& plan,
                                     const std::map<std::string, std::string>& passwords) {
  std::vector<NewPassword> out;
  for (const RosterStep& step : plan.steps) {
    if (step.change != RosterStep::Change::kCreate) continue;
    const RosterRow& row = step.row;
    out.push_back({row.login, NameOf(step), row.cohort, passwords.at(row.login)});
  }
  return out;
}

json::object StepJson(const RosterStep& step) {
  return {{"row", step.row.row},
          {"login", step.row.login},
          {"display_name", NameOf(step)},
          {"role", RoleName(step.row.role)},
          {"cohort", step.row.cohort},
          {"others", json::value_from(step.others)},
          {"change", RosterChangeName(step.change)},
          {"renames", step.renames},
          {"joins", step.joins},
          {"note", step.note}};
}

}  // namespace

Result<ImportResult> ImportRoster(RosterRows& roster, std::string_view bytes,
                                  const ImportOptions& options, const Actor& by) {
  RosterFile file = ReadRoster(bytes, options.file);
  // With a bad row nothing is written. The readable rows are still compared with the existing
  // people, to report all problems at once.
  bool dry_run = options.dry_run || !file.problems.empty();
  std::map<std::string, std::string> passwords;
  // Before the transaction and not in it: hashing for a year's students would hold the writer.
  if (!dry_run) {
    ENAMEL_ASSIGN_OR_RETURN(auto made, MakePasswords(file.rows));
    passwords = std::move(made);
  }
  if (!dry_run && options.keep) {
    ENAMEL_ASSIGN_OR_RETURN(const auto planned,
                            roster.ImportRoster(file.rows, {.dry_run = true}, by));
    if (planned.problems.empty())
      ENAMEL_RETURN_IF_ERROR(options.keep(PasswordsOf(planned, passwords)));
  }
  ENAMEL_ASSIGN_OR_RETURN(auto plan, roster.ImportRoster(file.rows, {dry_run, options.move}, by));
  ImportResult out;
  out.plan = std::move(plan);
  out.done = !dry_run && out.plan.problems.empty();
  out.reading = std::move(file.reading);
  out.ignored_columns = std::move(file.ignored_columns);
  out.left_out = std::move(file.left_out);
  out.plan.problems.insert(out.plan.problems.end(), file.problems.begin(), file.problems.end());
  // Those of the file and those of the store in one list, in the order in which they are mended.
  std::ranges::stable_sort(out.plan.problems, {}, &RosterProblem::row);
  if (out.done) out.passwords = PasswordsOf(out.plan, passwords);
  return out;
}

json::object ImportJson(const ImportResult& result) {
  const RosterPlan& plan = result.plan;
  json::array problems, steps, passwords, left_out;
  for (const RosterProblem& problem : plan.problems) {
    if (problems.size() == kMaxListed) break;
    problems.push_back({{"row", problem.row},
                        {"column", problem.column},
                        {"found", problem.found},
                        {"expected", problem.expected}});
  }
  for (const RosterStep& step : plan.steps) steps.push_back(StepJson(step));
  for (const NewPassword& made : result.passwords) {
    passwords.push_back({{"login", made.login},
                         {"display_name", made.display_name},
                         {"cohort", made.cohort},
                         {"password", made.password}});
  }
  for (const LeftOutRow& row : result.left_out) {
    left_out.push_back({{"row", row.row}, {"text", row.text}});
  }
  return {{"done", result.done},
          {"created", plan.Count(RosterStep::Change::kCreate)},
          {"updated", plan.Count(RosterStep::Change::kUpdate)},
          {"unchanged", plan.Count(RosterStep::Change::kUnchanged)},
          {"reading", result.reading},
          {"new_cohorts", json::value_from(plan.new_cohorts)},
          {"ignored_columns", json::value_from(result.ignored_columns)},
          {"left_out", std::move(left_out)},
          {"problem_count", plan.problems.size()},
          {"problems", std::move(problems)},
          {"people", std::move(steps)},
          {"passwords", std::move(passwords)}};
}

std::string PasswordsCsv(const std::vector<NewPassword>& passwords) {
  std::string out = CsvLine({"login", "display_name", "cohort", "password"});
  for (const NewPassword& made : passwords) {
    out += CsvLine({made.login, made.display_name, made.cohort, made.password});
  }
  return out;
}

}  // namespace enamel::server::roster
