#include "common/scoring/movement/path_align.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

// A straight way along x, then along y, each 2 mm; `slow` takes twice the time on the second leg.
// `aside_mm`: its offset in z.
ProcessRecorder Corner(double aside_mm, bool slow) {
  ProcessRecorder recorder(SomeParams());
  auto put = [&](double x_mm, double y_mm) {
    trace::Tick tick;
    tick.witness.anchor_100nm = {static_cast<int32_t>(std::lround(x_mm * 1e4)),
                                 static_cast<int32_t>(std::lround(y_mm * 1e4)),
                                 static_cast<int32_t>(std::lround(aside_mm * 1e4))};
    tick.witness.force_computed_mn[2] = 1000;
    recorder.AddRecorded(tick);
  };
  for (int i = 0; i < 2000; ++i) put(i * 1e-3, 0);
  const int ticks = slow ? 4000 : 2000;
  for (int i = 0; i <= ticks; ++i) put(2, i * 2.0 / ticks);
  return recorder;
}

TEST(PathAlignTest, AlongItsWayASlowPathIsTheSamePath) {
  const ProcessRecorder reference = Corner(0, false), attempt = Corner(0.3, true);
  const PathPair paths = ResampleAlike(attempt, reference, PathBy::kArcLength);
  // 4 mm of way each, 20 um apart.
  EXPECT_NEAR(static_cast<double>(paths.attempt.size()), 201, 2);
  EXPECT_NEAR(static_cast<double>(paths.reference.size()), 201, 2);
  for (size_t i = 0; i + 1 < paths.attempt.size(); ++i) {
    const dvec3 way = paths.attempt[i + 1].anchor_m - paths.attempt[i].anchor_m;
    // Less only where the way turns the corner between two samples.
    EXPECT_NEAR(std::sqrt(Dot(way, way)), 20e-6, i > 97 && i < 102 ? 8e-6 : 1e-7) << i;
  }
  const Alignment mean = AlignPoses(paths), worst = AlignPoses(paths, Pairing::kWorst);
  EXPECT_NEAR(mean.mean_cost, 0.3e-3, 1e-6);
  EXPECT_NEAR(worst.worst_cost, 0.3e-3, 1e-5) << "a parallel path is as far everywhere";
  for (const auto& [i, j] : mean.path) EXPECT_NEAR(i, j, 1);
}

TEST(PathAlignTest, InTimeThePathSaysWhichMomentIsWhich) {
  const ProcessRecorder reference = Corner(0, false), attempt = Corner(0, true);
  const PathPair paths = ResampleAlike(attempt, reference, PathBy::kTime);
  const Alignment mean = AlignPoses(paths);
  EXPECT_EQ(mean.path.front(), std::make_pair(0u, 0u));
  EXPECT_EQ(mean.path.back(), std::make_pair(static_cast<uint32_t>(paths.attempt.size() - 1),
                                             static_cast<uint32_t>(paths.reference.size() - 1)));
  EXPECT_NEAR(AlignForces(paths).mean_cost, 0, 1e-12);
  // The band ends at a tenth: the middle of the slow leg meets the reference's at most that far
  // off.
  EXPECT_GT(mean.mean_cost, 0);
  EXPECT_LE(AlignPoses(paths, Pairing::kWorst).worst_cost, mean.worst_cost);
}

TEST(PathAlignTest, ABurThatNeverMovedHasOnePlace) {
  const ProcessRecorder still = StraightRecording(500, 0, 1), moved = StraightRecording(500, 2, 1);
  const PathPair paths = ResampleAlike(still, moved, PathBy::kArcLength);
  ASSERT_EQ(paths.attempt.size(), 1u);
  // 1 mm of way in half a second, less the last tick.
  EXPECT_NEAR(AlignPoses(paths, Pairing::kWorst).worst_cost, 0.96e-3, 0.05e-3);
}

TEST(PathAlignTest, TenMinutesAreBounded) {
  const ProcessRecorder a = StraightRecording(600'000, 5, 1), b = StraightRecording(60'000, 5, 1);
  for (PathBy by : {PathBy::kTime, PathBy::kArcLength}) {
    const PathPair paths = ResampleAlike(a, b, by);
    EXPECT_LE(paths.attempt.size(), PathPair::kMaxSamples);
    EXPECT_LE(paths.reference.size(), PathPair::kMaxSamples);
    EXPECT_GT(paths.attempt.size(), 2900u);
  }
}

}  // namespace
}  // namespace enamel::scoring
