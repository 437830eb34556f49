#include "server/commands/admin.h"

#include <sodium.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iostream>
#include <set>
#include <sstream>

#include "common/base/counted.h"
#include "common/base/csv.h"
#include "common/base/hex.h"
#include "common/base/unix_time.h"
#include "common/program/input.h"
#include "server/app/data_folder.h"
#include "server/auth/password.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/commands/teaching.h"
#include "server/jobs/reference_check.h"
#include "server/training/access.h"
#include "server/training/names.h"
#include "server/training/ticket_rules.h"

namespace enamel::server::app {
namespace {

// Its text is empty unless it was made up here, for one use.
struct Password {
  std::string text, verifier;
  bool made_up = false;
};

Result<Password> ReadOrMakePassword(bool from_stdin, const std::string& login,
                                    const std::string& name) {
  if (!from_stdin) {
    auth::OneTimePassword made = auth::MakeOneTimePassword();
    // Without memory to hash in there is no verifier, and never a weaker one.
    if (!made.verifier.empty()) return Password{made.text, made.verifier, true};
    return Status(Code::kUnavailable, "no memory to hash a password; try again");
  }
  std::string text;
  if (!std::getline(std::cin, text)) {
    return Status(Code::kInvalidInput,
                  "expected a password as one line on standard input, found nothing");
  }
  // The page's own rule. Somebody with a shell could write to the database anyway, but an admin's
  // habit of short passwords should fail here too.
  ENAMEL_RETURN_IF_ERROR(auth::CheckPasswordPolicy(text, login, name));
  ENAMEL_ASSIGN_OR_RETURN(auto verifier, auth::HashPassword(text));
  return Password{"", verifier, false};
}

void ShowIfMadeUp(const Password& password) {
  if (!password.made_up) return;
  Say("password (shown only now; valid for one sign-in to the page, within 7 days unless serve has "
      "another --one-time-password-days): {}\n",
      password.text);
}

void Show(const AttemptRow& row) {
  std::string score = row.score ? fmt::format("{:.1f}", *row.score) : "-";
  std::string flags;
  for (const char* flag : AttemptFlagNames(row.flags)) flags += std::string("  ") + flag;
  Say("{}  {:<20} {:>6}  {:>7} ticks  {:<20} {}{}{}\n", row.id.Text(), StateText(row.state), score,
      row.ticks, row.person_name, row.exercise_title, flags,
      row.problem.empty() ? "" : "  (" + row.problem + ")");
}

// All versions of this exercise that were published; of every one where no name is given.
Result<std::vector<ExerciseRow>> VersionsOf(ExerciseRows& exercises_rows, const std::string& name) {
  std::vector<ExerciseRow> out;
  std::set<std::string> names{name};
  if (name.empty()) {
    names.clear();
    for (ExerciseState state : {ExerciseState::kPublished, ExerciseState::kRetired}) {
      ENAMEL_ASSIGN_OR_RETURN(const auto rows, exercises_rows.ExercisesIn(state));
      for (const ExerciseRow& row : rows) names.insert(row.name);
    }
  }
  for (const std::string& each : names) {
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, exercises_rows.ExerciseVersions(each));
    out.insert(out.end(), rows.begin(), rows.end());
  }
  if (!out.empty() || name.empty()) return out;
  return Status(Code::kNotFound, "no exercise named \"" + name + "\"; list-exercises shows them",
                "exercise");
}

// By its own id, or by that of its attempt, as mark-reference took it.
Result<ReferenceRow> ReferenceNamed(AttemptRows& attempts, ReferenceRows& references_rows,
                                    const Uuid& id) {
  auto row = references_rows.ReferenceById(id);
  if (row.ok() || row.status().code() != Code::kNotFound) return row;
  auto attempt = attempts.AttemptById(id);
  if (attempt.ok()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, references_rows.References(attempt->exercise));
    const auto found = std::ranges::find(rows, id, &ReferenceRow::attempt);
    if (found != rows.end()) return *found;
  }
  return Status(Code::kNotFound,
                "expected the id of a reference, or of an attempt that is one, found " + id.Text() +
                    "; list-references shows them",
                "reference");
}

}  // namespace

