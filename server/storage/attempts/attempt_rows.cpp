#include "server/storage/attempts/attempt_rows.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "server/storage/engine/query.h"
#include "server/storage/people/people_rows.h"
#include "server/training/names.h"

// Attempts as rows.
namespace enamel::server {
namespace {

constexpr char kAttemptSelect[] =
    "SELECT a.id, a.person, p.display_name, a.station, a.exercise, e.title, e.content, "
    "a.profile_content, "
    "a.state, a.as_reference, a.released, a.ticketed_ms, a.sealed_ms, a.chunks, a.ticks, "
    "a.gap_ticks, "
    "a.trace_bytes, a.score, a.critical_fail, a.progress, a.problem, a.expired_ms, a.assignment, "
    "a.exam, a.due_ms, a.rate_hz, a.limit_ticks, a.flags, a.last_chunk_ms, a.override_score, "
    "a.override_reason, a.override_by, a.override_ms, a.revision, a.facts, a.hands, "
    "a.hand_kind, a.hand_device, a.hand_driver, a.hand_unit, a.sign_off, a.problem_field, "
    "a.score_json, p.login FROM "
    "attempts a "
    "JOIN people p ON p.tenant = a.tenant AND p.id = a.person "
    "JOIN exercises e ON e.tenant = a.tenant AND e.id = a.exercise WHERE a.tenant = ?1";

AttemptRow AttemptOf(const Query& q) {
  AttemptRow out;
  out.id = q.Id(0);
  out.person = q.Id(1);
  out.person_name = q.Text(2);
  out.station = q.Id(3);
  out.exercise = q.Id(4);
  out.exercise_title = q.Text(5);
  out.exercise_content = q.Hash(6);
  out.profile_content = q.Hash(7);
  out.state = static_cast<AttemptState>(q.Int(8));
  out.as_reference = q.Int(9) != 0;
  out.released = q.Int(10) != 0;
  out.ticketed_ms = q.Int(11);
  out.sealed_ms = q.Int(12);
  out.chunks = static_cast<uint32_t>(q.Int(13));
  out.ticks = static_cast<uint64_t>(q.Int(14));
  out.gap_ticks = static_cast<uint64_t>(q.Int(15));
  out.trace_bytes = static_cast<uint64_t>(q.Int(16));
  if (!q.IsNull(17)) out.score = q.Real(17);
  out.critical_fail = q.Int(18) != 0;
  out.progress = q.Real(19);
  out.problem = q.Text(20);
  out.expired_ms = q.Int(21);
  if (!q.IsNull(22)) out.assignment = q.Id(22);
  out.exam = q.Int(23) != 0;
  out.due_ms = q.Int(24);
  out.rate_hz = static_cast<int32_t>(q.Int(25));
  out.limit_ticks = static_cast<uint64_t>(q.Int(26));
  out.flags = static_cast<uint32_t>(q.Int(27));
  out.last_chunk_ms = q.Int(28);
  if (!q.IsNull(29)) out.overridden = ScoreOverride{q.Real(29), q.Text(30), q.Id(31), q.Int(32)};
  out.revision = static_cast<int32_t>(q.Int(33));
  out.facts = q.Text(34);
  out.hands = static_cast<HandsAllowed>(q.Int(35));
  out.hand = {static_cast<HandKind>(q.Int(36)), q.Text(37), q.Text(38), q.Text(39)};
  out.sign_off = q.Int(40) != 0;
  out.problem_field = q.Text(41);
  if (!q.IsNull(42)) out.score_document = q.Hash(42);
  out.person_login = q.Text(43);
  return out;
}

// AttemptRows::Teaches as a condition on an attempt `a`, for one attempt and for lists. `person` is a parameter. An
// assignment for everybody names no cohort that there is.
std::string TaughtBy(const std::string& person) {
  return "CASE WHEN EXISTS (SELECT 1 FROM assignments s JOIN cohorts c ON c.tenant = s.tenant AND "
         "c.id = s.cohort WHERE s.tenant = a.tenant AND s.id = a.assignment) "
         "THEN EXISTS (SELECT 1 FROM assignments s JOIN cohort_members i ON i.tenant = s.tenant "
         "AND i.cohort = s.cohort WHERE s.tenant = a.tenant AND s.id = a.assignment AND i.person "
         "= " +
         person +
         ") ELSE EXISTS (SELECT 1 FROM cohort_members i JOIN cohort_members m ON m.tenant = "
         "i.tenant AND m.cohort = i.cohort WHERE i.tenant = a.tenant AND m.person = a.person AND "
         "i.person = " +
         person + ") END";
}

// An order of the list, and the condition for what comes after an attempt whose id is between both.
struct Ordering {
  const char *by, *before, *after;
};
#define ENAMEL_COUNTING_SCORE(a) "coalesce(" a ".override_score, " a ".score, 1000.0)"
constexpr Ordering kOrderings[] = {
    {"a.id DESC", "a.id < ", ""},
    {"p.search_name, a.id DESC",
     "EXISTS (SELECT 1 FROM attempts b JOIN people bp ON bp.tenant = b.tenant AND bp.id = b.person "
     "WHERE b.tenant = a.tenant AND (p.search_name > bp.search_name OR p.search_name = "
     "bp.search_name AND a.id < b.id) AND b.id = ",
     ")"},
    {ENAMEL_COUNTING_SCORE("a") ", a.id DESC",
     "EXISTS (SELECT 1 FROM attempts b WHERE b.tenant = a.tenant AND "
     "(" ENAMEL_COUNTING_SCORE("a") " > " ENAMEL_COUNTING_SCORE("b") " OR " ENAMEL_COUNTING_SCORE(
         "a") " = " ENAMEL_COUNTING_SCORE("b") " AND a.id < b.id) AND b.id = ",
     ")"}};
#undef ENAMEL_COUNTING_SCORE

}  // namespace

Result<AttemptRow> FindAttempt(Db& db, const Uuid& id) {
  static const std::string kSql = std::string(kAttemptSelect) + " AND a.id = ?2";
  Query q(db, kSql.c_str());
  if (q.Bind(id).Next()) return AttemptOf(q);
  if (!q.status().ok()) return q.status();
  return Status(Code::kNotFound, "no attempt " + id.Text());
}

Result<AttemptRow> AttemptRows::AttemptById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindAttempt(db, id); });
}

