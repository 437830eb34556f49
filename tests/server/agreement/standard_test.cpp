#include "server/agreement/standard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <random>

namespace enamel::server {
namespace {

// Points of a marked attempt at `base` + `step` for each rating, with some spread.
std::vector<RatedWork> Drawn(size_t works, double base, double step, double spread,
                             std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> rating(1, 5);
  std::vector<RatedWork> out;
  for (size_t i = 0; i < works; ++i) {
    const int r = rating(random);
    out.push_back({base + step * r + spread * normal(random), {r}});
  }
  return out;
}

TEST(StandardTest, OnALineTheCutIsWhatTheLineGivesForBorderline) {
  std::vector<RatedWork> works;
  for (int i = 0; i < 10; ++i) works.push_back({30 + 12.0 * (1 + i % 5), {1 + i % 5}});
  const auto cut = BorderlineRegression(works);
  ASSERT_TRUE(cut.ok()) << cut.status().message();
  EXPECT_NEAR(cut->cut.value, 54, 1e-9);
  EXPECT_NEAR(cut->cut.interval.low, 54, 1e-9);
  EXPECT_NEAR(cut->cut.interval.high, 54, 1e-9);
  EXPECT_NEAR(cut->points_per_rating, 12, 1e-9);
  EXPECT_NEAR(cut->explained, 1, 1e-9);
  EXPECT_TRUE(cut->few);
}

// By hand: ratings 1, 2, 2, 3, 3, 3, 4, 5 and points 40, 50, 55, 58, 62, 66, 75, 90 have the means
// 2.875 and 62, and sums of squares 10.875 (ratings) and 132 (both).
TEST(StandardTest, AWorkedExampleIsFound) {
  const auto cut = BorderlineRegression(
      {{40, {1}}, {50, {2}}, {55, {2}}, {58, {3}}, {62, {3}}, {66, {3}}, {75, {4}}, {90, {5}}});
  ASSERT_TRUE(cut.ok());
  EXPECT_NEAR(cut->points_per_rating, 132 / 10.875, 1e-9);
  EXPECT_NEAR(cut->cut.value, 62 - 0.875 * 132 / 10.875, 1e-9);
}

TEST(StandardTest, TheIntervalHoldsTheTruthAboutAsOftenAsItSays) {
  std::mt19937_64 random(3);
  int held = 0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    const auto cut = BorderlineRegression(Drawn(40, 30, 12, 8, random));
    ASSERT_TRUE(cut.ok());
    EXPECT_FALSE(cut->few);
    held += cut->cut.interval.low <= 54 && 54 <= cut->cut.interval.high ? 1 : 0;
  }
  // 95 %, less what percentile intervals of 40 draws are known to lack; 0.88 is three errors below
  // 0.94.
  EXPECT_GE(held, 0.88 * kRuns);
  EXPECT_LE(held, 0.995 * kRuns);
}

TEST(StandardTest, TooFewAttemptsOrRatingsAreRefusedWithTheReason) {
  std::mt19937_64 random(5);
  auto why = [](const std::vector<RatedWork>& works) {
    const auto cut = BorderlineRegression(works);
    EXPECT_FALSE(cut.ok());
    EXPECT_EQ(cut.status().code(), Code::kInvalidInput);
    return cut.status().message();
  };
  EXPECT_NE(why(Drawn(7, 30, 12, 5, random)).find("found 7"), std::string::npos);
  std::vector<RatedWork> two = Drawn(20, 30, 12, 5, random);
  for (RatedWork& work : two) work.ratings = {work.points > 60 ? 3 : 2};
  EXPECT_NE(why(two).find("different ratings at least, found 2"), std::string::npos);
  std::vector<RatedWork> upside_down = Drawn(20, 30, 12, 1, random);
  for (RatedWork& work : upside_down) work.points = 100 - work.points;
  EXPECT_NE(why(upside_down).find("no more points"), std::string::npos);
  std::vector<RatedWork> beyond = Drawn(20, 30, 12, 1, random);
  beyond[3].ratings = {6};
  EXPECT_NE(why(beyond).find("found 6"), std::string::npos);
}

Mark Of(std::string work, std::string criterion, std::string marker, double points,
        std::optional<double> full = {}) {
  return {std::move(work), std::move(criterion), std::move(marker), points, full};
}

// Two examiners, 30 points: 18 and 21 are 60 and 70 %. Student's t of one degree of freedom is
// 12.706; the spread of the two 7.071.
TEST(StandardTest, AngoffIsTheMeanOfWhatExaminersExpect) {
  const std::string work(kBorderlineWork);
  const std::vector<Mark> marks = {Of(work, "Floor", "A", 6, 10), Of(work, "Floor", "B", 7, 10),
                                   Of(work, "Walls", "A", 12, 20), Of(work, "Walls", "B", 14, 20)};
  const auto cut = Angoff(marks);
  ASSERT_TRUE(cut.ok()) << cut.status().message();
  EXPECT_NEAR(cut->cut.value, 65, 1e-9);
  EXPECT_NEAR(cut->cut.interval.low, 65 - 12.7062 * 7.0711 / std::sqrt(2.0), 0.01);
  EXPECT_EQ(cut->cut.interval.high, 100);
  ASSERT_EQ(cut->criteria.size(), 2U);
  EXPECT_EQ(cut->criteria[0].criterion, "Floor");
  EXPECT_NEAR(cut->criteria[0].mean, 6.5, 1e-9);

  auto without = [&](size_t i) {
    std::vector<Mark> less = marks;
    less.erase(less.begin() + static_cast<std::ptrdiff_t>(i));
    return Angoff(less).status();
  };
  EXPECT_NE(without(3).message().find("2 examiners for \"Walls\", found 1"), std::string::npos);
  EXPECT_FALSE(Angoff({marks[0], marks[2]}).ok()) << "one examiner";
  std::vector<Mark> other = marks;
  other[3].full_marks = 25;
  EXPECT_EQ(Angoff(other).status().field(), "full_marks");
}

// Shrout and Fleiss 1979, table 4: ICC(2,4) is .62.
const MarkTable kFourJudges = {{9, 2, 5, 8}, {6, 1, 3, 2},  {8, 4, 6, 8},
                               {7, 1, 2, 6}, {10, 5, 6, 9}, {6, 2, 4, 7}};

TEST(StandardTest, DependabilityIsThePublishedFigureForTheMeanOfAllMarkers) {
  const auto phi = Dependability(kFourJudges);
  ASSERT_TRUE(phi.ok());
  EXPECT_NEAR(phi->value, 0.62, 0.005);
  EXPECT_LT(phi->interval.low, phi->value);
  EXPECT_GT(phi->interval.high, phi->value);
}

double MeanOf(const MarkTable& marks) {
  double sum = 0;
  for (const auto& row : marks) {
    for (double mark : row) sum += mark;
  }
  return sum / double(marks.size() * marks[0].size());
}

// Brennan's form of the unbiased Φ(λ), which needs no analysis of variance: the mean of squares
// within rows over k - 1 is the error of a row's mean, and the spread of row means (over n) with
// (mean - λ)^2 is the whole. For marks of 0 and 1 the squares within are what is left of
// mean (1 - mean), and this is his formula 1 - (m (1 - m) - s2) / ((k - 1) ((m - λ)^2 + s2)).
double ClosedPhiAt(const MarkTable& marks, double cut) {
  const double n = double(marks.size()), k = double(marks[0].size()), mean = MeanOf(marks);
  double within = 0, spread = 0;
  for (const auto& row : marks) {
    const double of_row = MeanOf({row});
    spread += (of_row - mean) * (of_row - mean) / n;
    for (double mark : row) within += (mark - of_row) * (mark - of_row) / (n * k);
  }
  return 1 - within / ((k - 1) * ((mean - cut) * (mean - cut) + spread));
}

// Marks of 0 to `most`, of work that differs by `work` and markers that differ by `marker`.
MarkTable DrawnMarks(size_t n, size_t k, double work, double marker, double most,
                     std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<double> strict(k);
  for (double& each : strict) each = marker * normal(random);
  MarkTable out(n, std::vector<double>(k));
  for (auto& row : out) {
    const double worth = work * normal(random);
    for (size_t j = 0; j < k; ++j) {
      const double mark = most / 2 + worth + strict[j] + normal(random);
      row[j] = std::clamp(std::round(mark), 0.0, most);
    }
  }
  return out;
}

// Work differs by more than chance here: the variance of the mean is not estimated below 0, where it
// is cut off.
TEST(StandardTest, PhiOfACutIsBrennansClosedForm) {
  EXPECT_NEAR(DependabilityAt(kFourJudges, 10)->value, ClosedPhiAt(kFourJudges, 10), 1e-12);
  std::mt19937_64 random(11);
  for (const double most : {1.0, 5.0, 100.0}) {
    for (int run = 0; run < 20; ++run) {
      const MarkTable marks = DrawnMarks(12, 2 + run % 3, 1 + most / 5, most / 10, most, random);
      // Beyond the marks: there the squared distance is larger than its variance.
      for (const double cut : {-0.5 * most, 1.5 * most}) {
        const auto phi = DependabilityAt(marks, cut);
        ASSERT_TRUE(phi.ok()) << phi.status().message();
        EXPECT_NEAR(phi->value, ClosedPhiAt(marks, cut), 1e-9) << most << " " << run;
      }
    }
  }
}

// Also where markers differ less, or work does, than chance alone would have it: the variances are
// then estimated below 0.
TEST(StandardTest, PhiOfACutIsLeastAtTheMeanAndIsPhiThere) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> anywhere(-5, 15);
  int few_markers = 0, few_work = 0;
  for (int run = 0; run < 150; ++run) {
    const MarkTable marks =
        DrawnMarks(3 + run % 7, 2 + run % 3, run % 4, run % 2 == 0 ? 0 : 2, 10, random);
    const auto phi = Dependability(marks);
    if (!phi.ok()) continue;  // all work is alike
    const double mean = MeanOf(marks);
    const auto at_mean = DependabilityAt(marks, mean);
    if (!at_mean.ok()) continue;  // too many draws are
    EXPECT_NEAR(at_mean->value, phi->value, 1e-12) << run;
    for (const double cut : {mean + 0.01, mean - 0.5, mean + 2, anywhere(random)}) {
      EXPECT_GE(DependabilityAt(marks, cut)->value, phi->value) << run << " at " << cut;
    }
    // Only where markers differ less than by chance is Φ above the consistency of the same marks.
    few_markers += phi->value > Icc3k(marks)->value ? 1 : 0;
    few_work += phi->value < 0 ? 1 : 0;
  }
  EXPECT_GT(few_markers, 15);
  EXPECT_GT(few_work, 5);
}

