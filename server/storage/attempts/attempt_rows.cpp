#include "server/storage/attempts/attempt_rows.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "server/storage/engine/query.h"
#include "server/storage/people/people_rows.h"
#include "server/training/names.h"

// Attempts as rows.
namespace enamel::server {
namespace {

// In the order of AttemptRow. LEFT finds the same rows, as no attempt is without its exercise. It keeps SQLite's planner from beginning a second page with
// all exercises.
constexpr char kAttemptSelect[] =
    "SELECT a.id, a.person, p.display_name, p.login, a.station, a.exercise, e.title, e.content, "
    "a.profile_content, a.state, a.as_reference, a.released, a.ticketed_ms, a.sealed_ms, a.chunks, "
    "a.ticks, a.gap_ticks, a.trace_bytes, a.score, a.score_json, a.critical_fail, "
    "a.override_score, a.override_reason, a.override_by, a.override_ms, a.progress, a.expired_ms, "
    "a.problem, a.problem_field, a.assignment, a.exam, a.due_ms, a.rate_hz, a.limit_ticks, "
    "a.hands, a.sign_off, a.flags, a.last_chunk_ms, a.revision, a.facts, a.hand_kind, "
    "a.hand_device, a.hand_driver, a.hand_unit FROM "
    "attempts a "
    "JOIN people p ON p.tenant = a.tenant AND p.id = a.person "
    "LEFT JOIN exercises e ON e.tenant = a.tenant AND e.id = a.exercise WHERE a.tenant = ?1";

// A condition with a place of a value instead of each %1, another instead of each %2.
std::string With(std::string condition, const std::vector<std::string>& places) {
  for (size_t i = 0; i < places.size(); ++i) {
    const std::string mark = "%" + std::to_string(i + 1);
    for (size_t at = 0; (at = condition.find(mark, at)) != std::string::npos;) {
      condition.replace(at, mark.size(), places[i]);
    }
  }
  return condition;
}

// AttemptRows::Teaches as a condition on an attempt `a`, for one attempt and for lists. An assignment
// for everybody names no cohort that there is.
constexpr char kTaughtBy[] =
    "CASE WHEN EXISTS (SELECT 1 FROM assignments s JOIN cohorts c ON c.tenant = s.tenant AND "
    "c.id = s.cohort WHERE s.tenant = a.tenant AND s.id = a.assignment) "
    "THEN EXISTS (SELECT 1 FROM assignments s JOIN cohort_members i ON i.tenant = s.tenant "
    "AND i.cohort = s.cohort WHERE s.tenant = a.tenant AND s.id = a.assignment AND i.person = %1) "
    "ELSE EXISTS (SELECT 1 FROM cohort_members i JOIN cohort_members m ON m.tenant = i.tenant AND "
    "m.cohort = i.cohort WHERE i.tenant = a.tenant AND m.person = a.person AND i.person = %1) END";
constexpr char kNotToBeMarkedBy[] =
    "NOT EXISTS (SELECT 1 FROM marking_works w JOIN markings m ON m.tenant = w.tenant AND m.id = "
    "w.marking JOIN marking_people b ON b.tenant = m.tenant AND b.marking = m.id WHERE w.tenant = "
    "a.tenant AND w.attempt = a.id AND m.ended_ms = 0 AND b.removed_ms = 0 AND EXISTS (SELECT 1 "
    "FROM marking_works o WHERE o.tenant = m.tenant AND o.marking = m.id AND NOT EXISTS (SELECT 1 "
    "FROM marks k WHERE k.tenant = o.tenant AND k.work = o.id AND k.marker = b.person)) AND "
    "b.person = %1)";
// A set of attempts that a list may be of: the ids of its attempts, by %1; the condition that lets the planner begin with
// the set; and the condition on one attempt after the other.
struct Set {
  const char *ids, *found, *tested;
};
#define ENAMEL_IDS_OF_COHORT                                                                 \
  "SELECT t.id FROM cohort_members m JOIN attempts t ON t.tenant = m.tenant AND t.person = " \
  "m.person WHERE m.tenant = ?1 AND m.cohort = %1"
constexpr char kIdsOfCohort[] = ENAMEL_IDS_OF_COHORT;
constexpr char kInCohort[] = "a.id IN (" ENAMEL_IDS_OF_COHORT ")";
#undef ENAMEL_IDS_OF_COHORT
constexpr char kOfCohort[] =
    "EXISTS (SELECT 1 FROM cohort_members m WHERE m.tenant = a.tenant AND m.cohort = %1 AND "
    "m.person = a.person)";
constexpr char kIdsOfAssignment[] =
    "SELECT t.id FROM attempts t WHERE t.tenant = ?1 AND t.assignment = %1";
constexpr char kInAssignment[] = "a.assignment = %1";
// SQLite looks for no index for this.
constexpr char kOfAssignment[] = "(a.assignment = %1) = TRUE";
constexpr char kIdsOfExercise[] =
    "SELECT t.id FROM attempts t WHERE t.tenant = ?1 AND t.exercise = %1";
constexpr char kInExercise[] = "a.exercise = %1";
constexpr char kOfExercise[] = "(a.exercise = %1) = TRUE";
// All that kTaughtBy may be true of, and more. The students' attempts alone are counted: PostgreSQL would make all of a
// union before its first rows.
#define ENAMEL_IDS_OF_TAUGHT                                                                     \
  "SELECT t.id FROM cohort_members i JOIN cohort_members m ON m.tenant = i.tenant AND m.cohort " \
  "= i.cohort JOIN attempts t ON t.tenant = m.tenant AND t.person = m.person WHERE i.tenant = "  \
  "?1 AND i.person = %1"
constexpr char kIdsOfTaught[] = ENAMEL_IDS_OF_TAUGHT;
constexpr char kInTaught[] =
    "a.id IN (" ENAMEL_IDS_OF_TAUGHT
    " UNION ALL SELECT t.id FROM cohort_members i JOIN assignments s ON s.tenant = i.tenant AND "
    "s.cohort = i.cohort JOIN attempts t ON t.tenant = s.tenant AND t.assignment = s.id WHERE "
    "i.tenant = ?1 AND i.person = %1)";
#undef ENAMEL_IDS_OF_TAUGHT
constexpr Set kCohorts{kIdsOfCohort, kInCohort, kOfCohort},
    kAssignments{kIdsOfAssignment, kInAssignment, kOfAssignment},
    kExercises{kIdsOfExercise, kInExercise, kOfExercise},
    kTaught{kIdsOfTaught, kInTaught, kTaughtBy};

// The orders of a list, each an index's (attempts_by_score, people_by_name), and the condition for what comes after an
// attempt. Its first comparison says where in the index a page begins, the second what is left out from there.
#define ENAMEL_COUNTING_SCORE "coalesce(a.override_score, a.score, 1000.0)"
constexpr char kNewestFirst[] = "a.id DESC";
constexpr char kAfterId[] = "a.id < %1";
constexpr char kByName[] = "p.search_name, p.id, a.id DESC";
constexpr char kAfterName[] = "(p.search_name, p.id) >= (%1, %2) AND (p.id <> %2 OR a.id < %3)";
constexpr char kByScore[] = ENAMEL_COUNTING_SCORE ", a.id DESC";
constexpr char kAfterScore[] =
    ENAMEL_COUNTING_SCORE " >= %1 AND (" ENAMEL_COUNTING_SCORE " > %1 OR a.id < %2)";
// The same orders as expressions that no index offers: both engines then sort, which suits few attempts.
constexpr char kSortedByName[] = "p.search_name || '', p.id, a.id DESC";
constexpr char kSortedByScore[] = ENAMEL_COUNTING_SCORE " + 0.0, a.id DESC";
constexpr char kPlaceInOrders[] =
    "SELECT p.search_name, a.person, " ENAMEL_COUNTING_SCORE
    " FROM attempts a JOIN people p ON p.tenant = a.tenant AND p.id = "
    "a.person WHERE a.tenant = ?1 AND a.id = ?2";
#undef ENAMEL_COUNTING_SCORE

// Puts the list's statement together. Values take the places from ?2 on, in the order in which they come.
class ListSql {
 public:
  template <typename... Values>
  ListSql& And(const std::string& condition, const Values&... values) {
    sql_ += " AND " + With(condition, {Place(values)...});
    return *this;
  }
  ListSql& OrderBy(const std::string& order, int64_t limit) {
    sql_ += " ORDER BY " + order + " LIMIT " + Place(limit);
    return *this;
  }
  Result<std::vector<AttemptRow>> Rows(Db& db) const {
    Query q(db, sql_);
    for (const Value& value : values_) {
      std::visit([&](const auto& each) { q.Bind(each); }, value);
    }
    return q.All<AttemptRow>();
  }

