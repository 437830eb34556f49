#include "common/cutting/sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace enamel::cutting {
namespace {

constexpr double kVoxel_m = 50e-6, kReach = 5e-3, kTolerance = kVoxel_m / 32;

std::vector<Pose> CutOf(const std::vector<Pose>& path) {
  Sweep sweep(kVoxel_m, kReach);
  std::vector<Pose> cut;
  for (const Pose& p : path) {
    for (const Pose& due : sweep.Move(p)) cut.push_back(due);
  }
  for (const Pose& due : sweep.Flush()) cut.push_back(due);
  return cut;
}

double ToSegment(const dvec3& p, const dvec3& a, const dvec3& b) {
  dvec3 d = b - a;
  double t = glm::dot(d, d) > 0 ? glm::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0) : 0;
  return glm::length(p - a - t * d);
}

// Every pose of the path is within the tolerance of the way through the poses that are cut, and
// those are no more than half a voxel and a step apart.
void ExpectCovered(const std::vector<Pose>& path, double step_m) {
  std::vector<Pose> cut = CutOf(path);
  ASSERT_FALSE(cut.empty());
  for (const Pose& p : path) {
    double nearest = glm::length(p.tip_m - cut[0].tip_m);
    for (size_t i = 0; i + 1 < cut.size(); ++i) {
      nearest = std::min(nearest, ToSegment(p.tip_m, cut[i].tip_m, cut[i + 1].tip_m));
    }
    ASSERT_LE(nearest, 1.5 * kTolerance);
  }
  for (size_t i = 0; i + 1 < cut.size(); ++i) {
    EXPECT_LE(glm::length(cut[i + 1].tip_m - cut[i].tip_m),
              Sweep::SpanOf(kVoxel_m) + step_m + 1e-12);
  }
}

TEST(SweepTest, StraightWayIsCutEveryHalfVoxel) {
  std::vector<Pose> path;
  for (int i = 0; i <= 1000; ++i) path.push_back({dvec3(i * 0.1 * kVoxel_m, 0, 0), Quat{}});
  ExpectCovered(path, 0.1 * kVoxel_m);
  EXPECT_LT(CutOf(path).size(), 260u);
}

TEST(SweepTest, NothingOfATurningPathIsLeftOut) {
  for (double step : {0.01, 0.1, 0.3}) {
    std::vector<Pose> spiral, zigzag, tremor;
    for (int i = 0; i <= 3000; ++i) {
      double t = i * step * 0.05, along = i * step * kVoxel_m;
      spiral.push_back(
          {dvec3(std::cos(t), std::sin(t), 0.02 * t) * (0.5 * kVoxel_m * (1 + 0.05 * t)), Quat{}});
      double saw = std::fabs(std::remainder(i * step, 2.6)) * kVoxel_m;
      zigzag.push_back({dvec3(saw, 0.1 * along, 0), Quat{}});
      tremor.push_back({dvec3(along * 0.2, 0.2 * kVoxel_m * std::sin(i * 0.7), 0), Quat{}});
    }
    ExpectCovered(spiral, 2 * kVoxel_m);
    ExpectCovered(zigzag, 2 * kVoxel_m);
    ExpectCovered(tremor, 2 * kVoxel_m);
  }
}

TEST(SweepTest, BurThatStaysIsCutAndThenNoMore) {
  std::vector<Pose> path(1, Pose{});
  for (int i = 0; i < 500; ++i) path.push_back({dvec3(0.2 * kVoxel_m, 0, 0), Quat{}});
  std::vector<Pose> cut = CutOf(path);
  ASSERT_EQ(cut.size(), 2u);
  EXPECT_EQ(cut[1].tip_m, path.back().tip_m);
}

TEST(SweepTest, TurnOfTheBurCountsLikeAMove) {
  std::vector<Pose> path;
  for (int i = 0; i <= 200; ++i) path.push_back({dvec3(0), Quat{i * 1e-4, 0, 0, 1}.Normalised()});
  // 0.04 rad at 5 mm is 4 voxels: some eight cuts and more.
  EXPECT_GE(CutOf(path).size(), 8u);
}

TEST(SweepTest, NoMoveMakesMoreThanItsMostCutsDue) {
  Sweep sweep(kVoxel_m, kReach);
  for (int i = 0; i < 20000; ++i) {
    double wild = (i * 7919 % 1000) * 1e-3;
    auto due = sweep.Move(
        {dvec3(0.4 * wild, 0.3 * std::sin(i * 0.9), 0.1 * std::cos(i * 2.3)) * kVoxel_m, Quat{}});
    ASSERT_LE(due.size(), Sweep::kMaxDue);
  }
}

}  // namespace
}  // namespace enamel::cutting
