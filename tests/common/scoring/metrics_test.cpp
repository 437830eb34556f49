#include "common/scoring/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "common/cutting/cutter.h"
#include "common/haptics/coupling.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

using cutting::Volume;

MetricSet Compare(const Volume& block, const Cut& attempt, const Cut& reference, int tooth = 0) {
  scene::Scene scene = BlockScene();
  scene.tooth = tooth;
  auto metrics = ComputeMetrics(scene, BlockExercise(), attempt.Data(block), reference.Data(block));
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  return metrics.ok() ? *metrics : MetricSet{};
}

const char* const kParts[] = {"wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm",
                              "wall_lingual_mm", "floor_mm"};

struct WallCase {
  const char* name;
  int32_t voxel_nm;
  double turn, tilt;
  double shift_mm;  // of every wall, so that none lines up with the grid
};

class OneWallOff : public testing::TestWithParam<WallCase> {
 protected:
  Cavity Reference() const {
    const WallCase& c = GetParam();
    Cavity out;
    out.mesial_mm += c.shift_mm;
    out.distal_mm -= c.shift_mm;
    out.buccal_mm += 0.7 * c.shift_mm;
    out.depth_mm += 0.3 * c.shift_mm;
    out.turn = c.turn;
    out.tilt = c.tilt;
    return out;
  }
};

// Moves one part of the cavity outwards.
void Move(Cavity& cavity, size_t part, double by_mm) {
  double* sides[] = {&cavity.mesial_mm, &cavity.distal_mm, &cavity.buccal_mm, &cavity.lingual_mm,
                     &cavity.depth_mm};
  *sides[part] += by_mm;
}

