#include "server/storage/sql/server_identity.h"

#include <string>

#include "server/storage/sql/query.h"

namespace enamel::server::sqlite {
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
    case ServerPart::kMasterKey:
      return {"master_key", "master key", "; copy the master key file of a server that runs"};
  }
  return {};
}

}  // namespace

Status MatchIdentityRow(sql::Db& db, ServerPart part, const Sha256& fingerprint) {
  const PartWords words = WordsOf(part);
  Query put(db,
            "INSERT INTO server_identity (tenant, name, fingerprint) VALUES (?1, ?2, ?3) "
            "ON CONFLICT DO NOTHING");
  ENAMEL_RETURN_IF_ERROR(put.Bind(words.name).Bind(fingerprint).Run());
  Query q(db, "SELECT fingerprint FROM server_identity WHERE tenant = ?1 AND name = ?2");
  if (q.Bind(words.name).Next() && q.Hash(0) == fingerprint) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(q.status());
  // Enough of a hash for people to compare.
  const auto brief = [](const Sha256& hash) { return hash.Hex().substr(0, 16); };
  return Status(Code::kConflict, std::string("expected the ") + words.what +
                                     " of the other servers of this database (fingerprint " +
                                     brief(q.Hash(0)) + "…), found another (" + brief(fingerprint) +
                                     "…)" + words.how);
}

Result<bool> HasIdentityRow(sql::Db& db, ServerPart part) {
  Query q(db, "SELECT 1 FROM server_identity WHERE tenant = ?1 AND name = ?2");
  const bool found = q.Bind(WordsOf(part).name).Next();
  if (!q.status().ok()) return q.status();
  return found;
}

}  // namespace enamel::server::sqlite
