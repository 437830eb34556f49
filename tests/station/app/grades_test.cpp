#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "common/base/sha256.h"
#include "common/core/core.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scene/preparation.h"
#include "common/scoring/score.h"
#include "common/scoring/task.h"
#include "station/devices/operators.h"
#include "station/loop/tick_loop.h"

// Scores of simulated people in the built-in exercises, on coarse grids so that all of them fit
// into a test: the lab measures on the demo's (enamel-lab grades).
namespace enamel::station {
namespace {

constexpr int32_t kVoxel_nm = 100'000;
constexpr uint64_t kMaxTicks = 600'000;

struct CutTooth {
  cutting::Volume volume;
  surface::Mesh mesh;
  scoring::ProcessRecorder process;

  scoring::AttemptData Data(const cutting::Volume& initial) const {
    return {&initial, &volume, &mesh, &process};
  }
};

CutTooth CutBy(const OperatorPreset& preset, const scene::BuiltScene& built,
               const scene::Exercise& exercise, uint64_t most_ticks = kMaxTicks) {
  const scene::DeviceProfile profile = scene::BuiltinProfiles()[1];
  auto params = scene::CompilePlan(built.scene, exercise, profile);
  ENAMEL_CHECK(params.ok());
  auto device = MakeSimulatedDevice(preset, built.scene, exercise, profile, *params, built.volume);
  EXPECT_TRUE(device.ok()) << device.status().message();
  core::Core core(*params, built.volume);
  SampleRing ring(4);
  TickLoop loop(**device, core, ring, {params->rate_hz, true, false});
  scoring::ProcessRecorder process(*params);
  bool finished = false;
  for (uint64_t i = 0; !finished && i < most_ticks; ++i) {
    finished = loop.Tick();
    Sample sample;
    while (ring.Pop(sample)) process.AddRecorded(sample.tick);
  }
  EXPECT_TRUE(finished || most_ticks < kMaxTicks);
  surface::Mesh mesh = surface::ExtractSurface(core.volume());
  return {core.volume(), std::move(mesh), std::move(process)};
}

scoring::ScoreResult ScoreOf(const scene::BuiltScene& built, const scene::Exercise& exercise,
                             const CutTooth& attempt, const CutTooth& reference) {
  auto metrics = scoring::ComputeMetrics(built.scene, exercise, attempt.Data(built.volume),
                                         reference.Data(built.volume));
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  const scoring::AcceptableCut r(built.volume, reference.volume,
                                 {built.scene.tooth, built.scene.up});
  auto judged = scoring::JudgeCut(r, attempt.volume, exercise.rubric);
  EXPECT_TRUE(judged.ok()) << judged.status().message();
  if (!judged.ok()) return {};
  auto score = scoring::ApplyRubric(exercise.rubric, *metrics, std::move(judged->measures),
                                    std::move(judged->found.mistakes));
  EXPECT_TRUE(score.ok()) << score.status().message();
  return score.ok() ? *score : scoring::ScoreResult{};
}

double LostBy(const scoring::ScoreResult& score, scoring::Group group) {
  const auto found = std::ranges::find(score.criteria, group, &scoring::CriterionResult::group);
  EXPECT_NE(found, score.criteria.end()) << NameOf(group);
  return found == score.criteria.end() ? -1 : found->lost;
}

// The exercises whose box a simulated person can cut. A crown and the shapes of the block need
// other hands.
bool IsBoxOfACavity(const scene::Exercise& exercise) {
  return exercise.name.starts_with("class-") || exercise.name.starts_with("caries-");
}

class Grades : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (std::string_view(GetParam()) != "molar" && std::getenv("ENAMEL_FULL") == nullptr)
      GTEST_SKIP() << "takes long: ./check --full";
    auto built = scene::BuildBuiltinScene(GetParam(), kVoxel_nm);
    ASSERT_TRUE(built.ok());
    built_ = std::move(*built);
    const Sha256 hash = HashSha256(AsBytes(scene::ToJson(built_.scene)));
    for (scene::Exercise& e : scene::BuiltinExercises(built_.scene, hash)) {
      ASSERT_TRUE(scoring::ValidateRubric(e.rubric).ok()) << e.name;
      if (IsBoxOfACavity(e)) exercises_.push_back(std::move(e));
    }
    ASSERT_FALSE(exercises_.empty());
  }
  CutTooth Cut(const char* operator_name, const scene::Exercise& exercise,
               uint64_t most_ticks = kMaxTicks) const {
    return CutBy(*FindOperator(operator_name), built_, exercise, most_ticks);
  }

