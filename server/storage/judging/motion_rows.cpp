#include "server/storage/judging/motion_rows.h"

#include <optional>
#include <set>
#include <vector>

#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/judging/result_rows.h"

// Motions of attempts, and what lies nearest to them.
namespace enamel::server {
Status KeepMotion(Db& db, const Uuid& attempt, const AttemptResult& result) {
  // A run without a motion does not change earlier findings.
  if (result.motion.IsZero()) return Status::Ok();
  {
    Query q(db, "DELETE FROM motions WHERE tenant = ?1 AND attempt = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Run());
  }
  const NearAttempt near = result.near.value_or(NearAttempt{});
  const scoring::HandFigures& hand = result.hand;
  ENAMEL_RETURN_IF_ERROR(
      Insert(db, "motions", "attempt", attempt, "content", result.motion, "nearest",
             result.near ? std::optional(near.attempt) : std::nullopt, "others", near.others,
             "nearest_um", near.nearest_um, "median_um", near.median_um, "size_um", near.size_um,
             "preset", near.presets > 0 ? std::optional(near.preset) : std::nullopt, "presets",
             near.presets, "preset_um", near.preset_um, "tremor_nm", hand.tremor_nm, "still_ppm",
             hand.still_ppm, "late_ppm", hand.late_ppm, "gap_ppm", hand.gap_ppm));
  return PutFlag(db, attempt, kNearAnother, near.worth_a_look);
}

Status DropMotion(Db& db, const Uuid& attempt, std::set<Sha256>& blobs) {
  Query named(db, "SELECT content FROM motions WHERE tenant = ?1 AND attempt = ?2");
  if (named.Bind(attempt).Next()) blobs.insert(named.Hash(0));
  ENAMEL_RETURN_IF_ERROR(named.status());
  return Query(db, "DELETE FROM motions WHERE tenant = ?1 AND attempt = ?2").Bind(attempt).Run();
}

Result<std::vector<MotionRow>> MotionRows::MotionsBefore(const Uuid& attempt, uint32_t limit) {
  return rows_.Read([&](Db& db) -> Result<std::vector<MotionRow>> {
    Query q(db,
            "SELECT o.id, m.content, CASE WHEN o.hand_kind = ?4 OR EXISTS (SELECT 1 FROM "
            "reference_cuts r WHERE r.tenant = o.tenant AND r.exercise = o.exercise AND r.attempt "
            "= o.id) THEN 1 ELSE 0 END FROM attempts a JOIN exercises e ON e.tenant = a.tenant AND "
            "e.id = a.exercise JOIN exercises v ON v.tenant = e.tenant AND v.name = e.name AND "
            "v.scene = e.scene JOIN attempts o ON o.tenant = v.tenant AND o.exercise = v.id AND "
            "o.id <> a.id AND (o.sealed_ms < a.sealed_ms OR (o.sealed_ms = a.sealed_ms AND o.id < "
            "a.id)) JOIN motions m ON m.tenant = o.tenant AND m.attempt = o.id WHERE a.tenant = "
            "?1 AND a.id = ?2 ORDER BY 3 DESC, o.sealed_ms DESC, o.id DESC LIMIT ?3");
    return q.Bind(attempt, limit, HandKind::kProgram).All<MotionRow>();
  });
}

Result<std::vector<AssignedMotion>> MotionRows::MotionsUnder(const Uuid& assignment,
                                                             uint32_t limit) {
  return rows_.Read([&](Db& db) -> Result<std::vector<AssignedMotion>> {
    Query q(db,
            "SELECT a.id, m.others, m.nearest_um, m.size_um, m.tremor_nm, m.still_ppm, m.late_ppm, "
            "m.gap_ppm FROM attempts a JOIN motions m ON m.tenant = a.tenant AND m.attempt = a.id "
            "WHERE a.tenant = ?1 AND a.assignment = "
            "?2 AND a.flags & ?3 = 0 ORDER BY a.id DESC LIMIT ?4");
    q.Bind(assignment, kExcused, limit);
    std::vector<AssignedMotion> out;
    while (q.Next()) {
      auto figure = [&](int column) { return static_cast<int32_t>(q.Int(column)); };
      out.push_back({q.Id(0), {{figure(4), figure(5), figure(6), figure(7)}, std::nullopt}});
      if (q.Int(1) == 0 || q.Int(3) == 0) continue;
      out.back().record.near_share = static_cast<double>(q.Int(2)) / static_cast<double>(q.Int(3));
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
    return out;
  });
}

Result<std::optional<NearAttempt>> MotionRows::NearestTo(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<std::optional<NearAttempt>> {
    Query q(db,
            "SELECT m.nearest, m.others, m.nearest_um, m.median_um, m.size_um, (a.flags & " +
                Sql(kNearAnother) +
                ") <> 0, m.preset, m.presets, m.preset_um FROM motions m JOIN attempts a ON "
                "a.tenant = m.tenant AND a.id = m.attempt WHERE m.tenant = ?1 AND m.attempt = ?2 "
                "AND m.others > 0");
    return q.Bind(attempt).Maybe<NearAttempt>();
  });
}

}  // namespace enamel::server
