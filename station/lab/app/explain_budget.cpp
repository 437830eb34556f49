#include <algorithm>
#include <cstdio>

#include "common/haptics/force_law.h"
#include "common/import/scene_folder.h"
#include "common/scene/plan.h"
#include "station/lab/app/explain_steps.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

struct VoxelPoint {
  int32_t voxel_nm;
  StepCost cost;
  double mb;
};
struct LawPoint {
  const haptics::LawEntry* law;
  int32_t rate_hz;
  double force_error_n;
  double more_us;  // a tick's mean against the exercise's own law
  bool passive;    // anchored laws are, by the coupling's proof; only they are picked
};

class Budget {
 public:
  Budget(const ExplainCommand& options, const Explained& subject, const StepCost& base)
      : options_(options), s_(subject), base_(base), budget_us_(*options.budget_us) {}

  Status Decide(json::object& out) {
    out["budget_us"] = budget_us_;
    if (s_.exercise.graded) return DecideGraded(out);
    MeasureVoxels();
    MeasureLaws();
    EndProgress();
    Print(out);
    return Pick(out);
  }

 private:
  // A graded exercise fixes everything: the only question is whether this machine can run it.
  Status DecideGraded(json::object& out) {
    EndProgress();
    double period_us = 1e6 / s_.exercise.rate_hz;
    // By p99, not the mean: the hand feels a tick that is occasionally late.
    bool fits = base_.p99_us <= std::min(budget_us_, period_us);
    out["graded"] = true;
    out["fits"] = fits;
    char text[400];
    std::snprintf(text, sizeof text,
                  "exercise '%s' is graded: voxel %.0f um, law and rate (%d Hz) are fixed; "
                  "99 %% of its ticks take %.1f us here, the budget is %.1f us",
                  s_.exercise.name.c_str(), s_.built.scene.voxel_nm * 1e-3, s_.exercise.rate_hz,
                  base_.p99_us, std::min(budget_us_, period_us));
    if (!fits) {
      return Status(Code::kUnavailable,
                    std::string(text) +
                        ": this machine cannot carry it. Use a faster one, or practise on a "
                        "coarser scene",
                    "budget_us");
    }
    std::printf("%s: it fits.\n", text);
    return Status::Ok();
  }

  void MeasureVoxels() {
    std::vector<int32_t> sizes = {s_.built.scene.voxel_nm};
    // An imported scene has one size; a built-in one can be made in any.
    if (options_.scene.starts_with(import::kBuiltin)) sizes = {200'000, 100'000, 50'000, 25'000};
    for (int32_t nm : sizes) {
      ShowProgress("voxels of " + std::to_string(nm / 1000) + " um");
      auto built = LoadAt(options_, nm);
      if (!built.ok()) continue;  // more memory than allowed
      double mb = static_cast<double>(built->volume.MemoryBytes()) * 1e-6;
      CutWay way = MakeCutWay(s_.params, s_.exercise.target, kTicks);
      voxels_.push_back({nm, MeasureSteps(s_.params, built->volume, way, kReplays), mb});
      // Finer ones cost more, so the search ends here.
      if (voxels_.back().cost.p99_us > 4 * budget_us_) break;
    }
  }