  scene::BuiltScene built_;
  std::vector<scene::Exercise> exercises_;
};

TEST_P(Grades, AReferenceScoresAHundredAgainstItselfAndAnUntouchedToothNothing) {
  for (const scene::Exercise& exercise : exercises_) {
    SCOPED_TRACE(exercise.name);
    const CutTooth reference = Cut("dentist", exercise);
    const auto own = ScoreOf(built_, exercise, reference, reference);
    EXPECT_NEAR(own.score, 100, 1e-9);
    EXPECT_TRUE(own.mistakes.empty());
    for (const auto& c : own.criteria) {
      EXPECT_TRUE(c.judged) << c.name << ": a criterion of a built-in rubric that never counts";
      EXPECT_NEAR(c.lost, 0, 1e-9) << c.name;
    }
    const auto nothing = ScoreOf(built_, exercise, Cut("dentist", exercise, 500), reference);
    EXPECT_EQ(nothing.score, 0);
    EXPECT_EQ(nothing.acceptance, scoring::Acceptance::kNotAcceptable);
  }
}

TEST_P(Grades, AnotherGoodHandKeepsNinetyFivePointsAndADeepWallCostsItsOwnGroup) {
  for (const scene::Exercise& exercise : exercises_) {
    SCOPED_TRACE(exercise.name);
    const CutTooth reference = Cut("dentist", exercise);
    const auto good = ScoreOf(built_, exercise, Cut("graduate", exercise), reference);
    EXPECT_GE(good.score, 95);
    const auto deep = ScoreOf(built_, exercise, Cut("student-deep-mesial", exercise), reference);
    EXPECT_LE(deep.score, 95);
    // On the open side of a class II box there is the neighbour instead of a wall.
    const auto own = exercise.name.starts_with("class-2") ? scoring::Group::kTissuePreserved
                                                          : scoring::Group::kOutline;
    EXPECT_GE(LostBy(deep, own), LostBy(good, own) + 1);
  }
}

// A person with one fault scores below a good hand, and for that fault.
struct OneFault {
  const char* operator_name;
  scoring::Group group;
  const char* exercise = "";  // the beginning of its name; else all of the scene's
};
constexpr OneFault kOneFaults[] = {
    {"undercutter", scoring::Group::kOutline},
    {"too-shallow", scoring::Group::kInternalForm, "class-1"},
    {"over-extender", scoring::Group::kOutline, "class-1"},
    {"caries-leaver", scoring::Group::kInternalForm, "caries-"},
    {"neighbour-nicker", scoring::Group::kTissuePreserved, "class-2"},
};

TEST_P(Grades, OneFaultFallsBelowAGoodHandAndInItsOwnGroup) {
  for (const scene::Exercise& exercise : exercises_) {
    // The teeth with a speciality have the same class I cavity as the one without.
    if (exercise.name.starts_with("class-1") && std::string(GetParam()) != "molar") continue;
    SCOPED_TRACE(exercise.name);
    const CutTooth reference = Cut("dentist", exercise);
    const auto good = ScoreOf(built_, exercise, Cut("good", exercise), reference);
    EXPECT_GE(good.score, 90);
    for (const OneFault& fault : kOneFaults) {
      const OperatorPreset& preset = *FindOperator(fault.operator_name);
      if (!HasUseFor(preset, built_.scene, exercise) || !exercise.name.starts_with(fault.exercise))
        continue;
      SCOPED_TRACE(fault.operator_name);
      const auto score = ScoreOf(built_, exercise, CutBy(preset, built_, exercise), reference);
      EXPECT_LT(score.score, good.score);
      EXPECT_GE(LostBy(score, fault.group), LostBy(good, fault.group) + 1);
    }
  }
}