Result<Uuid> CohortByName(CohortRows& cohorts_rows, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto cohorts, cohorts_rows.Cohorts());
  // All of them are read: a school has dozens, and the store keeps their names apart.
  auto found = std::ranges::find(cohorts, name, &Cohort::name);
  if (found != cohorts.end()) return found->id;
  return Status(Code::kNotFound, "no cohort named \"" + name + "\"; make it with admin add-cohort",
                "cohort");
}

Result<Person> PersonNamed(PeopleRows& people, const std::string& login) {
  // Logins are stored in lower case, so that a login typed in any case finds its person.
  ENAMEL_ASSIGN_OR_RETURN(auto checked, CheckedLogin(login));
  return people.PersonByLogin(checked);
}

Status AddPerson(const std::filesystem::path& data, const NewPerson& person) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto login, CheckedLogin(person.login));
  // Checks the arguments before asking for a password.
  auto role = RoleFromName(person.role);
  if (!role) {
    return Status(Code::kInvalidInput,
                  "a role is student, instructor or admin, found \"" + person.role + "\"", "role");
  }
  ENAMEL_ASSIGN_OR_RETURN(
      auto name,
      CheckedPersonName(person.display_name.empty() ? login : person.display_name, "name"));
  Person row;
  if (!person.id.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(person.id));
    row.id = id;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto password,
                          ReadOrMakePassword(person.password_from_stdin, login, name));
  row.login = login;
  row.display_name = name;
  row.role = *role;
  // Whoever ran this command has seen it, and so has the terminal's memory.
  row.must_change_password = password.made_up;
  ENAMEL_ASSIGN_OR_RETURN(auto id,
                          store->people.CreatePerson(row, password.verifier, {}, kCommandLine));
  Say("added {} ({}), id {}\n", login, RoleName(*role), id.Text());
  ShowIfMadeUp(password);
  return Status::Ok();
}

Status SetPassword(const std::filesystem::path& data, const std::string& login, bool from_stdin) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(store->people, login));
  ENAMEL_ASSIGN_OR_RETURN(auto password,
                          ReadOrMakePassword(from_stdin, login, person.display_name));
  ENAMEL_RETURN_IF_ERROR(
      store->people.SetPassword(person.id, password.verifier, password.made_up, kCommandLine));
  Say("new password for {}; all sessions of this person have ended\n", login);
  ShowIfMadeUp(password);
  return Status::Ok();
}

Status SetDisabled(const std::filesystem::path& data, const std::string& login, bool disabled) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(store->people, login));
  ENAMEL_RETURN_IF_ERROR(store->people.SetDisabled(person.id, disabled, kCommandLine));
  Say("{} {}\n", login, disabled ? "may no longer sign in" : "may sign in again");
  return Status::Ok();
}

Status AddCohort(const std::filesystem::path& data, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto checked, CheckedName(name, "name"));
  ENAMEL_ASSIGN_OR_RETURN(auto id, store->cohorts.CreateCohort(checked, kCommandLine));
  Say("added cohort \"{}\", id {}\n", checked, id.Text());
  return Status::Ok();
}

Status AddToCohort(const std::filesystem::path& data, const std::string& cohort,
                   const std::string& login) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto id, CohortByName(store->cohorts, cohort));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(store->people, login));
  ENAMEL_RETURN_IF_ERROR(store->cohorts.AddToCohort(id, person.id, kCommandLine));
  Say("{} is in \"{}\"\n", login, cohort);
  return Status::Ok();
}

namespace {

constexpr size_t kMaxEnrolled = 5000;

// CODE@FINGERPRINT. The station pins this fingerprint from its first byte on: whoever brings the
// code brings the trust, and no authority is needed.
Result<std::string> MakeEnrolCode(StationRows& stations, const Sha256& fingerprint,
                                  int valid_minutes) {
  Bytes random(16);
  randombytes_buf(random.data(), random.size());
  std::string code = ToHex(random);
  const UnixMs expires = enamel::UnixMs() + UnixMs{valid_minutes} * 60'000;
  // The hash alone is kept, so that a copy of the database enrols no station.
  ENAMEL_ASSIGN_OR_RETURN(auto added,
                          stations.AddEnrolCode(HashSha256(AsBytes(code)), expires, kCommandLine));
  return code + "@" + fingerprint.Hex();
}

Result<std::vector<std::string>> StationNames(std::string_view text) {
  std::vector<std::string> names;
  std::set<std::string> keys;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int at = 1; std::getline(lines, line); ++at) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const std::string place = "line " + std::to_string(at) + ": ";
    auto name = CheckedName(line, "name");
    if (!name.ok()) return Status(name.status().code(), place + name.status().message());
    if (!keys.insert(NameKey(*name)).second) {
      return Status(Code::kInvalidInput, place + "\"" + *name + "\" is the name of two stations");
    }
    names.push_back(*name);
  }
  if (names.empty()) return Status(Code::kInvalidInput, "expected a name on each line, found none");
  if (names.size() > kMaxEnrolled) {
    return Status(Code::kTooLarge, "expected at most " + std::to_string(kMaxEnrolled) +
                                       " names, found " + std::to_string(names.size()));
  }
  return names;
}

}  // namespace

