#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/json.hpp>
#include <map>
#include <set>

#include "common/scene/json/json.h"
#include "common/scoring/score.h"
#include "server/agreement/standard.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/json_body.h"
#include "server/http/kept.h"
#include "server/http/operations.h"
#include "server/jobs/marked_work.h"
#include "server/jobs/regrade.h"
#include "server/training/access.h"
#include "server/training/names.h"

// Blind marking (schemas/marks.md): without names and computed scores, in an order of each marker's
// own, until all are done.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kMaxMarkersOfOne = 20, kMaxComment = 500, kMaxComments = 50;
constexpr size_t kMaxWorks = 500;

// What the caller may see of it: as a marker, or as somebody who teaches the cohort.
struct SeenMarking {
  MarkingRow row;
  AssignmentRow assignment;
  bool is_marker = false, teaches = false;
};

bool IsMarker(const MarkingRow& row, const Uuid& person) {
  return std::ranges::find(row.markers, person, &MarkingRow::Marker::person) != row.markers.end();
}

Result<SeenMarking> SeeMarking(const Call& call, Store& store, const Uuid& id) {
  const Status none{Code::kNotFound, "there is no such blind marking", "id"};
  SeenMarking out;
  Result<MarkingRow> row = store.markings.MarkingById(id);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  out.row = *row;
  ENAMEL_ASSIGN_OR_RETURN(out.assignment, store.assignments.AssignmentById(row->assignment));
  const Person& person = call.caller->person;
  out.is_marker = IsMarker(*row, person.id);
  ENAMEL_ASSIGN_OR_RETURN(const bool in_cohort,
                          IsInCohort(call, store.cohorts, out.assignment.cohort));
  out.teaches = CanAssign(person, out.assignment.cohort, in_cohort);
  if (!out.is_marker && !out.teaches) return none;
  return out;
}

Result<scene::Rubric> RubricOf(Store& store, const AssignmentRow& assignment) {
  ENAMEL_ASSIGN_OR_RETURN(const auto row, store.exercises.ExerciseById(assignment.version_id));
  ENAMEL_ASSIGN_OR_RETURN(const auto text, store.blobs.GetBlob(row.content));
  ENAMEL_ASSIGN_OR_RETURN(const auto exercise, scene::ExerciseFromJson(AsText(text)));
  return CountingRubric(store.blobs, store.rubrics, row.id, exercise.rubric);
}

// Each marker's own, and not that of the attempts or of the ids.
std::vector<MarkingWork> InOrderOf(const Uuid& marker, std::vector<MarkingWork> works) {
  auto place = [&](const MarkingWork& work) {
    ByteWriter out;
    out.Raw(marker.view());
    out.Raw(work.id.view());
    return HashSha256(out.Take());
  };
  std::ranges::sort(works, {}, place);
  return works;
}

double TotalOf(const json::array& criteria) {
  double points = 0, full = 0;
  for (const json::value& c : criteria) {
    points += c.at("points").to_number<double>(), full += c.at("max_points").to_number<double>();
  }
  return full > 0 ? 100 * points / full : 0;
}

// As schemas/marks.md has them: by attempt, group and marker.
Result<std::vector<Mark>> MarksFrom(Store& store, const MarkingRow& row,
                                    const std::vector<BlindMark>& blind) {
  ENAMEL_ASSIGN_OR_RETURN(const auto works, store.markings.WorksOf(row.id));
  std::map<Uuid, std::string> attempt_of;
  std::vector<ScoredWork> scored;
  for (const MarkingWork& work : works) {
    attempt_of[work.id] = work.attempt.Text();
    ENAMEL_ASSIGN_OR_RETURN(auto score, StoredScore(store.blobs, store.results, work.attempt));
    scored.push_back({work.attempt, std::move(score)});
  }
  std::vector<Mark> out;
  std::set<std::string, std::less<>> marked{std::string(kTotalCriterion)};
  for (const BlindMark& mark : blind) {
    const json::array criteria = json::parse(mark.criteria).as_array();
    const std::string marker = mark.marker.Text(), &work = attempt_of[mark.work];
    for (const json::value& c : criteria) {
      marked.emplace(c.at("title").as_string());
      out.push_back({work, std::string(c.at("title").as_string()), marker,
                     c.at("points").to_number<double>(), c.at("max_points").to_number<double>()});
    }
    out.push_back({work, std::string(kTotalCriterion), marker, TotalOf(criteria), 100});
    out.push_back({work, std::string(kRatingCriterion), marker, double(mark.rating), 5});
  }
  for (Mark& mark : ComputedMarks(scored)) {
    if (marked.contains(mark.criterion)) out.push_back(std::move(mark));
  }
  return out;
}

