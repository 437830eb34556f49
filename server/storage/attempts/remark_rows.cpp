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
  out.id = q.Id(0);
  out.attempt = q.Id(1);
  out.author = q.Id(2);
  out.author_name = q.Text(3);
  out.tick = static_cast<uint64_t>(q.Int(4));
  if (!q.IsNull(5)) {
    out.point_um = {static_cast<int32_t>(q.Int(5)), static_cast<int32_t>(q.Int(6)),
                    static_cast<int32_t>(q.Int(7))};
  }
  out.text = q.Text(8);
  out.created_ms = q.Int(9);
  out.edited_ms = q.Int(10);
  out.revision = static_cast<int32_t>(q.Int(11));
  out.to_chair = q.Int(12) != 0;
  out.remark_id = static_cast<uint64_t>(q.Int(13));
  return out;
}

Result<AnnotationRow> FindAnnotation(Db& db, const Uuid& id) {
  Query q(db, ENAMEL_ANNOTATION_SELECT " AND n.id = ?2");
  if (q.Bind(id).Next()) return AnnotationOf(q);
  if (!q.status().ok()) return q.status();
  return Status(Code::kNotFound, "no annotation " + id.Text());
}

// Binds ?3 and on: tick, point, text.
Query& BindRemark(Query& q, const AnnotationRow& row) {
  q.Bind(static_cast<int64_t>(row.tick));
  for (size_t axis = 0; axis < 3; ++axis) {
    if (row.point_um) {
      q.Bind(int64_t{(*row.point_um)[axis]});
    } else {
      q.BindNull(sql::Type::kInt);
    }
  }
  return q.Bind(row.text);
}

Status SendToChair(Db& db, const AnnotationRow& row, int64_t now_ms) {
  Query last(db,
             "SELECT coalesce(max(remark_id), 0) FROM annotations WHERE tenant = ?1 AND attempt = "
             "?2");
  const int64_t before = last.Bind(row.attempt).Next() ? last.Int(0) : 0;
  ENAMEL_RETURN_IF_ERROR(last.status());
  Query q(db,
          "UPDATE annotations SET remark_id = ?3, remark_state = 'waiting' WHERE tenant = ?1 AND "
          "id = ?2");
  // Time, so that one is not taken for an earlier one that was deleted.
  return q.Bind(row.id).Bind(std::max({now_ms, before + 1, int64_t{1}})).Run();
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
    Query q(db,
            "INSERT INTO annotations (tenant, id, tick, x_um, y_um, z_um, text, attempt, author, "
            "created_ms, to_chair) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)");
    BindRemark(q.Bind(row.id), row).Bind(row.attempt).Bind(by.person).Bind(now_ms);
    q.Bind(int64_t{row.to_chair});
    ENAMEL_RETURN_IF_ERROR(q.Run());
    if (row.to_chair) ENAMEL_RETURN_IF_ERROR(SendToChair(db, row, now_ms));
    return WriteAuditAbout(db, SubjectOf("annotation", row.id.Text()), by, "annotation.add",
                           row.attempt.Text(), "{}", RemarkJson(row));
  });
  if (!status.ok()) return status;
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
    BindRemark(q.Bind(row.id), row).Bind(NowMs());
    ENAMEL_RETURN_IF_ERROR(q.Run());
    return WriteAuditAbout(db, SubjectOf("annotation", stored.id.Text()), by, "annotation.edit",
                           stored.attempt.Text(), RemarkJson(stored), RemarkJson(row));
  });
  if (!status.ok()) return status;
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
    q.Bind(attempt);
    std::vector<AnnotationRow> out;
    while (q.Next()) out.push_back(AnnotationOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

}  // namespace enamel::server
