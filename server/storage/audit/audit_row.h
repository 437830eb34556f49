#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"
#include "common/trace/trace.h"
#include "server/training/types.h"

// How a row of the audit trail is signed; normative text: schemas/audit.md.
namespace enamel::server {

using AuditSalt = std::array<uint8_t, 32>;
AuditSalt NewAuditSalt();  // from the system's random source

// The signed text has this hash instead of the words that may have to be erased. Without the salt
// it reveals nothing about them.
Sha256 AuditContentHash(const AuditSalt& salt, const std::string& before_json,
                        const std::string& after_json, const std::string& state);

// Where a row stands.
struct AuditLink {
  Uuid chain;
  uint64_t number = 0;  // from 1
  Sha256 previous;      // AuditSealHash of the row before; zero: there is none, or it is not known
};

// The signed content.
struct AuditSeal {
  Uuid id;
  UnixMs at_ms = 0;
  Uuid actor;
  std::string via, action, object, subject;
  Sha256 content;  // AuditContentHash
  AuditLink link{};
};
Bytes EncodeAuditSeal(const AuditSeal& seal);
Sha256 AuditSealHash(const AuditSeal& seal);
trace::Signature SignAuditSeal(const AuditSeal& seal, const trace::SecretKey& key);
bool VerifyAuditSeal(const AuditSeal& seal, const trace::Signature& signature,
                     const trace::PublicKey& key);

// Where a chain ends.
struct AuditHead {
  Uuid chain;
  uint64_t number = 0;  // of the last row
  Uuid last_id;
  Sha256 hash;  // AuditSealHash of the last row
  trace::Signature signature{};

  bool operator==(const AuditHead&) const = default;
};
Bytes EncodeAuditHead(const AuditHead& head);
trace::Signature SignAuditHead(const AuditHead& head, const trace::SecretKey& key);
bool VerifyAuditHead(const AuditHead& head, const trace::PublicKey& key);

// Goes with every connection that writes rows (sql::Db::companion). Thread safety: the
// connection's.
struct AuditSigner final : sql::Db::Companion {
  explicit AuditSigner(const trace::SecretKey& secret_key, const Uuid& own_chain = {});
  const trace::SecretKey key;
  const trace::PublicKey public_key;
  // The rows of this writer. All who write to one SQLite file take turns, so they share one;
  // servers that write at the same time need one each.
  const Uuid chain;
  // Last signed here: an unchanged end needs no check of its signature.
  mutable AuditHead known;
};

}  // namespace enamel::server
