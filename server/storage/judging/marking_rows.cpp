#include "server/storage/judging/marking_rows.h"

#include <algorithm>

#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"

namespace enamel::server {
namespace {

Status NoSuchWork(const Uuid& work) {
  return Status(Code::kNotFound, "no work " + work.Text() + " that you mark");
}

Result<MarkingRow> FindMarking(Db& db, const Uuid& id) {
  MarkingRow out;
  {
    Query q(db,
            "SELECT id, assignment, created_ms, ended_ms, (SELECT count(*) FROM marking_works w "
            "WHERE w.tenant = ?1 AND w.marking = ?2) FROM markings WHERE tenant = ?1 AND id = ?2");
    if (!q.Bind(id).Next()) {
      ENAMEL_RETURN_IF_ERROR(q.status());
      return Status(Code::kNotFound, "no marking " + id.Text());
    }
    out = {q.Id(0), q.Id(1), q.Int(2), q.Int(3), {}, static_cast<uint32_t>(q.Int(4))};
  }
  Query q(
      db,
      "SELECT p.person, (SELECT count(*) FROM marks k JOIN marking_works w ON w.tenant = "
      "k.tenant AND w.id = k.work WHERE k.tenant = ?1 AND w.marking = ?2 AND k.marker = "
      "p.person) FROM marking_people p WHERE p.tenant = ?1 AND p.marking = ?2 AND p.removed_ms = 0 "
      "ORDER BY p.person");
  for (q.Bind(id); q.Next();) out.markers.push_back({q.Id(0), static_cast<uint32_t>(q.Int(1))});
  ENAMEL_RETURN_IF_ERROR(q.status());
  return out;
}

Result<std::vector<Uuid>> IdsOfMarkings(Db& db, const Uuid& assignment) {
  Query q(db,
          "SELECT id FROM markings WHERE tenant = ?1 AND assignment = ?2 ORDER BY created_ms DESC, "
          "id DESC");
  return q.Bind(assignment).All<Uuid>();
}

Result<std::vector<MarkingWork>> FindWorks(Db& db, const Uuid& marking) {
  Query q(db,
          "SELECT id, marking, attempt FROM marking_works WHERE tenant = ?1 AND marking = ?2 "
          "ORDER BY id");
  return q.Bind(marking).All<MarkingWork>();
}

Result<bool> IsUnderWay(Db& db, const Uuid& marking) {
  ENAMEL_ASSIGN_OR_RETURN(const auto row, FindMarking(db, marking));
  return row.ended_ms == 0 && !row.done();
}

Status AddMarker(Db& db, const Uuid& marking, const Uuid& person) {
  return Explain(Insert(db, "marking_people", "marking", marking, "person", person),
                 "person " + person.Text() +
                     " was removed from this blind marking before, and may have seen scores since");
}

Status RemoveMarker(Db& db, const Uuid& marking, const Uuid& person) {
  Query q(db,
          "UPDATE marking_people SET removed_ms = ?4 WHERE tenant = ?1 AND marking = ?2 AND person "
          "= ?3");
  return q.Bind(marking, person, NowMs()).Run();
}

Status AddWork(Db& db, const Uuid& marking, const Uuid& attempt, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(const auto row, FindAttempt(db, attempt));
  if (row.released) {
    return Status(Code::kConflict, "attempt " + attempt.Text() +
                                       " is released: its score is known, and marks of it are not "
                                       "blind any more");
  }
  // Random, and not the time's as other ids: it would tell the order in which they were made.
  Uuid id;
  const Sha256 hash = HashSha256(Uuid::New().view());
  std::copy_n(hash.bytes.begin(), id.bytes.size(), id.bytes.begin());
  ENAMEL_RETURN_IF_ERROR(
      Insert(db, "marking_works", "id", id, "marking", marking, "attempt", attempt));
  // Without the attempt: an admin who marks as well reads the trail.
  return WriteAudit(db, by, "marking.work", id.Text(), "{}", "{}");
}

}  // namespace

Status MustNotBeMarkedNow(Db& db, const Uuid& attempt) {
  Query q(db, "SELECT marking FROM marking_works WHERE tenant = ?1 AND attempt = ?2");
  ENAMEL_ASSIGN_OR_RETURN(const auto markings, q.Bind(attempt).All<Uuid>());
  for (const Uuid& marking : markings) {
    ENAMEL_ASSIGN_OR_RETURN(const bool under_way, IsUnderWay(db, marking));
    if (!under_way) continue;
    return Status(Code::kConflict,
                  "a blind marking of attempt " + attempt.Text() +
                      " is under way, which needs scores that nobody knows: release it when every "
                      "marker is done, or give the marking up first",
                  "marking_holds_release");
  }
  return Status::Ok();
}

Result<MarkingRow> MarkingRows::BeginMarking(const Uuid& assignment,
                                             const std::vector<Uuid>& attempts,
                                             const std::vector<Uuid>& markers, const Actor& by) {
  const Uuid id = Uuid::New();
  const Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto earlier, IdsOfMarkings(db, assignment));
    for (const Uuid& marking : earlier) {
      ENAMEL_ASSIGN_OR_RETURN(const bool under_way, IsUnderWay(db, marking));
      if (!under_way) continue;
      return Status(Code::kConflict,
                    "a blind marking of this assignment is under way; finish it or give it up",
                    "marking_under_way");
    }
    ENAMEL_RETURN_IF_ERROR(
        Insert(db, "markings", "id", id, "assignment", assignment, "created_ms", NowMs()));
    for (const Uuid& marker : markers) ENAMEL_RETURN_IF_ERROR(AddMarker(db, id, marker));
    for (const Uuid& attempt : attempts) ENAMEL_RETURN_IF_ERROR(AddWork(db, id, attempt, by));
    return WriteAudit(db, by, "marking.begin", id.Text(), "{}",
                      JsonOf({{"assignment", assignment.Text()},
                              {"markers", std::to_string(markers.size())},
                              {"works", std::to_string(attempts.size())}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return MarkingById(id);
}

Result<std::vector<MarkingRow>> MarkingRows::MarkingsOf(const Uuid& assignment) {
  return rows_.Read([&](Db& db) -> Result<std::vector<MarkingRow>> {
    ENAMEL_ASSIGN_OR_RETURN(const auto ids, IdsOfMarkings(db, assignment));
    std::vector<MarkingRow> out;
    for (const Uuid& id : ids) {
      ENAMEL_ASSIGN_OR_RETURN(out.emplace_back(), FindMarking(db, id));
    }
    return out;
  });
}

Result<MarkingRow> MarkingRows::MarkingById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindMarking(db, id); });
}

