#include "station/lab/grades/operators.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scoring/score.h"
#include "station/devices/operators.h"
#include "station/lab/grades/operator_run.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

constexpr uint64_t kMaxTicks = 3'000'000;  // fifty minutes: a timid hand's crown

struct CutTooth {
  cutting::Volume volume;
  surface::Mesh mesh;
  scoring::ProcessRecorder process;

  scoring::AttemptData Data(const cutting::Volume& initial) const {
    return {&initial, &volume, &mesh, &process};
  }
};

Result<CutTooth> CutBy(const OperatorPreset& preset, const scene::BuiltScene& built,
                       const scene::Exercise& exercise, const scene::DeviceProfile& profile,
                       uint64_t seed) {
  std::optional<scoring::ProcessRecorder> process;
  ENAMEL_ASSIGN_OR_RETURN(auto volume,
                          RunOperator(preset, built, exercise, profile, seed, kMaxTicks,
                                      [&](const core::CoreParams& params, const trace::Tick& tick) {
                                        if (!process) process.emplace(params);
                                        process->AddRecorded(tick);
                                      }));
  surface::Mesh mesh = surface::ExtractSurface(volume);
  return CutTooth{std::move(volume), std::move(mesh), std::move(*process)};
}

bool IsAskedFor(const OperatorsOptions& options, const std::string& name) {
  return options.exercises.empty() ||
         std::any_of(options.exercises.begin(), options.exercises.end(),
                     [&](const std::string& e) { return name.starts_with(e); });
}

// A coarse tooth has the same exercises.
Result<bool> HasAskedFor(const OperatorsOptions& options, const std::string& scene_name) {
  constexpr int32_t kCoarse_nm = 500'000;
  ENAMEL_ASSIGN_OR_RETURN(const auto coarse, scene::BuildBuiltinScene(scene_name, kCoarse_nm));
  return std::ranges::any_of(scene::BuiltinExercises(coarse.scene, {}), [&](const auto& exercise) {
    return IsAskedFor(options, exercise.name);
  });
}

// Whether the simulated person can plan it.
bool CanCut(const OperatorPreset& preset, const scene::BuiltScene& built,
            const scene::Exercise& exercise, const scene::DeviceProfile& profile) {
  const auto params = scene::CompilePlan(built.scene, exercise, profile);
  return params.ok() &&
         MakeSimulatedDevice(preset, built.scene, exercise, profile, *params, built.volume).ok();
}

// Of the people with a rank, those that the options ask for.
Result<std::vector<OperatorPreset>> People(const std::vector<std::string>& names) {
  std::vector<OperatorPreset> out;
  for (const OperatorPreset& preset : OperatorPresets()) {
    const bool asked = names.empty() || std::ranges::find(names, preset.name) != names.end();
    if (preset.rank != 0 && asked) out.push_back(preset);
  }
  if (!names.empty() && out.size() < names.size()) {
    return Status(Code::kNotFound,
                  "no simulated person with a rank has such a name: there are dentist, graduate, "
                  "student, fourth-year, third-year, second-year, first-year and untrained",
                  "operator");
  }
  return out;
}

class Study {
 public:
  Study(const OperatorsOptions& options, const std::function<void(const OperatorRow&)>& row,
        const std::function<void(const std::string&, double)>& progress)
      : options_(options), row_(row), progress_(progress) {}