// After the last mark: whose work it was, what the program gave, and how well all agree.
Result<json::object> ResultsJson(Store& store, const MarkingRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(const auto blind, store.markings.MarksOf(row.id));
  ENAMEL_ASSIGN_OR_RETURN(const auto works, store.markings.WorksOf(row.id));
  json::array list;
  for (const MarkingWork& work : works) {
    ENAMEL_ASSIGN_OR_RETURN(const auto attempt, store.attempts.AttemptById(work.attempt));
    json::array marks;
    for (const BlindMark& mark : blind) {
      if (mark.work != work.id) continue;
      json::array criteria = json::parse(mark.criteria).as_array();
      const double total = TotalOf(criteria);
      marks.push_back({{"marker_id", mark.marker.Text()},
                       {"rating", mark.rating},
                       {"total", total},
                       {"criteria", std::move(criteria)},
                       {"made_ms", mark.made_ms}});
    }
    list.push_back(
        {{"id", work.id.Text()},
         {"attempt_id", work.attempt.Text()},
         {"person", {{"id", attempt.person.Text()}, {"display_name", attempt.person_name}}},
         {"computed_score", attempt.score ? json::value(*attempt.score) : nullptr},
         {"marks", std::move(marks)}});
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto marks, MarksFrom(store, row, blind));
  ENAMEL_ASSIGN_OR_RETURN(const auto agreement, CompareMarks(marks));
  ENAMEL_ASSIGN_OR_RETURN(const auto standard, SetStandard(marks));
  return json::object{{"works", std::move(list)},
                      {"agreement", json::parse(AgreementJson(agreement)).at("criteria")},
                      {"standard", json::parse(StandardJson(standard))}};
}

Result<json::array> MarkersJson(Store& store, const MarkingRow& row) {
  json::array out;
  for (const MarkingRow::Marker& marker : row.markers) {
    Result<Person> person = store.people.PersonById(marker.person);
    if (!person.ok() && person.status().code() != Code::kNotFound) return person.status();
    out.push_back({{"id", marker.person.Text()},
                   {"display_name", person.ok() ? person->display_name : ""},
                   {"marked", marker.marked}});
  }
  return out;
}

Result<json::object> SummaryJson(Store& store, const MarkingRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto markers, MarkersJson(store, row));
  return json::object{{"id", row.id.Text()},          {"assignment_id", row.assignment.Text()},
                      {"created_ms", row.created_ms}, {"ended_ms", row.ended_ms},
                      {"works", row.works},           {"done", row.done()},
                      {"markers", std::move(markers)}};
}

// What this marker has said of each group before, newest first: to say it again in one click.
Result<json::array> CommentsJson(Store& store, const Uuid& marker) {
  ENAMEL_ASSIGN_OR_RETURN(const auto earlier, store.markings.CriteriaBy(marker));
  json::array out;
  std::map<std::pair<std::string, std::string>, bool> said;
  for (const std::string& text : earlier) {
    const json::value criteria = json::parse(text);
    for (const json::value& c : criteria.as_array()) {
      const std::string name(c.at("name").as_string()), comment(c.at("comment").as_string());
      if (comment.empty() || said[{name, comment}] || out.size() >= kMaxComments) continue;
      said[{name, comment}] = true;
      out.push_back({{"name", name}, {"comment", comment}});
    }
  }
  return out;
}

