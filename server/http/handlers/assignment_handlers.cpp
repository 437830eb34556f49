#include <algorithm>
#include <boost/json.hpp>
#include <map>

#include "common/base/unix_time.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/handlers.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/json_body.h"
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
    Result<std::vector<StationRow>> stations = store.stations.Stations();
    if (!stations.ok()) return stations.status();
    for (const StationRow& row : *stations) out.stations_[row.id] = row.name;
    Result<std::vector<ExerciseRow>> exercises = store.exercises.AllExercises();
    if (!exercises.ok()) return exercises.status();
    for (const ExerciseRow& row : *exercises) out.exercises_[row.name] = row;
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
  Result<bool> in_cohort = IsInCohort(call, cohorts, cohort);
  if (!in_cohort.ok()) return in_cohort.status();
  if (CanAssign(call.caller->person, cohort, *in_cohort)) return {};
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
  Result<std::vector<ExerciseRow>> offered = exercises.AllExercises();
  if (!offered.ok()) return offered.status();
  auto found = std::ranges::find(*offered, name, &ExerciseRow::name);
  // The same answer for a missing exercise and another's: names reveal nothing.
  if (found == offered->end() || !CanUseExercise(call.caller->person, *found)) {
    return Status{
        Code::kInvalidInput,
        "expected the name of a published exercise that is yours or shared, found \"" + name + "\"",
        "exercise"};
  }
  return *found;
}

Status MustBeAssignableNow(const Call& call, Store& store, const AssignmentRow& terms) {
  Result<ExerciseRow> version = OfferedVersion(call, store.exercises, terms.exercise);
  if (!version.ok()) return version.status();
  return MustHaveReference(store.blobs, store.references, *version, terms.exam);
}

constexpr size_t kMaxTermName = 16;

// `before`: hands and counting where the body does not give them.
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
  // Of the terms together: due after it opens; stations and sign-off with exams only.
  ENAMEL_RETURN_IF_ERROR(CheckTerms(row));
  return row;
}

Response Editable(Store& store, const AssignmentRow& row, int status = 200) {
  Result<AssignmentView> view = AssignmentView::Make(store);
  if (!view.ok()) return ErrorResponse(view.status());
  return WithETag(JsonResponse(view->Json(row), status), row.revision);
}

// An assignment that is the caller's to change, at the revision the caller has seen.
Result<AssignmentRow> BeginEdit(const Call& call, AssignmentRows& assignments,
                                CohortRows& cohorts) {
  Result<AssignmentRow> row = SeeAssignment(call, assignments, cohorts);
  if (!row.ok()) return row;
  // For the cohort that it is assigned to now; ReplaceAssignment asks again for the one that it is
  // to go to.
  ENAMEL_RETURN_IF_ERROR(MustBeAssignable(call, cohorts, row->cohort));
  Result<int32_t> seen = IfMatch(call.request);
  if (!seen.ok()) return seen.status();
  // The revision that the caller has seen; the store compares it with the stored one inside its
  // transaction.
  row->revision = *seen;
  return row;
}

// A new exercise must be assignable now, and a new exam needs a reference. Other changes need
// neither.
Status MustBeFitForTerms(const Call& call, Store& store, const AssignmentRow& now,
                         const AssignmentRow& terms) {
  if (terms.exercise != now.exercise) return MustBeAssignableNow(call, store, terms);
  if (!terms.exam || now.exam) return {};
  Result<ExerciseRow> version = store.exercises.ExerciseById(now.version_id);
  if (!version.ok()) return version.status();
  return MustHaveReference(store.blobs, store.references, *version, true);
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
Response Refused(const Call& call, Store& store, const Status& status) {
  if (status.field() != kStale) return ErrorResponse(status);
  Result<AssignmentRow> now = store.assignments.AssignmentById(call.id);
  if (!now.ok()) return ErrorResponse(now.status());
  Result<AssignmentView> view = AssignmentView::Make(store);
  if (!view.ok()) return ErrorResponse(view.status());
  return Stale(status, view->Json(*now), now->revision);
}

}  // namespace

Response ListAssignments(const Call& call, Store& store) {
  const Person& viewer = call.caller->person;
  Result<std::optional<Uuid>> cohort = QueryId(call.request, "cohort");
  if (!cohort.ok()) return ErrorResponse(cohort.status());
  Result<AssignmentView> view = AssignmentView::Make(store);
  if (!view.ok()) return ErrorResponse(view.status());
  // All at once if the request asks for no page: a student's list is short and shown whole.
  Result<Page> page = PageOf(call.request, kMaxPage, kMaxPage);
  if (!page.ok()) return ErrorResponse(page.status());
  json::array assignments;
  if (viewer.role == Role::kStudent) {
    Result<std::vector<AssignedRow>> rows = store.assignments.AssignmentsFor(viewer.id);
    if (!rows.ok()) return ErrorResponse(rows.status());
    std::erase_if(*rows, [&](const AssignedRow& row) {
      return *cohort && row.assignment.cohort != **cohort;
    });
    json::value next =
        CutPage(*rows, *page, [](const AssignedRow& row) { return PlaceOf(row.assignment); });
    GradeView grades(store, viewer);
    for (const AssignedRow& row : *rows) {
      Result<std::map<Uuid, Grade>> grade = grades.Of(row.assignment, {.person = viewer.id});
      if (!grade.ok()) return ErrorResponse(grade.status());
      assignments.push_back(view->Json(row, (*grade)[viewer.id], enamel::UnixMs()));
    }
    return JsonResponse({{"assignments", std::move(assignments)}, {"next", std::move(next)}});
  }
  AssignmentFilter filter;
  filter.cohort = *cohort;
  if (viewer.role == Role::kInstructor) filter.of_instructor = viewer.id;
  Result<std::vector<AssignmentRow>> rows = store.assignments.Assignments(filter);
  if (!rows.ok()) return ErrorResponse(rows.status());
  json::value next = CutPage(*rows, *page, PlaceOf);
  for (const AssignmentRow& row : *rows) assignments.push_back(view->Json(row));
  return JsonResponse({{"assignments", std::move(assignments)}, {"next", std::move(next)}});
}

