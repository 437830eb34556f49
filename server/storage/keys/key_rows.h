#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"
#include "server/storage/keys/keyring.h"

// Rows of the tables `person_keys` (schemas/sql/0001_initial.sql) and `erasures`, for S3Keyring.
// Each function is part of a transaction of the caller's. Private to server/storage.
namespace enamel::server {

struct KeyRow {
  Uuid person;
  int64_t generation = 0;
  Sha256 hash;  // of the object
};

Result<std::optional<KeyRow>> FindKeyRow(sql::Db& db, const Uuid& person);
// Unless the person is erased: an erasure that broke off has left the row, and the object perhaps.
Result<std::optional<KeyRow>> FindLivingKeyRow(sql::Db& db, const Uuid& person);
Result<std::vector<KeyRow>> AllKeyRows(sql::Db& db);
// Unless there is one. Of a transaction of Isolation::kSerial.
Status AddKeyRow(sql::Db& db, const KeyRow& row, int64_t now_ms);
Status DeleteKeyRow(sql::Db& db, const Uuid& person);

Result<std::vector<Tombstone>> ErasuresIn(sql::Db& db);
Result<bool> IsErased(sql::Db& db, const Sha256& person);
// Adds it unless it exists.
Status AddErasure(sql::Db& db, const Tombstone& tombstone);

}  // namespace enamel::server
