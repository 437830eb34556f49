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

// The cost of known faults in the built-in exercises, on coarse grids; the lab measures on fine
// ones (enamel-lab grades).
namespace enamel::station::lab {
namespace {

constexpr int32_t kVoxel_nm = 100'000;

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

// A scene, and an exercise's name without the scene's.
struct Asked {
  const char* scene;
  const char* exercise;
  // First mistakes, at most: a pit in a corner, a rim that is wide, a hole beside the walls and a shaved tooth have
  // other names than an instructor's.
  size_t misnamed = 0;
  bool only_full = false;
};

std::string Found(const GradeRow& row) {
  std::string out;
  for (const scoring::Mistake& m : row.judged.found) {
    out += std::string(out.empty() ? "" : ", ") + std::string(NameOf(m.kind)) + " " + m.place +
           " " + std::to_string(m.points);
  }
  return out;
}
class Grades : public testing::TestWithParam<Asked> {};

// A fault at its threshold must cost at least a point.
TEST_P(Grades, EveryFaultIsFoundAndCostsAndOnlyTheReferenceIsPerfect) {
  if (GetParam().only_full && std::getenv("ENAMEL_FULL") == nullptr) {
    GTEST_SKIP() << "takes minutes: ./check --full";
  }
  const Made made = Build(GetParam().scene);
  size_t graded_exercises = 0;
  for (const scene::Exercise& exercise : made.exercises) {
    if (exercise.name != GetParam().exercise + ("-" + made.built.scene.name)) continue;
    SCOPED_TRACE(exercise.name);
    ++graded_exercises;
    auto graded = GradedExercise::Make(made.built, exercise);
    ASSERT_TRUE(graded.ok()) << graded.status().message();
    size_t named = 0, misnamed = 0;
    std::string others;
    for (const Fault& fault : FaultsOf(made.built, exercise, graded->task(), true)) {
      auto row = graded->Grade(fault);
      ASSERT_TRUE(row.ok()) << row.status().message();
      EXPECT_TRUE(row->AsKnown()) << fault.name << ", " << row->metric << ": "
                                  << row->found.value_or(std::nan("")) << " for " << row->size
                                  << " +- " << row->tolerance;
      EXPECT_EQ(row->critical.empty(), fault.critical.empty())
          << fault.name << ": " << row->critical << " for " << fault.critical;
      EXPECT_TRUE(row->judged.sentences.wrong.empty())
          << fault.name << ": " << row->judged.sentences.wrong.front();
      EXPECT_LT(row->judged.sum_error, 1e-9) << fault.name;
      if (row->NamesItsMistake()) {
        ++named;
        if (!row->judged.FirstIsRight())
          ++misnamed, others += "; " + fault.name + ": " + Found(*row);
      }
      if (fault.name == "none") {
        EXPECT_NEAR(row->score, 100, 1e-9);
        EXPECT_TRUE(row->judged.found.empty());
      } else if (fault.name == "nothing" || fault.name == "everything removed") {
        EXPECT_EQ(row->score, 0);
      } else {
        EXPECT_TRUE(row->CostsEnough()) << fault.name << ": " << row->points_lost;
        EXPECT_FALSE(row->CostsTooMuch()) << fault.name << ": " << row->points_lost;
      }
    }
    EXPECT_LE(misnamed, GetParam().misnamed) << "of " << named << others;
  }
  EXPECT_EQ(graded_exercises, 1U);
}

INSTANTIATE_TEST_SUITE_P(
    Exercises, Grades,
    testing::Values(Asked{"molar", "class-1", 3}, Asked{"molar-buccal", "class-5", 5},
                    Asked{"incisor-labial", "veneer", 4}, Asked{"block", "line", 3},
                    Asked{"incisor", "crown", 5, true}, Asked{"molar-caries", "caries", 3},
                    Asked{"premolar", "crown", 4, true}, Asked{"molar", "crown", 5, true},
                    Asked{"molar", "access", 5, true}, Asked{"block", "circle", 4, true},
                    Asked{"molar-left", "fissures", 0, true}, Asked{"premolar", "access", 0, true},
                    Asked{"molar-buccal", "trapezoid", 0, true},
                    Asked{"primary-molar", "pulpotomy", 0, true}),
    [](const auto& test) {
      std::string name = std::string(test.param.scene) + "_" + test.param.exercise;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

TEST(GradesTest, TheMaterialsPricesCountInPlaceOfTheRubrics) {
  const Made made = Build("molar", 2 * kVoxel_nm);
  const auto found = std::ranges::find_if(
      made.exercises, [](const scene::Exercise& e) { return e.name.starts_with("class-1"); });
  ASSERT_NE(found, made.exercises.end());
  auto lost = [&](scene::Restoration restoration) {
    scene::Exercise exercise = *found;
    scene::Rubric& rubric = exercise.rubric;
    scene::RubricPrice dearer = *std::ranges::find(rubric.prices, "wall", &scene::RubricPrice::of);
    dearer.points *= 2;
    dearer.most *= 2;
    rubric.restoration = restoration;
    rubric.restorations = {{scene::Restoration::kCeramic, "chosen", {dearer}, {}}};
    const auto graded = GradedExercise::Make(made.built, exercise);
    ENAMEL_CHECK(graded.ok());
    BoxCavity box = graded->task().box;
    box.faces[scoring::kBuccal].moved_m = 0.4e-3;
    const auto scored =
        graded->Score([box](const dvec3& p) { return box.Distance_m(p); }, Neighbours::kSpared);
    ENAMEL_CHECK(scored.ok());
    return 100 - scored->score;
  };
  const double usual = lost(scene::Restoration::kNone);
  EXPECT_GT(usual, 1);
  EXPECT_GT(lost(scene::Restoration::kCeramic), 1.3 * usual);
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

// The edge where they meet is the deepest place.
TEST(GradesTest, AWallAndAFloorThatAreTooFarAreTwoMistakesAndNoneWhereTheyMeet) {
  const Made made = Build("molar-class-2");
  const auto exercise = std::ranges::find_if(
      made.exercises, [](const auto& e) { return e.name.starts_with("class-2"); });
  ASSERT_NE(exercise, made.exercises.end());
  auto graded = GradedExercise::Make(made.built, *exercise);
  ASSERT_TRUE(graded.ok());
  BoxCavity box = graded->task().box;
  box.faces[scoring::kFloor].moved_m = 0.3e-3;
  box.faces[scoring::kBuccal].moved_m = 0.3e-3;
  auto result =
      graded->Score([box](const dvec3& p) { return box.Distance_m(p); }, Neighbours::kSpared);
  ASSERT_TRUE(result.ok());
  double points = 0, own = 0;
  for (const scoring::Mistake& m : result->mistakes) {
    points += m.points;
    const bool wall = m.kind == scoring::MistakeKind::kOverExtended && m.place == "wall_buccal";
    const bool floor = m.kind == scoring::MistakeKind::kDeep && m.place.starts_with("floor");
    if (wall || floor) own += m.points;
  }
  EXPECT_GT(points, 5);
  EXPECT_GT(own, 0.85 * points);
}

// Caries is left, or a cavity is as deep again: all because of the one mistake.
TEST(GradesTest, ALargeMistakeIsNamedAndChargedAsItself) {
  using Change = std::function<void(BoxCavity&)>;
  auto moved = [](scoring::Part part, double mm) -> Change {
    return [=](BoxCavity& box) { box.faces[part].moved_m = 1e-3 * mm; };
  };
  const struct {
    const char *scene, *exercise, *fault;
    double size;
    Change change;
  } rows[] = {
      {"molar-caries", "caries", "wall_buccal", -0.5, moved(scoring::kBuccal, -0.5)},
      {"molar-buccal", "class-5", "floor", 1, moved(scoring::kFloor, 1)},
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
    fault.size = row.size;
    fault.taken = [box](const dvec3& p) { return box.Distance_m(p); };
    const auto found = graded->Grade(fault);
    ASSERT_TRUE(found.ok());
    EXPECT_TRUE(found->judged.FirstIsRight()) << Found(*found);
    EXPECT_GE(found->judged.OwnShare().value_or(0), 0.85) << Found(*found);
  }
}

// The check itself: a true sentence passes, and each way of being false is seen.
TEST(SentencesTest, AFalseSentenceIsFound) {
  using enum scoring::MistakeKind;
  const cutting::Volume block = FaultBlock({});
  const Hollow task = [box = FaultBlockCavity()](const dvec3& p) { return box.Distance_m(p); };
  const cutting::Volume exact = CutAway(block, task);
  const scoring::AcceptableCut r(block, exact, {});
  BoxCavity over = FaultBlockCavity();
  over.faces[scoring::kMesial].moved_m = 0.3e-3;
  const cutting::Volume attempt =
      CutAway(block, [over](const dvec3& p) { return over.Distance_m(p); });
  std::vector<scoring::RegionMeasure> measures =
      scoring::MeasuresOf(r, scoring::MeasureFaults(r, attempt));
  std::vector<scoring::RegionCost> costs(measures.size());
  for (size_t i = 0; i < measures.size(); ++i) {
    if (measures[i].name == "wall_mesial") costs[i] = {true, 5, scoring::State::kModify};
  }
  auto wrong = [&](scoring::MistakeKind kind, const char* place, double size = 0.3) {
    scoring::Mistake m;
    m.kind = kind, m.place = place, m.size = size, m.points = 5;
    return CheckSentences(r, attempt, measures, costs, {m}).wrong.size();
  };
  EXPECT_EQ(wrong(kOverExtended, "wall_mesial"), 0u);
  EXPECT_EQ(wrong(kOverExtended, "wall"), 0u);
  EXPECT_EQ(wrong(kUnderExtended, "wall_mesial"), 1u) << "the other side";
  EXPECT_EQ(wrong(kOverExtended, "wall_distal"), 1u) << "another place";
  EXPECT_EQ(wrong(kDeep, "floor"), 1u);
  EXPECT_EQ(wrong(kHole, ""), 1u);
  EXPECT_EQ(wrong(kNeighbour, ""), 1u);
  EXPECT_EQ(wrong(kNotDone, ""), 1u);
  EXPECT_EQ(wrong(kOverExtended, "wall_mesial", -0.3), 1u);
  EXPECT_EQ(CheckSentences(r, attempt, measures, costs, {scoring::Mistake{}}).said, 0u)
      << "without points";
}

TEST(GradesTest, ARowSaysWhatItWasAndWhatWasFoundAsTheSchemaHasIt) {
  GradeRow row{"class-1-x", "floor", 0.3, "mm", 0.05, "floor_mm", 0.31, 0.0125, 4, 96};
  EXPECT_TRUE(row.AsKnown());
  EXPECT_FALSE(row.CostsTooMuch());
  row.may_cost = 3;
  EXPECT_TRUE(row.CostsTooMuch());
  row.judged.expected = {{scoring::MistakeKind::kDeep, "floor"}};
  row.judged.found.resize(2);
  row.judged.found[0].kind = scoring::MistakeKind::kDeep;
  row.judged.found[1].kind = scoring::MistakeKind::kPit;
  row.judged.found[0].place = row.judged.found[1].place = "floor_1";
  row.judged.found[0].size = 0.29, row.judged.found[1].size = 0.4;
  row.judged.found[0].points = 3, row.judged.found[1].points = 1;
  row.judged.sentences = {2, {"pit at floor_1: nothing was cut too far there"}};
  row.judged.sum_error = 0.5;
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