 private:
  using Value = std::variant<Uuid, int64_t, double, std::string>;
  std::string Place(Value value) {
    values_.push_back(std::move(value));
    return "?" + std::to_string(values_.size() + 1);  // ?1 is the tenant
  }

  std::string sql_ = kAttemptSelect;
  std::vector<Value> values_;
};

// A list continues where the last page ended, whatever came in meanwhile: ids rise with time. False: its last attempt is
// gone, so nobody knows where.
Result<bool> Continue(Db& db, const AttemptFilter& filter, ListSql& list) {
  if (!filter.before) return true;
  if (filter.order == AttemptFilter::Order::kNewest) {
    list.And(kAfterId, *filter.before);
    return true;
  }
  Query q(db, kPlaceInOrders);
  if (!q.Bind(*filter.before).Next()) {
    ENAMEL_RETURN_IF_ERROR(q.status());
    return false;
  }
  if (filter.order == AttemptFilter::Order::kName) {
    list.And(kAfterName, q.Text(0), q.Id(1), *filter.before);
  } else {
    list.And(kAfterScore, q.Real(2), *filter.before);
  }
  return true;
}

// A page of a small set is the set, sorted. A page of a large one is what comes first in the order's index, which passes
// over the attempts that are not of the set: of 20 000, among which the set is spread evenly, some 2000 for 50.
constexpr int64_t kFew = 500;
constexpr uint32_t kMaxOfPage = 200;

Result<bool> AreFew(Db& db, const char* ids, const Uuid& of) {
  Query q(db, "SELECT count(*) FROM (" + With(ids, {"?2"}) + " LIMIT ?3) AS counted");
  if (q.Bind(of, kFew + 1).Next()) return q.Int(0) <= kFew;
  return q.status();
}

// Adds the conditions of the sets. Returns whether one of the sets is small.
Result<bool> AndSets(Db& db, const AttemptFilter& filter, ListSql& list) {
  const bool page = filter.limit <= kMaxOfPage;
  bool few = !page || filter.person.has_value();
  if (filter.person) list.And("a.person = %1", *filter.person);
  const bool newest = filter.order == AttemptFilter::Order::kNewest;
  const struct {
    const Set& set;
    const std::optional<Uuid>& of;
  } sets[] = {
      {kAssignments, filter.assignment}, {kCohorts, filter.cohort}, {kExercises, filter.exercise}};
  for (const auto& [set, of] : sets) {
    if (!of) continue;
    // The newest are the first of an index, or ids that no attempt is read for: a set is old where others are new.
    bool found = few || newest;
    if (!found) {
      ENAMEL_ASSIGN_OR_RETURN(found, AreFew(db, set.ids, *of));
      few = found;
    }
    list.And(found ? set.found : set.tested, *of);
  }
  if (!filter.taught_by) return few;
  if (!few) {
    ENAMEL_ASSIGN_OR_RETURN(few, AreFew(db, kTaught.ids, *filter.taught_by));
    if (few) list.And(kTaught.found, *filter.taught_by);
  }
  list.And(kTaught.tested, *filter.taught_by);
  return few;
}

const char* OrderOf(const AttemptFilter& filter, bool few) {
  switch (filter.order) {
    case AttemptFilter::Order::kName:
      return few ? kSortedByName : kByName;
    case AttemptFilter::Order::kLowestScore:
      return few ? kSortedByScore : kByScore;
    case AttemptFilter::Order::kNewest:
      break;
  }
  return kNewestFirst;
}

}  // namespace

Result<AttemptRow> FindAttempt(Db& db, const Uuid& id) {
  Query q(db, std::string(kAttemptSelect) + " AND a.id = ?2");
  return q.Bind(id).One<AttemptRow>("no attempt " + id.Text());
}

Result<AttemptRow> AttemptRows::AttemptById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindAttempt(db, id); });
}

