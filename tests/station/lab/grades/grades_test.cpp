#include "station/lab/grades/grades.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "common/scoring/deviation.h"
#include "station/lab/grades/expected_words.h"

// The cost of known faults in the built-in exercises, on coarse grids; the lab measures on fine
// ones (enamel-lab grades).
namespace enamel::station::lab {
namespace {

constexpr int32_t kVoxel_nm = 100'000;
constexpr double kDegree = 3.14159265358979323846 / 180;

struct Made {
  scene::BuiltScene built;
  std::vector<scene::Exercise> exercises;
};
Made Build(const char* scene, int32_t voxel_nm = kVoxel_nm) {
  auto built = scene::BuildBuiltinScene(scene, voxel_nm);
  ENAMEL_CHECK(built.ok());
  auto exercises = scene::BuiltinExercises(built->scene, {});
  return {std::move(*built), std::move(exercises)};
}

// A scene and the beginning of an exercise's name.
struct Asked {
  const char* scene;
  const char* exercise;
  bool only_full = false;
};
class Grades : public testing::TestWithParam<Asked> {};

// A fault at its threshold must cost at least a point.
TEST_P(Grades, EveryFaultIsFoundAndCostsAndOnlyTheReferenceIsPerfect) {
  if (GetParam().only_full && std::getenv("ENAMEL_FULL") == nullptr) {
    GTEST_SKIP() << "takes minutes: ./check --full";
  }
  const Made made = Build(GetParam().scene);
  size_t graded_exercises = 0;
  for (const scene::Exercise& exercise : made.exercises) {
    if (!exercise.name.starts_with(GetParam().exercise)) continue;
    SCOPED_TRACE(exercise.name);
    ++graded_exercises;
    auto graded = GradedExercise::Make(made.built, exercise);
    ASSERT_TRUE(graded.ok()) << graded.status().message();
    size_t with_words = 0, wrong_faults = 0, wrong_remedies = 0;
    std::string misnamed;
    for (const Fault& fault : FaultsOf(made.built, exercise, graded->task(), true)) {
      auto row = graded->Grade(fault);
      ASSERT_TRUE(row.ok()) << row.status().message();
      EXPECT_TRUE(row->AsKnown()) << fault.name << ", " << row->metric << ": "
                                  << row->found.value_or(std::nan("")) << " for " << row->size
                                  << " +- " << row->tolerance;
      EXPECT_EQ(row->critical.empty(), fault.critical.empty())
          << fault.name << ": " << row->critical << " for " << fault.critical;
      // One mistake costs points as itself, and not again as what follows from it.
      if (const auto& share = row->judged.own_share) {
        EXPECT_GE(*share, 0.85) << fault.name << ": "
                                << boost::json::value_from(row->judged.lost_for);
      }
      if (const ExpectedWords* words = ExpectedWordsOf(*row)) {
        ++with_words;
        if (!std::ranges::count(words->faults, row->judged.said_fault))
          misnamed += "; " + fault.name + " is called " + row->judged.said_fault, ++wrong_faults;
        if (!std::ranges::count(words->remedies, row->judged.said_remedy))
          misnamed += "; " + fault.name + " is told " + row->judged.said_remedy, ++wrong_remedies;
      } else {
        EXPECT_LT(row->points_lost, 1) << fault.name << " has no words";
      }
      if (fault.name == "none") {
        EXPECT_NEAR(row->score, 100, 1e-9);
      } else if (fault.name == "nothing" || fault.name == "everything removed") {
        EXPECT_EQ(row->score, 0);
      } else {
        EXPECT_TRUE(row->CostsEnough()) << fault.name << ": " << row->points_lost;
        EXPECT_FALSE(row->CostsTooMuch()) << fault.name << ": " << row->points_lost;
      }
    }
    // As stated: 95 of 100 are called what they are.
    EXPECT_LE(20 * wrong_faults, with_words) << with_words << misnamed;
    EXPECT_LE(20 * wrong_remedies, with_words) << with_words << misnamed;
  }
  EXPECT_EQ(graded_exercises, 1U);
}

INSTANTIATE_TEST_SUITE_P(
    Exercises, Grades,
    testing::Values(Asked{"molar", "class-1"}, Asked{"molar-buccal", "class-5"},
                    Asked{"incisor-labial", "veneer"}, Asked{"block", "line"},
                    Asked{"incisor", "crown", true}, Asked{"molar-caries", "caries"},
                    Asked{"premolar", "crown", true}, Asked{"molar", "crown", true},
                    Asked{"molar", "access", true}, Asked{"block", "circle", true}),
    [](const auto& test) {
      std::string name = std::string(test.param.scene) + "_" + test.param.exercise;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

// A class I cavity whose walls diverge by so many degrees, those for mesial and distal first.
Hollow LeaningBox(const Task& task, double mesiodistal_deg, double buccolingual_deg) {
  BoxCavity box = task.box;
  for (size_t w = 0; w < 4; ++w) {
    box.faces[w].slope = std::tan((w < 2 ? mesiodistal_deg : buccolingual_deg) * kDegree);
  }
  return [box](const dvec3& p) { return box.Distance_m(p); };
}

double PointsOf(const scoring::ScoreResult& score, std::string_view metric) {
  return std::ranges::find(score.criteria, metric, &scoring::CriterionResult::name)->points;
}

TEST(GradesTest, TheMaterialDecidesWhetherConvergentWallsLosePoints) {
  const Made made = Build("molar");
  const auto found = std::ranges::find_if(
      made.exercises, [](const scene::Exercise& e) { return e.name.starts_with("class-1"); });
  ASSERT_NE(found, made.exercises.end());
  auto score = [&](scene::Restoration restoration, double mesiodistal, double buccolingual) {
    scene::Exercise exercise = *found;
    exercise.rubric.restoration = restoration;
    const auto graded = GradedExercise::Make(made.built, exercise);
    ENAMEL_CHECK(graded.ok());
    const auto scored =
        graded->Score(LeaningBox(graded->task(), mesiodistal, buccolingual), Neighbours::kSpared);
    ENAMEL_CHECK(scored.ok());
    return *scored;
  };
  using enum scene::Restoration;
  for (const double mesiodistal : {0.0, 6.0}) {
    SCOPED_TRACE(mesiodistal);
    EXPECT_LT(score(kNone, mesiodistal, -4).score, 99);
    EXPECT_NEAR(score(kAmalgam, mesiodistal, -4).score, 100, 0.05);
    EXPECT_NEAR(score(kComposite, mesiodistal, -4).score, 100, 0.05);
  }
  const scoring::ScoreResult ceramic = score(kCeramic, 6, -4);
  EXPECT_EQ(PointsOf(ceramic, "undercut_deg"), 0);
  EXPECT_NEAR(score(kCeramic, 6, 6).score, 100, 0.05);
  EXPECT_LT(score(kNone, 6, 6).score, 98);
  EXPECT_LT(PointsOf(score(kAmalgam, -6, 0), "undercut_deg"), 3);
}

// The top of a premolar falls towards its mesial edge, below where it lies over the stump's middle.
TEST(GradesTest, APremolarsWallsEndWhereItsTopBegins) {
  const Made made = Build("premolar", 2 * kVoxel_nm);
  const auto exercise = std::ranges::find_if(
      made.exercises, [](const scene::Exercise& e) { return e.name.starts_with("crown"); });
  ASSERT_NE(exercise, made.exercises.end());
  const auto graded = GradedExercise::Make(made.built, *exercise);
  ASSERT_TRUE(graded.ok());
  const std::set<std::string> asked = {"none", "convergence", "undercut", "lean"};
  size_t found = 0;
  for (const Fault& fault : FaultsOf(made.built, *exercise, graded->task(), true)) {
    if (!asked.contains(fault.name)) continue;
    ++found;
    const auto row = graded->Grade(fault);
    ASSERT_TRUE(row.ok());
    if (fault.name == "none") {
      EXPECT_NEAR(row->score, 100, 1e-9);
    } else {
      ASSERT_TRUE(row->found);
      EXPECT_NEAR(*row->found, row->size, 0.5) << fault.name;
    }
  }
  EXPECT_EQ(found, asked.size());
}

// schemas/critical_errors.json names the exercises of each error.
TEST(GradesTest, EveryCriticalErrorOfAnExerciseIsMadeAndFound) {
  std::ifstream file(ENAMEL_SOURCE_DIR "/schemas/critical_errors.json");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto errors = boost::json::parse(text).at("errors").as_array();
  ASSERT_EQ(errors.size(), scoring::CriticalErrors().size());
  struct Of {
    const char *scene, *name;
    int32_t voxel_nm;  // a gap of 0.05 mm between teeth needs the finer one
  };
  for (const Of& asked :
       {Of{"molar-class-2", "class-2", kVoxel_nm}, Of{"premolar", "crown", 2 * kVoxel_nm}}) {
    const Made made = Build(asked.scene, asked.voxel_nm);
    const auto exercise = std::ranges::find_if(
        made.exercises, [&](const scene::Exercise& e) { return e.name.starts_with(asked.name); });
    ASSERT_NE(exercise, made.exercises.end());
    const auto graded = GradedExercise::Make(made.built, *exercise);
    ASSERT_TRUE(graded.ok());
    std::set<std::string> found;
    for (const Fault& fault : FaultsOf(made.built, *exercise, graded->task(), true)) {
      const bool other = fault.name == "undercut" || fault.name == "stopped early";
      if (fault.critical.empty() || other) continue;
      const auto row = graded->Grade(fault);
      ASSERT_TRUE(row.ok());
      EXPECT_EQ(row->critical, fault.critical) << fault.name;
      EXPECT_EQ(row->score, 0) << fault.name;
      found.insert(row->critical);
    }
    for (const auto& error : errors) {
      const std::string code(error.at("code").as_string());
      EXPECT_NE(scoring::FindCriticalError(code), nullptr) << code;
      for (const auto& of : error.at("exercises").as_array()) {
        if (of != "all" && of != asked.name) continue;
        if (code == "neighbour_damaged" && std::string_view(asked.scene) == "premolar") continue;
        EXPECT_TRUE(found.contains(code)) << asked.name << ", " << code;
      }
    }
  }
}

// Each fault of a kind costs at least as much as a smaller one, for any sizes.
TEST(GradesTest, TheLargerOfTwoFaultsNeverCostsLess) {
  const Made made = Build("molar");
  auto graded = GradedExercise::Make(made.built, made.exercises.front());
  ASSERT_TRUE(graded.ok());
  std::mt19937 random(15);
  auto score = [&](size_t face, int kind, double size) {
    BoxCavity box = graded->task().box;
    Face& f = box.faces[face];
    if (kind == 0) f.moved_m = 0.8e-3 * size;
    if (kind == 1) f.slope = 0.35 * size;
    if (kind == 2) f.wave_m = 0.25e-3 * size;
    if (kind == 3) f.moved_m = -0.8e-3 * size;
    auto result =
        graded->Score([box](const dvec3& p) { return box.Distance_m(p); }, Neighbours::kSpared);
    EXPECT_TRUE(result.ok());
    return result.ok() ? result->score : -1;
  };
  const int pairs = std::getenv("ENAMEL_FULL") != nullptr ? 100 : 8;
  for (int i = 0; i < pairs; ++i) {
    const size_t face = random() % 5;
    const int kind = static_cast<int>(random() % 4);
    std::uniform_real_distribution<double> sizes(0, 1);
    const double a = sizes(random), b = sizes(random);
    // Voxels make up to a hundredth of a point between nearly equal sizes.
    EXPECT_GE(score(face, kind, std::min(a, b)) + 0.01, score(face, kind, std::max(a, b)))
        << "face " << face << ", kind " << kind << ", " << a << " and " << b;
  }
}

// The edge where they meet is the deepest place. What is left of the tooth's mesial face lies off
// too, and is charged nowhere.
TEST(GradesTest, AWallAndAFloorThatAreTooFarMakeNoGougeWhereTheyMeet) {
  const Made made = Build("molar-class-2");
  const auto exercise = std::ranges::find_if(
      made.exercises, [](const auto& e) { return e.name.starts_with("class-2"); });
  ASSERT_NE(exercise, made.exercises.end());
  auto graded = GradedExercise::Make(made.built, *exercise);
  ASSERT_TRUE(graded.ok());
  for (const double floor_mm : {0.16, 0.24}) {
    for (const double wall_mm : {0.1, 0.18}) {
      BoxCavity box = graded->task().box;
      box.faces[scoring::kFloor].moved_m = 1e-3 * floor_mm;
      box.faces[scoring::kBuccal].moved_m = 1e-3 * wall_mm;
      auto result =
          graded->Score([box](const dvec3& p) { return box.Distance_m(p); }, Neighbours::kSpared);
      ASSERT_TRUE(result.ok());
      const auto gouge = std::ranges::find(result->criteria, std::string("deepest_over_mm"),
                                           &scoring::CriterionResult::name);
      ASSERT_NE(gouge, result->criteria.end());
      EXPECT_EQ(gouge->points, gouge->max_points)
          << floor_mm << " " << wall_mm << ": " << gouge->value << ", charged " << gouge->charged;
    }
  }
}

// A gate closes, much stands, or a wall is missing: all because of the one mistake.
TEST(GradesTest, ALargeMistakeIsNamedAndChargedAsItself) {
  using Change = std::function<void(BoxCavity&)>;
  auto moved = [](scoring::Part part, double mm) -> Change {
    return [=](BoxCavity& box) { box.faces[part].moved_m = 1e-3 * mm; };
  };
  const struct {
    const char *scene, *exercise, *fault;
    std::string_view said;
    Change change;
  } rows[] = {
      {"molar", "class-1", "shift_buccal", "over_extended",
       [&](BoxCavity& box) {
         moved(scoring::kBuccal, 0.5)(box), moved(scoring::kLingual, -0.5)(box);
       }},
      {"molar-caries", "caries", "wall_buccal", "caries_left", moved(scoring::kBuccal, -0.5)},
      {"molar-buccal", "class-5", "floor", "too_deep", moved(scoring::kFloor, 1)},
      {"molar-buccal", "class-5", "floor", "too_shallow", moved(scoring::kFloor, -0.5)},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.fault + std::string(" of ") + row.exercise);
    const Made made = Build(row.scene, 2 * kVoxel_nm);
    const auto exercise = std::ranges::find_if(
        made.exercises, [&](const auto& e) { return e.name.starts_with(row.exercise); });
    ASSERT_NE(exercise, made.exercises.end());
    const auto graded = GradedExercise::Make(made.built, *exercise);
    ASSERT_TRUE(graded.ok());
    BoxCavity box = graded->task().box;
    row.change(box);
    Fault fault;
    fault.name = row.fault;
    fault.taken = [box](const dvec3& p) { return box.Distance_m(p); };
    const auto found = graded->Grade(fault);
    ASSERT_TRUE(found.ok());
    EXPECT_EQ(found->judged.said_fault, row.said)
        << boost::json::value_from(found->judged.lost_for);
    EXPECT_GE(found->judged.own_share.value_or(0), 0.85)
        << boost::json::value_from(found->judged.lost_for);
  }
}

TEST(GradesTest, ARowSaysWhatItWasAndWhatWasFoundAsTheSchemaHasIt) {
  GradeRow row{"class-1-x", "floor", 0.3, "mm", 0.05, "floor_mm", 0.31, 0.0125, 4, 96};
  EXPECT_TRUE(row.AsKnown());
  EXPECT_FALSE(row.CostsTooMuch());
  row.may_cost = 3;
  EXPECT_TRUE(row.CostsTooMuch());
  GradeRow unseen{"class-1-x",    "nothing",    10,  "deg", 0.05,
                  "undercut_deg", std::nullopt, 0.5, 100,   0};
  unseen.critical_expected = unseen.critical = "nothing_cut";
  EXPECT_FALSE(unseen.AsKnown());
  std::ifstream file(ENAMEL_SOURCE_DIR "/schemas/golden/lab_grades.json");
  const std::string golden(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(boost::json::value(GradesJson({row, unseen})), boost::json::parse(golden));
  row.found = 0.32;
  EXPECT_FALSE(row.AsKnown());
}

TEST(GradesTest, AnExerciseThatIsNotThereIsRefusedByName) {
  GradesOptions options;
  options.quick = true;
  options.voxels_nm = {400'000};
  options.exercises = {"bridge"};
  const auto rows = MeasureGrades(options);
  ASSERT_FALSE(rows.ok());
  EXPECT_EQ(rows.status().code(), Code::kNotFound);
  EXPECT_NE(rows.status().message().find("enamel-station scenes"), std::string::npos);
}

}  // namespace
}  // namespace enamel::station::lab