// An archived cohort counts too: people still look at its attempts.
Result<bool> AttemptRows::Teaches(const Uuid& person, const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<bool> {
    static const std::string kSql =
        "SELECT 1 FROM attempts a WHERE a.tenant = ?1 AND a.id = ?2 AND " + TaughtBy("?3");
    Query q(db, kSql.c_str());
    const bool found = q.Bind(attempt).Bind(person).Next();
    if (!q.status().ok()) return q.status();
    return found;
  });
}

Result<std::vector<AttemptRow>> AttemptRows::Attempts(const AttemptFilter& filter) {
  std::string sql = kAttemptSelect;
  std::vector<Uuid> ids;
  std::vector<int64_t> numbers;
  // ?1 is the tenant; all ids are bound before all numbers, so ids must be placed first.
  auto next = [&] { return "?" + std::to_string(ids.size() + numbers.size() + 1); };
  auto where = [&](const std::optional<Uuid>& id, const std::string& before,
                   const std::string& after) {
    if (!id) return;
    ids.push_back(*id);
    sql += " AND " + before + next() + after;
  };
  auto number = [&](int64_t value) {
    numbers.push_back(value);
    return next();
  };
  where(filter.person, "a.person = ", "");
  // IN and not EXISTS: the planner then begins with the members.
  where(filter.cohort,
        "a.person IN (SELECT m.person FROM cohort_members m WHERE m.tenant = ?1 AND m.cohort = ",
        ")");
  if (filter.taught_by) {
    ids.push_back(*filter.taught_by);
    sql += " AND " + TaughtBy(next());
  }
  where(filter.not_to_be_marked_by,
        "NOT EXISTS (SELECT 1 FROM marking_works w JOIN markings m ON m.tenant = w.tenant AND m.id "
        "= w.marking JOIN marking_people b ON b.tenant = m.tenant AND b.marking = m.id WHERE "
        "w.tenant = a.tenant AND w.attempt = a.id AND m.ended_ms = 0 AND b.removed_ms = 0 AND "
        "EXISTS (SELECT 1 FROM "
        "marking_works o WHERE o.tenant = m.tenant AND o.marking = m.id AND NOT EXISTS (SELECT 1 "
        "FROM marks k WHERE k.tenant = o.tenant AND k.work = o.id AND k.marker = b.person)) AND "
        "b.person = ",
        ")");
  where(filter.exercise, "a.exercise = ", "");
  where(filter.assignment, "a.assignment = ", "");
  // A list continues where the last page ended, whatever came in meanwhile: ids rise with time.
  const Ordering& ordering = kOrderings[static_cast<size_t>(filter.order)];
  where(filter.before, ordering.before, ordering.after);
  if (filter.state) sql += " AND a.state = " + number(static_cast<int64_t>(*filter.state));
  if (filter.flags != 0) {
    std::string bits = number(filter.flags);
    sql += " AND a.flags & " + bits + " = " + bits;
  }
  if (filter.open_appeal) {
    sql +=
        " AND a.id IN (SELECT o.attempt FROM appeals o WHERE o.tenant = ?1 AND o.state = 'open')";
  }
  const std::vector<std::string> words = SearchWords(filter.name);
  const size_t first_word = ids.size() + numbers.size() + 2;
  for (size_t i = 0; i < words.size(); ++i) {
    sql += " AND " + NameHas("?" + std::to_string(first_word + 1 + i));
  }
  sql += std::string(" ORDER BY ") + ordering.by + " LIMIT " +
         number(std::clamp<uint32_t>(filter.limit, 1, AttemptFilter::kMostAtOnce));
  return rows_.Read([&](Db& db) -> Result<std::vector<AttemptRow>> {
    Query q(db, sql.c_str());
    for (const Uuid& id : ids) q.Bind(id);
    for (int64_t value : numbers) q.Bind(value);
    for (const std::string& word : words) q.Bind(word);
    std::vector<AttemptRow> out;
    while (q.Next()) out.push_back(AttemptOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

}  // namespace enamel::server
