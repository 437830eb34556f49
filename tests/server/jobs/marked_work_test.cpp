#include "server/jobs/marked_work.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "server/agreement/standard.h"

namespace enamel::server {
namespace {

scoring::CriterionResult Criterion(const char* name, scoring::Group group, double lost,
                                   double most) {
  scoring::CriterionResult out;
  out.name = name;
  out.group = group;
  out.title = std::string("Title of ") + name;
  out.lost = lost;
  out.most = most;
  return out;
}

// Walls that cost more than their group's full marks, and a bur pressed too hard.
scoring::ScoreResult SomeScore() {
  scoring::ScoreResult out;
  out.score = 25;
  out.criteria = {Criterion("outline", scoring::Group::kOutline, 68, 50),
                  Criterion("internal_form", scoring::Group::kInternalForm, 0.001, 50),
                  Criterion("force_sent_p95_n", scoring::Group::kHand, 7, 10)};
  return out;
}

TEST(MarkedWorkTest, TheProgramMarksTheGroupsAndTakesNoMoreOffThanFullMarks) {
  const Uuid attempt = Uuid::New();
  const auto marks = ComputedMarks({{attempt, SomeScore()}});
  ASSERT_EQ(marks.size(), 3u) << "two groups and the total: nobody marks the hand";
  EXPECT_EQ(marks[0].criterion, "Title of outline");
  EXPECT_EQ(marks[0].points, 0);
  EXPECT_EQ(marks[0].full_marks, 50);
  EXPECT_NEAR(marks[1].points, 49.999, 1e-9);
  EXPECT_EQ(marks[2].criterion, kTotalCriterion);
  EXPECT_EQ(marks[2].points, 25);
  EXPECT_TRUE(std::ranges::all_of(marks, [&](const Mark& mark) {
    return mark.work == attempt.Text() && mark.marker == kComputed;
  }));
}

}  // namespace
}  // namespace enamel::server
