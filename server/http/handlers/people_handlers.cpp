#include <algorithm>
#include <boost/json.hpp>

#include "server/auth/password.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"
#include "server/http/views/person_view.h"
#include "server/roster/import.h"
#include "server/roster/text_reading.h"
#include "server/training/names.h"
#include "server/training/revision.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kMaxText = 200;

// True where the parameter is `one`, false where it is `other` or absent.
Result<bool> QueryChoice(const Request& request, const std::string& name, std::string_view one,
                         std::string_view other) {
  const auto found = request.query.find(name);
  if (found == request.query.end() || found->second == other) return false;
  if (found->second == one) return true;
  return Status{Code::kInvalidInput, "expected " + std::string(one) + " or " + std::string(other),
                name};
}

Result<Role> RoleNamed(const std::string& text) {
  if (std::optional<Role> role = RoleFromName(text)) return *role;
  return Status{Code::kInvalidInput,
                "expected student, instructor or admin, found \"" + text + "\"", "role"};
}

Result<PeopleFilter> FilterOf(const Call& call) {
  PeopleFilter filter;
  const auto& query = call.request.query;
  if (auto role = query.find("role"); role != query.end()) {
    ENAMEL_ASSIGN_OR_RETURN(Role named, RoleNamed(role->second));
    filter.role = named;
  }
  ENAMEL_ASSIGN_OR_RETURN(std::optional<Uuid> cohort, QueryId(call.request, "cohort"));
  filter.cohort = cohort;
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> disabled, QueryFlag(call.request, "disabled"));
  filter.disabled = disabled;
  if (auto text = query.find("text"); text != query.end()) {
    if (text->second.size() > kMaxText) {
      return Status{Code::kInvalidInput, "expected at most 200 bytes", "text"};
    }
    filter.text = text->second;
  }
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kDefaultPage, kMaxPage));
  filter.after_login = page.after.value_or("");
  filter.limit = page.limit + 1;  // whether there is one more
  return filter;
}

Result<Response> PersonResponse(const Person& person, int status = 200) {
  return WithETag(JsonResponse(PersonJson(person), status), person.revision);
}

// A person as JSON with the password that is shown this once.
Result<Response> WithPassword(const Call& call, const Person& person, const std::string& password,
                              int status) {
  json::object out = PersonJson(person);
  // The only time that the password appears: the store has only its verifier, and no log has the
  // body of an answer.
  out["password"] = password;
  out["password_until_ms"] = call.authenticator.OneTimeUntil(person);
  return WithETag(JsonResponse(out, status), person.revision);
}

Result<auth::OneTimePassword> NewPassword() {
  auth::OneTimePassword made = auth::MakeOneTimePassword();
  if (!made.verifier.empty()) return made;
  return Status{Code::kUnavailable, "no memory to hash a password; try again"};
}

Result<PersonEdit> EditOf(const Call& call) {
  PersonEdit edit;
  BodyReader body(call.request);
  if (body.Has("display_name")) edit.display_name = body.Text("display_name", 1, kMaxNameBytes);
  // Longer than any role: an error message then shows the text as sent.
  std::string role = body.Has("role") ? body.Text("role", 1, 16) : "";
  if (body.Has("disabled")) edit.disabled = body.Flag("disabled", false);
  if (body.Has("may_import_teeth")) edit.may_import_teeth = body.Flag("may_import_teeth", false);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  if (edit.display_name) {
    ENAMEL_ASSIGN_OR_RETURN(std::string name,
                            CheckedPersonName(*edit.display_name, "display_name"));
    edit.display_name = name;
  }
  if (role.empty()) return edit;
  ENAMEL_ASSIGN_OR_RETURN(Role named, RoleNamed(role));
  edit.role = named;
  return edit;
}

struct NewPerson {
  Person person;
  std::vector<Uuid> cohorts;
};

Result<NewPerson> NewPersonOf(const Call& call) {
  NewPerson out;
  BodyReader body(call.request);
  std::string login = body.Text("login", 1, kMaxLoginBytes);
  std::string name = body.Has("display_name") ? body.Text("display_name", 1, kMaxNameBytes) : login;
  std::string role = body.Text("role", 1, 16);
  out.cohorts = body.Ids("cohorts", 20);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(std::string checked_login, CheckedLogin(login));
  ENAMEL_ASSIGN_OR_RETURN(std::string checked_name, CheckedPersonName(name, "display_name"));
  ENAMEL_ASSIGN_OR_RETURN(Role named, RoleNamed(role));
  out.person.login = checked_login;
  out.person.display_name = checked_name;
  out.person.role = named;
  // The admin has seen it, and so has whatever carried it to the person.
  out.person.must_change_password = true;
  return out;
}

}  // namespace

Result<Response> ListPeople(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(PeopleFilter filter, FilterOf(call));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Person> rows, store.people.FindPeople(filter));
  json::value next;
  if (rows.size() == filter.limit) {
    rows.pop_back();
    next = NextAfter(rows.back().login);
  }
  json::array people;
  for (const Person& person : rows) people.push_back(PersonJson(person));
  return JsonResponse({{"people", std::move(people)}, {"next", std::move(next)}});
}

Result<Response> GetPerson(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Person person, store.people.PersonById(call.id));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Cohort> cohorts, store.cohorts.CohortsOf(call.id));
  json::object out = PersonJson(person);
  json::array in;
  for (const Cohort& cohort : cohorts) {
    in.push_back({{"id", cohort.id.Text()}, {"name", cohort.name}});
  }
  out["cohorts"] = std::move(in);
  return WithETag(JsonResponse(out), person.revision);
}

