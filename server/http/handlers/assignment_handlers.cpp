#include <algorithm>
#include <boost/json.hpp>
#include <map>

#include "common/base/unix_time.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"
#include "server/http/views/grade_view.h"
#include "server/jobs/comparison.h"
#include "server/training/access.h"
#include "server/training/revision.h"
#include "server/training/ticket_rules.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr int64_t kMaxTimeMs = 4'102'444'800'000;  // 2100
constexpr int64_t kMaxAttempts = 1000;
constexpr size_t kMaxStations = 1000;
constexpr size_t kMaxName = 64;

// Exams first, then by due time, those without one last.
std::string PlaceOf(const AssignmentRow& row) {
  // Fixed width, since places in the list are compared as text; 2100 has 13 digits in milliseconds.
  UnixMs due = row.due_ms == 0 ? kMaxTimeMs : row.due_ms;
  std::string text = std::to_string(due);
  return (row.exam ? "0" : "1") + std::string(13 - std::min<size_t>(13, text.size()), '0') + text +
         row.id.Text();
}

// Names for the ids in a list of assignments, looked up once.
class AssignmentView {
 public:
  static Result<AssignmentView> Make(Store& store) {
    AssignmentView out;
    ENAMEL_ASSIGN_OR_RETURN(std::vector<StationRow> stations, store.stations.Stations());
    for (const StationRow& row : stations) out.stations_[row.id] = row.name;
    ENAMEL_ASSIGN_OR_RETURN(std::vector<ExerciseRow> exercises, store.exercises.AllExercises());
    for (const ExerciseRow& row : exercises) out.exercises_[row.name] = row;
    return out;
  }

  json::object Json(const AssignmentRow& row) const {
    json::array stations;
    for (const Uuid& id : row.stations) {
      stations.push_back({{"id", id.Text()}, {"name", StationName(id)}});
    }
    json::value cohort, exercise_id, title, newest_id, newest_version;
    if (!row.cohort.IsZero()) {
      cohort = {{"id", row.cohort.Text()}, {"name", row.cohort_name}};
    }
    // A retired exercise can be finished, so the student gets its instructions.
    if (!row.version_id.IsZero()) {
      exercise_id = row.version_id.Text();
      title = row.title;
    }
    if (auto found = exercises_.find(row.exercise); found != exercises_.end()) {
      newest_id = found->second.id.Text();
      newest_version = found->second.version;
    }
    return {{"id", row.id.Text()},
            {"text", WordsOf(row)},
            {"exercise",
             {{"name", row.exercise},
              {"id", std::move(exercise_id)},
              {"title", std::move(title)},
              {"version", row.version},
              {"retired", row.retired},
              {"graded", row.graded},
              {"newest_id", std::move(newest_id)},
              {"newest_version", std::move(newest_version)}}},
            {"cohort", std::move(cohort)},
            {"opens_ms", row.opens_ms},
            {"due_ms", row.due_ms},
            {"attempt_limit", row.attempt_limit},
            {"exam", row.exam},
            {"late_allowed", row.late_allowed},
            {"hands", HandsAllowedName(row.hands)},
            {"sign_off", row.sign_off},
            {"outline", OutlineShownName(row.outline)},
            {"counting", CountingName(row.counting)},
            {"stations", std::move(stations)},
            {"created_ms", row.created_ms},
            {"revision", row.revision},
            // For students; who teaches has no attempts left to count.
            {"mine", nullptr}};
  }

  // With how it stands for the caller.
  json::object Json(const AssignedRow& row, const Grade& grade, UnixMs now_ms) const {
    json::object out = Json(row.assignment);
    std::string names;
    for (const Uuid& id : row.assignment.stations) {
      names += (names.empty() ? "" : ", ") + StationName(id);
    }
    // The rule that the station link asks when it gives a ticket, here without a station. Page and
    // chair have the same sentence for each reason.
    Status may = MayBegin(row, now_ms, std::nullopt, names);
    json::value left;
    if (row.assignment.attempt_limit != 0) {
      left =
          row.assignment.attempt_limit - std::min(row.attempts_used, row.assignment.attempt_limit);
    }
    out["mine"] = {{"attempts_used", row.attempts_used},
                   {"attempts_left", std::move(left)},
                   {"refusal", may.ok() ? "" : may.field()},
                   {"grade", GradeView::Json(grade)}};
    return out;
  }

