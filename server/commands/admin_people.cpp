#include "server/commands/admin_people.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cerrno>
#include <cstring>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/program/output.h"
#include "server/app/data_folder.h"
#include "server/commands/admin.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/roster/import.h"
#include "server/roster/text_reading.h"
#include "server/training/names.h"

namespace enamel::server::app {
namespace {

using Change = RosterStep::Change;

// The most that the store gives at once (PeopleRows::FindPeople).
constexpr uint32_t kPage = 1000;
constexpr size_t kMaxShown = 200;

// The file for the passwords, made before anything is changed: what cannot be written down must not
// be made. Empty, mode 0600; removed again unless kept.
class PasswordFile {
 public:
  static Result<PasswordFile> Make(const std::filesystem::path& path) {
    // O_EXCL: an older file could be readable by others, or a link to somewhere else.
    int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (file >= 0) {
      ::close(file);
      return PasswordFile(path);
    }
    return Status(Code::kStorage, "cannot make " + path.string() +
                                      " for the passwords: " + std::strerror(errno) +
                                      (errno == EEXIST ? "; name a new file" : ""));
  }
  ~PasswordFile() {
    std::error_code ignored;
    if (!kept_ && !path_.empty()) std::filesystem::remove(path_, ignored);
  }
  PasswordFile(PasswordFile&& other) noexcept
      : path_(std::exchange(other.path_, {})),
        written_(std::move(other.written_)),
        kept_(other.kept_) {}
  PasswordFile(const PasswordFile&) = delete;
  PasswordFile& operator=(const PasswordFile&) = delete;

  Status Write(const std::vector<roster::NewPassword>& passwords) {
    const std::string text = WithPlainLineEnds(roster::PasswordsCsv(passwords));
    if (text == written_) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(WriteFileDurably(path_, AsBytes(text), 0600));
    written_ = text;
    return Status::Ok();
  }
  // Keeps the file: from now on it is the only copy of its content.
  void Keep() { kept_ = true; }

