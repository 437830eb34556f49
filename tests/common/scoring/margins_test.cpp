#include "common/scoring/margins.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/scene/builder.h"
#include "common/scoring/metrics.h"
#include "common/scoring/task.h"
#include "tests/common/scoring/synthetic_cavity.h"

// A box of 3 x 2.4 mm and 2 mm depth in a flat block, its line angles round and its walls leaning,
// in closed form.
namespace enamel::scoring {
namespace {

constexpr double kHalfX_mm = 1.5, kHalfY_mm = 1.2, kDepth_mm = 2;

struct Box {
  double round_mm = 0;          // of the floor's edges
  double opens_deg = 0;         // all walls
  double mesial_opens_deg = 0;  // the mesial one besides
  bool cut = true;
};

double Distance_mm(const Box& box, const dvec3& p) {
  const double block = std::max({std::fabs(p.x) - 3.5, std::fabs(p.y) - 3.0, p.z, -4.0 - p.z});
  if (!box.cut) return block;
  auto wall = [&](double out, double deg) {
    const double slope = std::tan(deg * std::numbers::pi / 180);
    return (out - slope * (p.z + kDepth_mm)) / std::sqrt(1 + slope * slope);
  };
  const double side = std::max({wall(p.x - kHalfX_mm, box.opens_deg + box.mesial_opens_deg),
                                wall(-p.x - kHalfX_mm, box.opens_deg),
                                wall(std::fabs(p.y) - kHalfY_mm, box.opens_deg)});
  const double floor = -p.z - kDepth_mm, r = box.round_mm;
  // The round touches both planes, whose outward directions are this far from upright to each
  // other.
  const double c = std::sin(box.opens_deg * std::numbers::pi / 180);
  const double a = side + r, b = floor + r;
  double hollow = std::max(side, floor);
  if (a > b * c && b > a * c) {
    hollow = std::sqrt((a * a + b * b - 2 * a * b * c) / (1 - c * c)) - r;
  }
  return std::max(block, -hollow);
}

struct Made {
  cutting::Volume volume;
  surface::Mesh mesh;
  ProcessRecorder process = StraightRecording(200, 1, 1);

  AttemptData Data(const cutting::Volume& initial) const {
    return {&initial, &volume, &mesh, &process};
  }
};

cutting::Volume Filled(const Box& box, int32_t voxel_nm) {
  cutting::GridSpec spec;
  spec.voxel_nm = voxel_nm;
  spec.origin_nm = {-4'013'000, -3'507'000, -4'519'000};
  const double side = cutting::kBrickSide * voxel_nm * 1e-6;
  spec.bricks = ivec3(static_cast<int>(8.1 / side) + 1, static_cast<int>(7.1 / side) + 1,
                      static_cast<int>(5.1 / side) + 1);
  return scene::BuildVolume(spec, [&](const dvec3& p) -> scene::FieldSample {
    return {Distance_mm(box, p * 1e3) * 1e-3, cutting::Tissue::kDentin};
  });
}

class MarginsTest : public testing::TestWithParam<int32_t> {
 protected:
  Made Make(const Box& box) const {
    Made out{Filled(box, GetParam()), {}};
    out.mesh = surface::ExtractSurface(out.volume);
    return out;
  }
  MetricSet Measure(const Made& attempt, const Made& reference) const {
    scene::Rubric rubric;
    for (const char* name : {"line_angle_radius_mm", "cavosurface_deg", "cavosurface_off_deg"}) {
      rubric.criteria.push_back({name, "", "", 1, {}, "", {}});
    }
    auto out = ComputeMetrics(BlockScene(), BlockExercise(), attempt.Data(initial_),
                              reference.Data(initial_), {}, MetricPlan::For(rubric));
    EXPECT_TRUE(out.ok()) << out.status().message();
    return *out;
  }
  double voxel_mm() const { return GetParam() * 1e-6; }

