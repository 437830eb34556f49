#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/database_look.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

struct SessionRow {
  Sha256 token_hash;
  Uuid person;
  UnixMs created_ms = 0, last_used_ms = 0, expires_ms = 0;
  std::string via;          // "page" | "station"
  Uuid id{};                // what it is called where the token must not be; zero: made up
  UnixMs confirmed_ms = 0;  // when the password was given last; 0: when it was created
  // The address and program; both empty if unknown.
  std::string address{};  // IPv4, or the /64 of an IPv6 address
  std::string device{};   // "Firefox on Linux", or the station's name
};

// Sessions. Whether one still counts (idle, absolute end) is for server/auth to say.
class SessionRows {
 public:
  SessionRows(Transactions& rows, const DatabaseLook& look) : rows_(rows), look_(look) {}

  // Sessions: whether one still counts (idle, absolute end) is for server/auth to say.
  Status CreateSession(const SessionRow& session);
  Result<SessionRow> FindSession(const Sha256& token_hash);
  Status TouchSession(const Sha256& token_hash, UnixMs now_ms);
  Status EndSession(const Sha256& token_hash);
  // How many there were.
  Result<size_t> EndSessionsOf(const Uuid& person, const Actor& by);
  // Newest first.
  Result<std::vector<SessionRow>> SessionsOf(const Uuid& person);
  // Errors: kNotFound.
  Result<SessionRow> SessionById(const Uuid& id);
  Status EndSessionById(const Uuid& id, const Actor& by);
  // The password was given once more.
  Status ConfirmSession(const Sha256& token_hash, UnixMs now_ms);

 private:
  Transactions& rows_;
  const DatabaseLook& look_;
};

// Inside a transaction, for other rows.
Status DeleteSessions(Db& db, const Uuid& person);

}  // namespace enamel::server