Response AddAssignment(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<AssignmentRow> terms = TermsIn(call, AssignmentRow{});
  if (!terms.ok()) return ErrorResponse(terms.status());
  if (Status may = MustBeAssignable(call, store.cohorts, terms->cohort); !may.ok())
    return ErrorResponse(may);
  if (Status can = MustBeAssignableNow(call, store, *terms); !can.ok()) return ErrorResponse(can);
  Result<AssignmentRow> row = store.assignments.AddAssignment(*terms, ActorOf(call));
  if (!row.ok()) return ErrorResponse(row.status());
  return Editable(store, *row, 201);
}

Response GetAssignment(const Call& call, Store& store) {
  Result<AssignmentRow> row = SeeAssignment(call, store.assignments, store.cohorts);
  if (!row.ok()) return ErrorResponse(row.status());
  return Editable(store, *row);
}

Response ReplaceAssignment(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<AssignmentRow> edited = BeginEdit(call, store.assignments, store.cohorts);
  if (!edited.ok()) return ErrorResponse(edited.status());
  Result<AssignmentRow> terms = TermsIn(call, *edited);
  if (!terms.ok()) return ErrorResponse(terms.status());
  if (Status may = MustBeAssignable(call, store.cohorts, terms->cohort); !may.ok())
    return ErrorResponse(may);
  if (Status can = MustBeFitForTerms(call, store, *edited, *terms); !can.ok()) {
    return ErrorResponse(can);
  }
  terms->id = call.id;
  terms->revision = edited->revision;
  terms->created_ms = edited->created_ms;
  Result<AssignmentRow> row = store.assignments.ReplaceAssignment(*terms, ActorOf(call));
  if (!row.ok()) return Refused(call, store, row.status());
  return Editable(store, *row);
}

Response MoveAssignment(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<std::optional<bool>> dry_run = QueryFlag(call.request, "dry_run");
  if (!dry_run.ok()) return ErrorResponse(dry_run.status());
  const bool look_only = dry_run->value_or(false);
  // To look needs no If-Match: it shows what there is.
  Result<AssignmentRow> row = look_only ? SeeAssignment(call, store.assignments, store.cohorts)
                                        : BeginEdit(call, store.assignments, store.cohorts);
  if (!row.ok()) return ErrorResponse(row.status());
  if (Status may = MustBeAssignable(call, store.cohorts, row->cohort); !may.ok())
    return ErrorResponse(may);
  BodyReader body(call.request);
  const Uuid wanted = body.MaybeId("exercise_id").value_or(Uuid{});
  if (Status fits = body.Finish(); !fits.ok()) return ErrorResponse(fits);
  Result<ExerciseRow> version = store.exercises.ExerciseById(wanted);
  if (!version.ok() && version.status().code() != Code::kNotFound) {
    return ErrorResponse(version.status());
  }
  if (!version.ok() || !CanUseExercise(call.caller->person, *version)) {
    return ErrorResponse(
        Status{Code::kInvalidInput,
               "expected a published version of \"" + row->exercise + "\" that is yours or shared",
               "exercise_id"});
  }
  if (Status can = MustHaveReference(store.blobs, store.references, *version, row->exam);
      !can.ok()) {
    return ErrorResponse(can);
  }
  Result<AssignmentMove> move =
      store.assignments.MoveAssignment(call.id, wanted, row->revision, look_only, ActorOf(call));
  if (!move.ok()) return Refused(call, store, move.status());
  Result<AssignmentView> view = AssignmentView::Make(store);
  if (!view.ok()) return ErrorResponse(view.status());
  return WithETag(JsonResponse(MoveJson(*view, *move, !look_only)),
                  look_only ? move->before.revision : move->after.revision);
}

Response DeleteAssignment(const Call& call, Store& store) {
  Result<AssignmentRow> edited = BeginEdit(call, store.assignments, store.cohorts);
  if (!edited.ok()) return ErrorResponse(edited.status());
  Status done = store.assignments.DeleteAssignment(call.id, edited->revision, ActorOf(call));
  if (!done.ok()) return Refused(call, store, done);
  return Done();
}

Response ReleaseAssignment(const Call& call, Store& store) {
  Result<AssignmentRow> row = SeeAssignment(call, store.assignments, store.cohorts);
  if (!row.ok()) return ErrorResponse(row.status());
  if (Status may = MustBeAssignable(call, store.cohorts, row->cohort); !may.ok())
    return ErrorResponse(may);
  Result<uint32_t> released = store.judging.ReleaseAssignment(call.id, ActorOf(call));
  if (!released.ok()) return ErrorResponse(released.status());
  // How many were let out now; those released before are not counted again.
  return JsonResponse({{"released", *released}});
}

}  // namespace enamel::server::http