Status EnrolCode(const std::filesystem::path& data, int valid_minutes) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureIdentity(data));
  ENAMEL_ASSIGN_OR_RETURN(auto code,
                          MakeEnrolCode(store->stations, identity.fingerprint, valid_minutes));
  Say("{}\n", code);
  return Status::Ok();
}

Status EnrolCodes(const std::filesystem::path& data, const std::filesystem::path& names_file,
                  int valid_minutes) {
  ENAMEL_ASSIGN_OR_RETURN(auto text,
                          program::ReadInput(names_file, kMaxEnrolled * (kMaxNameBytes + 2)));
  ENAMEL_ASSIGN_OR_RETURN(auto names, StationNames(text));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureIdentity(data));
  std::cout << WithPlainLineEnds(CsvLine({"name", "code"}));
  for (const std::string& name : names) {
    ENAMEL_ASSIGN_OR_RETURN(auto code,
                            MakeEnrolCode(store->stations, identity.fingerprint, valid_minutes));
    std::cout << WithPlainLineEnds(CsvLine({name, code}));
  }
  return Status::Ok();
}

Status MarkReference(const std::filesystem::path& data, const std::string& attempt,
                     const std::string& dentist, bool consent, const std::string& anyway) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(attempt));
  // The rule is the page's. The sentence is completed with the option that a reader of a terminal
  // can give.
  if (Status agreed = CheckConsent(consent); !agreed.ok()) {
    return Status(agreed.code(), agreed.message() + " with --consent", agreed.field());
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(const std::string name, CheckedName(dentist, "dentist"));
  std::string why;
  if (!anyway.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(why, CheckedReason(anyway, "anyway"));
  }
  auto made = MakeReference(*store, id, name, consent, why, kCommandLine);
  if (!made.ok()) return InsistWith(made.status(), "--anyway REASON");
  const ReferenceRow& row = *made;
  Say("reference version {} of the exercise: attempt {} by {}\n", row.version, attempt, name);
  if (const auto done = store->attempts.AttemptById(id); done.ok()) {
    if (const auto work = WorkOfAttempt(store->blobs, store->results, *done); work.ok()) {
      Say("it did {:.1f} % of the exercise's own target and cut {:.1f} % of it beside\n",
          work->done_percent, work->beside_percent);
    }
  }
  if (row.version > 1) {
    Say("attempts that earn most against this cut are judged by it from now on. Existing scores "
        "stay; rescore computes them again\n");
  }
  return Status::Ok();
}

Status ListReferences(const std::filesystem::path& data, const std::string& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(const auto versions, VersionsOf(store->exercises, exercise));
  size_t shown = 0;
  for (const ExerciseRow& version : versions) {
    ENAMEL_ASSIGN_OR_RETURN(const auto counting, store->references.Counting(version.id));
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, store->references.References(version.id));
    for (const ReferenceRow& row : rows) {
      const bool counts = std::ranges::find(counting, row.id, &ReferenceRow::id) != counting.end();
      Say("{}  {} version {}, reference {}  {:<9} attempt {}  {}{}  {}\n", row.id.Text(),
          version.name, version.version, row.version,
          row.withdrawn_ms != 0 ? "withdrawn" : (counts ? "counts" : "earlier"), row.attempt.Text(),
          row.dentist, row.consent ? "" : " (not to be named)", TimeText(row.created_ms));
    }
    shown += rows.size();
  }
  if (shown == 0) Say("no references; mark-reference makes a scored attempt one\n");
  return Status::Ok();
}

