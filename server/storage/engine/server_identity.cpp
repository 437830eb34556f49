#include "server/storage/engine/server_identity.h"

#include <string>

#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

struct PartWords {
  const char* name;
  const char* what;
  const char* how;
};

// An identity is three files, so that one remedy mends two of them.
constexpr char kCopyFiles[] =
    "; take station.crt, station.key and ticket.key of a server that runs: --identity FOLDER";

PartWords WordsOf(ServerPart part) {
  switch (part) {
    case ServerPart::kStationCertificate:
      return {"station_certificate", "certificate for stations", kCopyFiles};
    case ServerPart::kTicketKey:
      return {"ticket_key", "ticket key", kCopyFiles};
    case ServerPart::kKeyRing:
      return {"key_ring", "key ring",
              "; name the same bucket, prefix and master key file as a server that runs"};
  }
  return {};
}

// Enough of a hash for people to compare.
std::string Brief(const Sha256& hash) { return hash.Hex().substr(0, 16) + "…"; }

}  // namespace

Status MatchIdentityRow(sql::Db& db, ServerPart part, const std::optional<Sha256>& fingerprint) {
  const PartWords words = WordsOf(part);
  if (fingerprint) {
    Query put(db,
              "INSERT INTO server_identity (tenant, name, fingerprint) VALUES (?1, ?2, ?3) "
              "ON CONFLICT DO NOTHING");
    ENAMEL_RETURN_IF_ERROR(put.Bind(words.name, *fingerprint).Run());
  }
  Query q(db, "SELECT fingerprint FROM server_identity WHERE tenant = ?1 AND name = ?2");
  const bool there = q.Bind(words.name).Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  if (!there || (fingerprint && q.Hash(0) == *fingerprint)) return Status::Ok();
  const std::string theirs = std::string("expected the ") + words.what +
                             " of the other servers of this database (" + Brief(q.Hash(0)) +
                             "), found ";
  if (!fingerprint) return Status(Code::kNotFound, theirs + "none" + words.how);
  return Status(Code::kConflict, theirs + "another (" + Brief(*fingerprint) + ")" + words.how);
}

Status ServerIdentityRows::MatchIdentity(ServerPart part,
                                         const std::optional<Sha256>& fingerprint) {
  if (!rows_.shared()) return Status::Ok();
  return rows_.Write([&](sql::Db& db) { return MatchIdentityRow(db, part, fingerprint); });
}

}  // namespace enamel::server
