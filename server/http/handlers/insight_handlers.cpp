#include <algorithm>
#include <boost/json.hpp>
#include <map>

#include "common/scoring/score.h"
#include "server/http/error_response.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/query.h"
#include "server/http/views/grade_view.h"
#include "server/jobs/regrade.h"
#include "server/training/insight.h"

// How a class did under one assignment.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

// A score document is read for each: some 20 kB.
constexpr size_t kMaxStudents = 1000;
constexpr uint32_t kMaxTries = 50;  // of one who teaches

struct Class {
  std::vector<Person> students, staff;  // by name
  uint32_t left_out = 0;                // students beyond kMaxStudents
};

// Students of the assignment's cohort, of one cohort that was asked for, or of all that the caller
// sees.
Result<Class> ClassOf(const Call& call, CohortRows& cohorts_rows, const AssignmentRow& row,
                      const std::optional<Uuid>& asked) {
  const std::optional<Uuid> one = row.cohort.IsZero() ? asked : std::optional(row.cohort);
  ENAMEL_ASSIGN_OR_RETURN(auto cohorts, VisibleCohorts(call, cohorts_rows));
  const bool known = !one || std::ranges::find(cohorts, *one, &Cohort::id) != cohorts.end();
  if (!known || (asked && asked != one)) {
    return Status(Code::kInvalidInput, "this is not assigned to a cohort of yours", "cohort");
  }
  std::map<Uuid, Person> people;
  for (const Cohort& cohort : cohorts) {
    if (one ? cohort.id != *one : cohort.archived_ms != 0) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto members, cohorts_rows.CohortMembers(cohort.id));
    for (Person& person : members) people.try_emplace(person.id, std::move(person));
  }
  Class out;
  for (auto& [id, person] : people) {
    (person.role == Role::kStudent ? out.students : out.staff).push_back(std::move(person));
  }
  for (std::vector<Person>* list : {&out.students, &out.staff}) {
    std::ranges::sort(*list, [](const Person& a, const Person& b) {
      return a.display_name != b.display_name ? a.display_name < b.display_name : a.id < b.id;
    });
  }
  if (out.students.size() > kMaxStudents) {
    out.left_out = static_cast<uint32_t>(out.students.size() - kMaxStudents);
    out.students.resize(kMaxStudents);
  }
  return out;
}

// Gaps passed at the chair as well.
double SecondsOf(const AttemptRow& row) {
  return row.rate_hz > 0 ? static_cast<double>(row.ticks + row.gap_ticks) / row.rate_hz : 0;
}

double ScoreOf(const AttemptRow& row) {
  return row.overridden ? row.overridden->score : row.score.value_or(0);
}

// The attempt whose mistakes count: the one whose score is the result; for a mean or a median, the
// newest scored one.
std::optional<Uuid> LookedAt(const GradeView::Work& work) {
  if (work.grade.attempt) return work.grade.attempt;
  for (const AttemptRow& row : work.attempts) {
    if (row.score) return row.id;
  }
  return std::nullopt;
}

// False: its score document cannot be read, so its criteria and mistakes are left out.
bool AddScore(StoredBlobs& blobs, ResultRows& results, const Uuid& attempt, StudentWork& out) {
  const Result<scoring::ScoreResult> score = StoredScore(blobs, results, attempt);
  if (!score.ok()) return false;
  out.failed = score->critical_fail;
  for (const scoring::CriterionResult& c : score->criteria) {
    const bool of_hand = c.group == scoring::Group::kHand;
    out.criteria.push_back({c.name, std::string(scoring::NameOf(c.group)), c.title, c.unit, c.lost,
                            c.state != scoring::State::kAcceptable, c.judged,
                            of_hand ? std::optional(c.value) : std::nullopt});
  }
  for (const scoring::Mistake& m : score->mistakes) {
    const dvec3 at_mm = m.at_m * 1e3;
    out.mistakes.push_back({std::string(scoring::NameOf(m.kind)),
                            m.place,
                            std::string(scoring::NameOf(m.group)),
                            std::string(scoring::UnitOf(m.kind)),
                            m.points,
                            m.size,
                            {at_mm.x, at_mm.y, at_mm.z}});
  }
  return true;
}

json::object NamesJson(const Person& person) {
  return {{"id", person.id.Text()}, {"login", person.login}, {"display_name", person.display_name}};
}

json::value SpreadJson(const std::optional<Spread>& spread) {
  if (!spread) return nullptr;
  return {{"count", spread->count},   {"least", spread->least}, {"lower", spread->lower},
          {"median", spread->median}, {"upper", spread->upper}, {"most", spread->most}};
}

json::array TenthsJson(const Tenths& tenths) { return json::array(tenths.begin(), tenths.end()); }

const char* StateOf(const StudentWork& work) {
  if (work.attempts == 0) return "not_started";
  return work.score ? "scored" : "waiting";
}

// Points by criterion, in the order of the answer's criteria; null where there were none to lose.
json::array LostJson(const Insight& insight, const StudentWork& work) {
  json::array out;
  for (const CriterionInsight& criterion : insight.criteria) {
    const auto found = std::ranges::find(work.criteria, criterion.name, &CriterionLost::name);
    const bool has = found != work.criteria.end() && found->judged;
    out.push_back(has ? json::value(found->lost) : json::value());
  }
  return out;
}

json::object SummaryJson(const Insight& insight) {
  return {{"students", insight.students},
          {"not_started", insight.not_started},
          {"waiting", insight.waiting},
          {"scored", insight.scored},
          {"failed", insight.failed},
          {"scores", SpreadJson(insight.scores)},
          {"times_s", SpreadJson(insight.times_s)},
          {"score_tenths", TenthsJson(insight.score_tenths)}};
}