 private:
  std::string StationName(const Uuid& id) const {
    auto found = stations_.find(id);
    return found == stations_.end() ? std::string() : found->second;
  }

  std::map<Uuid, std::string> stations_;
  std::map<std::string, ExerciseRow> exercises_;  // newest published, by name
};

Status MustBeAssignable(const Call& call, CohortRows& cohorts, const Uuid& cohort) {
  ENAMEL_ASSIGN_OR_RETURN(bool in_cohort, IsInCohort(call, cohorts, cohort));
  if (CanAssign(call.caller->person, cohort, in_cohort)) return {};
  return {Code::kForbidden,
          cohort.IsZero() ? "only admins assign to everybody; name a cohort"
                          : "only instructors of this cohort and admins can do this",
          "cohort_id"};
}

Status MustHaveReference(StoredBlobs& blobs, ReferenceRows& references, const ExerciseRow& version,
                         bool exam) {
  ENAMEL_ASSIGN_OR_RETURN(const bool comparable, HasComparison(blobs, references, version));
  return CheckReference(exam, version, comparable);
}

// The version that an assignment of this name would be of.
Result<ExerciseRow> OfferedVersion(const Call& call, ExerciseRows& exercises,
                                   const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ExerciseRow> offered, exercises.AllExercises());
  auto found = std::ranges::find(offered, name, &ExerciseRow::name);
  // The same answer for a missing exercise and another's: names reveal nothing.
  if (found == offered.end() || !CanUseExercise(call.caller->person, *found)) {
    return Status{
        Code::kInvalidInput,
        "expected the name of a published exercise that is yours or shared, found \"" + name + "\"",
        "exercise"};
  }
  return *found;
}

Status MustBeAssignableNow(const Call& call, Store& store, const AssignmentRow& terms) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow version,
                          OfferedVersion(call, store.exercises, terms.exercise));
  return MustHaveReference(store.blobs, store.references, version, terms.exam);
}

constexpr size_t kMaxTermName = 16;

// `before`: hands, counting and outline where the body leaves them out.
Result<AssignmentRow> TermsIn(const Call& call, const AssignmentRow& before) {
  BodyReader body(call.request);
  AssignmentRow row;
  const std::string named =
      body.Has("hands") ? body.Text("hands", 1, kMaxTermName) : HandsAllowedName(before.hands);
  row.exercise = body.Text("exercise", 1, kMaxName);
  row.cohort = body.MaybeId("cohort_id").value_or(Uuid{});
  row.opens_ms = body.Integer("opens_ms", 0, kMaxTimeMs, 0);
  row.due_ms = body.Integer("due_ms", 0, kMaxTimeMs, 0);
  row.attempt_limit = static_cast<uint32_t>(body.Integer("attempt_limit", 0, kMaxAttempts, 0));
  row.exam = body.Flag("exam", false);
  row.late_allowed = body.Flag("late_allowed", false);
  row.sign_off = body.Flag("sign_off", false);
  row.stations = body.Ids("station_ids", kMaxStations);
  const std::string counting =
      body.Has("counting") ? body.Text("counting", 1, kMaxTermName) : CountingName(before.counting);
  const std::string outline = body.Has("outline") ? body.Text("outline", 1, kMaxTermName)
                                                  : OutlineShownName(before.outline);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  const auto admitted = HandsAllowedFromName(named);
  if (!admitted) {
    return Status(Code::kInvalidInput,
                  "expected hands to be listed, haptic, pointer or any, found \"" + named + "\"",
                  "hands");
  }
  row.hands = *admitted;
  const std::optional<Counting> known = CountingFromName(counting);
  if (!known) {
    return Status{Code::kInvalidInput,
                  "expected best, last, mean or median, found \"" + counting + "\"", "counting"};
  }
  row.counting = *known;
  const std::optional<OutlineShown> shown = OutlineShownFromName(outline);
  if (!shown) {
    return Status{Code::kInvalidInput,
                  "expected practice, always or never, found \"" + outline + "\"", "outline"};
  }
  row.outline = *shown;
  // Of the terms together: due after it opens; stations and sign-off with exams only.
  ENAMEL_RETURN_IF_ERROR(CheckTerms(row));
  return row;
}

