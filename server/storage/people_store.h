#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/training/revision.h"
#include "server/training/roster.h"
#include "server/training/types.h"

namespace enamel::server {

struct SessionRow {
  Sha256 token_hash;
  Uuid person;
  UnixMs created_ms = 0, last_used_ms = 0, expires_ms = 0;
  std::string via;          // "page" | "station"
  Uuid id{};                // what it is called where the token must not be; zero: made up
  UnixMs confirmed_ms = 0;  // when the password was given last; 0: when it was created
  // From where and with what; both empty where that is not known.
  std::string address{};  // IPv4, or the /64 of an IPv6 address
  std::string device{};   // "Firefox on Linux", or the station's name
};

// People and their sessions.
// A part of Store (store.h), which says what holds for all parts.
class PeopleStore {
 public:
  virtual ~PeopleStore() = default;

  // People. Passwords are verifier strings made by server/auth; never shown by any reader.
  // Together with the memberships or not at all. Errors: kConflict (the login is taken), kNotFound
  // with field "cohorts".
  virtual Result<Uuid> CreatePerson(const Person& person, const std::string& password_verifier,
                                    const std::vector<Uuid>& cohorts, const Actor& by) = 0;
  virtual Result<Person> PersonById(const Uuid& id) = 0;
  virtual Result<Person> PersonByLogin(const std::string& login) = 0;
  virtual Result<std::string> PasswordVerifier(const Uuid& person) = 0;
  // Ends the person's sessions. `for_one_use`: it has to be changed before anything else is done.
  virtual Status SetPassword(const Uuid& person, const std::string& verifier, bool for_one_use,
                             const Actor& by) = 0;
  // Somebody signs in with a password for one use: the first of those who do at once. Errors:
  // kNotFound (it was used, or was not for one use).
  virtual Status UseOneTimePassword(const Uuid& person) = 0;
  // One of kPageLanguages, or empty. No decision: it leaves no audit row. Errors: kNotFound.
  virtual Status SetLanguage(const Uuid& person, const std::string& language) = 0;
  // Disabling ends the person's sessions in the same transaction. Errors also: kConflict (the last
  // admin who may sign in).
  virtual Status SetDisabled(const Uuid& person, bool disabled, const Actor& by) = 0;
  virtual Result<std::vector<Person>> People() = 0;
  // By login.
  virtual Result<std::vector<Person>> FindPeople(const PeopleFilter& filter) = 0;
  // Another role and disabling end the person's sessions. Returns the person as it is then. Errors:
  // kConflict with field kStale (`revision` is not the stored one), without one (the last admin who
  // may sign in).
  virtual Result<Person> EditPerson(const Uuid& id, const PersonEdit& edit, int32_t revision,
                                    const Actor& by) = 0;
  // Carries out what PlanRoster says, all or nothing, and returns it; with `dry_run`, or with
  // problems in the plan, changes nothing.
  virtual Result<RosterPlan> ImportRoster(const std::vector<RosterRow>& rows, bool dry_run,
                                          const Actor& by) = 0;

  // Sessions: whether one still counts (idle, absolute end) is for server/auth to say.
  virtual Status CreateSession(const SessionRow& session) = 0;
  virtual Result<SessionRow> FindSession(const Sha256& token_hash) = 0;
  virtual Status TouchSession(const Sha256& token_hash, UnixMs now_ms) = 0;
  virtual Status EndSession(const Sha256& token_hash) = 0;
  // How many there were.
  virtual Result<size_t> EndSessionsOf(const Uuid& person, const Actor& by) = 0;
  // Newest first.
  virtual Result<std::vector<SessionRow>> SessionsOf(const Uuid& person) = 0;
  // Errors: kNotFound.
  virtual Result<SessionRow> SessionById(const Uuid& id) = 0;
  virtual Status EndSessionById(const Uuid& id, const Actor& by) = 0;
  // The password was given once more.
  virtual Status ConfirmSession(const Sha256& token_hash, UnixMs now_ms) = 0;
};

}  // namespace enamel::server
