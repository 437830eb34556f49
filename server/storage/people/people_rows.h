#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/keyring.h"
#include "server/training/types.h"

namespace enamel::server {

// People. Passwords are verifier strings made by server/auth; no reader ever shows one.
class PeopleRows {
 public:
  PeopleRows(Transactions& rows, Keyring& keyring) : rows_(rows), keyring_(keyring) {}

  // People. Passwords are verifier strings made by server/auth; never shown by any reader.
  // Together with the memberships or not at all. Errors: kConflict (the login is taken), kNotFound
  // with field "cohorts".
  Result<Uuid> CreatePerson(const Person& person, const std::string& password_verifier,
                            const std::vector<Uuid>& cohorts, const Actor& by);
  Result<Person> PersonById(const Uuid& id);
  Result<Person> PersonByLogin(const std::string& login);
  Result<std::string> PasswordVerifier(const Uuid& person);
  // A try of the PIN that signs exams at a chair.
  struct PinTry {
    std::string verifier;  // empty: none was chosen
    bool locked = false;   // no PIN is right now
    bool last = false;     // if it is wrong, the PIN is locked
  };
  // After so many wrong PINs in a row the PIN is locked, until SetPin.
  static constexpr int kMaxWrongPins = 10;
  // Counts the try as a wrong one before it is checked: of tries at the same time, at any of the
  // servers of a school, no more than kMaxWrongPins are checked. Errors: kNotFound.
  Result<PinTry> TryPin(const Uuid& person);
  // The try was right: forgets the wrong ones.
  Status PinWasRight(const Uuid& person);
  // The last try was wrong: leaves an audit row if the PIN is locked.
  Status NotePinLocked(const Uuid& person, const Actor& by);
  // Also unlocks it.
  Status SetPin(const Uuid& person, const std::string& verifier, const Actor& by);
  // Ends the person's sessions. `for_one_use`: it has to be changed before anything else is done.
  Status SetPassword(const Uuid& person, const std::string& verifier, bool for_one_use,
                     const Actor& by);
  // One of kPageLanguages, or empty. No decision: it leaves no audit row. Errors: kNotFound.
  Status SetLanguage(const Uuid& person, const std::string& language);
  // Disabling ends the person's sessions in the same transaction. Errors also: kConflict (the last
  // admin who may sign in).
  Status SetDisabled(const Uuid& person, bool disabled, const Actor& by);
  Result<std::vector<Person>> People();
  // By login.
  Result<std::vector<Person>> FindPeople(const PeopleFilter& filter);
  // A new role or disabling ends the person's sessions. Returns the edited person. Errors:
  // kConflict with field kStale (`revision` is not the stored one), without one (the last admin who
  // may sign in).
  Result<Person> EditPerson(const Uuid& id, const PersonEdit& edit, int32_t revision,
                            const Actor& by);

 private:
  Transactions& rows_;
  Keyring& keyring_;
};

// Inside a transaction, for other rows.
//
// A Person of the table as `p`.
inline constexpr char kPersonColumns[] =
    "p.id, p.login, p.display_name, p.role, p.disabled, p.created_ms, p.must_change_password, "
    "p.password_ms, p.revision, p.language, p.wrong_pins >= 10, p.may_import_teeth";
static_assert(PeopleRows::kMaxWrongPins == 10);
// A condition: the login or the name has the word (SearchWords) that is bound as `word`, "?4".
std::string NameHas(const std::string& word);
Result<Person> FindPerson(Db& db, const Uuid& id);
// Each leaves its audit row.
Status InsertPerson(Db& db, const Person& person, const std::string& verifier, const Actor& by);
Status RenamePerson(Db& db, const Person& before, const std::string& display_name, const Actor& by);
// kConflict when the person is the only admin who may sign in.
Status MustNotBeTheOnlyAdmin(Db& db, const Person& person);

}  // namespace enamel::server
