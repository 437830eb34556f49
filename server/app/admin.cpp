#include "server/app/admin.h"

#include <sodium.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <iostream>

#include "common/base/hex.h"
#include "server/app/data_folder.h"
#include "server/app/say.h"
#include "server/auth/password.h"
#include "server/training/access.h"
#include "server/training/names.h"

namespace enamel::server::app {
namespace {

// Its text is empty unless it was made up here, for one use.
struct Password {
  std::string text, verifier;
  bool made_up = false;
};

Result<Password> ReadOrMakePassword(bool from_stdin, const std::string& login) {
  if (!from_stdin) {
    auth::OneTimePassword made = auth::MakeOneTimePassword();
    if (!made.verifier.empty()) return Password{made.text, made.verifier, true};
    return Status(Code::kUnavailable, "no memory to hash a password; try again");
  }
  std::string text;
  if (!std::getline(std::cin, text)) {
    return Status(Code::kInvalidInput,
                  "expected a password as one line on standard input, found nothing");
  }
  ENAMEL_RETURN_IF_ERROR(auth::CheckPasswordPolicy(text, login));
  ENAMEL_ASSIGN_OR_RETURN(auto verifier, auth::HashPassword(text));
  return Password{"", verifier, false};
}

void ShowIfMadeUp(const Password& password) {
  if (!password.made_up) return;
  Say("password (shown only now, to be changed when signing in): {}\n", password.text);
}

void Show(const AttemptRow& row) {
  std::string score = row.score ? fmt::format("{:.1f}", *row.score) : "-";
  std::string flags;
  for (const char* flag : AttemptFlagNames(row.flags)) flags += std::string("  ") + flag;
  Say("{}  {:<11} {:>6}  {:>7} ticks  {:<20} {}{}{}\n", row.id.Text(), AttemptStateName(row.state),
      score, row.ticks, row.person_name, row.exercise_title, flags,
      row.problem.empty() ? "" : "  (" + row.problem + ")");
}

}  // namespace

Result<Uuid> CohortByName(Store& store, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto cohorts, store.Cohorts());
  auto found = std::ranges::find(cohorts, name, &Cohort::name);
  if (found != cohorts.end()) return found->id;
  return Status(Code::kNotFound, "no cohort named \"" + name + "\"; make it with admin add-cohort",
                "cohort");
}

Result<Person> PersonNamed(Store& store, const std::string& login) {
  ENAMEL_ASSIGN_OR_RETURN(auto checked, CheckedLogin(login));
  return store.PersonByLogin(checked);
}

Status AddPerson(const std::filesystem::path& data, const NewPerson& person) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto login, CheckedLogin(person.login));
  auto role = RoleFromName(person.role);
  if (!role) {
    return Status(Code::kInvalidInput,
                  "a role is student, instructor or admin, found \"" + person.role + "\"", "role");
  }
  ENAMEL_ASSIGN_OR_RETURN(
      auto name, CheckedName(person.display_name.empty() ? login : person.display_name, "name"));
  Person row;
  if (!person.id.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(person.id));
    row.id = id;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto password, ReadOrMakePassword(person.password_from_stdin, login));
  row.login = login;
  row.display_name = name;
  row.role = *role;
  row.must_change_password = password.made_up;
  ENAMEL_ASSIGN_OR_RETURN(auto id, store->CreatePerson(row, password.verifier, {}, kCommandLine));
  Say("added {} ({}), id {}\n", login, RoleName(*role), id.Text());
  ShowIfMadeUp(password);
  return Status::Ok();
}

Status SetPassword(const std::filesystem::path& data, const std::string& login, bool from_stdin) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(*store, login));
  ENAMEL_ASSIGN_OR_RETURN(auto password, ReadOrMakePassword(from_stdin, login));
  ENAMEL_RETURN_IF_ERROR(
      store->SetPassword(person.id, password.verifier, password.made_up, kCommandLine));
  Say("new password for {}; its sessions have ended\n", login);
  ShowIfMadeUp(password);
  return Status::Ok();
}

Status SetDisabled(const std::filesystem::path& data, const std::string& login, bool disabled) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(*store, login));
  ENAMEL_RETURN_IF_ERROR(store->SetDisabled(person.id, disabled, kCommandLine));
  Say("{} {}\n", login, disabled ? "may no longer sign in" : "may sign in again");
  return Status::Ok();
}

Status AddCohort(const std::filesystem::path& data, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto checked, CheckedName(name, "name"));
  ENAMEL_ASSIGN_OR_RETURN(auto id, store->CreateCohort(checked, kCommandLine));
  Say("added cohort \"{}\", id {}\n", checked, id.Text());
  return Status::Ok();
}

Status AddToCohort(const std::filesystem::path& data, const std::string& cohort,
                   const std::string& login) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto id, CohortByName(*store, cohort));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(*store, login));
  ENAMEL_RETURN_IF_ERROR(store->AddToCohort(id, person.id, kCommandLine));
  Say("{} is in \"{}\"\n", login, cohort);
  return Status::Ok();
}

Status EnrolCode(const std::filesystem::path& data, int valid_minutes) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureIdentity(data));
  Bytes random(16);
  randombytes_buf(random.data(), random.size());
  std::string code = ToHex(random);
  auto now = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  UnixMs expires = now.count() + UnixMs{valid_minutes} * 60'000;
  auto added = store->AddEnrolCode(HashSha256(AsBytes(code)), expires, kCommandLine);
  if (!added.ok()) return added.status();
  Say("{}@{}\n", code, identity.fingerprint.Hex());
  return Status::Ok();
}

Status MarkReference(const std::filesystem::path& data, const std::string& attempt,
                     const std::string& dentist, bool consent) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(attempt));
  if (Status agreed = CheckConsent(consent); !agreed.ok()) {
    return Status(agreed.code(), agreed.message() + " with --consent", agreed.field());
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto row, store->AddReference(id, dentist, consent, kCommandLine));
  Say("reference version {} of the exercise: attempt {} by {}\n", row.version, attempt, dentist);
  return Status::Ok();
}

Status ReleaseScore(const std::filesystem::path& data, const std::string& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_RETURN_IF_ERROR(store->ReleaseAttempt(id, kCommandLine));
  Say("the score of attempt {} is released to its student\n", attempt);
  return Status::Ok();
}

Status ListAttempts(const std::filesystem::path& data, uint32_t limit) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  constexpr uint32_t kPage = 200;
  AttemptFilter filter;
  for (uint32_t shown = 0; shown < limit;) {
    filter.limit = std::min(limit - shown, kPage);
    ENAMEL_ASSIGN_OR_RETURN(auto rows, store->Attempts(filter));
    for (const AttemptRow& row : rows) Show(row);
    if (rows.size() < filter.limit) break;
    shown += filter.limit;
    filter.before = rows.back().id;
  }
  return Status::Ok();
}

}  // namespace enamel::server::app
