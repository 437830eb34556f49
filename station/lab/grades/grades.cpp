#include "station/lab/grades/grades.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>

#include "common/scene/json/json.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

bool IsAskedFor(const GradesOptions& options, const std::string& name) {
  return options.exercises.empty() ||
         std::any_of(options.exercises.begin(), options.exercises.end(),
                     [&](const std::string& e) { return name.starts_with(e); });
}

std::vector<scene::Exercise> AskedFor(const GradesOptions& options, const scene::Scene& scene) {
  auto out = scene::BuiltinExercises(scene, HashSha256(AsBytes(scene::ToJson(scene))));
  std::erase_if(out, [&](const scene::Exercise& e) { return !IsAskedFor(options, e.name); });
  return out;
}

// Looked up in coarse teeth, which are fast to build: the names are the same.
Result<std::vector<std::string>> ScenesAskedFor(const GradesOptions& options) {
  constexpr int32_t kCoarse_nm = 400'000;
  std::vector<std::string> out;
  for (const std::string& name : scene::BuiltinSceneNames()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto built, scene::BuildBuiltinScene(name, kCoarse_nm));
    if (!AskedFor(options, built.scene).empty()) out.push_back(name);
  }
  return out;
}

}  // namespace

bool GradeRow::AsKnown() const { return found && std::fabs(*found - size) <= tolerance; }

bool GradeRow::CostsEnough() const { return !must_cost || points_lost >= 1; }

bool GradeRow::CostsTooMuch() const { return may_cost && points_lost > *may_cost; }

GradedExercise::GradedExercise(const scene::BuiltScene& built, scene::Exercise exercise, Task task)
    : built_(&built),
      exercise_(std::move(exercise)),
      task_(std::move(task)),
      attempts_(built.volume,
                CutAway(
                    built.volume, [this](const dvec3& p) { return task_.Distance_m(p); },
                    Neighbours::kSpared)) {}

Result<GradedExercise> GradedExercise::Make(const scene::BuiltScene& built,
                                            scene::Exercise exercise) {
  ENAMEL_ASSIGN_OR_RETURN(Task task, TaskOf(built, exercise));
  return GradedExercise(built, std::move(exercise), std::move(task));
}

Result<scoring::ScoreResult> GradedExercise::Score(const Hollow& taken,
                                                   Neighbours neighbours) const {
  const cutting::Volume volume = CutAway(built_->volume, taken, neighbours);
  ENAMEL_ASSIGN_OR_RETURN(const auto metrics, attempts_.Measure(built_->scene, exercise_, volume));
  return scoring::ApplyRubric(exercise_.rubric, metrics);
}

Result<GradeRow> GradedExercise::Grade(const Fault& fault) const {
  ENAMEL_ASSIGN_OR_RETURN(const auto score, Score(fault.taken, fault.neighbours));
  GradeRow row;
  row.exercise = exercise_.name;
  row.fault = fault.name;
  row.size = fault.size;
  row.unit = fault.unit;
  row.voxel_mm = built_->scene.voxel_nm * 1e-6;
  row.metric = fault.metric;
  row.tolerance = fault.tolerance;
  row.must_cost = fault.must_cost;
  row.may_cost = fault.may_cost;
  for (const scoring::MetricValue& m : score.metrics) {
    if (m.name == fault.metric) row.found = m.value;
  }
  row.score = score.score;
  row.points_lost = 100 - score.score;
  row.critical_expected = fault.critical;
  for (const scoring::CriticalResult& c : score.critical) {
    if (row.critical.empty() || c.error == fault.critical) row.critical = c.error;
  }
  row.judged = JudgedOf(fault, exercise_.rubric, score);
  return row;
}

Result<std::vector<GradeRow>> MeasureGrades(
    const GradesOptions& options, const std::function<void(const GradeRow&)>& row,
    const std::function<void(const std::string&, double)>& progress) {
  std::vector<GradeRow> rows;
  std::vector<int32_t> voxels = options.voxels_nm;
  if (options.quick) voxels.resize(std::min<size_t>(1, voxels.size()));
  ENAMEL_ASSIGN_OR_RETURN(const auto names, ScenesAskedFor(options));
  double done = 0;
  for (int32_t voxel_nm : voxels) {
    for (const std::string& name : names) {
      auto tell = [&](const std::string& what, double part) {
        const auto all = static_cast<double>(voxels.size() * names.size());
        if (progress) progress(what, (done + part) / all);
      };
      tell(name, 0);
      ENAMEL_ASSIGN_OR_RETURN(const auto built, scene::BuildBuiltinScene(name, voxel_nm));
      const auto exercises = AskedFor(options, built.scene);
      for (size_t i = 0; i < exercises.size(); ++i) {
        ENAMEL_ASSIGN_OR_RETURN(const auto graded, GradedExercise::Make(built, exercises[i]));
        const auto faults = FaultsOf(built, exercises[i], graded.task(), options.quick);
        for (size_t k = 0; k < faults.size(); ++k) {
          tell(exercises[i].name + ", " + faults[k].name,
               (static_cast<double>(i) +
                static_cast<double>(k) / static_cast<double>(faults.size())) /
                   static_cast<double>(exercises.size()));
          ENAMEL_ASSIGN_OR_RETURN(rows.emplace_back(), graded.Grade(faults[k]));
          if (row) row(rows.back());
        }
      }
      done += 1;
    }
  }
  if (rows.empty()) {
    return Status(Code::kNotFound,
                  "no built-in exercise has such a name: 'enamel-station scenes' lists them",
                  "exercise");
  }
  return rows;
}

json::object GradesJson(const std::vector<GradeRow>& rows) {
  json::array out;
  for (const GradeRow& r : rows) {
    out.push_back(
        json::object{{"exercise", r.exercise},
                     {"fault", r.fault},
                     {"size", r.size},
                     {"unit", r.unit},
                     {"voxel_mm", r.voxel_mm},
                     {"metric", r.metric},
                     {"found", r.found ? json::value(*r.found) : json::value(nullptr)},
                     {"tolerance", r.tolerance},
                     {"points_lost", r.points_lost},
                     {"must_cost", r.must_cost},
                     {"may_cost", r.may_cost ? json::value(*r.may_cost) : json::value(nullptr)},
                     {"critical_expected", !r.critical_expected.empty()},
                     {"critical", !r.critical.empty()},
                     {"cause", r.judged.cause},
                     {"own_cause_share",
                      r.judged.own_share ? json::value(*r.judged.own_share) : json::value(nullptr)},
                     {"lost_for", json::value_from(r.judged.lost_for)},
                     {"said_fault", r.judged.said_fault},
                     {"said_remedy", r.judged.said_remedy},
                     {"score", r.score}});
  }
  return {{"format", 1}, {"rows", std::move(out)}};
}

}  // namespace enamel::station::lab
