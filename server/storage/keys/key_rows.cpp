#include "server/storage/keys/key_rows.h"

#include <string>

#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

constexpr char kFindKeys[] = "SELECT person, generation, hash FROM person_keys WHERE tenant = ?1";

KeyRow KeyRowOf(const Query& q) { return {q.Id(0), q.Int(1), q.Hash(2)}; }

Result<std::optional<KeyRow>> OneKeyRow(Query& q) {
  std::optional<KeyRow> out;
  if (q.Next()) out = KeyRowOf(q);
  if (!q.status().ok()) return q.status();
  return out;
}

}  // namespace

Result<std::optional<KeyRow>> FindKeyRow(sql::Db& db, const Uuid& person) {
  Query q(db, std::string(kFindKeys) + " AND person = ?2");
  return OneKeyRow(q.Bind(person));
}

Result<std::optional<KeyRow>> FindLivingKeyRow(sql::Db& db, const Uuid& person) {
  Query q(db,
          std::string(kFindKeys) +
              " AND person = ?2 AND NOT EXISTS (SELECT 1 FROM erasures e WHERE e.tenant = ?1 AND "
              "e.person_hash = ?3)");
  return OneKeyRow(q.Bind(person).Bind(TombstoneOf(person)));
}

Result<std::vector<KeyRow>> AllKeyRows(sql::Db& db) {
  Query q(db, kFindKeys);
  std::vector<KeyRow> out;
  while (q.Next()) out.push_back(KeyRowOf(q));
  if (!q.status().ok()) return q.status();
  return out;
}

Status AddKeyRow(sql::Db& db, const KeyRow& row, int64_t now_ms) {
  Query q(db,
          "INSERT INTO person_keys (tenant, person, generation, hash, made_ms) VALUES (?1, ?2, ?3, "
          "?4, ?5) ON CONFLICT DO NOTHING");
  return q.Bind(row.person).Bind(row.generation).Bind(row.hash).Bind(now_ms).Run();
}

Status DeleteKeyRow(sql::Db& db, const Uuid& person) {
  Query q(db, "DELETE FROM person_keys WHERE tenant = ?1 AND person = ?2");
  return q.Bind(person).Run();
}

Result<std::vector<Tombstone>> ErasuresIn(sql::Db& db) {
  Query q(db, "SELECT person_hash, erased_ms FROM erasures WHERE tenant = ?1");
  std::vector<Tombstone> out;
  while (q.Next()) out.push_back(Tombstone{q.Hash(0), q.Int(1)});
  if (!q.status().ok()) return q.status();
  return out;
}

Result<bool> IsErased(sql::Db& db, const Sha256& person) {
  Query q(db, "SELECT 1 FROM erasures WHERE tenant = ?1 AND person_hash = ?2");
  const bool found = q.Bind(person).Next();
  if (!q.status().ok()) return q.status();
  return found;
}

Status AddErasure(sql::Db& db, const Tombstone& tombstone) {
  Query q(db,
          "INSERT INTO erasures (tenant, person_hash, erased_ms) VALUES (?1, ?2, ?3) "
          "ON CONFLICT DO NOTHING");
  return q.Bind(tombstone.person).Bind(tombstone.erased_ms).Run();
}

}  // namespace enamel::server
