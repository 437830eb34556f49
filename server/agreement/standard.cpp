#include "server/agreement/standard.h"

#include <algorithm>
#include <boost/json.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <set>

#include "server/agreement/bootstrap.h"
#include "server/agreement/figure_json.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

// Points on ratings, least squares; each rating of a piece of work is a point of the plot.
struct Line {
  double slope = 0, at_mean = 0, mean_rating = 0, explained = 0;

  double At(double rating) const { return at_mean + slope * (rating - mean_rating); }
};

// None: all ratings are the same.
std::optional<Line> LineThrough(const std::vector<RatedWork>& works,
                                const std::vector<size_t>& which) {
  double n = 0;
  Line out;
  for (size_t i : which) {
    for (int rating : works[i].ratings) {
      n += 1, out.mean_rating += rating, out.at_mean += works[i].points;
    }
  }
  out.mean_rating /= n, out.at_mean /= n;
  double ratings = 0, both = 0, points = 0;
  for (size_t i : which) {
    const double y = works[i].points - out.at_mean;
    for (int rating : works[i].ratings) {
      const double x = rating - out.mean_rating;
      ratings += x * x, both += x * y, points += y * y;
    }
  }
  if (!(ratings > 0)) return std::nullopt;
  out.slope = both / ratings;
  out.explained = points > 0 ? both * both / (ratings * points) : 0;
  return out;
}

Status CheckRated(const std::vector<RatedWork>& works) {
  std::set<int> different;
  for (const RatedWork& work : works) {
    if (!std::isfinite(work.points) || work.ratings.empty()) {
      return Status(Code::kInvalidInput, "expected points and a rating for each piece of work");
    }
    for (int rating : work.ratings) {
      if (rating < kClearFail || rating > kExcellent) {
        return Status(Code::kInvalidInput,
                      "expected ratings from 1 (clear fail) to 5 (excellent), found " +
                          std::to_string(rating),
                      "rating");
      }
      different.insert(rating);
    }
  }
  if (works.size() < kMinRated) {
    return Status(Code::kInvalidInput, "a cut score needs " + std::to_string(kMinRated) +
                                           " rated attempts at least, found " +
                                           std::to_string(works.size()) + ": rate more of them");
  }
  if (different.size() < kMinRatings) {
    return Status(Code::kInvalidInput, "a cut score needs " + std::to_string(kMinRatings) +
                                           " different ratings at least, found " +
                                           std::to_string(different.size()) +
                                           ": add better and worse attempts");
  }
  return Status::Ok();
}

struct Judged {
  std::map<std::string, double> by_examiner;
  std::optional<double> full_marks;
};