 private:
  explicit PasswordFile(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
  std::string written_;
  bool kept_ = false;
};

void ShowProblems(const std::vector<RosterProblem>& problems) {
  for (size_t i = 0; i < std::min(problems.size(), kMaxShown); ++i) {
    const RosterProblem& problem = problems[i];
    Say("row {}{}{}: found {}; expected {}\n", problem.row, problem.column.empty() ? "" : ", ",
        problem.column, problem.found, problem.expected);
  }
  if (problems.size() > kMaxShown) {
    Say("… and {} more\n", problems.size() - kMaxShown);
  }
}

void ShowOutcome(const roster::ImportResult& result, bool moves) {
  const RosterPlan& plan = result.plan;
  if (result.reading != "utf-8") {
    Say("read as {}; if names are wrong, name another with --reading\n", result.reading);
  }
  for (const roster::LeftOutRow& row : result.left_out) {
    Say("row {} is no person: \"{}\"\n", row.row, row.text);
  }
  for (const std::string& column : result.ignored_columns) {
    Say("column \"{}\" is not used\n", column);
  }
  for (const std::string& cohort : plan.new_cohorts) {
    Say("new cohort \"{}\"\n", cohort);
  }
  for (const RosterStep& step : plan.steps) {
    if (!step.note.empty()) {
      Say("row {}: {} {}\n", step.row.row, step.row.login, step.note);
    }
    for (const std::string& other : step.others) {
      Say("row {}: {} {} \"{}\"{}\n", step.row.row, step.row.login, moves ? "leaves" : "stays in",
          other, moves ? "" : "; with --move they leave it");
    }
  }
  Say("{}: {} new, {} changed, {} as they were\n", result.done ? "imported" : "would be",
      plan.Count(Change::kCreate), plan.Count(Change::kUpdate), plan.Count(Change::kUnchanged));
}

Status WriteOutcome(const std::filesystem::path& file, const roster::ImportResult& result) {
  if (file.empty()) return Status::Ok();
  boost::json::object out = roster::ImportJson(result);
  // The API answers with them, over TLS and once. A file of outcomes is kept and passed on.
  out.erase("passwords");
  return program::WriteJsonFile(file, out);
}

Status Refusal(const roster::ImportResult& result) {
  return {Code::kInvalidInput, "the roster has " + Counted(result.plan.problems.size(), "problem") +
                                   ", listed above; nothing was changed"};
}

// New people's passwords go into a file that was created before.
Status Import(RosterRows& roster_rows, std::string_view bytes, const RosterCommand& command,
              roster::ImportOptions options, size_t fresh) {
  std::optional<PasswordFile> file;
  // Nobody new, nothing to write down: a repeated import leaves no empty file behind.
  if (fresh > 0) {
    if (command.passwords.empty()) {
      return {Code::kInvalidInput, Counted(fresh, "person is", "people are") +
                                       " new: name a file for their one-time passwords with "
                                       "--passwords FILE.csv; they are stored nowhere else"};
    }
    ENAMEL_ASSIGN_OR_RETURN(auto made, PasswordFile::Make(command.passwords));
    file.emplace(std::move(made));
    // Before anybody is added: where the disk is full nobody is.
    options.keep = [&file](const std::vector<roster::NewPassword>& passwords) {
      return file->Write(passwords);
    };
  }
  // Somebody may have changed people since the dry run. The import plans again, and may find
  // problems that the dry run did not.
  ENAMEL_ASSIGN_OR_RETURN(auto result,
                          roster::ImportRoster(roster_rows, bytes, options, kCommandLine));
  if (!result.plan.problems.empty()) {
    ShowProblems(result.plan.problems);
    return Refusal(result);
  }
  if (file && !result.passwords.empty()) {
    file->Keep();
    // Nearly always the same content: it differs only if somebody else added people meanwhile.
    ENAMEL_RETURN_IF_ERROR(file->Write(result.passwords));
  }
  ShowOutcome(result, command.move);
  if (file) {
    Say("one-time passwords of {} in {} (shown only there; hand them out, then remove it)\n",
        Counted(result.passwords.size(), "person", "people"), command.passwords.string());
  }
  return WriteOutcome(command.json, result);
}

}  // namespace

Status ImportRoster(const RosterCommand& command) {
  // One byte more than may be: ImportRoster then says itself that it is too much, and how much may
  // be.
  ENAMEL_ASSIGN_OR_RETURN(auto csv, ReadFile(command.file, roster::kMaxRosterBytes + 1));
  roster::ImportOptions options;
  // Always first as a dry run: it says how many are new, hence whether a file for passwords is
  // needed, before argon2id is spent on any of them.
  options.dry_run = true;
  options.move = command.move;
  options.file.ignore_unknown_columns = command.ignore_unknown_columns;
  options.file.reading = command.reading;
  if (!command.cohort.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto cohort, CheckedName(command.cohort, "cohort"));
    options.file.cohort = cohort;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(command.data));
  ENAMEL_ASSIGN_OR_RETURN(auto tried,
                          roster::ImportRoster(store->roster, AsText(csv), options, kCommandLine));
  if (!tried.plan.problems.empty() || command.dry_run) {
    ShowProblems(tried.plan.problems);
    if (tried.plan.problems.empty()) ShowOutcome(tried, command.move);
    ENAMEL_RETURN_IF_ERROR(WriteOutcome(command.json, tried));
    return tried.plan.problems.empty() ? Status::Ok() : Refusal(tried);
  }
  options.dry_run = false;
  return Import(store->roster, AsText(csv), command, options, tried.plan.Count(Change::kCreate));
}

Status ListPeople(const PeopleList& list) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(list.data));
  PeopleFilter filter;
  if (!list.role.empty()) {
    filter.role = RoleFromName(list.role);
    if (!filter.role) {
      return {Code::kInvalidInput,
              "a role is student, instructor or admin, found \"" + list.role + "\"", "role"};
    }
  }
  if (!list.cohort.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto cohort, CohortByName(store->cohorts, list.cohort));
    filter.cohort = cohort;
  }
  filter.text = list.text;
  for (uint32_t shown = 0; shown < list.limit;) {
    filter.limit = std::min(list.limit - shown, kPage);
    ENAMEL_ASSIGN_OR_RETURN(auto people, store->people.FindPeople(filter));
    for (const Person& person : people) {
      Say("{:<24} {:<11} {}{}{}\n", person.login, RoleName(person.role), person.display_name,
          person.disabled ? "  (disabled)" : "",
          person.must_change_password ? "  (one-time password)" : "");
    }
    if (people.size() < filter.limit) break;
    shown += filter.limit;
    filter.after_login = people.back().login;
  }
  return Status::Ok();
}