// Exactly the groups that are marked. Errors: kInvalidInput naming the group.
Result<std::string> CriteriaText(const scene::Rubric& rubric, const std::string& document) {
  const json::object given = json::parse(document).as_object();
  const double full_marks = scoring::FullMarksOf(rubric);
  json::array out;
  for (const scoring::Group group : scoring::GroupsOf(rubric)) {
    const std::string name(scoring::NameOf(group)), title(scoring::TitleOf(group));
    const json::value* mark = given.if_contains(name);
    const json::value* points =
        mark != nullptr && mark->is_object() ? mark->as_object().if_contains("points") : nullptr;
    const double value =
        points != nullptr && points->is_number() ? points->to_number<double>() : -1;
    if (!(value >= 0 && value <= full_marks)) {
      return Status(
          Code::kInvalidInput,
          fmt::format("expected points from 0 to {:g} for \"{}\" ({})", full_marks, title, name),
          "criteria");
    }
    std::string comment;
    if (const json::value* said = mark->as_object().if_contains("comment");
        said != nullptr && said->is_string()) {
      comment = said->as_string();
    }
    if (comment.size() > kMaxComment) {
      return Status(Code::kInvalidInput,
                    "expected a comment of at most " + std::to_string(kMaxComment) + " bytes",
                    "criteria");
    }
    if (!comment.empty()) ENAMEL_RETURN_IF_ERROR(CheckOneLine(comment, "criteria"));
    out.push_back({{"name", name},
                   {"title", title},
                   {"points", value},
                   {"max_points", full_marks},
                   {"comment", comment}});
  }
  if (given.size() != out.size()) {
    return Status(Code::kInvalidInput, "expected the marking's groups and no others", "criteria");
  }
  return json::serialize(out);
}

Status CheckMarkers(Store& store, const std::vector<Uuid>& markers) {
  std::vector<Uuid> sorted = markers;
  std::ranges::sort(sorted);
  if (markers.size() < 2 || std::ranges::adjacent_find(sorted) != sorted.end()) {
    return Status(Code::kInvalidInput, "expected two different markers at least", "marker_ids");
  }
  for (const Uuid& id : markers) {
    Result<Person> person = store.people.PersonById(id);
    if (!person.ok() && person.status().code() != Code::kNotFound) return person.status();
    if (!person.ok() || person->disabled || person->role == Role::kStudent) {
      return Status(Code::kInvalidInput, "expected instructors or admins who may sign in",
                    "marker_ids");
    }
  }
  return Status::Ok();
}

Result<std::vector<Uuid>> WorkToMark(Store& store, const AssignmentRow& assignment) {
  AttemptFilter filter;
  filter.assignment = assignment.id;
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, ScoredAttempts(store.attempts, filter));
  std::vector<Uuid> out;
  for (const AttemptRow& row : rows) {
    if (row.as_reference || (row.flags & (kExcused | kReturned)) != 0) continue;
    out.push_back(row.id);
  }
  if (out.empty() || out.size() > kMaxWorks) {
    return Status(Code::kConflict,
                  "a blind marking is of 1 to " + std::to_string(kMaxWorks) +
                      " scored attempts; this assignment has " + std::to_string(out.size()),
                  "marking_works");
  }
  return out;
}

// A missing work and one that somebody else marks get the same answer.
Status NoSuchWork() { return {Code::kNotFound, "there is no such work that you mark", "id"}; }

Result<MarkingWork> AskedWork(const Call& call, Store& store) {
  Result<MarkingWork> work = store.markings.WorkById(call.id);
  if (work.status().code() == Code::kNotFound) return NoSuchWork();
  return work;
}

}  // namespace

Result<Response> BeginMarking(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, SeeAssignment(call, store.assignments, store.cohorts));
  ENAMEL_ASSIGN_OR_RETURN(bool in_cohort, IsInCohort(call, store.cohorts, row.cohort));
  if (!CanAssign(call.caller->person, row.cohort, in_cohort)) {
    return Status(Code::kForbidden, "only instructors of this cohort can do this");
  }
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  const std::vector<Uuid> markers = body.Ids("marker_ids", kMaxMarkersOfOne);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(CheckMarkers(store, markers));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Uuid> works, WorkToMark(store, row));
  ENAMEL_ASSIGN_OR_RETURN(MarkingRow begun,
                          store.markings.BeginMarking(row.id, works, markers, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(json::object summary, SummaryJson(store, begun));
  return JsonResponse(summary, 201);
}

Result<Response> ListMarkings(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, SeeAssignment(call, store.assignments, store.cohorts));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<MarkingRow> rows, store.markings.MarkingsOf(row.id));
  json::array out;
  for (const MarkingRow& marking : rows) {
    ENAMEL_ASSIGN_OR_RETURN(json::object summary, SummaryJson(store, marking));
    out.push_back(std::move(summary));
  }
  return JsonResponse({{"markings", std::move(out)}});
}

