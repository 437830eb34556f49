#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <map>

#include "common/scoring/score.h"
#include "server/http/error_response.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/training/access.h"

// All attempts of an assignment or a cohort with the points lost by criterion, in one answer: a page
// that asked for every score by itself needed a request per attempt.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

// An answer of that many has about 6 MB.
constexpr uint32_t kMaxGraded = 10'000;
static_assert(kMaxGraded <= AttemptFilter::kMaxAtOnce);

// The columns of the table, in the order in which the scores name them.
class Columns {
 public:
  // Points lost by column; null where the attempt's rubric has no such criterion, or it could cost
  // nothing.
  json::array LostIn(const scoring::ScoreResult& score) {
    json::array out(columns_.size());
    for (const scoring::CriterionResult& c : score.criteria) {
      const size_t at = PlaceOf(c);
      if (at >= out.size()) out.resize(at + 1);
      if (c.judged) out[at] = c.lost;
    }
    return out;
  }
  json::array Json() const {
    json::array out;
    for (const scoring::CriterionResult& c : columns_) {
      out.push_back({{"name", c.name}, {"group", scoring::NameOf(c.group)}, {"title", c.title}});
    }
    return out;
  }

 private:
  size_t PlaceOf(const scoring::CriterionResult& c) {
    const auto [found, added] = places_.try_emplace(c.name, columns_.size());
    if (added) columns_.push_back(c);
    return found->second;
  }

  std::vector<scoring::CriterionResult> columns_;
  std::map<std::string, size_t> places_;
};

// Percent of the work; null where all of it was done.
json::value DoneIn(const scoring::ScoreResult& score) {
  const auto rest =
      std::ranges::find(score.mistakes, scoring::MistakeKind::kNotDone, &scoring::Mistake::kind);
  return rest == score.mistakes.end() ? json::value() : json::value(100 - rest->size);
}

class Grading {
 public:
  Grading(const Call& call, Store& store) : call_(call), store_(store) {}

  Status Read(AttemptFilter filter) {
    const Person& viewer = call_.caller->person;
    NarrowToTaught(call_, filter);
    filter.not_to_be_marked_by = viewer.id;
    filter.limit = kMaxGraded + 1;
    ENAMEL_ASSIGN_OR_RETURN(auto rows, store_.attempts.Attempts(filter));
    ENAMEL_ASSIGN_OR_RETURN(const auto hidden, store_.markings.HiddenFrom(viewer.id));
    more_ = rows.size() > kMaxGraded;
    if (more_) rows.resize(kMaxGraded);
    for (const AttemptRow& row : rows) {
      if (std::chrono::steady_clock::now() >= call_.request.answer_by) {
        return {Code::kUnavailable, "the server was too busy to read these scores in time"};
      }
      ENAMEL_ASSIGN_OR_RETURN(const Exercise* exercise, ExerciseOf(row));
      // The filter has left out everybody of whom the viewer sees nothing.
      const bool visible =
          !hidden.contains(row.id) && CanSeeScore(viewer, row, exercise->graded, true);
      attempts_.push_back(Json(row, *exercise, visible));
    }
    return Status::Ok();
  }
  json::object Json() {
    return {{"criteria", columns_.Json()},
            {"exercises", std::move(exercise_list_)},
            {"attempts", std::move(attempts_)},
            {"more", more_},
            {"unread", unread_}};
  }

 private:
  struct Exercise {
    size_t place = 0;  // in the answer's list
    bool graded = true;
    std::vector<Uuid> cuts;  // references that count
  };

  Result<const Exercise*> ExerciseOf(const AttemptRow& row) {
    if (auto found = exercises_.find(row.exercise); found != exercises_.end())
      return &found->second;
    ENAMEL_ASSIGN_OR_RETURN(const auto stored, store_.exercises.ExerciseById(row.exercise));
    ENAMEL_ASSIGN_OR_RETURN(const auto references, store_.references.Counting(row.exercise));
    Exercise out{exercise_list_.size(), stored.graded, {}};
    for (const ReferenceRow& reference : references) out.cuts.push_back(reference.attempt);
    exercise_list_.push_back(
        {{"id", stored.id.Text()}, {"title", stored.title}, {"graded", stored.graded}});
    return &exercises_.emplace(row.exercise, std::move(out)).first->second;
  }

  json::object Json(const AttemptRow& row, const Exercise& exercise, bool visible) {
    json::value score, computed, critical_fail, lost, done;
    if (row.score && visible) {
      score = row.overridden ? row.overridden->score : *row.score;
      computed = *row.score;
      critical_fail = row.critical_fail;
      Points(row, lost, done);
    }
    json::array flags;
    for (const char* name : AttemptFlagNames(row.flags)) flags.emplace_back(name);
    return {{"id", row.id.Text()},
            {"person", {{"id", row.person.Text()}, {"display_name", row.person_name}}},
            {"exercise", exercise.place},
            {"state", AttemptStateName(row.state)},
            {"as_reference", row.as_reference},
            {"is_reference", std::ranges::find(exercise.cuts, row.id) != exercise.cuts.end()},
            {"released", row.released},
            {"score", std::move(score)},
            {"computed_score", std::move(computed)},
            {"critical_fail", std::move(critical_fail)},
            {"exam", row.exam},
            {"flags", std::move(flags)},
            {"hand", {{"kind", HandKindName(row.hand.kind)}}},
            {"progress", row.progress},
            {"problem_field", row.problem_field},
            {"ticketed_ms", row.ticketed_ms},
            {"gap_ticks", row.gap_ticks},
            {"revision", row.revision},
            {"done_percent", std::move(done)},
            {"lost", std::move(lost)}};
  }

  void Points(const AttemptRow& row, json::value& lost, json::value& done) {
    Result<Bytes> text = store_.blobs.GetBlob(row.score_document);
    if (text.ok()) {
      if (const auto points = scoring::PointsFromJson(AsText(*text)); points.ok()) {
        lost = columns_.LostIn(*points);
        done = DoneIn(*points);
        return;
      }
    }
    // One document that cannot be read costs its row the points, and not the class its table.
    ++unread_;
  }

  const Call& call_;
  Store& store_;
  Columns columns_;
  std::map<Uuid, Exercise> exercises_;
  json::array exercise_list_, attempts_;
  bool more_ = false;
  uint32_t unread_ = 0;
};

// `of`: whose attempts they are.
Result<Response> GradingResponse(const Call& call, Store& store, const AttemptFilter& filter,
                                 json::object of) {
  Grading grading(call, store);
  ENAMEL_RETURN_IF_ERROR(grading.Read(filter));
  json::object answer = grading.Json();
  answer["of"] = std::move(of);
  return JsonResponse(answer);
}

}  // namespace

Result<Response> GetAssignmentGrading(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, SeeAssignment(call, store.assignments, store.cohorts));
  AttemptFilter filter;
  filter.assignment = row.id;
  return GradingResponse(call, store, filter, {{"title", row.title}, {"graded", row.graded}});
}

Result<Response> GetCohortGrading(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Cohort cohort, VisibleCohort(call, store.cohorts));
  AttemptFilter filter;
  filter.cohort = cohort.id;
  return GradingResponse(call, store, filter, {{"title", cohort.name}, {"graded", nullptr}});
}

}  // namespace enamel::server::http