  const cutting::Volume initial_ = Filled({.cut = false}, GetParam());
  const Made reference_ = Make({});
};

double Solid_mm3(const cutting::Volume& volume) {
  return cutting::SolidVolume_m3(volume)[static_cast<size_t>(cutting::Tissue::kDentin)] * 1e9;
}

// Solid that rounds of this radius leave along the edges of the box: at every height the cut is a
// rectangle that is smaller all around.
double LeftByRounds_mm3(double radius_mm) {
  double sum = 0;
  constexpr int kSteps = 2000;
  for (int i = 0; i < kSteps; ++i) {
    const double up = radius_mm * (i + 0.5) / kSteps, d = radius_mm - up;
    const double in = radius_mm - std::sqrt(radius_mm * radius_mm - d * d);
    sum += 4 * (kHalfX_mm * kHalfY_mm - (kHalfX_mm - in) * (kHalfY_mm - in)) * radius_mm / kSteps;
  }
  return sum;
}

TEST_P(MarginsTest, RadiusOfLineAnglesIsThatOfTheRoundAndOfWhatItLeaves) {
  const double sharp_mm3 = Solid_mm3(reference_.volume);
  for (double radius : {0.2, 0.3, 0.4}) {
    const Made round = Make({.round_mm = radius});
    const double found = ValueOf(Measure(round, reference_), "line_angle_radius_mm");
    EXPECT_NEAR(found, radius, voxel_mm()) << radius;
    // A second way: the radius whose rounds leave as much as was left.
    const double left = Solid_mm3(round.volume) - sharp_mm3;
    double lo = 0, hi = 1;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (lo + hi);
      (LeftByRounds_mm3(middle) < left ? lo : hi) = middle;
    }
    EXPECT_NEAR(found, lo, voxel_mm());
  }
  EXPECT_LT(ValueOf(Measure(reference_, reference_), "line_angle_radius_mm"), voxel_mm());
}

TEST_P(MarginsTest, RadiusDoesNotDependOnHowTheWallsLean) {
  const Made leaning = Make({.round_mm = 0.4, .opens_deg = 15});
  EXPECT_NEAR(ValueOf(Measure(leaning, reference_), "line_angle_radius_mm"), 0.4, voxel_mm());
}

// Mean angle of the walls' normals to the level between two depths: of the mesh, where the metric
// reads the volume.
double MeshMargin_deg(const surface::Mesh& mesh) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    const auto& p = mesh.position_m[i];
    const bool corner = std::fabs(std::fabs(p.x) * 1e3 - kHalfX_mm) < 0.8 &&
                        std::fabs(std::fabs(p.y) * 1e3 - kHalfY_mm) < 0.8;
    if (p.z > -0.4e-3 || p.z < -1.2e-3 || std::fabs(p.x) > 2.8e-3 || std::fabs(p.y) > 2.6e-3 ||
        corner) {
      continue;
    }
    sum += 90 + std::asin(mesh.normal[i].z) * 180 / std::numbers::pi;
    ++count;
  }
  return sum / count;
}

TEST_P(MarginsTest, MarginOpensAsTheWallsDo) {
  for (double deg : {-10.0, -5.0, 0.0, 5.0, 20.0}) {
    const Made made = Make({.opens_deg = deg});
    const MetricSet metrics = Measure(made, reference_);
    EXPECT_NEAR(ValueOf(metrics, "cavosurface_deg"), 90 + deg, 0.5) << deg;
    EXPECT_NEAR(ValueOf(metrics, "cavosurface_deg"), MeshMargin_deg(made.mesh), 0.5) << deg;
    // Where two undercut walls meet, their edge leans by up to the root of 2 more.
    const double off = ValueOf(metrics, "cavosurface_off_deg"), edge = deg < 0 ? std::sqrt(2.0) : 1;
    EXPECT_GT(off, std::fabs(deg) - 1.5) << deg;
    EXPECT_LT(off, edge * std::fabs(deg) + 1.5) << deg;
  }
}

TEST_P(MarginsTest, OneWallThatLeansIsTheWorst) {
  const MetricSet metrics = Measure(Make({.mesial_opens_deg = 20}), reference_);
  EXPECT_NEAR(ValueOf(metrics, "cavosurface_deg"), 90, 0.5);
  EXPECT_NEAR(ValueOf(metrics, "cavosurface_off_deg"), 20, 1.5);
}

TEST_P(MarginsTest, AnUntouchedBlockHasNeitherAndTheReferenceIsNowhereOff) {
  const MetricSet none = Measure(Make({.cut = false}), reference_);
  for (const MetricValue& m : none.values) {
    EXPECT_FALSE(m.name.starts_with("cavosurface") || m.name.starts_with("line_angle")) << m.name;
  }
  EXPECT_EQ(ValueOf(Measure(reference_, reference_), "cavosurface_off_deg"), 0);
}

INSTANTIATE_TEST_SUITE_P(Voxels, MarginsTest, testing::Values(100'000, 60'000));

}  // namespace
}  // namespace enamel::scoring