  Status Run() {
    ENAMEL_ASSIGN_OR_RETURN(people_, People(options_.operators));
    const auto names = scene::BuiltinSceneNames();
    for (const std::string& device : options_.devices) {
      const auto all = scene::BuiltinProfiles();
      const auto profile =
          std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == device; });
      if (profile == all.end()) {
        return Status(Code::kNotFound, "no built-in device profile is named '" + device + "'",
                      "device");
      }
      profiles_.push_back(*profile);
    }
    for (size_t i = 0; i < names.size(); ++i) {
      done_ = static_cast<double>(i) / static_cast<double>(names.size());
      ENAMEL_ASSIGN_OR_RETURN(const bool asked, HasAskedFor(options_, names[i]));
      if (!asked) continue;
      ENAMEL_ASSIGN_OR_RETURN(const auto built,
                              scene::BuildBuiltinScene(names[i], options_.voxel_nm));
      for (const scene::Exercise& e :
           scene::BuiltinExercises(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))))) {
        if (!IsAskedFor(options_, e.name)) continue;
        ++asked_;
        if (!CanCut(*FindOperator("dentist"), built, e, profiles_.front())) {
          out_.not_cut.push_back(e.name);
          continue;
        }
        for (const auto& profile : profiles_) ENAMEL_RETURN_IF_ERROR(AddCell(built, e, profile));
      }
    }
    if (asked_ > 0) return Status::Ok();
    return Status(Code::kNotFound,
                  "no built-in exercise has such a name: 'enamel-station scenes' lists them",
                  "exercise");
  }
  OperatorsFindings Take() {
    out_.equal_skill = EqualSkillOf(out_.rows);
    return std::move(out_);
  }

 private:
  // All operators in one exercise on one device.
  Status AddCell(const scene::BuiltScene& built, const scene::Exercise& exercise,
                 const scene::DeviceProfile& profile) {
    const OperatorPreset* dentist = FindOperator("dentist");
    ENAMEL_CHECK(dentist != nullptr);
    Tell(exercise.name + ", " + profile.name + ", reference");
    ENAMEL_ASSIGN_OR_RETURN(const auto reference, CutBy(*dentist, built, exercise, profile, 0));
    const scoring::AcceptableCut r(built.volume, reference.volume,
                                   {built.scene.tooth, built.scene.up});
    std::vector<double> ranks, scores;
    for (const OperatorPreset& preset : people_) {
      if (!CanCut(preset, built, exercise, profile)) {
        out_.left_out.push_back({exercise.name, profile.name, std::string(preset.name)});
        continue;
      }
      for (uint64_t seed : options_.seeds) {
        Tell(exercise.name + ", " + profile.name + ", " + std::string(preset.name));
        ENAMEL_ASSIGN_OR_RETURN(const auto cut, CutBy(preset, built, exercise, profile, seed));
        ENAMEL_ASSIGN_OR_RETURN(
            auto metrics, scoring::ComputeMetrics(built.scene, exercise, cut.Data(built.volume),
                                                  reference.Data(built.volume)));
        ENAMEL_ASSIGN_OR_RETURN(auto judged, scoring::JudgeCut(r, cut.volume, exercise.rubric));
        ENAMEL_ASSIGN_OR_RETURN(const auto score, scoring::ApplyRubric(exercise.rubric, metrics,
                                                                       std::move(judged.measures)));
        out_.rows.push_back({exercise.name, profile.name, std::string(preset.name), preset.rank,
                             seed != 0 ? seed : preset.seed, score.critical_fail, score.score});
        if (row_) row_(out_.rows.back());
        ranks.push_back(preset.rank);
        scores.push_back(score.score);
      }
    }
    if (people_.size() > 1) {
      out_.order.push_back({exercise.name, profile.name, scores.size(), Spearman(ranks, scores)});
    }
    return Status::Ok();
  }
  void Tell(const std::string& what) const {
    if (progress_) progress_(what, done_);
  }

  const OperatorsOptions& options_;
  const std::function<void(const OperatorRow&)>& row_;
  const std::function<void(const std::string&, double)>& progress_;
  std::vector<scene::DeviceProfile> profiles_;
  std::vector<OperatorPreset> people_;
  OperatorsFindings out_;
  size_t asked_ = 0;
  double done_ = 0;
};

}  // namespace

