#include "server/training/grade.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

GradedAttempt Scored(uint8_t id, double score, bool shown = true) {
  GradedAttempt out;
  out.id.bytes[0] = id;
  out.ticketed_ms = id;
  out.score = score;
  out.shown = shown;
  return out;
}

const std::vector<GradedAttempt> kThree = {Scored(1, 70), Scored(2, 90), Scored(3, 85)};

TEST(GradeTest, OneResultOfSeveralAttemptsByWhatTheAssignmentSays) {
  EXPECT_EQ(GradeOver(Counting::kBest, kThree).score, 90);
  EXPECT_EQ(GradeOver(Counting::kLast, kThree).score, 85);
  EXPECT_EQ(GradeOver(Counting::kMean, kThree).score, (70.0 + 90.0 + 85.0) / 3);
  EXPECT_EQ(GradeOver(Counting::kMedian, kThree).score, 85);
  EXPECT_EQ(GradeOver(Counting::kBest, kThree).attempt, kThree[1].id);
  EXPECT_EQ(GradeOver(Counting::kLast, kThree).attempt, kThree[2].id);
  EXPECT_FALSE(GradeOver(Counting::kMean, kThree).attempt.has_value());
  for (Counting counting : {Counting::kBest, Counting::kLast, Counting::kMean, Counting::kMedian}) {
    EXPECT_EQ(GradeOver(counting, kThree).counted, 3u);
    EXPECT_EQ(CountingFromName(CountingName(counting)), counting);
    // One attempt is its own result, whatever counts.
    EXPECT_EQ(GradeOver(counting, {Scored(1, 62.5)}).score, 62.5);
    EXPECT_EQ(GradeOver(counting, {kThree[2], kThree[0], kThree[1]}).score,
              GradeOver(counting, kThree).score)
        << "the order in which they are read changes nothing";
  }
  EXPECT_FALSE(CountingFromName("worst").has_value());
}

TEST(GradeTest, MedianOfAnEvenNumberIsTheMeanOfTheTwoInTheMiddle) {
  EXPECT_EQ(GradeOver(Counting::kMedian, {Scored(1, 70), Scored(2, 85)}).score, 77.5);
  EXPECT_EQ(
      GradeOver(Counting::kMedian, {Scored(1, 100), Scored(2, 0), Scored(3, 60), Scored(4, 70)})
          .score,
      65);
}

TEST(GradeTest, AttemptWithoutAScoreIsMadeAndDoesNotCount) {
  GradedAttempt waits = Scored(9, 0);
  waits.score.reset();
  std::vector<GradedAttempt> attempts = kThree;
  attempts.push_back(waits);
  const Grade grade = GradeOver(Counting::kLast, attempts);
  EXPECT_EQ(grade.attempts, 4u);
  EXPECT_EQ(grade.counted, 3u);
  EXPECT_EQ(grade.score, 85);
  const Grade none = GradeOver(Counting::kMean, {waits});
  EXPECT_EQ(none.attempts, 1u);
  EXPECT_FALSE(none.score.has_value() || none.shown);
  EXPECT_FALSE(GradeOver(Counting::kBest, {}).score.has_value());
}

TEST(GradeTest, NoResultIsToldWhileAnAttemptWithoutItsScoreIsGradedAgain) {
  GradedAttempt low{Uuid::New(), 1, 0.0, true}, again{Uuid::New(), 2, {}, false, true};
  Grade grade = GradeOver(Counting::kBest, {low, again});
  EXPECT_TRUE(grade.regrading);
  EXPECT_EQ(grade.score, std::nullopt) << "0.0 is the other attempt's";
  EXPECT_EQ(grade.attempt, std::nullopt);
  again.score = 80;
  grade = GradeOver(Counting::kBest, {low, again});
  EXPECT_TRUE(grade.regrading);
  EXPECT_EQ(grade.score, 80) << "who sees the score of before is told it, and that it may change";
}

TEST(GradeTest, ResultIsShownOnceEveryScoreThatCountsIs) {
  EXPECT_TRUE(GradeOver(Counting::kBest, kThree).shown);
  EXPECT_FALSE(GradeOver(Counting::kBest, {Scored(1, 90), Scored(2, 10, false)}).shown);
}

TEST(GradeTest, EqualScoresAreDecidedByWhichWasFirst) {
  EXPECT_EQ(GradeOver(Counting::kBest, {Scored(2, 80), Scored(1, 80)}).attempt, Scored(1, 80).id);
}

TEST(GradeTest, CohortIsSummedUpOverThoseWhoHaveAResult) {
  std::vector<Grade> grades(4);
  grades[0].score = 50;
  grades[1].score = 80;
  grades[3].score = 90;
  const GradeSummary sum = SummaryOf(grades);
  EXPECT_EQ(sum.students, 4u);
  EXPECT_EQ(sum.graded, 3u);
  EXPECT_EQ(sum.mean, (50.0 + 80.0 + 90.0) / 3);
  EXPECT_EQ(sum.median, 80);
  EXPECT_EQ(sum.lowest, 50);
  EXPECT_EQ(sum.highest, 90);
  EXPECT_FALSE(SummaryOf({Grade{}}).mean.has_value());
}

}  // namespace
}  // namespace enamel::server
