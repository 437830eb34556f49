#include "common/scoring/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/import/prepared_tooth.h"
#include "common/scene/builder.h"
#include "common/scoring/score.h"
#include "common/scoring/trial.h"
#include "station/lab/grades/faults.h"

// The stated uncertainties against what other places in the grid do to the same cut.
namespace enamel::station::lab {
namespace {

// Four of the sixteen places of enamel-lab grades --offsets; all with ./check --full.
int Offsets() { return std::getenv("ENAMEL_FULL") != nullptr ? 16 : 4; }

TEST(UncertaintyTest, ARegistrationIsAsGoodAsAnImportAsksFor) {
  EXPECT_DOUBLE_EQ(scoring::kRegistration_m, import::kMaxRms_mm * 1e-3);
}

struct Seen {
  std::vector<double> values, stated;

  static double Mean(const std::vector<double>& of) {
    double sum = 0;
    for (const double v : of) sum += v;
    return sum / static_cast<double>(of.size());
  }
  double Scatter() const {
    double squares = 0;
    for (const double v : values) squares += (v - Mean(values)) * (v - Mean(values));
    return std::sqrt(squares / static_cast<double>(values.size() - 1));
  }
};

// The scene is filled finer where a gap is narrower than a voxel.
struct Scattered {
  const char* scene;
  const char* exercise;
  int32_t built_nm, voxel_nm;
  std::set<std::string> faults;
};

// By metric and fault.
using AllSeen = std::map<std::string, std::map<std::string, Seen>>;

class OtherGrids {
 public:
  explicit OtherGrids(const Scattered& asked)
      : built_(*scene::BuildBuiltinScene(asked.scene, asked.built_nm)), voxel_nm_(asked.voxel_nm) {
    for (const scene::Exercise& e : scene::BuiltinExercises(built_.scene, {})) {
      if (!e.name.starts_with(asked.exercise)) continue;
      exercise_ = e;
    }
    task_ = *TaskOf(built_, exercise_);
    coarse_ = *scene::BuildBuiltinScene(asked.scene, asked.voxel_nm);
    for (const Fault& fault : FaultsOf(coarse_, exercise_, task_, true)) {
      if (asked.faults.contains(fault.name)) faults_.push_back(fault);
    }
  }

  AllSeen Look() const {
    AllSeen out;
    for (int i = 0; i < Offsets(); ++i) LookIn(Moved(i), out);
    return out;
  }

 private:
  // Fills a cube of a voxel's size evenly, as enamel-lab grades --offsets does.
  cutting::Volume Moved(int i) const {
    constexpr dvec3 kSpread(0.8191725134, 0.6710436067, 0.5497004779);
    const dvec3 by_voxels = glm::fract(kSpread * static_cast<double>(i));
    cutting::GridSpec spec = built_.volume.spec();
    const int coarser = voxel_nm_ / spec.voxel_nm;
    spec.voxel_nm = voxel_nm_;
    for (int a = 0; a < 3; ++a) {
      spec.bricks[a] = (spec.bricks[a] + coarser - 1) / coarser;
      spec.origin_nm[a] += std::llround(by_voxels[a] * voxel_nm_);
    }
    return scene::BuildVolume(spec, [&](const dvec3& p) {
      return scene::FieldSample{built_.volume.DistanceAt_m(p), built_.volume.TissueAtPoint(p)};
    });
  }

  void LookIn(const cutting::Volume& initial, AllSeen& out) const {
    const cutting::Volume exact = CutAway(
        initial, [this](const dvec3& p) { return task_.Distance_m(p); }, Neighbours::kSpared);
    const scoring::CalmAttempts calm(initial, exact);
    const scoring::AcceptableCut r(initial, calm.exact(), {built_.scene.tooth, built_.scene.up});
    for (const Fault& fault : faults_) {
      const cutting::Volume attempt = CutAway(initial, fault.taken, fault.neighbours);
      const auto metrics = calm.Measure(built_.scene, exercise_, attempt, {},
                                        scoring::MetricPlan::For(exercise_.rubric));
      ASSERT_TRUE(metrics.ok()) << metrics.status().message();
      for (const scene::RubricCritical& c : exercise_.rubric.critical) {
        const auto m = std::ranges::find(metrics->values, c.metric, &scoring::MetricValue::name);
        if (m == metrics->values.end()) continue;
        ASSERT_TRUE(m->uncertainty) << c.metric;
        Seen& seen = out[c.metric][fault.name];
        seen.values.push_back(m->value), seen.stated.push_back(*m->uncertainty);
      }
      const auto cut = scoring::MeasureCut(r, attempt, exercise_.rubric);
      Seen& seen = out["points"][fault.name];
      seen.values.push_back(cut->cost.sum), seen.stated.push_back(cut->cost.uncertainty);
    }
  }

  const scene::BuiltScene built_;
  scene::BuiltScene coarse_;
  const int32_t voxel_nm_;
  scene::Exercise exercise_;
  Task task_;
  std::vector<Fault> faults_;
};

// A cut's figures scatter by no more than is stated, and what is stated is no wide guess: points and the contact scatter
// by a third of it.
TEST(UncertaintyTest, WhatOtherPlacesInTheGridDoIsWithinWhatIsStated) {
  std::vector<Scattered> asked = {
      {"molar", "crown", 100'000, 200'000, {"critical: cannot_seat", "critical: pulp_exposed"}}};
  const bool full = std::getenv("ENAMEL_FULL") != nullptr;
  if (full) {
    asked.push_back({"molar-class-2",
                     "class-2",
                     50'000,
                     100'000,
                     {"critical: contact_left", "critical: caries_left_deep",
                      "critical: gross_overextension", "neighbour cut"}});
  }
  std::map<std::string, double> most;  // scatter, as a share of what is stated
  for (const Scattered& each : asked) {
    for (const auto& [metric, by_fault] : OtherGrids(each).Look()) {
      for (const auto& [fault, seen] : by_fault) {
        const double stated = Seen::Mean(seen.stated), scatter = seen.Scatter();
        EXPECT_LE(scatter, stated) << metric << " of " << fault << ", " << Seen::Mean(seen.values);
        if (stated > 0) most[metric] = std::max(most[metric], scatter / stated);
      }
    }
  }
  EXPECT_GT(most["points"], 1. / 3);
  if (full) EXPECT_GT(most["contact_left_percent"], 1. / 3);
}

}  // namespace
}  // namespace enamel::station::lab
