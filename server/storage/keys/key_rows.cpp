#include "server/storage/keys/key_rows.h"

#include <string>

#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

constexpr char kFindKeys[] = "SELECT person, generation, hash FROM person_keys WHERE tenant = ?1";

}  // namespace

Result<std::optional<KeyRow>> FindKeyRow(sql::Db& db, const Uuid& person) {
  Query q(db, std::string(kFindKeys) + " AND person = ?2");
  return q.Bind(person).Maybe<KeyRow>();
}

Result<std::optional<KeyRow>> FindLivingKeyRow(sql::Db& db, const Uuid& person) {
  Query q(db,
          std::string(kFindKeys) +
              " AND person = ?2 AND NOT EXISTS (SELECT 1 FROM erasures e WHERE e.tenant = ?1 AND "
              "e.person_hash = ?3)");
  return q.Bind(person, TombstoneOf(person)).Maybe<KeyRow>();
}

Result<std::vector<KeyRow>> AllKeyRows(sql::Db& db) {
  Query q(db, kFindKeys);
  return q.All<KeyRow>();
}

Status AddKeyRow(sql::Db& db, const KeyRow& row, int64_t now_ms) {
  return Insert(db, "person_keys", "person", row.person, "generation", row.generation, "hash",
                row.hash, "made_ms", now_ms, " ON CONFLICT DO NOTHING");
}

Status DeleteKeyRow(sql::Db& db, const Uuid& person) {
  Query q(db, "DELETE FROM person_keys WHERE tenant = ?1 AND person = ?2");
  return q.Bind(person).Run();
}

Result<std::vector<Tombstone>> ErasuresIn(sql::Db& db) {
  Query q(db, "SELECT person_hash, erased_ms FROM erasures WHERE tenant = ?1");
  return q.All<Tombstone>();
}

Result<bool> IsErased(sql::Db& db, const Sha256& person) {
  Query q(db, "SELECT 1 FROM erasures WHERE tenant = ?1 AND person_hash = ?2");
  return q.Bind(person).Any();
}

Status AddErasure(sql::Db& db, const Tombstone& tombstone) {
  return Insert(db, "erasures", "person_hash", tombstone.person, "erased_ms", tombstone.erased_ms,
                " ON CONFLICT DO NOTHING");
}

}  // namespace enamel::server
