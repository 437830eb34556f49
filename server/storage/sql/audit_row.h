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
namespace enamel::server::sqlite {

using AuditSalt = std::array<uint8_t, 32>;
AuditSalt NewAuditSalt();  // from the system's random source

// Stands in the signed text for what may have to be erased; without the salt it tells nothing of
// it.
Sha256 AuditContentHash(const AuditSalt& salt, const std::string& before_json,
                        const std::string& after_json, const std::string& state);

// What is signed.
struct AuditSeal {
  Uuid id;
  UnixMs at_ms = 0;
  Uuid actor;
  std::string via, action, object, subject;
  Sha256 content;  // AuditContentHash
};
Bytes EncodeAuditSeal(const AuditSeal& seal);
trace::Signature SignAuditSeal(const AuditSeal& seal, const trace::SecretKey& key);
bool VerifyAuditSeal(const AuditSeal& seal, const trace::Signature& signature,
                     const trace::PublicKey& key);

// Goes with every connection that writes rows (sql::Db::companion).
struct AuditSigner final : sql::Db::Companion {
  explicit AuditSigner(const trace::SecretKey& secret_key) : key(secret_key) {}
  const trace::SecretKey key;
};

}  // namespace enamel::server::sqlite