Result<Response> Editable(Store& store, const AssignmentRow& row, int status = 200) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentView view, AssignmentView::Make(store));
  return WithETag(JsonResponse(view.Json(row), status), row.revision);
}

// An assignment that is the caller's to change, at the revision the caller has seen.
Result<AssignmentRow> BeginEdit(const Call& call, AssignmentRows& assignments,
                                CohortRows& cohorts) {
  Result<AssignmentRow> row = SeeAssignment(call, assignments, cohorts);
  ENAMEL_RETURN_IF_ERROR(row.status());
  // For the cohort that it is assigned to now; ReplaceAssignment asks again for the one that it is
  // to go to.
  ENAMEL_RETURN_IF_ERROR(MustBeAssignable(call, cohorts, row->cohort));
  ENAMEL_ASSIGN_OR_RETURN(int32_t seen, IfMatch(call.request));
  // The revision that the caller has seen; the store compares it with the stored one inside its
  // transaction.
  row->revision = seen;
  return row;
}

// A new exercise must be assignable now, and a new exam needs a reference. Other changes need
// neither.
Status MustBeFitForTerms(const Call& call, Store& store, const AssignmentRow& now,
                         const AssignmentRow& terms) {
  if (terms.exercise != now.exercise) return MustBeAssignableNow(call, store, terms);
  if (!terms.exam || now.exam) return {};
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow version, store.exercises.ExerciseById(now.version_id));
  return MustHaveReference(store.blobs, store.references, version, true);
}

json::object MoveJson(const AssignmentView& view, const AssignmentMove& move, bool moved) {
  return {{"moved", moved},
          {"from_version", move.before.version},
          {"to_version", move.after.version},
          {"attempts", move.attempts},
          {"tickets", move.tickets},
          {"assignment", view.Json(moved ? move.after : move.before)}};
}

// Why a change of an assignment did not happen.
Result<Response> Refused(const Call& call, Store& store, const Status& status) {
  if (status.field() != kStale) return status;
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow now, store.assignments.AssignmentById(call.id));
  ENAMEL_ASSIGN_OR_RETURN(AssignmentView view, AssignmentView::Make(store));
  return Stale(status, view.Json(now), now.revision);
}

}  // namespace

Result<Response> ListAssignments(const Call& call, Store& store) {
  const Person& viewer = call.caller->person;
  ENAMEL_ASSIGN_OR_RETURN(std::optional<Uuid> cohort, QueryId(call.request, "cohort"));
  ENAMEL_ASSIGN_OR_RETURN(AssignmentView view, AssignmentView::Make(store));
  // All at once if the request asks for no page: a student's list is short and shown whole.
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  json::array assignments;
  if (viewer.role == Role::kStudent) {
    ENAMEL_ASSIGN_OR_RETURN(std::vector<AssignedRow> rows,
                            store.assignments.AssignmentsFor(viewer.id));
    std::erase_if(
        rows, [&](const AssignedRow& row) { return cohort && row.assignment.cohort != *cohort; });
    json::value next =
        CutPage(rows, page, [](const AssignedRow& row) { return PlaceOf(row.assignment); });
    GradeView grades(store, viewer);
    for (const AssignedRow& row : rows) {
      ENAMEL_ASSIGN_OR_RETURN(auto grade, grades.Of(row.assignment, {.person = viewer.id}));
      assignments.push_back(view.Json(row, grade[viewer.id], enamel::UnixMs()));
    }
    return JsonResponse({{"assignments", std::move(assignments)}, {"next", std::move(next)}});
  }
  AssignmentFilter filter;
  filter.cohort = cohort;
  if (viewer.role == Role::kInstructor) filter.of_instructor = viewer.id;
  ENAMEL_ASSIGN_OR_RETURN(std::vector<AssignmentRow> rows, store.assignments.Assignments(filter));
  json::value next = CutPage(rows, page, PlaceOf);
  for (const AssignmentRow& row : rows) assignments.push_back(view.Json(row));
  return JsonResponse({{"assignments", std::move(assignments)}, {"next", std::move(next)}});
}