TEST(StandardTest, ADecisionFarFromTheMeanIsMoreDependable) {
  const double mean = MeanOf(kFourJudges);
  const auto at_mean = DependabilityAt(kFourJudges, mean);
  ASSERT_TRUE(at_mean.ok()) << at_mean.status().message();
  EXPECT_NEAR(at_mean->value, 0.62, 0.005);
  double last = at_mean->value;
  for (double away : {2.0, 4.0, 8.0}) {
    for (double cut : {mean - away, mean + away}) {
      EXPECT_GT(DependabilityAt(kFourJudges, cut)->value, last) << cut;
    }
    last = DependabilityAt(kFourJudges, mean + away)->value;
  }
  EXPECT_EQ(DependabilityAt(kFourJudges, std::nan("")).status().field(), "cut");
}

TEST(StandardTest, OneMarkersTotalsHaveNoDependability) {
  std::vector<Mark> marks;
  for (int i = 0; i < 12; ++i) {
    marks.push_back(Of("w" + std::to_string(i), "rating", "A", 1 + i % 5));
    marks.push_back(Of("w" + std::to_string(i), "total", "A", 30 + 10 * (i % 5)));
  }
  const auto standard = SetStandard(marks);
  ASSERT_TRUE(standard.ok() && standard->borderline) << "a pass mark there is";
  EXPECT_EQ(standard->why_no_agreement.find("agreement needs a second marker, as only A"), 0u);
  EXPECT_EQ(standard->phi_at_cut.why, standard->why_no_agreement);
  EXPECT_EQ(SetStandard({Of("w", "rating", "A", 3)})->why_no_agreement.find("agreement needs two"),
            0u);
}

