#include "server/storage/upkeep/deletion.h"

#include <set>
#include <vector>

#include "server/storage/engine/query.h"
#include "server/storage/judging/motion_rows.h"
#include "server/storage/judging/timeline_rows.h"
#include "server/storage/recordings/trace_parts.h"

namespace enamel::server {
Status DeleteAttempts(Db& db, const std::vector<Uuid>& attempts, std::set<Sha256>& blobs) {
  for (const Uuid& attempt : attempts) {
    // Reads which blobs it named before deleting the row; the files are removed after the commit,
    // so that no row ever names a missing one.
    Query named(db,
                "SELECT trace_blob, score_json, final_volume, deviation, series FROM attempts "
                "WHERE tenant = ?1 AND id = ?2");
    if (named.Bind(attempt).Next()) {
      for (int i = 0; i < 5; ++i) {
        if (Sha256 hash = named.Hash(i); !hash.IsZero()) blobs.insert(hash);
      }
    }
    ENAMEL_RETURN_IF_ERROR(named.status());
    Query earlier(
        db,
        "SELECT score_json, final_volume, deviation, series FROM attempt_results WHERE tenant "
        "= ?1 AND attempt = ?2");
    for (earlier.Bind(attempt); earlier.Next();) {
      for (int i = 0; i < 4; ++i) {
        if (Sha256 hash = earlier.Hash(i); !hash.IsZero()) blobs.insert(hash);
      }
    }
    ENAMEL_RETURN_IF_ERROR(earlier.status());
    ENAMEL_RETURN_IF_ERROR(DropParts(db, attempt, blobs));
    ENAMEL_RETURN_IF_ERROR(DropTimeline(db, attempt, blobs));
    ENAMEL_RETURN_IF_ERROR(DropMotion(db, attempt, blobs));
    for (const char* sql :
         {"UPDATE motions SET nearest = NULL WHERE tenant = ?1 AND nearest = ?2",
          "UPDATE motions SET preset = NULL WHERE tenant = ?1 AND preset = ?2",
          "UPDATE attempts SET reference = NULL WHERE tenant = ?1 AND reference = ?2",
          "UPDATE attempt_results SET reference = NULL WHERE tenant = ?1 AND reference = ?2",
          "DELETE FROM reference_cuts WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM attempt_results WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM sign_offs WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM annotations WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM appeals WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM marks WHERE tenant = ?1 AND work IN (SELECT id FROM marking_works WHERE "
          "tenant = ?1 AND attempt = ?2)",
          "DELETE FROM marking_works WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM jobs WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM contradicting_chunks WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM attempts WHERE tenant = ?1 AND id = ?2"}) {
      ENAMEL_RETURN_IF_ERROR(Query(db, sql).Bind(attempt).Run());
    }
  }
  return Status::Ok();
}

}  // namespace enamel::server
