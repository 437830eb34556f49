#include "station/lab/grades/figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "station/lab/grades/expected_words.h"

namespace enamel::station::lab {
namespace {

constexpr double kGoalShare = 0.85, kUnseen_points = 3, kMillimetre_points = 25;

std::string Format(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string NameOf(const GradeRow& r) {
  return r.exercise + ", " + r.fault + Format(" %g", r.size) + " " + r.unit +
         Format(" at %g mm", r.voxel_mm);
}

std::string LostFor(const GradeRow& r) {
  std::string out;
  for (size_t i = 0; i < std::min<size_t>(3, r.judged.lost_for.size()); ++i) {
    out += (i == 0 ? "" : ", ") + r.judged.lost_for[i];
  }
  return out;
}

// At most one in twenty is below it.
double FifthPercentile(std::vector<double> values) {
  std::ranges::sort(values);
  return values[(values.size() - 1) / 20];
}

using Key = std::string GradeRow::*;
GradeFigure OwnShare(const std::vector<GradeRow>& rows, const char* of, Key key) {
  std::map<std::string, std::vector<double>> groups;
  for (const GradeRow& r : rows) {
    if (r.judged.own_share) groups[key == nullptr ? "all" : r.*key].push_back(*r.judged.own_share);
  }
  GradeFigure out{std::string("share of the points lost for the mistake itself, 5th percentile ") +
                      of + ", goal 0.85 or more",
                  "",
                  {}};
  double least = 1;
  for (const auto& [name, shares] : groups) {
    const double share = FifthPercentile(shares);
    least = std::min(least, share);
    if (key != nullptr && share < kGoalShare) {
      out.misses.push_back(name + ": " + Format("%.3f", share) + " of " +
                           std::to_string(shares.size()));
    }
  }
  out.value = groups.empty() ? "-" : Format("%.3f", least);
  if (key != nullptr) return out;
  for (const GradeRow& r : rows) {
    if (!r.judged.own_share || *r.judged.own_share >= kGoalShare) continue;
    out.misses.push_back(NameOf(r) + ": " + Format("%.3f", *r.judged.own_share) + " (" +
                         LostFor(r) + ")");
  }
  return out;
}

// Of the rows that `counts` accepts, those that `is_right` does not.
GradeFigure Counted(const std::vector<GradeRow>& rows, std::string what,
                    const std::function<bool(const GradeRow&)>& counts,
                    const std::function<bool(const GradeRow&)>& is_right,
                    const std::function<std::string(const GradeRow&)>& why) {
  GradeFigure out{std::move(what), "", {}};
  size_t all = 0;
  for (const GradeRow& r : rows) {
    if (!counts(r)) continue;
    ++all;
    if (!is_right(r)) out.misses.push_back(NameOf(r) + ": " + why(r));
  }
  out.value = std::to_string(all - out.misses.size()) + " of " + std::to_string(all);
  return out;
}

std::string Lost(const GradeRow& r) {
  return Format("%.2f points (", r.points_lost) + LostFor(r) + ")";
}

GradeFigure Words(const std::vector<GradeRow>& rows, const char* what, std::string Judged::*said,
                  std::vector<std::string_view> ExpectedWords::*expected) {
  return Counted(
      rows, std::string(what) + " as an instructor would, goal 95 % or more",
      [](const GradeRow& r) { return r.points_lost >= 1; },
      [&](const GradeRow& r) {
        const ExpectedWords* words = ExpectedWordsOf(r);
        return words != nullptr &&
               std::ranges::find(words->*expected, r.judged.*said) != (words->*expected).end();
      },
      [&](const GradeRow& r) { return "\"" + r.judged.*said + "\" (" + LostFor(r) + ")"; });
}

bool IsOneOf(const GradeRow& r, std::initializer_list<const char*> causes) {
  return std::ranges::any_of(causes, [&](const char* c) { return r.judged.cause == c; });
}

bool LosesForAnother(const GradeRow& r) {
  return std::ranges::any_of(r.judged.lost_for, [](const std::string& what) {
    return what.find("waviness") != std::string::npos || what.starts_with("deepest_over_mm");
  });
}

}  // namespace

std::vector<GradeFigure> FiguresOf(const std::vector<GradeRow>& rows) {
  std::vector<GradeFigure> out;
  auto any = [](const GradeRow&) { return true; };
  out.push_back(
      Counted(rows, "faults found by their metric", any, &GradeRow::AsKnown, [](const GradeRow& r) {
        return r.metric + " " + (r.found ? Format("%.4f", *r.found) : "without a value");
      }));
  out.push_back(Counted(rows, "faults that cost what they must, a point at their threshold", any,
                        &GradeRow::CostsEnough, Lost));
  out.push_back(Counted(
      rows, "faults that cost no more than they may", any,
      [](const GradeRow& r) { return !r.CostsTooMuch(); }, Lost));
  out.push_back(OwnShare(rows, "of all", nullptr));
  out.push_back(OwnShare(rows, "of the worst exercise", &GradeRow::exercise));
  out.push_back(OwnShare(rows, "of the worst kind of fault", &GradeRow::fault));
  out.push_back(Words(rows, "mistakes named", &Judged::said_fault, &ExpectedWords::faults));
  out.push_back(Words(rows, "remedies named", &Judged::said_remedy, &ExpectedWords::remedies));
  out.push_back(Counted(
      rows, "critical where it should be and nowhere else, goal all", any,
      [](const GradeRow& r) { return r.critical.empty() == r.critical_expected.empty(); },
      [](const GradeRow& r) {
        return "\"" + r.critical + "\" for \"" + r.critical_expected + "\"";
      }));
  // A gate takes the value that was measured, whatever explains it.
  out.push_back(Counted(
      rows, "walls, floors, shifts and turns that lose nothing for waves or gouges, goal all",
      [](const GradeRow& r) {
        return r.critical.empty() && r.unit != "deg" &&
               IsOneOf(r, {"wall", "floor", "shift", "turn"});
      },
      [](const GradeRow& r) { return !LosesForAnother(r); }, Lost));
  out.push_back(Counted(
      rows, "all surfaces 0.08 mm off, goal at most 3 points",
      [](const GradeRow& r) { return r.fault.starts_with("all_"); },
      [](const GradeRow& r) { return r.points_lost <= kUnseen_points; }, Lost));
  out.push_back(Counted(
      rows, "walls a millimetre too far, goal at least 25 points",
      [](const GradeRow& r) { return r.judged.cause == "wall" && r.size >= 1 && r.unit == "mm"; },
      [](const GradeRow& r) { return r.points_lost >= kMillimetre_points; }, Lost));
  return out;
}

}  // namespace enamel::station::lab