  void MeasureLaws() {
    for (int32_t rate : {1'000, 2'000, 4'000}) {
      // The profile's rate is the device's own: nothing reads it faster.
      if (rate > s_.profile.rate_hz.value) continue;
      for (const haptics::LawEntry& law : haptics::ForceLaws()) {
        ShowProgress(std::string(law.name) + " at " + std::to_string(rate) + " Hz");
        scene::Exercise e = s_.exercise;
        e.law = law.kind;
        e.rate_hz = rate;
        auto params = scene::CompilePlan(s_.built.scene, e, s_.profile);
        if (!params.ok()) continue;
        CutWay way = MakeCutWay(*params, e.target, kTicks);
        // Fewer replays than for a voxel: there are many laws and rates, and somebody waits.
        double mean = MeasureSteps(*params, s_.built.volume, way, 3).mean_us;
        laws_.push_back({&law, rate, ForceError_n(*params), mean - base_.mean_us,
                         law.make({law.kind, 1000, dvec3(1e-5)})->anchored()});
      }
    }
  }

  void Print(json::object& out) const {
    std::printf("\nvoxel um   tick mean us   p99 us      MB   removed mm3 (against the finest)\n");
    json::array voxels, laws;
    double finest = voxels_.empty() ? 0 : voxels_.back().cost.removed_mm3;
    for (const VoxelPoint& v : voxels_) {
      double error = finest > 0 ? 100 * (v.cost.removed_mm3 / finest - 1) : 0;
      std::printf("%8.0f %14.1f %8.1f %7.1f   %.4f (%+.2f %%)\n", v.voxel_nm * 1e-3, v.cost.mean_us,
                  v.cost.p99_us, v.mb, v.cost.removed_mm3, error);
      voxels.push_back(json::object{{"voxel_nm", v.voxel_nm},
                                    {"mean_us", v.cost.mean_us},
                                    {"p99_us", v.cost.p99_us},
                                    {"mb", v.mb},
                                    {"removed_mm3", v.cost.removed_mm3},
                                    {"removed_error_percent", error}});
    }
    std::printf(
        "\nlaw                  rate Hz   force error N   tick us against the exercise's   "
        "passive\n");
    for (const LawPoint& l : laws_) {
      std::printf("%-20s %7d %15.4f %+30.2f   %s\n", std::string(l.law->name).c_str(), l.rate_hz,
                  l.force_error_n, l.more_us, l.passive ? "yes" : "not proved");
      laws.push_back(json::object{{"law", l.law->name},
                                  {"rate_hz", l.rate_hz},
                                  {"force_error_n", l.force_error_n},
                                  {"more_us", l.more_us},
                                  {"passive", l.passive}});
    }
    out["voxels"] = std::move(voxels);
    out["laws"] = std::move(laws);
  }

  // The finest voxel first, then the smallest force error of a law that cannot release energy.
  Status Pick(json::object& out) const {
    for (auto v = voxels_.rbegin(); v != voxels_.rend(); ++v) {
      const LawPoint* best = nullptr;
      for (const LawPoint& l : laws_) {
        // Adds a law's cost to the voxel's: measuring each pair would take minutes.
        bool fits =
            v->cost.p99_us + std::max(l.more_us, 0.0) <= std::min(budget_us_, 1e6 / l.rate_hz);
        if (fits && l.passive && (best == nullptr || l.force_error_n < best->force_error_n))
          best = &l;
      }
      if (best == nullptr) continue;
      std::printf(
          "\nfor practice within %.1f us: voxels of %.0f um, law %s, %d Hz. The finest voxel whose "
          "slowest\nhundredth of ticks fits, then the law and rate with the smallest force "
          "error.\n",
          budget_us_, v->voxel_nm * 1e-3, std::string(best->law->name).c_str(), best->rate_hz);
      out["picked"] = json::object{
          {"voxel_nm", v->voxel_nm}, {"law", best->law->name}, {"rate_hz", best->rate_hz}};
      return Status::Ok();
    }
    out["picked"] = nullptr;
    double least = 1e12;
    for (const VoxelPoint& v : voxels_) least = std::min(least, v.cost.p99_us);
    return Status(Code::kUnavailable,
                  "no voxel size, law and rate fits a tick of " + std::to_string(budget_us_) +
                      " us on this machine: the least measured is " + std::to_string(least) + " us",
                  "budget_us");
  }

  const ExplainCommand& options_;
  const Explained& s_;
  const StepCost& base_;
  const double budget_us_;
  std::vector<VoxelPoint> voxels_;  // coarse to fine
  std::vector<LawPoint> laws_;
};

}  // namespace

Status DecideBudget(const ExplainCommand& options, const Explained& subject, const StepCost& base,
                    json::object& out) {
  return Budget(options, subject, base).Decide(out);
}

}  // namespace enamel::station::lab
