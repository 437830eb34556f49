#include "server/storage/blobs/named_blobs.h"

#include <set>
#include <string>

#include "server/storage/engine/query.h"

namespace enamel::server {
Result<std::set<Sha256>> NamedBlobs(Db& db) {
  std::set<Sha256> out;
  auto add = [&](Query& q, int columns) {
    while (q.Next()) {
      for (int i = 0; i < columns; ++i) {
        if (Sha256 hash = q.Hash(i); !hash.IsZero()) out.insert(hash);
      }
    }
    return q.status();
  };
  std::string sql;
  for (const char* document :
       {"content FROM profiles", "content FROM profile_versions", "content FROM profile_reports",
        "content FROM scenes", "volume FROM scenes", "surface FROM scenes",
        "content FROM exercises", "content FROM rubrics", "content FROM start_teeth",
        "content FROM timelines", "content FROM motions", "content FROM trace_parts",
        "score_json FROM attempt_results", "final_volume FROM attempt_results",
        "deviation FROM attempt_results", "series FROM attempt_results"}) {
    sql +=
        (sql.empty() ? "SELECT " : " UNION SELECT ") + std::string(document) + " WHERE tenant = ?1";
  }
  Query documents(db, sql.c_str());
  ENAMEL_RETURN_IF_ERROR(add(documents, 1));
  Query attempts(db,
                 "SELECT profile_content, trace_blob, score_json, final_volume, deviation, series "
                 "FROM attempts WHERE tenant = ?1");
  ENAMEL_RETURN_IF_ERROR(add(attempts, 6));
  return out;
}

}  // namespace enamel::server
