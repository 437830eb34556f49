#include "server/storage/audit/audit_row.h"

#include <sodium.h>

#include <algorithm>

namespace enamel::server {
namespace {

constexpr char kDomain[] = "enamel.trail.v1", kHeadDomain[] = "enamel.trail.end.v1";

// The second half of a secret key is the public one.
trace::PublicKey PublicOf(const trace::SecretKey& key) {
  trace::PublicKey out;
  std::copy(key.end() - static_cast<ptrdiff_t>(out.size()), key.end(), out.begin());
  return out;
}

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
  out.Raw(seal.link.chain.view());
  out.U64(seal.link.number);
  out.Raw(seal.link.previous.view());
  return out.Take();
}

Sha256 AuditSealHash(const AuditSeal& seal) { return HashSha256(EncodeAuditSeal(seal)); }

trace::Signature SignAuditSeal(const AuditSeal& seal, const trace::SecretKey& key) {
  return trace::SignText(kDomain, EncodeAuditSeal(seal), key);
}

bool VerifyAuditSeal(const AuditSeal& seal, const trace::Signature& signature,
                     const trace::PublicKey& key) {
  return trace::VerifyText(kDomain, EncodeAuditSeal(seal), signature, key);
}

Bytes EncodeAuditHead(const AuditHead& head) {
  ByteWriter out;
  out.Raw(head.chain.view());
  out.U64(head.number);
  out.Raw(head.last_id.view());
  out.Raw(head.hash.view());
  return out.Take();
}

trace::Signature SignAuditHead(const AuditHead& head, const trace::SecretKey& key) {
  return trace::SignText(kHeadDomain, EncodeAuditHead(head), key);
}

bool VerifyAuditHead(const AuditHead& head, const trace::PublicKey& key) {
  return trace::VerifyText(kHeadDomain, EncodeAuditHead(head), head.signature, key);
}

AuditSigner::AuditSigner(const trace::SecretKey& secret_key, const Uuid& own_chain)
    : key(secret_key), public_key(PublicOf(secret_key)), chain(own_chain) {}

}  // namespace enamel::server