json::array CriteriaJson(const Insight& insight) {
  json::array out;
  for (const CriterionInsight& c : insight.criteria) {
    out.push_back({{"name", c.name},
                   {"group", c.group},
                   {"title", c.title},
                   {"unit", c.unit},
                   {"judged", c.judged},
                   {"to_change", c.to_change},
                   {"mean_lost", c.mean_lost},
                   {"lost", SpreadJson(c.lost)},
                   {"values", SpreadJson(c.values)}});
  }
  return out;
}

json::array MistakesJson(const Insight& insight) {
  json::array out;
  for (const MistakeInsight& m : insight.mistakes) {
    out.push_back({{"kind", m.kind},
                   {"place", m.place},
                   {"group", m.group},
                   {"students", m.students},
                   {"points", m.points},
                   {"size", m.size},
                   {"unit", m.unit},
                   {"at_mm", json::array(m.at_mm.begin(), m.at_mm.end())}});
  }
  return out;
}

json::object InsightJson(const Insight& insight, const Class& people) {
  json::array outliers;
  for (const Outlier& o : insight.outliers) {
    outliers.push_back({{"person_id", people.students[o.student].id.Text()},
                        {"what", o.what},
                        {"value", o.value},
                        {"median", o.median},
                        {"z", o.z}});
  }
  json::value commonest;
  if (insight.commonest) commonest = *insight.commonest;
  return {{"summary", SummaryJson(insight)},
          {"criteria", CriteriaJson(insight)},
          {"mistakes", MistakesJson(insight)},
          {"commonest", std::move(commonest)},
          {"outliers", std::move(outliers)}};
}

// What those who teach the class tried of the exercise version themselves: beside the class, in
// none of its figures.
Result<json::array> StaffJson(const Call& call, AttemptRows& attempts_rows,
                              const AssignmentRow& row, const Class& people) {
  json::array out;
  for (const Person& person : people.staff) {
    AttemptFilter filter;
    filter.person = person.id;
    filter.exercise = row.version_id;
    filter.limit = kMaxTries;
    NarrowToTaught(call, filter);
    ENAMEL_ASSIGN_OR_RETURN(auto attempts, attempts_rows.Attempts(filter));
    for (const AttemptRow& attempt : attempts) {
      json::value score;
      if (attempt.score) score = ScoreOf(attempt);
      out.push_back({{"person", NamesJson(person)},
                     {"attempt_id", attempt.id.Text()},
                     {"score", std::move(score)},
                     {"time_s", SecondsOf(attempt)},
                     {"ticketed_ms", attempt.ticketed_ms},
                     {"as_reference", attempt.as_reference}});
    }
  }
  return out;
}

Result<json::object> InsightOfClass(const Call& call, Store& store, const AssignmentRow& row,
                                    const std::optional<Uuid>& asked) {
  ENAMEL_ASSIGN_OR_RETURN(auto people, ClassOf(call, store.cohorts, row, asked));
  GradeView view(store, call.caller->person);
  ENAMEL_ASSIGN_OR_RETURN(auto made, view.WorkOf(row, {.cohort = asked}));
  std::vector<Uuid> attempts;
  for (const auto& [person, work] : made) {
    for (const AttemptRow& attempt : work.attempts) attempts.push_back(attempt.id);
  }
  ENAMEL_RETURN_IF_ERROR(ScoresMustNotBeHidden(call, store, attempts));
  std::vector<StudentWork> class_work;
  std::vector<std::optional<Uuid>> looked_at;
  uint32_t unread = 0;
  for (const Person& person : people.students) {
    const GradeView::Work& work = made[person.id];
    StudentWork& out = class_work.emplace_back();
    out.attempts = work.grade.attempts;
    out.score = work.grade.score;
    for (const AttemptRow& attempt : work.attempts) out.time_s += SecondsOf(attempt);
    looked_at.push_back(LookedAt(work));
    if (looked_at.back())
      unread += AddScore(store.blobs, store.results, *looked_at.back(), out) ? 0 : 1;
  }
  const Insight insight = InsightOf(class_work);
  json::array students;
  for (size_t i = 0; i < class_work.size(); ++i) {
    const GradeView::Work& work = made[people.students[i].id];
    json::value score, attempt;
    if (work.grade.score) score = *work.grade.score;
    if (looked_at[i]) attempt = looked_at[i]->Text();
    students.push_back({{"person", NamesJson(people.students[i])},
                        {"state", StateOf(class_work[i])},
                        {"attempts", work.grade.attempts},
                        {"score", std::move(score)},
                        {"released", work.grade.shown},
                        {"time_s", class_work[i].time_s},
                        {"failed", class_work[i].failed},
                        {"attempt_id", std::move(attempt)},
                        {"lost", LostJson(insight, class_work[i])}});
  }
  json::object out = InsightJson(insight, people);
  out["assignment_id"] = row.id.Text();
  out["counting"] = CountingName(row.counting);
  out["students"] = std::move(students);
  ENAMEL_ASSIGN_OR_RETURN(out["staff"], StaffJson(call, store.attempts, row, people));
  out["left_out"] = people.left_out;
  out["unread"] = unread;
  return out;
}

}  // namespace

Result<Response> GetInsight(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, SeeAssignment(call, store.assignments, store.cohorts));
  ENAMEL_ASSIGN_OR_RETURN(std::optional<Uuid> cohort, QueryId(call.request, "cohort"));
  ENAMEL_ASSIGN_OR_RETURN(json::object insight, InsightOfClass(call, store, row, cohort));
  return JsonResponse(insight);
}

}  // namespace enamel::server::http