TEST_P(OneWallOff, IsFoundWithinAQuarterVoxelAndTheOthersAreZero) {
  Volume block = MakeBlock(GetParam().voxel_nm);
  double tolerance = GetParam().voxel_nm * 1e-6 / 4;
  Cut reference(block, Reference());
  for (double d_mm : {0.3, -0.3}) {
    for (size_t part = 0; part < 5; ++part) {
      Cavity wrong = Reference();
      Move(wrong, part, d_mm);
      auto metrics = Compare(block, Cut(block, wrong), reference);
      for (size_t p = 0; p < 5; ++p) {
        EXPECT_NEAR(ValueOf(metrics, kParts[p]), p == part ? d_mm : 0, tolerance)
            << kParts[p] << " with " << kParts[part] << " off by " << d_mm;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cavities, OneWallOff,
                         testing::Values(WallCase{"coarse", 100'000, 0, 0, 0},
                                         WallCase{"coarse_off_grid", 100'000, 0, 0, 0.0371},
                                         WallCase{"coarse_turned", 100'000, 0.13, 0, 0.0123},
                                         WallCase{"fine", 50'000, 0, 0, 0},
                                         WallCase{"fine_off_grid", 50'000, 0, 0, 0.0171},
                                         WallCase{"fine_turned", 50'000, -0.1, 0, 0.0213}),
                         [](const auto& test) { return test.param.name; });

// Grooves of a 0.1 mm bur, 0.06 mm deep and 0.4 mm apart: they take less than half of the wall, so
// its median height is that of the flat between them.
void GrooveMesialWall(Cut& cut, const Cavity& cavity) {
  cutting::Bur bur{cutting::BurShape::kCylinder, 0.1e-3, 6e-3};
  cut.volume.Reserve();
  cutting::Cutter cutter(cut.volume, bur);
  cutting::RemovedUnits removed{};
  double x_mm = cavity.mesial_mm + 0.06 - 0.1;
  for (double y_mm = -cavity.lingual_mm; y_mm < cavity.buccal_mm; y_mm += 0.4) {
    cutting::Pose pose{dvec3(x_mm, y_mm, -cavity.depth_mm) * 1e-3, {}};
    ASSERT_TRUE(cutter.Cut(pose, removed));
  }
  cut.mesh = surface::ExtractSurface(cut.volume);
}

TEST(MetricsTest, ARoughReferenceDoesNotMakeADeepWallShallower) {
  Volume block = MakeBlock(50'000);
  Cavity deep;
  deep.mesial_mm += 0.3;
  Cut reference(block, {}), attempt(block, deep);
  GrooveMesialWall(reference, {});
  auto metrics = Compare(block, attempt, reference);
  EXPECT_NEAR(ValueOf(metrics, "wall_mesial_mm"), 0.3, 0.0125);
  // A nearest point would be in a groove for most of the wall.
  surface::DistanceQuery nearest(reference.mesh);
  EXPECT_LT(nearest.Distance_m(dvec3(1.8, 0.1, -1) * 1e-3, 1e-3), 0.27e-3);
}

// The wall at +x is the mesial one of a lower left molar and the distal one of a lower right one.
TEST(MetricsTest, TheWallThatIsTooDeepIsNamedByTheToothsNumber) {
  const Volume block = MakeBlock(100'000);
  Cavity deep;
  deep.mesial_mm += 0.3;
  const Cut reference(block, {}), attempt(block, deep);
  const auto of_36 = Compare(block, attempt, reference, 36);
  const auto of_46 = Compare(block, attempt, reference, 46);
  EXPECT_NEAR(ValueOf(of_36, "wall_mesial_mm"), 0.3, 0.025);
  EXPECT_NEAR(ValueOf(of_36, "wall_distal_mm"), 0, 0.025);
  EXPECT_EQ(ValueOf(of_46, "wall_distal_mm"), ValueOf(of_36, "wall_mesial_mm"));
  EXPECT_EQ(ValueOf(of_46, "wall_mesial_mm"), ValueOf(of_36, "wall_distal_mm"));
  EXPECT_EQ(ValueOf(of_46, "wall_buccal_mm"), ValueOf(of_36, "wall_buccal_mm"));
}

TEST(MetricsTest, TheReferenceAgainstItselfHasNoDeviationAtAll) {
  Volume block = MakeBlock(50'000);
  Cavity cavity;
  cavity.turn = 0.07;
  Cut cut(block, cavity);
  auto metrics = Compare(block, cut, cut);
  for (const char* part : kParts) EXPECT_EQ(ValueOf(metrics, part), 0) << part;
  for (const char* name : {"deviation_rms_mm", "deviation_p95_mm", "dtw_pose_mm", "dtw_force_n",
                           "frechet_pose_mm", "dtw_way_mm", "frechet_way_mm"}) {
    EXPECT_EQ(ValueOf(metrics, name), 0) << name;
  }
}

TEST(MetricsTest, AWallThatWasNeverCutIsShortByItsDistanceFromWhatWas) {
  Volume block = MakeBlock(100'000);
  Cut reference(block, {});
  Cavity half;
  half.mesial_mm = -0.2;  // the cavity ends before the middle
  auto metrics = Compare(block, Cut(block, half), reference);
  EXPECT_LT(ValueOf(metrics, "wall_mesial_mm"), -0.7);
  EXPECT_NEAR(ValueOf(metrics, "wall_distal_mm"), 0, 0.025);
  // It is missed as that: the walls that were made are judged.
  for (const char* of_others : {"wall_tilt_deg", "undercut_deg"}) {
    EXPECT_NEAR(ValueOf(metrics, of_others), 0, 0.5) << of_others;
  }
}

TEST(MetricsTest, AnAttemptThatCutNothingHasNoWallsToMeasure) {
  Volume block = MakeBlock(100'000);
  Cut reference(block, {}), attempt(block, {});
  attempt.volume = block;
  attempt.mesh = surface::ExtractSurface(block);
  auto metrics = Compare(block, attempt, reference);
  EXPECT_EQ(ValueOf(metrics, "zone_target_removed_percent"), 0);
  EXPECT_EQ(ValueOf(metrics, "removed_enamel_mm3"), 0);
  // The tooth's own surface is no wall that is short, and no floor that slopes.
  for (const std::string part :
       {"wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm", "floor_mm",
        "tilt_floor_deg", "floor_waviness_mm", "wall_tilt_deg"}) {
    const auto why = std::find_if(metrics.missing.begin(), metrics.missing.end(),
                                  [&](const MissingMetric& m) { return m.name == part; });
    ASSERT_NE(why, metrics.missing.end()) << part;
    EXPECT_EQ(why->why, NoValue::kNotMade) << part;
  }
}

// The nearest surface to the middle of the floor is a wall.
TEST(MetricsTest, AFloorIsShortByWhatStandsOverIt) {
  Volume block = MakeBlock(100'000);
  Cut reference(block, {});
  Cavity shallow;
  shallow.depth_mm = 0.4;
  auto metrics = Compare(block, Cut(block, shallow), reference);
  EXPECT_NEAR(ValueOf(metrics, "floor_mm"), -1.6, 0.025);
  EXPECT_NEAR(ValueOf(metrics, "tilt_floor_deg"), 0, 0.5);
}

TEST(MetricsTest, ZonesOfTheCavityAsAskedForAreFullEmptyAndEmpty) {
  Volume block = MakeBlock(50'000);
  Cut cut(block, {});
  auto metrics = Compare(block, cut, cut);
  // Only the four corners of the bur's radius stay: (4 - pi) r^2 of 3 x 2.4 mm.
  EXPECT_NEAR(ValueOf(metrics, "zone_target_removed_percent"), 100 * (1 - 0.8584 * 0.25 / 7.2),
              0.1);
  EXPECT_NEAR(ValueOf(metrics, "zone_leeway_removed_percent"), 0, 0.5);
  EXPECT_NEAR(ValueOf(metrics, "zone_container_removed_mm3"), 0, 0.02);
}

TEST(MetricsTest, PulpThatWasOpenedIsItsArea) {
  Volume block = MakeBlock(50'000);
  Cut shallow(block, {});
  EXPECT_EQ(ValueOf(Compare(block, shallow, shallow), "pulp_exposed_mm2"), 0);
  Cavity deep;
  deep.depth_mm = 3.2;  // 0.4 mm into the pulp
  Cut cut(block, deep);
  auto metrics = Compare(block, cut, shallow);
  double corners = 0.8584 * 0.25, floor = 3 * 2.4 - corners;
  double around = 2 * (3 + 2.4) - 8 * kBurRadius_mm + 2 * 3.14159 * kBurRadius_mm;
  // Surface nets cut edges off and a label boundary may be half a voxel off.
  EXPECT_NEAR(ValueOf(metrics, "pulp_exposed_mm2"), floor + 0.4 * around, 0.05 * around);
  EXPECT_NEAR(ValueOf(metrics, "removed_pulp_mm3"), floor * 0.4, floor * 0.026);
}

TEST(MetricsTest, AlignmentFindsAConstantOffsetOfPoseAndForce) {
  Volume block = MakeBlock(100'000);
  Cut attempt(block, {}), reference(block, {});
  attempt.process = StraightRecording(4000, 0, 1.5);
  reference.process = StraightRecording(3000, 0, 0.9);
  auto metrics = Compare(block, attempt, reference);
  EXPECT_NEAR(ValueOf(metrics, "dtw_force_n"), 0.6, 1e-9);
  EXPECT_NEAR(ValueOf(metrics, "dtw_pose_mm"), 0, 1e-12);
  // The same way at three quarters of the speed is the same way, but for the spacing of samples.
  attempt.process = StraightRecording(4000, 1.5, 1);
  reference.process = StraightRecording(3000, 2, 1);
  EXPECT_LT(ValueOf(Compare(block, attempt, reference), "dtw_pose_mm"), 0.04);
}

TEST(MetricsTest, TenMinutesAreAlignedWithinTheBound) {
  Volume block = MakeBlock(100'000);
  Cut attempt(block, {}), reference(block, {});
  attempt.process = StraightRecording(600'000, 0.01, 1);
  auto metrics = Compare(block, attempt, reference);
  EXPECT_TRUE(std::isfinite(ValueOf(metrics, "dtw_pose_mm")));
}

TEST(MetricsTest, EveryMetricHasAUniqueNameATitleAndAFiniteValueOrAReasonForNone) {
  Volume block = MakeBlock(100'000);
  Cut cut(block, {});
  auto metrics = Compare(block, cut, cut);
  std::set<std::string_view> names, found;
  for (const MetricInfo& info : Metrics()) {
    EXPECT_FALSE(info.title.empty());
    EXPECT_TRUE(names.insert(info.name).second);
    EXPECT_EQ(FindMetric(info.name), &info);
  }
  for (const MetricValue& m : metrics.values) {
    EXPECT_TRUE(found.insert(m.name).second);
    EXPECT_EQ(m.unit, FindMetric(m.name)->unit);
    EXPECT_TRUE(std::isfinite(m.value)) << m.name;
  }
  for (const MissingMetric& m : metrics.missing) EXPECT_TRUE(found.insert(m.name).second);
  EXPECT_EQ(found, names);
  EXPECT_EQ(FindMetric("beauty"), nullptr);
}

TEST(MetricsTest, EqualInputsGiveEqualBits) {
  Volume block = MakeBlock(100'000);
  Cavity wrong;
  wrong.lingual_mm += 0.17;
  EXPECT_EQ(Compare(block, Cut(block, wrong), Cut(block, {})),
            Compare(block, Cut(block, wrong), Cut(block, {})));
}

// The box of 3 x 2.4 x 2 mm, its corners round, in ten seconds of cutting; the upper 1.2 mm are
// enamel, known to half a voxel.
TEST(MetricsTest, RatesAndOrderAreThoseOfAKnownWork) {
  Volume block = MakeBlock(100'000);
  Cut attempt(block, {}), reference(block, {});
  attempt.process = ProcessRecorder(SomeParams());
  for (int i = 0; i < 12'000; ++i) {
    trace::Tick tick;
    tick.witness.force_computed_mn[2] = 1000;
    core::TickOutput output;
    output.witness = tick.witness;
    const auto tissue = i < 6000 ? cutting::Tissue::kEnamel : cutting::Tissue::kDentin;
    if (i >= 1000 && i < 11'000) output.removed[static_cast<size_t>(tissue)] = 1;
    attempt.process.Add(tick, output);
  }
  const MetricSet metrics = Compare(block, attempt, reference);
  const double seconds = ValueOf(metrics, "cutting_time_s");
  EXPECT_NEAR(seconds, 10, 0.06);
  const double area_mm2 = 3 * 2.4 - (4 - std::numbers::pi) * kBurRadius_mm * kBurRadius_mm;
  const double label = area_mm2 * 0.05 / seconds;
  EXPECT_NEAR(ValueOf(metrics, "enamel_rate_mm3_per_s"), area_mm2 * 1.2 / seconds, label);
  EXPECT_NEAR(ValueOf(metrics, "dentin_rate_mm3_per_s"), area_mm2 * 0.8 / seconds, label);
  EXPECT_NEAR(ValueOf(metrics, "enamel_half_s"), 3.5, 0.051);
  EXPECT_NEAR(ValueOf(metrics, "dentin_half_s"), 8.5, 0.051);
  EXPECT_NEAR(ValueOf(metrics, "impulse_n_s"), 12, 1e-9);
  EXPECT_EQ(ValueOf(metrics, "contact_count"), 1);
  for (const MissingMetric& m : metrics.missing) {
    const bool caries = m.name.starts_with("caries_"), motion = m.name.starts_with("smoothness_");
    EXPECT_TRUE(!caries || m.why == NoValue::kNotInTask) << m.name;
    EXPECT_TRUE(!motion || m.why == NoValue::kNotMade) << m.name << ": it never moved";
  }
}

// A wall of one voxel between the cavity and the pulp measures what the grid makes of it.
TEST(MetricsTest, AThicknessBelowTwoVoxelsSaysSoWhereverTheGridLies) {
  constexpr int32_t kVoxel_nm = 100'000;
  Cavity one, four;
  one.depth_mm = 2.7;
  four.depth_mm = 2.4;
  double least = 1, most = 0;
  for (const int64_t up_nm : {0, 25'000, 50'000}) {
    const Volume block = MakeBlock(kVoxel_nm, up_nm);
    const Cut reference(block, {});
    for (const Cavity& cavity : {one, four}) {
      const MetricSet metrics = Compare(block, Cut(block, cavity), reference);
      const auto thick =
          std::ranges::find(metrics.values, "remaining_dentin_mm", &MetricValue::name);
      ASSERT_NE(thick, metrics.values.end());
      EXPECT_EQ(thick->below_grid.has_value(), cavity.depth_mm == one.depth_mm) << up_nm;
      if (!thick->below_grid) continue;
      EXPECT_NEAR(*thick->below_grid, 0.2, 1e-9);
      least = std::min(least, thick->value);
      most = std::max(most, thick->value);
      for (const MetricValue& m : metrics.values)
        EXPECT_EQ(m.below_grid.has_value(), m.name == thick->name) << m.name;
    }
  }
  EXPECT_GT(most - least, 0.05) << "the grid alone, of one wall of 0.1 mm";
}

TEST(MetricsTest, ForcesAtTheDevicesLimitSaySo) {
  Volume block = MakeBlock(200'000);
  Cut attempt(block, {}), reference(block, {});
  auto limited = [&](int bounded) {
    attempt.process = ProcessRecorder(SomeParams());
    for (int i = 0; i < 1000; ++i) {
      trace::Tick tick;
      tick.witness.force_sent_mn[2] = tick.witness.force_computed_mn[2] = 6000;
      if (i < bounded) tick.witness.flags = haptics::kPeakBounded;
      attempt.process.AddRecorded(tick);
    }
    std::set<std::string> out;
    for (const MetricValue& m : Compare(block, attempt, reference).values) {
      if (m.limited) out.insert(m.name);
    }
    return out;
  };
  EXPECT_EQ(limited(50), std::set<std::string>{});
  EXPECT_EQ(limited(51), (std::set<std::string>{"dtw_force_n", "force_rate_p95_n_per_s",
                                                "force_sent_max_n", "force_sent_mean_cutting_n",
                                                "force_sent_p95_n", "impulse_n_s", "work_mj"}));
}

scene::Rubric RubricFor(std::initializer_list<const char*> names) {
  scene::Rubric rubric;
  for (const char* name : names) {
    rubric.criteria.push_back(
        {name, name, std::string(FindMetric(name)->unit), 1, {{0, 1}}, "", {}});
  }
  return rubric;
}

// Metrics left out are reported as such; measured ones have the same bits as with all metrics.
TEST(MetricsTest, AnExerciseMeasuresWhatItsRubricUsesAndWhatEveryPageShows) {
  Volume block = MakeBlock(100'000);
  Cavity wrong;
  wrong.lingual_mm += 0.17;
  Cut attempt(block, wrong), reference(block, {});
  const MetricSet all = Compare(block, attempt, reference);
  for (const MissingMetric& m : all.missing) EXPECT_NE(m.why, NoValue::kNotUsed) << m.name;
  auto planned = [&](const scene::Rubric& rubric) {
    return *ComputeMetrics(BlockScene(), BlockExercise(), attempt.Data(block),
                           reference.Data(block), {}, MetricPlan::For(rubric));
  };
  for (const MetricInfo& info : Metrics()) {
    const MetricSet some = planned(RubricFor({std::string(info.name).c_str()}));
    EXPECT_EQ(some.values.size() + some.missing.size(), Metrics().size());
    for (const MetricValue& m : some.values) EXPECT_EQ(m.value, ValueOf(all, m.name)) << m.name;
    for (const MissingMetric& m : some.missing) {
      EXPECT_TRUE(m.name != info.name || m.why != NoValue::kNotUsed) << m.name;
    }
  }
  std::set<std::string> unused;
  for (const MissingMetric& m : planned(RubricFor({"time_s", "wall_mesial_mm"})).missing) {
    if (m.why == NoValue::kNotUsed) unused.insert(m.name);
  }
  for (const char* name : {"dtw_pose_mm", "zone_target_removed_percent", "outline_over_mm"}) {
    EXPECT_TRUE(unused.contains(name)) << name;
  }
  for (const char* name : {"deviation_rms_mm", "task_done_percent", "force_sent_p95_n", "time_s",
                           "wall_mesial_mm", "removed_enamel_mm3", "pulp_exposed_mm2"}) {
    EXPECT_FALSE(unused.contains(name)) << name;
  }
}

// The page shows these beside the regions that the prices judge.
TEST(MetricsTest, ARubricsPricesAskForTheFiguresThatSayMoreOfTheirRegions) {
  const auto groups = [](const char* kind) {
    scene::Rubric rubric;
    rubric.prices.emplace_back().of = kind;
    std::set<MetricGroup> out;
    for (size_t i = 0; i < kMetricGroups; ++i) {
      const auto group = static_cast<MetricGroup>(i);
      if (MetricPlan::For(rubric).Has(group)) out.insert(group);
    }
    for (const MetricGroup base : MetricPlan::kBaseGroups) EXPECT_EQ(out.erase(base), 1U);
    return out;
  };
  using Groups = std::set<MetricGroup>;
  EXPECT_EQ(groups("wall"), (Groups{MetricGroup::kWalls, MetricGroup::kOutline}));
  EXPECT_EQ(groups("margin"), Groups{MetricGroup::kCrown});
  EXPECT_EQ(groups("pulp"), Groups{MetricGroup::kCover});
  EXPECT_EQ(groups("elsewhere"), Groups{});
}

TEST(MetricsTest, DeviationGivenByTheCallerIsUsed) {
  Volume block = MakeBlock(100'000);
  Cavity wrong;
  wrong.buccal_mm += 0.3;
  Cut attempt(block, wrong), reference(block, {});
  auto deviation =
      DeviationPerVertex(attempt.mesh, block, attempt.volume, reference.volume, reference.mesh);
  AttemptData data = attempt.Data(block);
  data.deviation_m = &deviation;
  auto given = ComputeMetrics(BlockScene(), BlockExercise(), data, reference.Data(block));
  ASSERT_TRUE(given.ok());
  EXPECT_EQ(*given, Compare(block, attempt, reference));
}

TEST(MetricsTest, CutsOfDifferentGridsAreRefused) {
  Volume fine = MakeBlock(100'000), coarse = MakeBlock(200'000);
  Cut attempt(fine, {}), reference(coarse, {});
  auto metrics =
      ComputeMetrics(BlockScene(), BlockExercise(), attempt.Data(fine), reference.Data(coarse));
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.status().code(), Code::kInvalidInput);
}

TEST(MetricsTest, ATargetInTheAirIsRefused) {
  Volume block = MakeBlock(100'000);
  Cut cut(block, {});
  scene::Scene scene = BlockScene();
  scene.landmarks["occlusal_centre"] = {0, 0, 9000};
  auto metrics = ComputeMetrics(scene, BlockExercise(), cut.Data(block), cut.Data(block));
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.status().field(), "target");
}

TEST(MetricsTest, AnEmptyRecordingIsRefused) {
  Volume block = MakeBlock(100'000);
  Cut attempt(block, {}), reference(block, {});
  attempt.process = ProcessRecorder(SomeParams());
  auto metrics =
      ComputeMetrics(BlockScene(), BlockExercise(), attempt.Data(block), reference.Data(block));
  ASSERT_FALSE(metrics.ok());
}

}  // namespace
}  // namespace enamel::scoring
