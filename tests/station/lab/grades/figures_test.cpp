#include "station/lab/grades/figures.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace enamel::station::lab {
namespace {

GradeRow Row(const char* exercise, const char* fault, double lost) {
  GradeRow row{exercise, fault, 0.3, "mm", 0.1, "wall_mesial_mm", 0.3, 0.025, lost, 100 - lost};
  row.judged.cause = "wall";
  row.judged.own_share = 1;
  row.judged.said_fault = "over_extended";
  row.judged.said_remedy = "stop_earlier";
  return row;
}

const GradeFigure& Find(const std::vector<GradeFigure>& figures, const std::string& part) {
  static const GradeFigure kNone;
  const auto it = std::ranges::find_if(
      figures, [&](const GradeFigure& f) { return f.what.find(part) != std::string::npos; });
  EXPECT_NE(it, figures.end()) << part;
  return it == figures.end() ? kNone : *it;
}

TEST(FiguresTest, TheFifthPercentileLeavesOutOneInTwentyAndNamesIt) {
  std::vector<GradeRow> rows(21, Row("class-1-x", "wall_mesial", 6));
  rows[3].judged.own_share = 0.2;
  EXPECT_EQ(Find(FiguresOf(rows), "percentile of all").value, "1.000");
  EXPECT_EQ(Find(FiguresOf(rows), "percentile of all").misses.size(), 1u);
  rows[4].judged.own_share = 0.5;
  EXPECT_EQ(Find(FiguresOf(rows), "percentile of all").value, "0.500");
  // Of an exercise with one row it counts at once.
  rows[5].exercise = "crown-x", rows[5].judged.own_share = 0.7;
  const auto figures = FiguresOf(rows);
  EXPECT_EQ(Find(figures, "worst exercise").value, "0.200");
  EXPECT_EQ(Find(figures, "worst exercise").misses.size(), 2u);
}

TEST(FiguresTest, ARowThatIsCalledByAnotherNameOrNoneIsAMiss) {
  std::vector<GradeRow> rows(3, Row("class-1-x", "wall_mesial", 6));
  rows[1].judged.said_fault = "gouge";
  rows[2].judged.said_fault = rows[2].judged.said_remedy = "";
  EXPECT_EQ(Find(FiguresOf(rows), "mistakes named").value, "1 of 3");
  EXPECT_EQ(Find(FiguresOf(rows), "remedies named").value, "2 of 3");
  rows[2].points_lost = 0.9;
  EXPECT_EQ(Find(FiguresOf(rows), "mistakes named").value, "1 of 2") << "too little to be said";
}

TEST(FiguresTest, AWallThatIsChargedAsAGougeAndAMillimetreThatCostsLittleAreMisses) {
  std::vector<GradeRow> rows(2, Row("class-1-x", "wall_mesial", 24));
  rows[0].judged.lost_for = {"wall_mesial_mm 20.0", "gate deepest_over_mm 4.0"};
  rows[0].size = 1;
  rows[1].judged.lost_for = {"wall_mesial_mm 20.0", "deepest_over_mm 4.0"};
  EXPECT_EQ(Find(FiguresOf(rows), "waves or gouges").value, "1 of 2")
      << "a gate takes what it takes";
  EXPECT_EQ(Find(FiguresOf(rows), "millimetre").value, "0 of 1");
  rows[1].critical = "pulp_exposed";
  EXPECT_EQ(Find(FiguresOf(rows), "critical").value, "1 of 2");
}

}  // namespace
}  // namespace enamel::station::lab
