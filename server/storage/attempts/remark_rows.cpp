#include "server/storage/attempts/remark_rows.h"

#include <algorithm>
#include <string>
#include <vector>

#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"

// Remarks.
namespace enamel::server {
namespace {

#define ENAMEL_ANNOTATION_SELECT                                                             \
  "SELECT n.id, n.attempt, n.author, coalesce(p.display_name, ''), n.tick, n.x_um, n.y_um, " \
  "n.z_um, n.text, n.created_ms, n.edited_ms, n.revision, n.to_chair, "                      \
  "coalesce(n.remark_id, 0) FROM annotations n "                                             \
  "LEFT JOIN people p ON p.tenant = n.tenant AND p.id = n.author WHERE n.tenant = ?1"

AnnotationRow AnnotationOf(const Query& q) {
  AnnotationRow out;
  std::array<int32_t, 3> point{};
  q.Read(0, out.id, out.attempt, out.author, out.author_name, out.tick, point[0], point[1],
         point[2], out.text, out.created_ms, out.edited_ms, out.revision, out.to_chair,
         out.remark_id);
  if (!q.IsNull(5)) out.point_um = point;
  return out;
}

Result<AnnotationRow> FindAnnotation(Db& db, const Uuid& id) {
  Query q(db, ENAMEL_ANNOTATION_SELECT " AND n.id = ?2");
  return q.Bind(id).One(AnnotationOf, "no annotation " + id.Text());
}

std::optional<int32_t> Axis(const AnnotationRow& row, size_t axis) {
  return row.point_um ? std::optional((*row.point_um)[axis]) : std::nullopt;
}

Status SendToChair(Db& db, const AnnotationRow& row, int64_t now_ms) {
  Query last(db,
             "SELECT coalesce(max(remark_id), 0) FROM annotations WHERE tenant = ?1 AND attempt = "
             "?2");
  ENAMEL_ASSIGN_OR_RETURN(const int64_t before, last.Bind(row.attempt).Value<int64_t>());
  Query q(db,
          "UPDATE annotations SET remark_id = ?3, remark_state = 'waiting' WHERE tenant = ?1 AND "
          "id = ?2");
  // Time, so that one is not taken for an earlier one that was deleted.
  return q.Bind(row.id, std::max({now_ms, before + 1, int64_t{1}})).Run();
}

std::string RemarkJson(const AnnotationRow& row) {
  return JsonOf(
      {{"annotation", row.id.Text()}, {"tick", std::to_string(row.tick)}, {"text", row.text}});
}

}  // namespace

Result<AnnotationRow> RemarkRows::AddAnnotation(const AnnotationRow& annotation, const Actor& by) {
  AnnotationRow row = annotation;
  row.id = Uuid::New();
  Status status = rows_.Write([&](Db& db) -> Status {
    if (auto attempt = FindAttempt(db, row.attempt); !attempt.ok()) return attempt.status();
    const int64_t now_ms = NowMs();
    ENAMEL_RETURN_IF_ERROR(Insert(db, "annotations", "id", row.id, "tick", row.tick, "x_um",
                                  Axis(row, 0), "y_um", Axis(row, 1), "z_um", Axis(row, 2), "text",
                                  row.text, "attempt", row.attempt, "author", by.person,
                                  "created_ms", now_ms, "to_chair", row.to_chair));
    if (row.to_chair) ENAMEL_RETURN_IF_ERROR(SendToChair(db, row, now_ms));
    return WriteAuditAbout(db, SubjectOf("annotation", row.id.Text()), by, "annotation.add",
                           row.attempt.Text(), "{}", RemarkJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return AnnotationById(row.id);
}

Result<AnnotationRow> RemarkRows::ReplaceAnnotation(const AnnotationRow& row, const Actor& by) {
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto stored, FindAnnotation(db, row.id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, row.revision));
    Query q(
        db,
        "UPDATE annotations SET tick = ?3, x_um = ?4, y_um = ?5, z_um = ?6, text = ?7, edited_ms "
        "= ?8, revision = revision + 1 WHERE tenant = ?1 AND id = ?2");
    q.Bind(row.id, row.tick, Axis(row, 0), Axis(row, 1), Axis(row, 2), row.text, NowMs());
    ENAMEL_RETURN_IF_ERROR(q.Run());
    return WriteAuditAbout(db, SubjectOf("annotation", stored.id.Text()), by, "annotation.edit",
                           stored.attempt.Text(), RemarkJson(stored), RemarkJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return AnnotationById(row.id);
}

Status RemarkRows::DeleteAnnotation(const Uuid& id, int32_t revision, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto stored, FindAnnotation(db, id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, revision));
    Query q(db, "DELETE FROM annotations WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id).Run());
    return WriteAuditAbout(db, SubjectOf("annotation", stored.id.Text()), by, "annotation.delete",
                           stored.attempt.Text(), RemarkJson(stored), "{}");
  });
}

Result<AnnotationRow> RemarkRows::AnnotationById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindAnnotation(db, id); });
}

Result<std::vector<AnnotationRow>> RemarkRows::AnnotationsOf(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<std::vector<AnnotationRow>> {
    Query q(db, ENAMEL_ANNOTATION_SELECT " AND n.attempt = ?2 ORDER BY n.tick, n.id");
    return q.Bind(attempt).All(AnnotationOf);
  });
}

}  // namespace enamel::server
