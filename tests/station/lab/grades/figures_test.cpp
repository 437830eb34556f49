#include "station/lab/grades/figures.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace enamel::station::lab {
namespace {

scoring::Mistake Mistake(scoring::MistakeKind kind, double points) {
  scoring::Mistake out;
  out.kind = kind;
  out.place = "wall_mesial";
  out.points = points;
  return out;
}

GradeRow Row(const char* exercise, const char* fault, double lost) {
  GradeRow row{exercise, fault, 0.3, "mm", 0.1, "wall_mesial_mm", 0.3, 0.025, lost, 100 - lost};
  row.judged.expected = {{scoring::MistakeKind::kOverExtended, "wall_mesial"}};
  row.judged.found = {Mistake(scoring::MistakeKind::kOverExtended, lost)};
  row.judged.sentences.said = 1;
  return row;
}

const GradeFigure& Find(const std::vector<GradeFigure>& figures, const std::string& part) {
  static const GradeFigure kNone;
  const auto it = std::ranges::find_if(
      figures, [&](const GradeFigure& f) { return f.what.find(part) != std::string::npos; });
  EXPECT_NE(it, figures.end()) << part;
  return it == figures.end() ? kNone : *it;
}

// So that the expected mistake has this share of the points.
void Share(GradeRow& row, double share) {
  row.judged.found = {Mistake(scoring::MistakeKind::kOverExtended, 6 * share),
                      Mistake(scoring::MistakeKind::kPit, 6 * (1 - share))};
}

TEST(FiguresTest, TheFifthPercentileLeavesOutOneInTwentyAndNamesIt) {
  std::vector<GradeRow> rows(21, Row("class-1-x", "wall_mesial", 6));
  Share(rows[3], 0.2);
  EXPECT_EQ(Find(FiguresOf(rows), "percentile of all").value, "1.000");
  EXPECT_EQ(Find(FiguresOf(rows), "percentile of all").misses.size(), 1u);
  Share(rows[4], 0.5);
  EXPECT_EQ(Find(FiguresOf(rows), "percentile of all").value, "0.500");
  // Of an exercise with one row it counts at once.
  rows[5].exercise = "crown-x";
  Share(rows[5], 0.7);
  const auto figures = FiguresOf(rows);
  EXPECT_EQ(Find(figures, "worst exercise").value, "0.200");
  EXPECT_EQ(Find(figures, "worst exercise").misses.size(), 2u);
}

TEST(FiguresTest, ARowWhoseFirstMistakeIsAnotherOrNoneIsAMiss) {
  std::vector<GradeRow> rows(3, Row("class-1-x", "wall_mesial", 6));
  rows[1].judged.found.insert(rows[1].judged.found.begin(), Mistake(scoring::MistakeKind::kPit, 7));
  rows[2].judged.found.clear();
  EXPECT_EQ(Find(FiguresOf(rows), "named as an instructor would, cavities").value, "1 of 3");
  rows[2].points_lost = 0.9;
  EXPECT_EQ(Find(FiguresOf(rows), "named as an instructor would, cavities").value, "1 of 2")
      << "too little to be said";
  rows[0].exercise = "crown-x";
  EXPECT_EQ(Find(FiguresOf(rows), "named as an instructor would, crowns").value, "1 of 1");
}

TEST(FiguresTest, FalseSentencesAndLargerFaultsThatCostLessAreMisses) {
  std::vector<GradeRow> rows(2, Row("class-1-x", "wall_mesial", 24));
  rows[0].judged.sentences.wrong = {"pit at floor: nothing was cut too far there"};
  EXPECT_EQ(Find(FiguresOf(rows), "sentences that are true").value, "1 of 2");
  rows[1].size = 1;
  rows[1].points_lost = 20;
  EXPECT_EQ(Find(FiguresOf(rows), "cost less than smaller").value, "1");
  EXPECT_EQ(Find(FiguresOf(rows), "millimetre").value, "0 of 1");
  rows[1].size = -1;
  EXPECT_EQ(Find(FiguresOf(rows), "cost less than smaller").value, "0") << "another fault";
  rows[1].critical = "pulp_exposed";
  EXPECT_EQ(Find(FiguresOf(rows), "critical").value, "1 of 2");
}

}  // namespace
}  // namespace enamel::station::lab