Status ListCohorts(const std::filesystem::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto cohorts, store->cohorts.Cohorts());
  for (const Cohort& cohort : cohorts) {
    ENAMEL_ASSIGN_OR_RETURN(auto members, store->cohorts.CohortMembers(cohort.id));
    auto students = std::ranges::count(members, Role::kStudent, &Person::role);
    const auto others = static_cast<int64_t>(members.size()) - students;
    Say("{:<30} {}, {}{}\n", cohort.name, Counted(students, "student"), Counted(others, "other"),
        cohort.archived_ms != 0 ? "  (archived)" : "");
  }
  return Status::Ok();
}

Status ListSessions(const std::filesystem::path& data, const std::string& login) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(store->people, login));
  ENAMEL_ASSIGN_OR_RETURN(auto sessions, store->sessions.SessionsOf(person.id));
  for (const SessionRow& session : sessions) {
    Say("{}  {:<7}  since {}, last used {} UTC  {}  {}\n", session.id.Text(), session.via,
        UtcText(session.created_ms), UtcText(session.last_used_ms), session.address,
        session.device);
  }
  if (sessions.empty()) Say("{} has no sessions\n", login);
  return Status::Ok();
}

Status EndSessions(const std::filesystem::path& data, const std::string& login) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(store->people, login));
  ENAMEL_ASSIGN_OR_RETURN(auto ended, store->sessions.EndSessionsOf(person.id, kCommandLine));
  Say("ended {} of {}\n", Counted(ended, "session"), login);
  return Status::Ok();
}

void DeclareRoster(CommandGroup admin) {
  auto [roster, r] = Declare<RosterCommand>(
      admin, "import-roster", "Add or change people and cohorts from a CSV file", ImportRoster);
  roster->add_option("FILE", r.file, "login,display_name,role,cohort (schemas/roster.md)")
      ->required()
      ->check(CLI::ExistingFile);
  AddData(roster, r.data);
  roster->add_flag("--dry-run", r.dry_run, "Show what would change; change nothing");
  roster->add_option("--cohort", r.cohort, "Cohort of rows that name none");
  roster->add_option("--passwords", r.passwords,
                     "New file (mode 0600) for the one-time passwords of new people");
  roster->add_flag("--ignore-unknown-columns", r.ignore_unknown_columns,
                   "Leave out columns of other names instead of refusing them");
  roster->add_option("--reading", r.reading, "Encoding of the file, where it is not recognised")
      ->check(CLI::IsMember(
          std::vector<std::string>(roster::kReadings.begin(), roster::kReadings.end())));
  roster->add_flag(
      "--move", r.move,
      "Students who join a cohort leave the others that the file does not name for them");
  roster->add_option("--json", r.json, "Write the outcome to this file, without passwords");
  roster->footer(
      "All or nothing: with a problem in any row nothing is changed, and all problems are listed.\n"
      "People who already exist keep role and password; they take the name in the file and\n"
      "join the cohort. Nobody is removed; with --move, students leave the cohorts they were in.\n"
      "Importing the same file again changes nothing.");
  AddExample(roster, "year3.csv --passwords passwords.csv");

  auto [people, p] = Declare<PeopleList>(admin, "list-people", "People by login", ListPeople);
  AddData(people, p.data);
  people->add_option("--role", p.role, "Only people of this role")
      ->check(CLI::IsMember(RoleNames()));
  people->add_option("--cohort", p.cohort, "Only of this cohort");
  people->add_option("--text", p.text, "Only with this in login or name");
  people->add_option("--limit", p.limit, "Most rows to show")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  AddExample(people, "--cohort \"Year 3\" --role student");

  struct Folder {
    std::filesystem::path data;
  };
  auto [cohorts, c] =
      Declare<Folder>(admin, "list-cohorts", "Cohorts by name, with how many are in them",
                      [](const Folder& o) { return ListCohorts(o.data); });
  AddData(cohorts, c.data);
  AddExample(cohorts, "");
}

void DeclareSessions(CommandGroup admin) {
  struct Login {
    std::filesystem::path data;
    std::string login;
  };
  auto [list, l] = Declare<Login>(admin, "list-sessions", "Where a person is signed in",
                                  [](const Login& o) { return ListSessions(o.data, o.login); });
  AddData(list, l.data);
  list->add_option("--login", l.login, kLoginHelp)->required();
  AddExample(list, "--login anna");

  auto [end, e] = Declare<Login>(admin, "end-sessions", "Sign a person out everywhere",
                                 [](const Login& o) { return EndSessions(o.data, o.login); });
  AddData(end, e.data);
  end->add_option("--login", e.login, kLoginHelp)->required();
  AddExample(end, "--login anna");
}

}  // namespace enamel::server::app
