#include "server/http/views/grade_view.h"

#include <map>

#include "server/training/access.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr uint32_t kAttemptsAtOnce = AttemptFilter::kMaxAtOnce;

bool IsBeingScored(const AttemptRow& row) {
  return row.state == AttemptState::kScoring || row.state == AttemptState::kSealed;
}

json::value OrNull(const std::optional<double>& value) {
  return value ? json::value(*value) : json::value();
}

}  // namespace

Result<bool> GradeView::IsGraded(const Uuid& exercise) {
  if (auto found = graded_.find(exercise); found != graded_.end()) return found->second;
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, store_.exercises.ExerciseById(exercise));
  graded_.emplace(exercise, row.graded);
  return row.graded;
}

// Under way, or done and not released again: a release of other points is withdrawn.
Result<bool> GradeView::IsScoredAgain(const AttemptRow& row, bool seen) {
  if (!row.score) return false;
  if (seen) return IsBeingScored(row);
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ResultRow> runs, store_.results.ResultsOf(row.id));
  return runs.size() > 1;
}

Result<std::map<Uuid, GradeView::Work>> GradeView::WorkOf(const AssignmentRow& assignment,
                                                          const Whose& whose) {
  std::map<Uuid, std::vector<GradedAttempt>> attempts;
  std::map<Uuid, MarkingRows::Hidden> hidden;
  if (viewer_.role != Role::kStudent) {
    ENAMEL_ASSIGN_OR_RETURN(hidden, store_.markings.HiddenFrom(viewer_.id));
  }
  std::map<Uuid, Work> out;
  AttemptFilter filter;
  filter.assignment = assignment.id;
  filter.person = whose.person;
  filter.cohort = whose.cohort;
  filter.limit = kAttemptsAtOnce;
  for (bool more = true; more;) {
    ENAMEL_ASSIGN_OR_RETURN(std::vector<AttemptRow> rows, store_.attempts.Attempts(filter));
    more = rows.size() == kAttemptsAtOnce;
    if (more) filter.before = rows.back().id;
    for (AttemptRow& row : rows) {
      if ((row.flags & (kExcused | kReturned)) != 0) continue;
      ENAMEL_ASSIGN_OR_RETURN(bool graded, IsGraded(row.exercise));
      GradedAttempt each{row.id, row.ticketed_ms, {}, false, false};
      each.shown = !IsReleasedFirst(row, graded) || row.released;
      // Checks a student's own attempts as for a viewer who shares no cohort with anybody.
      const bool seen = viewer_.role != Role::kStudent ? !hidden.contains(row.id)
                                                       : CanSeeScore(viewer_, row, graded, false);
      if (row.score && seen) each.score = row.overridden ? row.overridden->score : *row.score;
      ENAMEL_ASSIGN_OR_RETURN(bool again, IsScoredAgain(row, seen));
      each.again = again;
      // The present score may not be the one that counts in a minute.
      if (each.again && viewer_.role == Role::kStudent) each.score.reset();
      attempts[row.person].push_back(each);
      out[row.person].attempts.push_back(std::move(row));
    }
  }
  for (auto& [person, made] : attempts) {
    out[person].grade = GradeOver(assignment.counting, std::move(made));
  }
  return out;
}

Result<std::map<Uuid, Grade>> GradeView::Of(const AssignmentRow& assignment, const Whose& whose) {
  ENAMEL_ASSIGN_OR_RETURN(auto work, WorkOf(assignment, whose));
  std::map<Uuid, Grade> out;
  for (const auto& [person, each] : work) out.emplace(person, each.grade);
  return out;
}

Result<GradeView::Book> GradeView::BookOf(const Uuid& cohort) {
  Book out;
  ENAMEL_ASSIGN_OR_RETURN(out.students, store_.cohorts.CohortMembers(cohort));
  std::erase_if(out.students, [](const Person& person) { return person.role != Role::kStudent; });
  AssignmentFilter which;
  which.cohort = cohort;
  which.or_everybody = true;
  ENAMEL_ASSIGN_OR_RETURN(out.assignments, store_.assignments.Assignments(which));
  for (const AssignmentRow& row : out.assignments) {
    // An assignment for everybody has the whole school's work: this reads the class's.
    ENAMEL_ASSIGN_OR_RETURN(auto by_person, Of(row, {.cohort = cohort}));
    std::vector<Grade>& results = out.results.emplace_back();
    for (const Person& student : out.students) results.push_back(by_person[student.id]);
  }
  return out;
}

json::object GradeView::Json(const Grade& grade) {
  json::value attempt;
  if (grade.attempt) attempt = grade.attempt->Text();
  return {{"attempts", grade.attempts},   {"counted", grade.counted},
          {"score", OrNull(grade.score)}, {"attempt_id", std::move(attempt)},
          {"released", grade.shown},      {"regrading", grade.regrading}};
}

json::object GradeView::Json(const GradeSummary& summary) {
  return {{"students", summary.students},     {"graded", summary.graded},
          {"mean", OrNull(summary.mean)},     {"median", OrNull(summary.median)},
          {"lowest", OrNull(summary.lowest)}, {"highest", OrNull(summary.highest)}};
}

}  // namespace enamel::server::http