double Spearman(const std::vector<double>& a, const std::vector<double>& b) {
  ENAMEL_CHECK(a.size() == b.size());
  auto ranks = [](const std::vector<double>& values) {
    std::vector<double> out;
    for (double v : values) {
      double below = 0, same = 0;
      for (double w : values) below += w < v, same += w == v;
      out.push_back(below + 0.5 * (same - 1));
    }
    return out;
  };
  const auto ra = ranks(a), rb = ranks(b);
  // The mean of ranks is the same on both sides.
  const double mean = 0.5 * (static_cast<double>(a.size()) - 1);
  double ab = 0, aa = 0, bb = 0;
  for (size_t i = 0; i < ra.size(); ++i) {
    ab += (ra[i] - mean) * (rb[i] - mean);
    aa += (ra[i] - mean) * (ra[i] - mean);
    bb += (rb[i] - mean) * (rb[i] - mean);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

std::vector<EqualSkill> EqualSkillOf(const std::vector<OperatorRow>& rows) {
  using Key = std::pair<std::string, std::string>;  // exercise, operator
  std::vector<Key> keys;
  std::map<Key, std::map<uint64_t, std::map<std::string, std::optional<double>>>> scores;
  std::set<std::string> devices;
  for (const OperatorRow& r : rows) {
    const Key key{r.exercise, r.name};
    if (!scores.contains(key)) keys.push_back(key);
    devices.insert(r.device);
    scores[key][r.seed][r.device] = r.critical_fail ? std::nullopt : std::optional(r.score);
  }
  std::vector<EqualSkill> out;
  if (devices.size() < 2) return out;
  for (const Key& key : keys) {
    std::map<std::string, double> sums;
    size_t seeds = 0;
    for (const auto& [seed, of_devices] : scores[key]) {
      const bool everywhere =
          of_devices.size() == devices.size() &&
          std::ranges::all_of(of_devices, [](const auto& s) { return s.second.has_value(); });
      if (!everywhere) continue;
      ++seeds;
      for (const auto& [device, score] : of_devices) sums[device] += *score;
    }
    if (seeds == 0) continue;
    const auto [least, most] =
        std::ranges::minmax_element(sums, {}, [](const auto& sum) { return sum.second; });
    out.push_back({key.first, key.second, seeds,
                   (most->second - least->second) / static_cast<double>(seeds)});
  }
  return out;
}

FullMarks FullMarksOf(const std::vector<OperatorRow>& rows, const std::string& name) {
  constexpr double kFull = 99.995;
  FullMarks out;
  for (const OperatorRow& row : rows) {
    if (row.name != name) continue;
    ++out.rows;
    out.full += row.score >= kFull ? 1 : 0;
  }
  return out;
}

Result<OperatorsFindings> MeasureOperators(
    const OperatorsOptions& options, const std::function<void(const OperatorRow&)>& row,
    const std::function<void(const std::string&, double)>& progress) {
  OperatorsOptions used = options;
  if (used.quick) {
    used.devices.resize(std::min<size_t>(1, used.devices.size()));
    used.seeds.resize(std::min<size_t>(1, used.seeds.size()));
  }
  Study study(used, row, progress);
  ENAMEL_RETURN_IF_ERROR(study.Run());
  return study.Take();
}

json::object OperatorsJson(const OperatorsFindings& findings) {
  json::array rows, order, equal, not_cut, left_out;
  for (const OperatorRow& r : findings.rows) {
    rows.push_back(json::object{{"exercise", r.exercise},
                                {"device", r.device},
                                {"operator", r.name},
                                {"rank", r.rank},
                                {"seed", r.seed},
                                {"critical_fail", r.critical_fail},
                                {"score", r.score}});
  }
  for (const SkillOrder& o : findings.order) {
    order.push_back(json::object{
        {"exercise", o.exercise}, {"device", o.device}, {"rows", o.rows}, {"value", o.spearman}});
  }
  for (const EqualSkill& e : findings.equal_skill) {
    equal.push_back(json::object{
        {"exercise", e.exercise}, {"operator", e.name}, {"seeds", e.seeds}, {"points", e.points}});
  }
  for (const std::string& name : findings.not_cut) not_cut.emplace_back(name);
  for (const LeftOut& l : findings.left_out) {
    left_out.push_back(
        json::object{{"exercise", l.exercise}, {"device", l.device}, {"operator", l.name}});
  }
  return {{"format", 1},
          {"rows", std::move(rows)},
          {"spearman", std::move(order)},
          {"equal_skill", std::move(equal)},
          {"not_cut", std::move(not_cut)},
          {"left_out", std::move(left_out)}};
}

}  // namespace enamel::station::lab