Result<Response> AddPerson(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_RETURN_IF_ERROR(RequireConfirmed(call));
  ENAMEL_ASSIGN_OR_RETURN(NewPerson wanted, NewPersonOf(call));
  ENAMEL_ASSIGN_OR_RETURN(auth::OneTimePassword password, NewPassword());
  ENAMEL_ASSIGN_OR_RETURN(Uuid id, store.people.CreatePerson(wanted.person, password.verifier,
                                                             wanted.cohorts, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(Person person, store.people.PersonById(id));
  return WithPassword(call, person, password.text, 201);
}

Result<Response> EditPerson(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(PersonEdit edit, EditOf(call));
  ENAMEL_ASSIGN_OR_RETURN(int32_t seen, IfMatch(call.request));
  // A role is power; anybody who notices can restore a name or a disabled account.
  if (edit.role) {
    ENAMEL_RETURN_IF_ERROR(RequireConfirmed(call));
  }
  Result<Person> person = store.people.EditPerson(call.id, edit, seen, ActorOf(call));
  if (person.ok()) return PersonResponse(*person);
  if (person.status().field() != kStale) return person.status();
  ENAMEL_ASSIGN_OR_RETURN(Person current, store.people.PersonById(call.id));
  return Stale(person.status(), PersonJson(current), current.revision);
}

Result<Response> ResetPassword(const Call& call, Store& store) {
  ENAMEL_RETURN_IF_ERROR(RequireConfirmed(call));
  ENAMEL_ASSIGN_OR_RETURN(auth::OneTimePassword password, NewPassword());
  ENAMEL_RETURN_IF_ERROR(store.people.SetPassword(call.id, password.verifier, true, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(Person person, store.people.PersonById(call.id));
  return WithPassword(call, person, password.text, 200);
}

namespace {

json::array MentionsJson(const std::vector<Mentions>& mentions) {
  json::array out;
  for (const Mentions& one : mentions) {
    out.push_back({{"kind", one.kind},
                   {"count", one.count},
                   {"places", json::array(one.places.begin(), one.places.end())}});
  }
  return out;
}

}  // namespace

Result<Response> ErasePerson(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  std::string login = body.Text("login", 1, kMaxLoginBytes);
  bool with_references = body.Flag("with_references", false);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(RequireConfirmed(call));
  ENAMEL_ASSIGN_OR_RETURN(Person person, store.people.PersonById(call.id));
  // Typed by hand: the page's button alone erases nobody.
  if (person.login != login) {
    return Status(
        Code::kInvalidInput,
        "that is not the person's login; type it to confirm, because this cannot be undone",
        "login");
  }
  // Only another admin can erase an admin, and can then still let others in.
  if (person.id == call.caller->person.id) {
    return Status(Code::kConflict, "you cannot erase yourself; ask another admin");
  }
  ENAMEL_ASSIGN_OR_RETURN(ErasureReport erased,
                          store.erasures.ErasePerson(call.id, with_references, ActorOf(call)));
  return JsonResponse({{"attempts", erased.attempts},
                       {"references", erased.references},
                       {"blobs", erased.blobs},
                       {"mentions", MentionsJson(erased.mentions)}});
}

Result<Response> ListSessionsOf(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Person person, store.people.PersonById(call.id));
  return SessionsResponse(call, store.sessions, call.id);
}

Result<Response> EndSessionsOf(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Person person, store.people.PersonById(call.id));
  ENAMEL_ASSIGN_OR_RETURN(size_t ended, store.sessions.EndSessionsOf(call.id, ActorOf(call)));
  return JsonResponse({{"ended", ended}});
}

Result<Response> ImportRoster(const Call& call, Store& store) {
  // The sender only guesses the encoding that the type may name. The reader looks at the bytes.
  std::string_view type = call.request.Header("content-type");
  type = type.substr(0, type.find(';'));
  if (type != "text/csv" && type != "application/octet-stream") {
    return ErrorResponse(415, "unsupported_media_type",
                         "expected Content-Type: text/csv or application/octet-stream",
                         "content-type");
  }
  roster::ImportOptions options;
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> dry_run, QueryFlag(call.request, "dry_run"));
  options.dry_run = dry_run.value_or(false);
  const auto& query = call.request.query;
  ENAMEL_ASSIGN_OR_RETURN(bool ignore,
                          QueryChoice(call.request, "unknown_columns", "ignore", "refuse"));
  options.file.ignore_unknown_columns = ignore;
  ENAMEL_ASSIGN_OR_RETURN(bool leave, QueryChoice(call.request, "other_cohorts", "leave", "keep"));
  options.move = leave;
  if (auto reading = query.find("reading"); reading != query.end()) {
    options.file.reading = reading->second;
    if (!roster::IsReading(reading->second)) {
      return Status(Code::kInvalidInput, "expected an encoding such as utf-8 or windows-1252",
                    "reading");
    }
  }
  if (auto cohort = query.find("cohort"); cohort != query.end()) {
    ENAMEL_ASSIGN_OR_RETURN(std::string name, CheckedName(cohort->second, "cohort"));
    options.file.cohort = name;
  }
  // Asked for before the roster is read: a dry run shows the same problems without a password.
  if (!options.dry_run) {
    ENAMEL_RETURN_IF_ERROR(RequireConfirmed(call));
  }
  ENAMEL_ASSIGN_OR_RETURN(
      roster::ImportResult result,
      roster::ImportRoster(store.roster, call.request.body, options, ActorOf(call)));
  json::object out = roster::ImportJson(result);
  size_t problems = result.plan.problems.size();
  if (problems == 0) return JsonResponse(out);
  // A refusal that carries the whole plan: the page lists every problem with its row.
  out["error"] = {{"code", "invalid_input"},
                  {"message", "expected a roster without problems, found " +
                                  std::to_string(problems) + "; nothing was changed"},
                  {"field", "body"}};
  return JsonResponse(out, 400);
}

}  // namespace enamel::server::http
