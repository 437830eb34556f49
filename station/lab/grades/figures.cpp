#include "station/lab/grades/figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

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

// The dearest three mistakes.
std::string LostFor(const GradeRow& r) {
  std::string out;
  for (size_t i = 0; i < std::min<size_t>(3, r.judged.found.size()); ++i) {
    const scoring::Mistake& m = r.judged.found[i];
    out += (i == 0 ? "" : ", ") + std::string(NameOf(m.kind)) + (m.place.empty() ? "" : " ") +
           m.place + Format(" %.1f", m.points);
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
    if (!r.critical.empty()) continue;
    if (const auto own = r.judged.OwnShare())
      groups[key == nullptr ? "all" : r.*key].push_back(*own);
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
    const auto own = r.judged.OwnShare();
    if (!r.critical.empty() || !own || *own >= kGoalShare) continue;
    out.misses.push_back(NameOf(r) + ": " + Format("%.3f", *own) + " (" + LostFor(r) + ")");
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

GradeFigure FirstMistakes(const std::vector<GradeRow>& rows, const char* of, bool crowns) {
  return Counted(
      rows,
      std::string("first mistakes named as an instructor would, ") + of + ", goal " +
          (crowns ? "95" : "98") + " % or more",
      [&](const GradeRow& r) { return r.NamesItsMistake() && r.IsCrown() == crowns; },
      [](const GradeRow& r) { return r.judged.FirstIsRight(); }, LostFor);
}

GradeFigure TrueSentences(const std::vector<GradeRow>& rows) {
  GradeFigure out{"sentences that are true of the cut, goal all", "", {}};
  size_t said = 0;
  for (const GradeRow& r : rows) {
    said += r.judged.sentences.said;
    for (const std::string& wrong : r.judged.sentences.wrong) {
      out.misses.push_back(NameOf(r) + ": " + wrong);
    }
  }
  out.value = std::to_string(said - out.misses.size()) + " of " + std::to_string(said);
  return out;
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
  out.push_back(FirstMistakes(rows, "cavities", false));
  out.push_back(FirstMistakes(rows, "crowns and veneers", true));
  out.push_back(TrueSentences(rows));
  const auto cheaper = CheaperThoughLarger(rows);
  out.push_back({"larger faults that cost less than smaller ones, goal none",
                 std::to_string(cheaper.size()), cheaper});
  out.push_back(Counted(
      rows, "critical where it should be and nowhere else, goal all", any,
      [](const GradeRow& r) { return r.critical.empty() == r.critical_expected.empty(); },
      [](const GradeRow& r) {
        return "\"" + r.critical + "\" for \"" + r.critical_expected + "\"";
      }));
  out.push_back(Counted(
      rows, "all surfaces 0.08 mm off, goal at most 3 points",
      [](const GradeRow& r) { return r.fault.starts_with("all_"); },
      [](const GradeRow& r) { return r.points_lost <= kUnseen_points; }, Lost));
  out.push_back(Counted(
      rows, "walls a millimetre too far, goal at least 25 points",
      [](const GradeRow& r) { return r.fault.starts_with("wall_") && r.size >= 1; },
      [](const GradeRow& r) { return r.points_lost >= kMillimetre_points; }, Lost));
  return out;
}

}  // namespace enamel::station::lab