Status WithdrawReference(const std::filesystem::path& data, const std::string& reference) {
  ENAMEL_ASSIGN_OR_RETURN(const auto id, Uuid::Parse(reference));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(const auto row, ReferenceNamed(store->attempts, store->references, id));
  if (row.withdrawn_ms != 0) {
    Say("this reference was withdrawn before, {}; nothing was changed\n",
        TimeText(row.withdrawn_ms));
    return Status::Ok();
  }
  ENAMEL_RETURN_IF_ERROR(store->references.WithdrawReference(row.id, kCommandLine));
  ENAMEL_ASSIGN_OR_RETURN(const auto left, store->references.Counting(row.exercise));
  Say("reference version {} by {} is withdrawn; scores made with it stay, rescore computes them "
      "again\n",
      row.version, row.dentist);
  Say("{}\n", left.empty()
                  ? "the exercise has no reference now: what is cut is compared with its own "
                    "target until there is one"
                  : Counted(left.size(), "reference counts", "references count") + " now");
  return Status::Ok();
}

Status ReleaseScore(const std::filesystem::path& data, const std::string& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_RETURN_IF_ERROR(store->judging.ReleaseAttempt(id, kCommandLine));
  Say("the score of attempt {} is released to its student\n", attempt);
  return Status::Ok();
}

Status ListAttempts(const std::filesystem::path& data, uint32_t limit) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  // The most that the store gives at once: a larger wish would look like the last page.
  constexpr uint32_t kPage = 200;
  AttemptFilter filter;
  for (uint32_t shown = 0; shown < limit;) {
    filter.limit = std::min(limit - shown, kPage);
    ENAMEL_ASSIGN_OR_RETURN(auto rows, store->attempts.Attempts(filter));
    for (const AttemptRow& row : rows) Show(row);
    if (rows.size() < filter.limit) break;
    shown += filter.limit;
    filter.before = rows.back().id;
  }
  return Status::Ok();
}

void DeclarePeople(CommandGroup admin) {
  struct Adding {
    std::filesystem::path data;
    NewPerson person;
  };
  auto [add, a] = Declare<Adding>(admin, "add-person", "Add a person",
                                  [](const Adding& o) { return AddPerson(o.data, o.person); });
  AddData(add, a.data);
  add->add_option("--login", a.person.login, "Name to sign in with")->required();
  add->add_option("--name", a.person.display_name, "Name as shown");
  add->add_option("--role", a.person.role, "What the person may do")
      ->check(CLI::IsMember(RoleNames()))
      ->required();
  add->add_option("--id", a.person.id,
                  "The old id of a person that a restore has lost; list-awaited shows it");
  add->add_flag("--password-stdin", a.person.password_from_stdin,
                "Read the password from standard input; without this the server makes one up");
  AddExample(add, "--login anna --name \"Anna Schmidt\" --role instructor");

  struct Login {
    std::filesystem::path data;
    std::string login;
    bool password_from_stdin = false;
  };
  auto [password, p] = Declare<Login>(
      admin, "set-password", "Set a password; ends the person's sessions",
      [](const Login& o) { return SetPassword(o.data, o.login, o.password_from_stdin); });
  AddData(password, p.data);
  password->add_option("--login", p.login, kLoginHelp)->required();
  password->add_flag("--password-stdin", p.password_from_stdin,
                     "Read the password from standard input; without this the server makes one up");
  AddExample(password, "--login anna");

  // Two commands, one implementation: the captured value tells them apart.
  for (bool disabled : {true, false}) {
    auto [cmd, o] = Declare<Login>(
        admin, disabled ? "disable" : "enable",
        disabled ? "Stop a person from signing in, and end the person's sessions"
                 : "Let a person sign in again",
        [disabled](const Login& who) { return SetDisabled(who.data, who.login, disabled); });
    AddData(cmd, o.data);
    cmd->add_option("--login", o.login, kLoginHelp)->required();
    AddExample(cmd, "--login anna");
  }

  struct Membership {
    std::filesystem::path data;
    std::string cohort, login;
  };
  auto [cohort, c] =
      Declare<Membership>(admin, "add-cohort", "Add a cohort",
                          [](const Membership& o) { return AddCohort(o.data, o.cohort); });
  AddData(cohort, c.data);
  cohort->add_option("--name", c.cohort, "Name of the new cohort")->required();
  AddExample(cohort, "--name \"Year 3\"");

  auto [member, m] = Declare<Membership>(
      admin, "add-to-cohort", "Add a student or instructor to a cohort",
      [](const Membership& o) { return AddToCohort(o.data, o.cohort, o.login); });
  AddData(member, m.data);
  member->add_option("--cohort", m.cohort, "Name of the cohort (list-cohorts)")->required();
  member->add_option("--login", m.login, kLoginHelp)->required();
  AddExample(member, "--cohort \"Year 3\" --login anna");
}