TEST(StandardTest, TheWholeOfASetOfMarksIsSaid) {
  std::vector<Mark> marks;
  for (int i = 0; i < 12; ++i) {
    const std::string work = "w" + std::to_string(i);
    const int rating = 1 + i % 5;
    for (const char* marker : {"A", "B"}) {
      marks.push_back(Of(work, "rating", marker, rating));
      marks.push_back(Of(work, "total", marker, 30 + 10 * rating + i % 3));
    }
    marks.push_back(Of(work, "total", std::string(kComputed), 25 + 12 * rating));
  }
  const auto standard = SetStandard(marks);
  ASSERT_TRUE(standard.ok()) << standard.status().message();
  ASSERT_TRUE(standard->borderline.has_value()) << standard->why_no_borderline;
  EXPECT_NEAR(standard->borderline->cut.value, 49, 1e-9) << "of the program's points";
  EXPECT_EQ(standard->borderline->ratings, 24U);
  ASSERT_EQ(standard->warnings.size(), 1U);
  EXPECT_FALSE(standard->angoff.has_value());
  EXPECT_NE(standard->why_no_angoff.find("two examiners"), std::string::npos);
  EXPECT_NEAR(*standard->cut, 49, 1e-9);
  EXPECT_NEAR(standard->phi.value->value, 1, 1e-9);
  EXPECT_NEAR(standard->phi_at_cut.value->value, 1, 1e-9);
  const auto json = boost::json::parse(StandardJson(*standard));
  EXPECT_NEAR(json.at("borderline").at("value").as_double(), 49, 1e-9);
  EXPECT_TRUE(json.at("angoff").at("value").is_null());
  // As schemas/marks.md states them; without a value too.
  const std::string needs = R"({"works":8,"ratings":3,"enough":30})";
  EXPECT_EQ(boost::json::serialize(json.at("borderline").at("needs")), needs);
  const auto none = boost::json::parse(StandardJson(StandardSetting{}));
  EXPECT_EQ(boost::json::serialize(none.at("borderline").at("needs")), needs);
  EXPECT_EQ(SetStandard(marks, 70)->cut, 70);
  EXPECT_EQ(SetStandard(marks, 101).status().field(), "cut");
  marks.push_back(marks.back());
  EXPECT_FALSE(SetStandard(marks).ok()) << "a mark twice";
}

}  // namespace
}  // namespace enamel::server
