#pragma once

#include <cstddef>
#include <map>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/data_key.h"
#include "server/storage/keys/keyring.h"

namespace enamel::server {

// The key of each attempt's recording. Thread safety: any thread.
class AttemptKeys {
 public:
  AttemptKeys(Transactions& rows, Keyring& keyring) : rows_(rows), keyring_(keyring) {}

  // The attempt's person, from memory if known. Errors: kNotFound.
  Result<Uuid> PersonOf(const Uuid& attempt);
  struct PersonKey {
    Uuid person;
    DataKey key;
  };
  // Errors: kNotFound, kConflict (erased).
  Result<PersonKey> KeyOf(const Uuid& attempt);

 private:
  static constexpr size_t kMaxRemembered = 50'000;

  Transactions& rows_;
  Keyring& keyring_;
  Mutex mutex_;
  std::map<Uuid, Uuid> person_of_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server