void DeclareAttempts(CommandGroup admin) {
  struct Enrolment {
    std::filesystem::path data, names;
    int valid_minutes = 60;
  };
  auto [code, e] = Declare<Enrolment>(
      admin, "enrol-code", "Make a one-time code for a station: CODE@FINGERPRINT",
      [](const Enrolment& o) {
        return o.names.empty() ? EnrolCode(o.data, o.valid_minutes)
                               : EnrolCodes(o.data, o.names, o.valid_minutes);
      });
  AddData(code, e.data);
  code->add_option("--names", e.names,
                   "File with a station's name on each line, - for standard input: prints a table "
                   "of names and codes for 'enamel-station enrol --codes'");
  code->add_option("--minutes", e.valid_minutes, "How long it can be used")
      ->check(CLI::Range(1, 7 * 24 * 60))
      ->capture_default_str();
  AddExample(code, "--names chairs.txt --minutes 10080");

  struct Reference {
    std::filesystem::path data;
    std::string attempt, dentist, anyway;
    bool consent = false;
  };
  auto [mark, r] =
      Declare<Reference>(admin, "mark-reference", "Make a scored attempt its exercise's reference",
                         [](const Reference& o) {
                           return MarkReference(o.data, o.attempt, o.dentist, o.consent, o.anyway);
                         });
  AddData(mark, r.data);
  mark->add_option("--attempt", r.attempt, "Id of the attempt (list-attempts)")->required();
  mark->add_option("--dentist", r.dentist, "Name to be shown to students")->required();
  mark->add_flag(
      "--consent", r.consent,
      "Confirms that the dentist agrees to being named and to the use of the cut; required");
  mark->add_option("--anyway", r.anyway,
                   "Why it is the reference although it does not meet the exercise's target; "
                   "recorded in the audit trail");
  AddExample(mark, std::string("--attempt ") + kSomeId + " --dentist \"Dr Weber\" --consent");

  struct References {
    std::filesystem::path data;
    std::string name;
  };
  auto [references, f] =
      Declare<References>(admin, "list-references", "Reference cuts, newest first",
                          [](const References& o) { return ListReferences(o.data, o.name); });
  AddData(references, f.data);
  references->add_option("--exercise", f.name, "Its name; without: of every exercise");
  AddExample(references, "--exercise class-1-molar-46");
  auto [withdraw, w] =
      Declare<References>(admin, "withdraw-reference",
                          "Withdraw a reference: nobody is compared with it any more; scores stay",
                          [](const References& o) { return WithdrawReference(o.data, o.name); });
  AddData(withdraw, w.data);
  withdraw
      ->add_option("--reference", w.name,
                   "Its id, which list-references shows, or that of its attempt")
      ->required();
  AddExample(withdraw, std::string("--reference ") + kSomeId);

  struct Release {
    std::filesystem::path data;
    std::string attempt, assignment;
  };
  auto [release, l] = Declare<Release>(
      admin, "release", "Let the student see a graded score", [](const Release& o) -> Status {
        // The parser has refused both together (`excludes` below), but knows no "one of them".
        if (!o.assignment.empty()) return ReleaseAssignment(o.data, o.assignment);
        if (!o.attempt.empty()) return ReleaseScore(o.data, o.attempt);
        return Status(Code::kInvalidInput, "release needs --attempt ID or --assignment ID");
      });
  AddData(release, l.data);
  auto* one = release->add_option("--attempt", l.attempt, "One attempt's");
  release->add_option("--assignment", l.assignment, "Of every scored attempt under it")
      ->excludes(one);
  AddExample(release, std::string("--assignment ") + kSomeId);

  struct Listing {
    std::filesystem::path data;
    uint32_t limit = 50;
  };
  auto [list, n] = Declare<Listing>(admin, "list-attempts", "Newest attempts first",
                                    [](const Listing& o) { return ListAttempts(o.data, o.limit); });
  AddData(list, n.data);
  list->add_option("--limit", n.limit, "Most rows to show")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  AddExample(list, "--limit 200");
}

}  // namespace enamel::server::app
