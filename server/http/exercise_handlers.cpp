#include <algorithm>
#include <map>

#include "common/scene/json.h"
#include "server/http/error_response.h"
#include "server/http/handlers.h"
#include "server/http/json_body.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr uint32_t kCountedAttempts = 200;

Result<std::vector<ExerciseRow>> VisibleExercises(const Call& call) {
  const Person& person = call.caller->person;
  return person.role == Role::kAdmin ? call.store.AllExercises()
                                     : call.store.ExercisesFor(person.id);
}

Result<scene::Exercise> Document(Store& store, const ExerciseRow& row) {
  Result<Bytes> bytes = store.GetBlob(row.content);
  if (!bytes.ok()) return bytes.status();
  return scene::ExerciseFromJson(AsText(*bytes));
}

Result<std::map<Uuid, int>> OwnAttempts(const Call& call) {
  AttemptFilter filter;
  filter.person = call.caller->person.id;
  filter.limit = kCountedAttempts;
  Result<std::vector<AttemptRow>> attempts = call.store.Attempts(filter);
  if (!attempts.ok()) return attempts.status();
  std::map<Uuid, int> count;
  for (const AttemptRow& attempt : *attempts) ++count[attempt.exercise];
  return count;
}

Result<json::object> SummaryJson(const Call& call, const ExerciseRow& row,
                                 const scene::Exercise& exercise, std::map<Uuid, int>& attempts) {
  Result<std::optional<ReferenceRow>> reference = call.store.ReferenceFor(row.id);
  if (!reference.ok()) return reference.status();
  return json::object{{"id", row.id.Text()},
                      {"name", row.name},
                      {"title", row.title},
                      {"version", row.version},
                      {"graded", row.graded},
                      {"instructions", exercise.instructions},
                      {"bur",
                       {{"shape", cutting::BurShapeName(exercise.bur_shape)},
                        {"radius_um", exercise.bur_radius_um},
                        {"length_um", exercise.bur_length_um}}},
                      {"has_reference", reference->has_value()},
                      {"my_attempts", attempts[row.id]}};
}

json::object TargetJson(const scene::CavityTarget& target) {
  const auto& half = target.half_size_um;
  return {{"half_size_um", json::array{half[0], half[1], half[2]}},
          {"depth_um", target.depth_um},
          {"leeway_side_um", target.leeway_side_um},
          {"leeway_bottom_um", target.leeway_bottom_um},
          {"container_um", target.container_um}};
}

json::object RubricJson(const scene::Rubric& rubric) {
  json::array criteria;
  for (const scene::RubricCriterion& criterion : rubric.criteria) {
    json::array map;
    for (const scene::RubricPoint& point : criterion.map) {
      map.push_back({{"value", point.value}, {"share", point.share}});
    }
    criteria.push_back({{"metric", criterion.metric},
                        {"title", criterion.title},
                        {"unit", criterion.unit},
                        {"points", criterion.points},
                        {"map", std::move(map)},
                        {"comment", criterion.comment}});
  }
  return {{"criteria", std::move(criteria)}};
}

// Any version of an exercise of which the caller sees the newest.
Result<ExerciseRow> VisibleExercise(const Call& call) {
  Result<ExerciseRow> row = call.store.ExerciseById(call.id);
  if (!row.ok()) return row;
  Result<std::vector<ExerciseRow>> visible = VisibleExercises(call);
  if (!visible.ok()) return visible.status();
  bool seen = std::any_of(visible->begin(), visible->end(),
                          [&](const ExerciseRow& other) { return other.name == row->name; });
  if (!seen) return Status{Code::kNotFound, "there is no such exercise", "id"};
  return row;
}

json::array NumbersJson(const scene::DeviceProfile& profile) {
  struct Number {
    const char* name;
    const char* unit;
    const scene::Sourced& sourced;
  };
  const Number numbers[] = {
      {"resolution", "nm", profile.resolution_nm},
      {"max_stiffness", "mN/mm", profile.max_stiffness_mn_per_mm},
      {"coupling", "mN/mm", profile.coupling_mn_per_mm},
      {"damping", "mN s/m", profile.damping_mn_s_per_m},
      {"friction", "mN", profile.friction_mn},
      {"mass", "g", profile.mass_g},
      {"peak_force", "mN", profile.peak_force_mn},
      {"continuous_force", "mN", profile.continuous_force_mn},
      {"rate", "Hz", profile.rate_hz},
      {"bus_delay", "ticks", profile.bus_delay_ticks},
      {"workspace_radius", "um", profile.workspace_radius_um},
  };
  json::array out;
  for (const Number& number : numbers) {
    out.push_back({{"name", number.name},
                   {"value", number.sourced.value},
                   {"unit", number.unit},
                   {"source", number.sourced.source}});
  }
  return out;
}

}  // namespace

Response ListExercises(const Call& call) {
  Result<std::vector<ExerciseRow>> rows = VisibleExercises(call);
  if (!rows.ok()) return ErrorResponse(rows.status());
  Result<std::map<Uuid, int>> attempts = OwnAttempts(call);
  if (!attempts.ok()) return ErrorResponse(attempts.status());
  json::array exercises;
  for (const ExerciseRow& row : *rows) {
    Result<scene::Exercise> exercise = Document(call.store, row);
    if (!exercise.ok()) return ErrorResponse(Status{Code::kInternal, exercise.status().message()});
    Result<json::object> summary = SummaryJson(call, row, *exercise, *attempts);
    if (!summary.ok()) return ErrorResponse(summary.status());
    exercises.push_back(std::move(*summary));
  }
  return JsonResponse({{"exercises", std::move(exercises)}});
}

Response GetExercise(const Call& call) {
  Result<ExerciseRow> row = VisibleExercise(call);
  if (!row.ok()) return ErrorResponse(row.status());
  Result<std::map<Uuid, int>> attempts = OwnAttempts(call);
  if (!attempts.ok()) return ErrorResponse(attempts.status());
  Result<scene::Exercise> exercise = Document(call.store, *row);
  if (!exercise.ok()) return ErrorResponse(Status{Code::kInternal, exercise.status().message()});
  Result<json::object> out = SummaryJson(call, *row, *exercise, *attempts);
  if (!out.ok()) return ErrorResponse(out.status());
  out->emplace("target", TargetJson(exercise->target));
  out->emplace("rubric", RubricJson(exercise->rubric));
  return JsonResponse(std::move(*out));
}

Response ListProfiles(const Call& call) {
  Result<std::vector<ProfileRow>> rows = call.store.Profiles();
  if (!rows.ok()) return ErrorResponse(rows.status());
  json::array profiles;
  for (const ProfileRow& row : *rows) {
    Result<Bytes> bytes = call.store.GetBlob(row.content);
    if (!bytes.ok()) return ErrorResponse(Status{Code::kInternal, bytes.status().message()});
    Result<scene::DeviceProfile> profile = scene::ProfileFromJson(AsText(*bytes));
    if (!profile.ok()) return ErrorResponse(Status{Code::kInternal, profile.status().message()});
    profiles.push_back(
        {{"name", row.name}, {"title", row.title}, {"numbers", NumbersJson(*profile)}});
  }
  return JsonResponse({{"profiles", std::move(profiles)}});
}

}  // namespace enamel::server::http
