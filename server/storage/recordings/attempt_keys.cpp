#include "server/storage/recordings/attempt_keys.h"

#include "server/storage/attempts/attempt_rows.h"

namespace enamel::server {
Result<Uuid> AttemptKeys::PersonOf(const Uuid& attempt) {
  {
    MutexLock lock(mutex_);
    const auto known = person_of_.find(attempt);
    if (known != person_of_.end()) return known->second;
  }
  ENAMEL_ASSIGN_OR_RETURN(const AttemptRow row,
                          rows_.Read([&](Db& db) { return FindAttempt(db, attempt); }));
  MutexLock lock(mutex_);
  // All at once and not the oldest, which is simple: each is found again when needed.
  if (person_of_.size() >= kMaxRemembered) person_of_.clear();
  person_of_[attempt] = row.person;
  return row.person;
}

Result<AttemptKeys::PersonKey> AttemptKeys::KeyOf(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(const Uuid person, PersonOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto key, keyring_.FindOrMake(person));
  return PersonKey{person, key};
}

}  // namespace enamel::server