Result<std::vector<MarkingWork>> MarkingRows::WorksOf(const Uuid& marking) {
  return rows_.Read([&](Db& db) { return FindWorks(db, marking); });
}

Result<MarkingWork> MarkingRows::WorkById(const Uuid& work) {
  return rows_.Read([&](Db& db) -> Result<MarkingWork> {
    Query q(db, "SELECT id, marking, attempt FROM marking_works WHERE tenant = ?1 AND id = ?2");
    if (q.Bind(work).Next()) return MarkingWork{q.Id(0), q.Id(1), q.Id(2)};
    ENAMEL_RETURN_IF_ERROR(q.status());
    return NoSuchWork(work);
  });
}

Status MarkingRows::AddMark(const BlindMark& mark, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    {
      Query q(db,
              "SELECT m.ended_ms FROM marking_works w JOIN markings m ON m.tenant = "
              "w.tenant AND m.id = w.marking JOIN marking_people p ON p.tenant = w.tenant AND "
              "p.marking = w.marking WHERE w.tenant = ?1 AND w.id = ?2 AND p.person = ?3 AND "
              "p.removed_ms = 0");
      if (!q.Bind(mark.work, mark.marker).Next()) {
        ENAMEL_RETURN_IF_ERROR(q.status());
        return NoSuchWork(mark.work);
      }
      if (q.Int(0) != 0) {
        return Status(Code::kConflict, "this blind marking was given up; nothing more is marked",
                      "marking_given_up");
      }
    }
    ENAMEL_RETURN_IF_ERROR(
        Explain(Insert(db, "marks", "work", mark.work, "marker", mark.marker, "rating", mark.rating,
                       "criteria", mark.criteria, "made_ms", NowMs()),
                "you have marked this work; a mark is given once, before any "
                "other is seen"));
    // Hashes: an admin who marks as well reads the trail.
    const std::string rated = mark.marker.Text() + " " + std::to_string(mark.rating);
    return WriteAudit(db, by, "marking.mark", mark.work.Text(), "{}",
                      JsonOf({{"mark", HashSha256(AsBytes(rated + " " + mark.criteria)).Hex()}}));
  });
}

