#pragma once

#include <optional>
#include <string>

#include "common/base/bytes.h"
#include "common/base/sha256.h"
#include "common/base/unix_time.h"
#include "common/base/uuid.h"
#include "common/sql/query.h"

namespace enamel::server {

using sql::Db;

// One use of a statement of the store. ?1 is always the tenant; Bind fills ?2, ?3, … in order.
//   Query q(db, "SELECT name FROM people WHERE tenant = ?1 AND id = ?2");
//   q.Bind(id);
//   if (q.Next()) … q.Text(0) …
// A bound value has its column's type, without conversion: ids and hashes are BLOB, times and
// states INTEGER, scores REAL. Other C++ types have no Bind.
class Query : public sql::Query {
 public:
  Query(Db& db, const char* sql) : sql::Query(db, sql) { BindInt(kTenant); }
  Query(Db& db, const std::string& sql) : Query(db, sql.c_str()) {}

  Query& Bind(int64_t value) { return Mine(BindInt(value)); }
  Query& Bind(double value) { return Mine(BindReal(value)); }
  Query& Bind(const std::string& value) { return Mine(BindText(value)); }
  Query& Bind(ByteView value) { return Mine(BindBlob(value)); }
  Query& Bind(const Bytes& value) { return Bind(ByteView(value)); }
  Query& Bind(const Uuid& value) { return Bind(value.view()); }
  Query& Bind(const Sha256& value) { return Bind(value.view()); }
  // None: NULL.
  Query& Bind(const std::optional<Uuid>& value) {
    return value ? Bind(*value) : BindNull(sql::Type::kBlob);
  }
  Query& BindNull(sql::Type type) { return Mine(sql::Query::BindNull(type)); }

  static constexpr int64_t kTenant = 1;

 private:
  Query& Mine(const sql::Query&) { return *this; }
};

// Milliseconds since the epoch, now.
inline int64_t NowMs() { return enamel::UnixMs(); }

}  // namespace enamel::server
