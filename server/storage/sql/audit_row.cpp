#include "server/storage/sql/audit_row.h"

#include <sodium.h>

namespace enamel::server::sqlite {
namespace {

constexpr char kDomain[] = "enamel.audit.v1";

}  // namespace

AuditSalt NewAuditSalt() {
  AuditSalt salt;
  randombytes_buf(salt.data(), salt.size());
  return salt;
}

Sha256 AuditContentHash(const AuditSalt& salt, const std::string& before_json,
                        const std::string& after_json, const std::string& state) {
  ByteWriter out;
  out.Raw(salt);
  for (const std::string* text : {&before_json, &after_json, &state}) out.Text(*text);
  return HashSha256(out.bytes());
}

Bytes EncodeAuditSeal(const AuditSeal& seal) {
  ByteWriter out;
  out.Raw(seal.id.view());
  out.I64(seal.at_ms);
  out.Raw(seal.actor.view());
  for (const std::string* text : {&seal.via, &seal.action, &seal.object, &seal.subject}) {
    out.Text(*text);
  }
  out.Raw(seal.content.view());
  return out.Take();
}

trace::Signature SignAuditSeal(const AuditSeal& seal, const trace::SecretKey& key) {
  return trace::SignText(kDomain, EncodeAuditSeal(seal), key);
}

bool VerifyAuditSeal(const AuditSeal& seal, const trace::Signature& signature,
                     const trace::PublicKey& key) {
  return trace::VerifyText(kDomain, EncodeAuditSeal(seal), signature, key);
}

}  // namespace enamel::server::sqlite