Result<Response> GetMarking(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenMarking seen, SeeMarking(call, store, call.id));
  ENAMEL_ASSIGN_OR_RETURN(json::object out, SummaryJson(store, seen.row));
  ENAMEL_ASSIGN_OR_RETURN(scene::Rubric rubric, RubricOf(store, seen.assignment));
  json::array criteria, mine, comments;
  for (const scoring::Group group : scoring::GroupsOf(rubric)) {
    criteria.push_back({{"name", scoring::NameOf(group)},
                        {"title", scoring::TitleOf(group)},
                        {"max_points", scoring::FullMarksOf(rubric)}});
  }
  const Uuid& person = call.caller->person.id;
  if (seen.is_marker) {
    ENAMEL_ASSIGN_OR_RETURN(std::vector<MarkingWork> works, store.markings.WorksOf(seen.row.id));
    ENAMEL_ASSIGN_OR_RETURN(std::vector<BlindMark> marks, store.markings.MarksOf(seen.row.id));
    for (const MarkingWork& work : InOrderOf(person, std::move(works))) {
      const bool marked = std::ranges::any_of(
          marks, [&](const BlindMark& m) { return m.work == work.id && m.marker == person; });
      mine.push_back({{"id", work.id.Text()}, {"marked", marked}});
    }
    ENAMEL_ASSIGN_OR_RETURN(json::array said, CommentsJson(store, person));
    comments = std::move(said);
  }
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow exercise,
                          store.exercises.ExerciseById(seen.assignment.version_id));
  out["exercise"] = {
      {"id", exercise.id.Text()}, {"title", exercise.title}, {"graded", exercise.graded}};
  out["criteria"] = std::move(criteria);
  out["mine"] = std::move(mine);
  out["comments"] = std::move(comments);
  out["results"] = nullptr;
  if (seen.row.done()) {
    ENAMEL_ASSIGN_OR_RETURN(json::object results, ResultsJson(store, seen.row));
    out["results"] = std::move(results);
  }
  return JsonResponse(out);
}

Result<Response> SetMarkers(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  const std::vector<Uuid> markers = body.Ids("marker_ids", kMaxMarkersOfOne);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(SeenMarking seen, SeeMarking(call, store, call.id));
  if (!seen.teaches) {
    return Status(Code::kForbidden, "only instructors of this cohort can do this");
  }
  ENAMEL_RETURN_IF_ERROR(CheckMarkers(store, markers));
  ENAMEL_ASSIGN_OR_RETURN(MarkingRow row,
                          store.markings.SetMarkers(call.id, markers, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(json::object summary, SummaryJson(store, row));
  return JsonResponse(summary);
}

Result<Response> EndMarking(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenMarking seen, SeeMarking(call, store, call.id));
  if (!seen.teaches) {
    return Status(Code::kForbidden, "only instructors of this cohort can do this");
  }
  return DoneOr(store.markings.EndMarking(call.id, ActorOf(call)));
}

Result<Response> AddMark(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(MarkingWork work, AskedWork(call, store));
  Result<SeenMarking> seen = SeeMarking(call, store, work.marking);
  if (!seen.ok() || !seen->is_marker) return NoSuchWork();
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  BlindMark mark{work.id, call.caller->person.id, 0, "", 0};
  mark.rating = static_cast<int32_t>(body.Integer("rating", kClearFail, kExcellent));
  const std::string document = body.Document("criteria");
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(scene::Rubric rubric, RubricOf(store, seen->assignment));
  ENAMEL_ASSIGN_OR_RETURN(std::string criteria, CriteriaText(rubric, document));
  mark.criteria = criteria;
  return DoneOr(store.markings.AddMark(mark, ActorOf(call)));
}

// How the tooth became what it is, without the deviation from any reference.
Result<Response> GetMarkingTimeline(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(MarkingWork work, AskedWork(call, store));
  ENAMEL_ASSIGN_OR_RETURN(MarkingRow row, store.markings.MarkingById(work.marking));
  if (!IsMarker(row, call.caller->person.id)) return NoSuchWork();
  ENAMEL_ASSIGN_OR_RETURN(TimelineRow timeline, store.timelines.AskForTimeline(work.attempt));
  if (timeline.content.IsZero()) {
    if (timeline.waits) {
      return Status(Code::kUnavailable,
                    "the playback of this work is being made; it is shown once it is there",
                    "playback_waits");
    }
    return Status(Code::kNotFound, "the playback of this work could not be made");
  }
  return KeptResponse(call.request,
                      {timeline.content, "application/octet-stream", "private, no-cache"},
                      *call.bodies, [&] { return store.blobs.GetBlob(timeline.content); });
}

}  // namespace enamel::server::http
