#include "server/storage/teaching/scene_rows.h"

#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"

// Scenes.
namespace enamel::server {
Status SceneRows::PutScene(const SceneRow& row, const Actor& by) {
  // A row must name existing blobs; see profile_rows.cpp.
  if (!blobs_.Has(row.content) || !blobs_.Has(row.volume)) {
    return Status(Code::kNotFound,
                  "the scene's document or volume is not stored; put both blobs first");
  }
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(Insert(db, "scenes", "name", row.name, "title", row.title, "content",
                                  row.content, "volume", row.volume, " ON CONFLICT DO NOTHING"));
    // A scene is named by its content: the same content is the existing scene.
    if (db.Changes() == 0) return Status::Ok();
    return WriteAuditAbout(db, SubjectOf("scene", row.content.Hex()), by, "scene.put", row.name,
                           "{}", JsonOf({{"content", row.content.Hex()}}));
  });
}

Result<std::vector<SceneRow>> SceneRows::Scenes() {
  return rows_.Read([&](Db& db) -> Result<std::vector<SceneRow>> {
    Query q(
        db,
        "SELECT name, title, content, volume, surface FROM scenes WHERE tenant = ?1 ORDER BY name");
    return q.All<SceneRow>();
  });
}

// Follows from the volume alone: nothing that somebody did, so no audit row.
Status SceneRows::PutSceneSurface(const Sha256& volume, const Sha256& surface) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "UPDATE scenes SET surface = ?3 WHERE tenant = ?1 AND volume = ?2");
    return q.Bind(volume, surface).Run();
  });
}

}  // namespace enamel::server
