#include "station/lab/grades/grades.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>

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

bool GradeRow::CostsEnough() const { return !must_cost || borderline || points_lost >= 1; }

bool GradeRow::CostsTooMuch() const { return may_cost && points_lost > *may_cost; }

bool GradeRow::NamesItsMistake() const {
  return points_lost >= 1 && critical.empty() && !judged.expected.empty();
}

bool GradeRow::IsCrown() const {
  return exercise.starts_with("crown") || exercise.starts_with("veneer");
}

GradedExercise::GradedExercise(const scene::BuiltScene& built, scene::Exercise exercise, Task task)
    : built_(&built),
      exercise_(std::move(exercise)),
      task_(std::move(task)),
      attempts_(std::make_unique<scoring::CalmAttempts>(
          built.volume, CutAway(
                            built.volume, [this](const dvec3& p) { return task_.Distance_m(p); },
                            Neighbours::kSpared))),
      r_(std::make_unique<scoring::AcceptableCut>(
          built.volume, attempts_->exact(),
          scoring::ToothPlace{built.scene.tooth, built.scene.up})) {}

Result<GradedExercise> GradedExercise::Make(const scene::BuiltScene& built,
                                            scene::Exercise exercise) {
  ENAMEL_ASSIGN_OR_RETURN(Task task, TaskOf(built, exercise));
  return GradedExercise(built, std::move(exercise), std::move(task));
}

Result<scoring::ScoreResult> GradedExercise::ScoreOf(const cutting::Volume& attempt) const {
  ENAMEL_ASSIGN_OR_RETURN(const auto metrics,
                          attempts_->Measure(built_->scene, exercise_, attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto judged, scoring::JudgeCut(*r_, attempt, exercise_.rubric));
  return scoring::ApplyRubric(exercise_.rubric, metrics, std::move(judged.measures),
                              std::move(judged.found.mistakes));
}

Result<scoring::ScoreResult> GradedExercise::Score(const Hollow& taken,
                                                   Neighbours neighbours) const {
  return ScoreOf(CutAway(built_->volume, taken, neighbours));
}

Result<GradeRow> GradedExercise::Grade(const Fault& fault) const {
  const cutting::Volume attempt = CutAway(built_->volume, fault.taken, fault.neighbours);
  ENAMEL_ASSIGN_OR_RETURN(const auto score, ScoreOf(attempt));
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
  for (const scoring::CriticalResult& c : score.borderline) {
    if (c.error == fault.critical) row.critical = c.error, row.borderline = true;
  }
  row.judged = JudgedOf(fault, exercise_.name, *r_, attempt, score);
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

std::vector<std::string> CheaperThoughLarger(const std::vector<GradeRow>& rows) {
  constexpr double kVoxels_points = 0.05;
  std::vector<std::string> out;
  for (const GradeRow& a : rows) {
    for (const GradeRow& b : rows) {
      const bool same = a.exercise == b.exercise && a.fault == b.fault && a.metric == b.metric &&
                        a.voxel_mm == b.voxel_mm && (a.size > 0) == (b.size > 0);
      if (!same || std::fabs(b.size) <= std::fabs(a.size)) continue;
      if (b.points_lost >= a.points_lost - kVoxels_points) continue;
      char text[96];
      std::snprintf(text, sizeof text, "%g %s costs %.2f, %g costs %.2f", a.size, a.unit.c_str(),
                    a.points_lost, b.size, b.points_lost);
      out.push_back(a.exercise + ", " + a.fault + ": " + text);
    }
  }
  return out;
}

namespace {

json::array ExpectedJson(const Judged& judged) {
  json::array out;
  for (const ExpectedMistake& e : judged.expected) {
    out.push_back(json::object{{"kind", NameOf(e.kind)}, {"place", e.place}});
  }
  return out;
}

json::array FoundJson(const Judged& judged) {
  json::array out;
  for (const scoring::Mistake& m : judged.found) {
    out.push_back(json::object{{"kind", NameOf(m.kind)},
                               {"place", m.place},
                               {"size", m.size},
                               {"unit", UnitOf(m.kind)},
                               {"points", m.points}});
  }
  return out;
}

json::object TotalsJson(const std::vector<GradeRow>& rows) {
  struct Count {
    size_t right = 0, all = 0;
    json::object Json() const { return {{"right", right}, {"all", all}}; }
  };
  Count cavities, crowns, metrics, critical;
  size_t sentences = 0, wrong = 0;
  double sum_error = 0;
  for (const GradeRow& r : rows) {
    if (r.NamesItsMistake()) {
      Count& first = r.IsCrown() ? crowns : cavities;
      ++first.all;
      first.right += r.judged.FirstIsRight();
    }
    ++metrics.all, metrics.right += r.AsKnown();
    ++critical.all, critical.right += r.critical.empty() == r.critical_expected.empty();
    sentences += r.judged.sentences.said;
    wrong += r.judged.sentences.wrong.size();
    sum_error = std::max(sum_error, r.judged.sum_error);
  }
  return {{"first_mistakes_of_cavities", cavities.Json()},
          {"first_mistakes_of_crowns", crowns.Json()},
          {"found_by_their_metric", metrics.Json()},
          {"critical_as_made", critical.Json()},
          {"cheaper_though_larger", CheaperThoughLarger(rows).size()},
          {"sentences", sentences},
          {"sentences_false", wrong},
          {"sum_error", sum_error}};
}

}  // namespace

json::object GradesJson(const std::vector<GradeRow>& rows) {
  json::array out;
  for (const GradeRow& r : rows) {
    const auto own = r.judged.OwnShare();
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
                     {"mistakes_expected", ExpectedJson(r.judged)},
                     {"mistakes_found", FoundJson(r.judged)},
                     {"own_share", own ? json::value(*own) : json::value(nullptr)},
                     {"sentences", r.judged.sentences.said},
                     {"sentences_false", r.judged.sentences.wrong.size()},
                     {"sum_error", r.judged.sum_error},
                     {"score", r.score}});
  }
  return {{"format", 1}, {"totals", TotalsJson(rows)}, {"rows", std::move(out)}};
}

}  // namespace enamel::station::lab