Result<std::vector<BlindMark>> MarkingRows::MarksOf(const Uuid& marking) {
  return rows_.Read([&](Db& db) -> Result<std::vector<BlindMark>> {
    Query q(db,
            "SELECT k.work, k.marker, k.rating, k.criteria, k.made_ms FROM marks k JOIN "
            "marking_works w ON w.tenant = k.tenant AND w.id = k.work JOIN marking_people p ON "
            "p.tenant = w.tenant AND p.marking = w.marking AND p.person = k.marker AND "
            "p.removed_ms = 0 WHERE k.tenant = ?1 AND w.marking = ?2 ORDER BY k.work, k.marker");
    return q.Bind(marking).All<BlindMark>();
  });
}

Result<std::vector<std::string>> MarkingRows::CriteriaBy(const Uuid& marker) {
  return rows_.Read([&](Db& db) -> Result<std::vector<std::string>> {
    Query q(db,
            "SELECT criteria FROM marks WHERE tenant = ?1 AND marker = ?2 ORDER BY made_ms DESC, "
            "work LIMIT 500");
    return q.Bind(marker).All<std::string>();
  });
}

Result<MarkingRow> MarkingRows::SetMarkers(const Uuid& id, const std::vector<Uuid>& markers,
                                           const Actor& by) {
  const Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindMarking(db, id));
    if (row.ended_ms != 0 || row.done()) {
      return Status(Code::kConflict, "this blind marking is over; its markers stay as they are");
    }
    const auto marks = [&](const Uuid& person) {
      return std::ranges::find(row.markers, person, &MarkingRow::Marker::person) !=
             row.markers.end();
    };
    size_t added = 0, removed = 0;
    for (const Uuid& person : markers) {
      if (marks(person)) continue;
      ENAMEL_RETURN_IF_ERROR(AddMarker(db, id, person));
      ++added;
    }
    for (const MarkingRow::Marker& marker : row.markers) {
      if (std::ranges::find(markers, marker.person) != markers.end()) continue;
      ENAMEL_RETURN_IF_ERROR(RemoveMarker(db, id, marker.person));
      ++removed;
    }
    if (added + removed == 0) return Status::Ok();
    return WriteAudit(
        db, by, "marking.markers", id.Text(), "{}",
        JsonOf({{"added", std::to_string(added)}, {"removed", std::to_string(removed)}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return MarkingById(id);
}

Status MarkingRows::EndMarking(const Uuid& id, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindMarking(db, id));
    if (row.ended_ms != 0 || row.done()) {
      return row.done()
                 ? Status(Code::kConflict, "all markers are done; there is nothing to give up",
                          "marking_done")
                 : Status(Code::kConflict, "this blind marking was given up before",
                          "marking_given_up");
    }
    Query q(db, "UPDATE markings SET ended_ms = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id, NowMs()).Run());
    return WriteAudit(db, by, "marking.end", id.Text(), "{}", "{}");
  });
}

Result<std::map<Uuid, MarkingRows::Hidden>> MarkingRows::HiddenFrom(const Uuid& person) {
  return rows_.Read([&](Db& db) -> Result<std::map<Uuid, Hidden>> {
    Query q(db,
            "SELECT m.id FROM marking_people p JOIN markings m ON m.tenant = p.tenant AND m.id = "
            "p.marking WHERE p.tenant = ?1 AND p.person = ?2 AND p.removed_ms = 0 AND m.ended_ms = "
            "0");
    ENAMEL_ASSIGN_OR_RETURN(const auto markings, q.Bind(person).All<Uuid>());
    std::map<Uuid, Hidden> out;
    for (const Uuid& id : markings) {
      ENAMEL_ASSIGN_OR_RETURN(const auto row, FindMarking(db, id));
      if (row.done()) continue;
      const auto own = std::ranges::find(row.markers, person, &MarkingRow::Marker::person);
      const Hidden what = own->marked < row.works ? Hidden::kAll : Hidden::kScore;
      ENAMEL_ASSIGN_OR_RETURN(const auto works, FindWorks(db, id));
      for (const MarkingWork& work : works) {
        out[work.attempt] = std::max(out[work.attempt], what);
      }
    }
    return out;
  });
}

}  // namespace enamel::server
