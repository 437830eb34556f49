#include "server/storage/audit/audit_trail.h"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"

// The audit trail: added to, never changed (schemas/audit.md).
namespace enamel::server {
std::string JsonOf(std::initializer_list<std::pair<const char*, std::string>> members) {
  boost::json::object object;
  for (const auto& [name, value] : members) object[name] = value;
  return boost::json::serialize(object);
}

namespace {

// The next one after it, where no clock gives a later one: rows about one thing are in the order of
// their ids, also where a clock has been set back.
Uuid After(Uuid id) {
  for (size_t i = id.bytes.size(); i-- > 0;) {
    if (++id.bytes[i] != 0) break;
  }
  return id;
}

// Number and id of the newest row of the chain; zero: there is none.
Result<std::pair<int64_t, Uuid>> LastOfChain(Db& db, const Uuid& chain) {
  Query q(
      db,
      "SELECT number, id FROM audit WHERE tenant = ?1 AND chain = ?2 ORDER BY number DESC LIMIT "
      "1");
  std::pair<int64_t, Uuid> out{};
  if (q.Bind(chain).Next()) out = {q.Int(0), q.Id(1)};
  ENAMEL_RETURN_IF_ERROR(q.status());
  return out;
}

AuditHead HeadOf(const Query& q) {
  AuditHead out{q.Id(0), static_cast<uint64_t>(q.Int(1)), q.Id(2), q.Hash(3)};
  // Of another length: a signature that fits nothing.
  const Bytes signature = q.Blob(4);
  if (signature.size() == out.signature.size()) std::ranges::copy(signature, out.signature.begin());
  return out;
}

Result<std::optional<AuditHead>> FindHead(Db& db, const Uuid& chain, const char* lock) {
  Query q(db, std::string(
                  "SELECT chain, number, last_id, hash, signature FROM audit_heads WHERE tenant "
                  "= ?1 AND chain = ?2") +
                  lock);
  return q.Bind(chain).Maybe(HeadOf);
}

// Where the next row goes, and the id that it has to be above.
struct NextPlace {
  AuditLink link;
  Uuid after;
};

// Continues from the chain's signed end. A missing end, or one not signed here, leaves a row that
// follows no other, and `verify` reports it from then on: the next row does not mend a trail whose
// end somebody cut off.
Result<NextPlace> NextInChain(Db& db, const AuditSigner& signer) {
  // Locked: another process of this server (a command beside it) extends the same chain.
  ENAMEL_ASSIGN_OR_RETURN(const auto head, FindHead(db, signer.chain, db.RowLock()));
  if (head && (*head == signer.known || VerifyAuditHead(*head, signer.public_key)))
    return NextPlace{{signer.chain, head->number + 1, head->hash}, head->last_id};
  ENAMEL_ASSIGN_OR_RETURN(const auto last, LastOfChain(db, signer.chain));
  const uint64_t before = std::max(static_cast<uint64_t>(last.first), head ? head->number : 0);
  return NextPlace{{signer.chain, before + 1, {}}, last.second};
}

// Reads only rows about the same subject: servers that write about others at the same time must not
// conflict here.
Result<Uuid> NewestAbout(Db& db, const std::string& subject) {
  if (subject.empty()) return Uuid{};
  Query q(db,
          std::string("SELECT id FROM audit WHERE ") + kAboutSubject + " ORDER BY id DESC LIMIT 1");
  return q.Bind(subject).Value<Uuid>();
}

Status KeepHead(Db& db, const AuditSigner& signer, const AuditSeal& seal) {
  AuditHead head{seal.link.chain, seal.link.number, seal.id, AuditSealHash(seal)};
  head.signature = SignAuditHead(head, signer.key);
  ENAMEL_RETURN_IF_ERROR(Insert(db, "audit_heads", "chain", head.chain, "number", head.number,
                                "last_id", head.last_id, "hash", head.hash, "signature",
                                ByteView(head.signature),
                                " ON CONFLICT (tenant, chain) DO UPDATE SET number = "
                                "excluded.number, last_id = excluded.last_id, hash = "
                                "excluded.hash, signature = excluded.signature"));
  signer.known = head;
  return Status::Ok();
}

}  // namespace

Result<std::optional<AuditHead>> FindAuditHead(Db& db, const Uuid& chain) {
  return FindHead(db, chain, "");
}

Result<std::vector<AuditHead>> AuditHeads(Db& db) {
  Query q(db,
          "SELECT chain, number, last_id, hash, signature FROM audit_heads WHERE tenant = ?1 ORDER "
          "BY chain");
  return q.All(HeadOf);
}

// In the transaction of the change: neither exists without the other.
Status WriteAuditAbout(Db& db, const std::string& subject, const Actor& by, const char* action,
                       const std::string& object, const std::string& before,
                       const std::string& after) {
  const auto* signer = dynamic_cast<const AuditSigner*>(db.companion());
  ENAMEL_CHECK(signer != nullptr);
  std::string state;
  if (!subject.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(state, StateOf(db, subject));
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto next, NextInChain(db, *signer));
  ENAMEL_ASSIGN_OR_RETURN(const auto newest, NewestAbout(db, subject));
  const Uuid last = std::max(next.after, newest), fresh = Uuid::New();
  const Uuid id = last < fresh ? fresh : After(last);
  const AuditSalt salt = NewAuditSalt();
  const AuditSeal seal{id,       NowMs(), by.person, by.via,
                       action,   object,  subject,   AuditContentHash(salt, before, after, state),
                       next.link};
  ENAMEL_RETURN_IF_ERROR(
      Insert(db, "audit", "id", seal.id, "at_ms", seal.at_ms, "actor", seal.actor, "via", seal.via,
             "action", seal.action, "object", seal.object, "before_json", before, "after_json",
             after, "subject", seal.subject, "state", state, "salt", ByteView(salt), "content_hash",
             seal.content, "signature", ByteView(SignAuditSeal(seal, signer->key)), "chain",
             next.link.chain, "number", next.link.number, "previous", next.link.previous));
  return KeepHead(db, *signer, seal);
}

Status WriteAudit(Db& db, const Actor& by, const char* action, const std::string& object,
                  const std::string& before, const std::string& after) {
  return WriteAuditAbout(db, SubjectOfAction(action, object), by, action, object, before, after);
}

}  // namespace enamel::server
