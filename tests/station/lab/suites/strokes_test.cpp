#include <gtest/gtest.h>

#include <map>

#include "common/fidelity/way.h"
#include "station/lab/suites/exercise_strokes.h"

namespace enamel::station::lab {
namespace {

TEST(ExerciseStrokesTest, EachStandsForTheSameTimeOfItsExerciseAndIsCutInItsTissue) {
  const auto found = StrokesOfExercises({.scenes = {"block"}, .people = {"dentist"}, .each = 3});
  ASSERT_TRUE(found.ok()) << found.status().message();
  std::map<std::string, std::vector<const ExerciseStroke*>> by_exercise;
  for (const ExerciseStroke& s : *found) {
    by_exercise[s.exercise].push_back(&s);
    const double length_s = static_cast<double>(s.way_m.size()) * fidelity::kWayStep_s;
    EXPECT_GE(length_s, 0.3) << s.exercise << " " << s.name;
    EXPECT_LE(length_s, 4) << s.exercise << " " << s.name;
    // Enamel with all of a cylinder is 6.5 to 11 N s/mm, a bur that only polishes some N s/m.
    EXPECT_GT(s.b_n_s_per_m, 1) << s.exercise << " " << s.name;
    EXPECT_LT(s.b_n_s_per_m, 11'300) << s.exercise << " " << s.name;
    EXPECT_GT(s.speed_m_per_s, 0.02e-3);
    EXPECT_LT(s.speed_m_per_s, 10e-3);
  }
  EXPECT_GE(by_exercise.size(), 4u);
  for (const auto& [exercise, strokes] : by_exercise) {
    ASSERT_EQ(strokes.size(), 3u) << exercise;
    for (const ExerciseStroke* s : strokes)
      EXPECT_DOUBLE_EQ(s->seconds, strokes.front()->seconds) << exercise;
  }
}

}  // namespace
}  // namespace enamel::station::lab