TEST_P(Grades, ADestroyedToothScoresNothing) {
  for (const scene::Exercise& exercise : exercises_) {
    SCOPED_TRACE(exercise.name);
    const CutTooth reference = Cut("dentist", exercise);
    CutTooth gone{cutting::Volume(built_.volume.spec()), {}, reference.process};
    gone.mesh = surface::ExtractSurface(gone.volume);
    EXPECT_EQ(ScoreOf(built_, exercise, gone, reference).score, 0);
  }
}

// The shape of an exercise, not the box around it.
TEST(ShapesTest, TheDentistsCircleIsACircle) {
  auto built = scene::BuildBuiltinScene("block", kVoxel_nm);
  ASSERT_TRUE(built.ok());
  for (const scene::Exercise& exercise : scene::BuiltinExercises(built->scene, {})) {
    if (exercise.name != "circle-block") continue;
    auto shape = scene::TargetShape(built->scene, exercise.target);
    ASSERT_TRUE(shape.ok());
    const cutting::Volume wanted = scene::Prepared(built->volume, *shape);
    const surface::DistanceQuery wanted_cut(surface::ExtractSurface(wanted));
    const CutTooth cut = CutBy(*FindOperator("dentist"), *built, exercise);
    const auto volumes = scoring::MeasureTask(built->volume, cut.volume, wanted, wanted_cut, 0);
    // 2.5^2 pi 1.5 mm3; the square around it holds 8 mm3 more.
    EXPECT_NEAR(volumes.task_m3() * 1e9, 29.45, 0.2);
    EXPECT_GE(volumes.done_m3() / volumes.task_m3(), 0.98);
    EXPECT_LE((scoring::Sum_m3(volumes.near) + scoring::Sum_m3(volumes.outside)) * 1e9, 0.4);
    return;
  }
  FAIL() << "no circle";
}

// Spearman's rank correlation, ties at their mean rank.
double Spearman(const std::vector<double>& a, const std::vector<double>& b) {
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
  const auto n = static_cast<double>(a.size());
  double ma = 0, mb = 0, ab = 0, aa = 0, bb = 0;
  for (size_t i = 0; i < ra.size(); ++i) ma += ra[i] / n, mb += rb[i] / n;
  for (size_t i = 0; i < ra.size(); ++i) {
    ab += (ra[i] - ma) * (rb[i] - mb);
    aa += (ra[i] - ma) * (ra[i] - ma);
    bb += (rb[i] - mb) * (rb[i] - mb);
  }
  return ab / std::sqrt(aa * bb);
}

TEST_P(Grades, SkillIsFoundInTheOrderItWasMade) {
  if (std::getenv("ENAMEL_FULL") == nullptr) GTEST_SKIP() << "takes minutes: ./check --full";
  for (const scene::Exercise& exercise : exercises_) {
    SCOPED_TRACE(exercise.name);
    const CutTooth reference = Cut("dentist", exercise);
    std::vector<double> skill, scores;
    std::string table;
    for (const OperatorPreset& preset : OperatorPresets()) {
      if (preset.rank == 0) continue;
      const auto score = ScoreOf(built_, exercise, CutBy(preset, built_, exercise), reference);
      skill.push_back(preset.rank);
      scores.push_back(score.score);
      table += std::string(preset.name) + " " + std::to_string(score.score) + "\n";
    }
    const double found = Spearman(skill, scores);
    EXPECT_GE(found, 0.93) << table;
    RecordProperty(exercise.name, table);
    if (std::getenv("ENAMEL_PRINT") != nullptr)
      std::printf("%s %.3f\n%s", exercise.name.c_str(), found, table.c_str());
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Grades, testing::Values("molar", "molar-caries", "molar-class-2"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace enamel::station