double MeanOf(const std::vector<double>& values) {
  double sum = 0;
  for (double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}
double SpreadOf(const std::vector<double>& values) {
  const double mean = MeanOf(values);
  double squares = 0;
  for (double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

Result<std::map<std::string, Judged>> JudgedBorderline(const std::vector<Mark>& marks) {
  std::map<std::string, Judged> out;
  for (const Mark& mark : marks) {
    if (mark.work != kBorderlineWork || mark.marker == kComputed) continue;
    if (mark.criterion == kTotalCriterion || mark.criterion == kRatingCriterion) continue;
    Judged& judged = out[mark.criterion];
    if (!mark.full_marks || (judged.full_marks && *judged.full_marks != *mark.full_marks)) {
      return Status(Code::kInvalidInput,
                    "expected the same full marks for \"" + mark.criterion +
                        "\" in every row of the borderline student",
                    "full_marks");
    }
    judged.full_marks = mark.full_marks;
    judged.by_examiner[mark.marker] = mark.points;
  }
  return out;
}

// Of all pieces of work that people rated.
Result<std::vector<RatedWork>> RatedOf(const std::vector<Mark>& marks) {
  struct Found {
    std::vector<int> ratings;
    std::vector<double> totals;
    std::optional<double> computed;
  };
  std::map<std::string, Found> by_work;
  for (const Mark& mark : marks) {
    if (mark.work == kBorderlineWork) continue;
    Found& found = by_work[mark.work];
    const bool person = mark.marker != kComputed;
    if (mark.criterion == kRatingCriterion && person) {
      const int rating = mark.points >= 0 && mark.points <= 9 ? static_cast<int>(mark.points) : 0;
      if (rating != mark.points || rating < kClearFail || rating > kExcellent) {
        return Status(Code::kInvalidInput,
                      mark.marker + " rated " + mark.work +
                          ": expected 1 (clear fail), 2 (borderline), 3 (clear pass), 4 (good) or "
                          "5 (excellent)",
                      "rating");
      }
      found.ratings.push_back(rating);
    } else if (mark.criterion == kTotalCriterion && person) {
      found.totals.push_back(mark.points);
    } else if (mark.criterion == kTotalCriterion) {
      found.computed = mark.points;
    }
  }
  std::vector<RatedWork> out;
  for (const auto& [work, found] : by_work) {
    if (found.ratings.empty() || (!found.computed && found.totals.empty())) continue;
    out.push_back({found.computed ? *found.computed : MeanOf(found.totals), found.ratings});
  }
  return out;
}

MarkTable TotalsOfPeople(const std::vector<Mark>& marks, std::set<std::string>& markers) {
  std::map<std::string, std::map<std::string, double>> by_work;
  for (const Mark& mark : marks) {
    if (mark.criterion != kTotalCriterion || mark.marker == kComputed ||
        mark.work == kBorderlineWork)
      continue;
    markers.insert(mark.marker);
    by_work[mark.work][mark.marker] = mark.points;
  }
  std::vector<std::vector<std::optional<double>>> rows;
  for (const auto& [work, of] : by_work) {
    auto& row = rows.emplace_back();
    for (const std::string& marker : markers) {
      const auto mark = of.find(marker);
      row.push_back(mark == of.end() ? std::nullopt : std::optional(mark->second));
    }
  }
  return CompleteRows(rows);
}

json::value BorderlineJson(const StandardSetting& s) {
  json::object needs{{"works", kMinRated}, {"ratings", kMinRatings}, {"enough", kEnoughRated}};
  if (!s.borderline) {
    return {{"value", nullptr}, {"why", s.why_no_borderline}, {"needs", std::move(needs)}};
  }
  const BorderlineCut& b = *s.borderline;
  json::object out = FigureJson(b.cut);
  out["needs"] = std::move(needs);
  out["points_per_rating"] = b.points_per_rating;
  out["explained"] = b.explained;
  out["works"] = b.works;
  out["ratings"] = b.ratings;
  out["few"] = b.few;
  return out;
}

json::value AngoffJson(const StandardSetting& s) {
  if (!s.angoff) return {{"value", nullptr}, {"why", s.why_no_angoff}};
  json::object out = FigureJson(s.angoff->cut);
  out["examiners"] = s.angoff->examiners;
  json::array criteria;
  for (const AngoffCriterion& c : s.angoff->criteria) {
    criteria.push_back({{"criterion", c.criterion},
                        {"mean", c.mean},
                        {"spread", c.spread},
                        {"full_marks", c.full_marks}});
  }
  out["criteria"] = std::move(criteria);
  return out;
}

}  // namespace

Result<BorderlineCut> BorderlineRegression(const std::vector<RatedWork>& works) {
  ENAMEL_RETURN_IF_ERROR(CheckRated(works));
  std::vector<size_t> all(works.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = i;
  const Line line = *LineThrough(works, all);  // CheckRated has found different ratings
  if (!(line.slope > 0)) {
    return Status(Code::kInvalidInput,
                  "work that was rated better has no more points: no line leads to a cut score. "
                  "Compare the rubric with the ratings");
  }
  BorderlineCut out;
  const auto interval = BootstrapInterval(
      works.size(), [&](const std::vector<size_t>& drawn) -> std::optional<double> {
        const auto again = LineThrough(works, drawn);
        return again ? std::optional(again->At(kBorderline)) : std::nullopt;
      });
  if (!interval) {
    return Status(Code::kInvalidInput,
                  "nearly all attempts have one rating: add better and worse attempts");
  }
  out.cut = {line.At(kBorderline), *interval};
  out.points_per_rating = line.slope;
  out.explained = line.explained;
  out.works = works.size();
  for (const RatedWork& work : works) out.ratings += work.ratings.size();
  out.few = works.size() < kEnoughRated;
  return out;
}

Result<AngoffCut> Angoff(const std::vector<Mark>& marks) {
  ENAMEL_ASSIGN_OR_RETURN(const auto judged, JudgedBorderline(marks));
  std::map<std::string, double> totals;
  double full_marks = 0;
  for (const auto& [criterion, of] : judged) {
    full_marks += *of.full_marks;
    for (const auto& [examiner, points] : of.by_examiner) totals[examiner] += points;
  }
  if (totals.size() < 2 || !(full_marks > 0)) {
    return Status(Code::kInvalidInput,
                  "expected two examiners at least who marked the work \"borderline\": what a "
                  "student who is just good enough would earn for each criterion");
  }
  AngoffCut out;
  out.examiners = totals.size();
  for (const auto& [criterion, of] : judged) {
    std::vector<double> points;
    for (const auto& [examiner, value] : of.by_examiner) points.push_back(value);
    if (points.size() != totals.size()) {
      return Status(Code::kInvalidInput, "expected a mark of each of the " +
                                             std::to_string(totals.size()) + " examiners for \"" +
                                             criterion + "\", found " +
                                             std::to_string(points.size()));
    }
    out.criteria.push_back({criterion, MeanOf(points), SpreadOf(points), *of.full_marks});
  }
  std::vector<double> percent;
  for (const auto& [examiner, points] : totals) percent.push_back(100 * points / full_marks);
  const auto n = static_cast<double>(percent.size());
  const double t = boost::math::quantile(boost::math::students_t(n - 1), 0.975);
  const double mean = MeanOf(percent), half = t * SpreadOf(percent) / std::sqrt(n);
  out.cut = {mean, {std::max(0.0, mean - half), std::min(100.0, mean + half)}};
  return out;
}

Result<StandardSetting> SetStandard(const std::vector<Mark>& marks, std::optional<double> cut) {
  if (cut && !(*cut >= 0 && *cut <= 100)) {
    return Status(Code::kInvalidInput, "expected a cut score from 0 to 100 points", "cut");
  }
  if (auto twice = CompareMarks(marks); !twice.ok()) return twice.status();
  ENAMEL_ASSIGN_OR_RETURN(const auto rated, RatedOf(marks));
  StandardSetting out;
  if (auto borderline = BorderlineRegression(rated); borderline.ok()) {
    out.borderline = *borderline;
    if (borderline->few) {
      out.warnings.push_back("the cut score is of " + std::to_string(borderline->works) +
                             " attempts; below " + std::to_string(kEnoughRated) +
                             " it changes much with each one more");
    }
  } else {
    out.why_no_borderline = borderline.status().message();
  }
  if (auto angoff = Angoff(marks); angoff.ok()) {
    out.angoff = std::move(*angoff);
  } else {
    out.why_no_angoff = angoff.status().message();
  }
  out.cut = cut              ? cut
            : out.borderline ? std::optional(out.borderline->cut.value)
            : out.angoff     ? std::optional(out.angoff->cut.value)
                             : std::nullopt;
  std::set<std::string> people;
  const MarkTable totals = TotalsOfPeople(marks, people);
  if (people.size() < 2) {
    out.why_no_agreement = SecondMarkerNeeded({people.begin(), people.end()});
    out.icc21 = out.phi = out.phi_at_cut = Figure{std::nullopt, out.why_no_agreement};
    return out;
  }
  out.icc21 = FigureOf(Icc21(totals));
  out.phi = FigureOf(Dependability(totals));
  out.phi_at_cut = out.cut ? FigureOf(DependabilityAt(totals, *out.cut))
                           : Figure{std::nullopt, "there is no cut score"};
  return out;
}

std::string StandardJson(const StandardSetting& s) {
  json::object out{{"borderline", BorderlineJson(s)},
                   {"angoff", AngoffJson(s)},
                   {"cut", s.cut ? json::value(*s.cut) : json::value(nullptr)},
                   {"phi", FigureJson(s.phi)},
                   {"phi_at_cut", FigureJson(s.phi_at_cut)},
                   {"icc_2_1", FigureJson(s.icc21)},
                   {"warnings", json::value_from(s.warnings)}};
  return json::serialize(out) + "\n";
}

}  // namespace enamel::server