Result<Response> AddAssignment(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow terms, TermsIn(call, AssignmentRow{}));
  ENAMEL_RETURN_IF_ERROR(MustBeAssignable(call, store.cohorts, terms.cohort));
  ENAMEL_RETURN_IF_ERROR(MustBeAssignableNow(call, store, terms));
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, store.assignments.AddAssignment(terms, ActorOf(call)));
  return Editable(store, row, 201);
}

Result<Response> GetAssignment(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, SeeAssignment(call, store.assignments, store.cohorts));
  return Editable(store, row);
}

Result<Response> ReplaceAssignment(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow edited, BeginEdit(call, store.assignments, store.cohorts));
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow terms, TermsIn(call, edited));
  ENAMEL_RETURN_IF_ERROR(MustBeAssignable(call, store.cohorts, terms.cohort));
  if (Status can = MustBeFitForTerms(call, store, edited, terms); !can.ok()) {
    return can;
  }
  terms.id = call.id;
  terms.revision = edited.revision;
  terms.created_ms = edited.created_ms;
  Result<AssignmentRow> row = store.assignments.ReplaceAssignment(terms, ActorOf(call));
  if (!row.ok()) return Refused(call, store, row.status());
  return Editable(store, *row);
}

Result<Response> MoveAssignment(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> dry_run, QueryFlag(call.request, "dry_run"));
  const bool look_only = dry_run.value_or(false);
  // To look needs no If-Match: it shows what there is.
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row,
                          look_only ? SeeAssignment(call, store.assignments, store.cohorts)
                                    : BeginEdit(call, store.assignments, store.cohorts));
  ENAMEL_RETURN_IF_ERROR(MustBeAssignable(call, store.cohorts, row.cohort));
  BodyReader body(call.request);
  const Uuid wanted = body.MaybeId("exercise_id").value_or(Uuid{});
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  Result<ExerciseRow> version = store.exercises.ExerciseById(wanted);
  if (!version.ok() && version.status().code() != Code::kNotFound) {
    return version.status();
  }
  if (!version.ok() || !CanUseExercise(call.caller->person, *version)) {
    return Status(
        Code::kInvalidInput,
        "expected a published version of \"" + row.exercise + "\" that is yours or shared",
        "exercise_id");
  }
  if (Status can = MustHaveReference(store.blobs, store.references, *version, row.exam);
      !can.ok()) {
    return can;
  }
  Result<AssignmentMove> move =
      store.assignments.MoveAssignment(call.id, wanted, row.revision, look_only, ActorOf(call));
  if (!move.ok()) return Refused(call, store, move.status());
  ENAMEL_ASSIGN_OR_RETURN(AssignmentView view, AssignmentView::Make(store));
  return WithETag(JsonResponse(MoveJson(view, *move, !look_only)),
                  look_only ? move->before.revision : move->after.revision);
}

Result<Response> DeleteAssignment(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow edited, BeginEdit(call, store.assignments, store.cohorts));
  Status done = store.assignments.DeleteAssignment(call.id, edited.revision, ActorOf(call));
  if (!done.ok()) return Refused(call, store, done);
  return Done();
}

Result<Response> ReleaseAssignment(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, SeeAssignment(call, store.assignments, store.cohorts));
  ENAMEL_RETURN_IF_ERROR(MustBeAssignable(call, store.cohorts, row.cohort));
  ENAMEL_ASSIGN_OR_RETURN(uint32_t released,
                          store.judging.ReleaseAssignment(call.id, ActorOf(call)));
  // How many were let out now; those released before are not counted again.
  return JsonResponse({{"released", released}});
}

}  // namespace enamel::server::http
