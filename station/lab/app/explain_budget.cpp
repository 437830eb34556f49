#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>

#include "common/import/scene_folder.h"
#include "common/scene/plan.h"
#include "common/scene/rate.h"
#include "station/lab/app/explain_steps.h"
#include "station/lab/cutting/force_error.h"
#include "station/lab/report/report.h"
#include "station/lab/suites/joint_front.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

class Budget {
 public:
  Budget(const ExplainCommand& options, const Explained& subject, const StepCost& base)
      : options_(options), s_(subject), base_(base), budget_us_(*options.budget_us) {}

  Status Decide(json::object& out) {
    out["budget_us"] = budget_us_;
    ENAMEL_RETURN_IF_ERROR(MeasureFront());
    EndProgress();
    Print(out);
    Status practice = Pick(out);
    return s_.exercise.graded ? DecideGraded(out) : practice;
  }

 private:
  // A graded exercise fixes everything: the question is whether this machine can run it, and what is picked is for
  // practice of it.
  Status DecideGraded(json::object& out) {
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
                    std::string(text) + ": this machine cannot carry it. Use a faster one" +
                        (out.at("picked").is_null() ? "" : ", or practise with what is picked"),
                    "budget_us");
    }
    std::printf("%s: it fits.\n", text);
    return Status::Ok();
  }

  // The scene at each voxel, coarse to fine, as long as it has room and its ticks are not hopeless.
  std::vector<std::pair<int32_t, std::shared_ptr<cutting::Volume>>> Volumes() {
    std::set<int32_t, std::greater<>> sizes = {s_.built.scene.voxel_nm};
    // An imported scene has one size; a built-in one can be made in any.
    if (options_.scene.starts_with(import::kBuiltin))
      sizes.insert({200'000, 100'000, 50'000, 25'000});
    std::vector<std::pair<int32_t, std::shared_ptr<cutting::Volume>>> out;
    for (int32_t nm : sizes) {
      ShowProgress("voxels of " + std::to_string(nm / 1000) + " um");
      auto built = LoadAt(options_, nm);
      if (!built.ok()) continue;  // more memory than allowed
      const CutWay way = MakeCutWay(s_.params, s_.exercise.target, kTicks);
      // Finer ones cost more, so the search ends here.
      const bool last = MeasureSteps(s_.params, built->volume, way, 1).mean_us > 4 * budget_us_;
      out.emplace_back(nm, std::make_shared<cutting::Volume>(std::move(built->volume)));
      if (last) break;
    }
    return out;
  }

  // The exercise with the default law on this device at another rate; none where the plan refuses it.
  std::optional<core::CoreParams> ParamsAt(double rate_hz) const {
    scene::Exercise e = s_.exercise;
    e.law = haptics::kDefaultLaw;
    e.rate_hz = static_cast<int32_t>(rate_hz);
    scene::DeviceProfile profile = s_.profile;
    if (e.rate_hz > profile.rate_hz.value) {
      auto faster = scene::AtRate(profile, e.rate_hz);
      if (!faster.ok()) return {};
      profile = *faster;
    }
    auto params = scene::CompilePlan(s_.built.scene, e, profile);
    if (!params.ok()) return {};
    return *params;
  }

  TimedCase TicksOf(std::shared_ptr<cutting::Volume> volume, const DeviceModel& at) const {
    const std::optional<core::CoreParams> params = ParamsAt(at.rate_hz);
    if (!params) return {};
    auto way = std::make_shared<CutWay>(MakeCutWay(*params, s_.exercise.target, kTicks));
    return {[p = *params, volume = std::move(volume), way] {
      const StepCost c = MeasureSteps(p, *volume, *way, kRunsOfRound);
      return Spread{c.mean_us, c.p99_us};
    }};
  }

  Status MeasureFront() {
    ENAMEL_ASSIGN_OR_RETURN(auto model, ModelOf(s_.profile));
    // Beyond the device's own loop nothing can be picked: one faster rate says what it would buy. The core leaves the
    // estimator to the law.
    JointAxes axes = FrontAxes(model, {1.0 * s_.exercise.rate_hz, 2 * model.rate_hz}, {});
    for (auto& [nm, volume] : Volumes()) {
      double off = 0;
      for (const cutting::Bur& bur : core::BursOf(s_.params)) {
        off = std::max(off, MeasureForceError(bur, nm));
      }
      axes.voxels.push_back({nm, off, [this, volume = volume](const DeviceModel& at) {
                               return TicksOf(volume, at);
                             }});
    }
    axes.planned_voxel_nm = s_.built.scene.voxel_nm;
    axes.planned_rate_hz = s_.exercise.rate_hz;
    axes.planned_law = s_.exercise.law;
    points_ = MeasureJointFront(axes, [](const char* what, size_t done, size_t all) {
      if (done == all) ShowProgress(what);
    });
    return Status::Ok();
  }

  void Print(json::object& out) const {
    const JointPoint* planned = nullptr;
    std::printf(
        "\nvoxel um  rate Hz  law                   tick us, mean and p99      felt error %%\n");
    json::array all;
    for (const JointPoint& p : points_) {
      all.push_back(JointPointJson(p));
      if (p.is_default) planned = &p;
      // Beyond the device's own loop: what it would buy is said below.
      if (!p.is_default && !(p.on_front && p.runs)) continue;
      std::printf("%8.0f %8.0f  %-20s %12.1f %12.1f %17.2f%s\n", p.voxel_nm * 1e-3, p.rate_hz,
                  p.law.Name().c_str(), p.tick.mean_us.value, p.tick.p99_us.value,
                  100 * p.felt_error, p.is_default ? "  as planned" : "");
    }
    std::printf(
        "%zu combinations; shown: of the front of those with a proof what this device's loop "
        "carries.\n"
        "Felt: a hand of 1 N/mm that works a surface, B 6.5 N s/mm, against an ideal tool, as "
        "'qualify\n"
        "--suite front' measures it.\n",
        points_.size());
    if (planned != nullptr) std::printf("%s\n", NextHalvings(points_, *planned).c_str());
    out["points"] = std::move(all);
  }

  Status Pick(json::object& out) const {
    const JointPoint* best = BestWithin(points_, budget_us_);
    if (best != nullptr) {
      std::printf("\nfor practice within %.1f us: %s\n", budget_us_,
                  WhyBest(points_, *best, budget_us_).c_str());
      if (!best->is_default) std::printf("%s\n", NextHalvings(points_, *best).c_str());
      out["picked"] = JointPointJson(*best);
      return Status::Ok();
    }
    out["picked"] = nullptr;
    double least = 1e12;
    for (const JointPoint& p : points_)
      if (p.proved && p.runs) least = std::min(least, p.tick.p99_us.value);
    return Status(Code::kUnavailable,
                  "no voxel size, law and rate fits a tick of " + std::to_string(budget_us_) +
                      " us on this machine: the least measured is " + std::to_string(least) + " us",
                  "budget_us");
  }

  const ExplainCommand& options_;
  const Explained& s_;
  const StepCost& base_;
  const double budget_us_;
  std::vector<JointPoint> points_;
};

}  // namespace

Status DecideBudget(const ExplainCommand& options, const Explained& subject, const StepCost& base,
                    json::object& out) {
  return Budget(options, subject, base).Decide(out);
}

}  // namespace enamel::station::lab