// An archived cohort counts too: people still look at its attempts.
Result<bool> AttemptRows::Teaches(const Uuid& person, const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<bool> {
    Query q(db, "SELECT 1 FROM attempts a WHERE a.tenant = ?1 AND a.id = ?2 AND " +
                    With(kTaughtBy, {"?3"}));
    return q.Bind(attempt, person).Any();
  });
}

Result<std::vector<AttemptRow>> AttemptRows::Attempts(const AttemptFilter& filter) {
  return rows_.Read([&](Db& db) -> Result<std::vector<AttemptRow>> {
    ListSql list;
    ENAMEL_ASSIGN_OR_RETURN(const bool few, AndSets(db, filter, list));
    if (filter.not_to_be_marked_by) list.And(kNotToBeMarkedBy, *filter.not_to_be_marked_by);
    if (filter.state) list.And("a.state = %1", static_cast<int64_t>(*filter.state));
    if (filter.flags != 0) list.And("a.flags & %1 = %1", int64_t{filter.flags});
    if (filter.open_appeal) {
      list.And(
          "a.id IN (SELECT o.attempt FROM appeals o WHERE o.tenant = ?1 AND o.state = 'open')");
    }
    for (const std::string& word : SearchWords(filter.name)) list.And(NameHas("%1"), word);
    ENAMEL_ASSIGN_OR_RETURN(const bool continues, Continue(db, filter, list));
    if (!continues) return std::vector<AttemptRow>{};
    const uint32_t limit = std::clamp<uint32_t>(filter.limit, 1, AttemptFilter::kMaxAtOnce);
    return list.OrderBy(OrderOf(filter, few), limit).Rows(db);
  });
}

}  // namespace enamel::server
