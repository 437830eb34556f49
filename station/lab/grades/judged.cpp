#include "station/lab/grades/judged.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::lab {

bool Judged::IsExpected(const scoring::Mistake& mistake) const {
  return std::ranges::any_of(expected, [&](const ExpectedMistake& e) { return e.Is(mistake); });
}

bool Judged::FirstIsRight() const { return !found.empty() && IsExpected(found.front()); }

std::optional<double> Judged::OwnShare() const {
  double all = 0, own = 0;
  for (const scoring::Mistake& m : found) {
    all += m.points;
    if (IsExpected(m)) own += m.points;
  }
  if (expected.empty() || all < 1) return std::nullopt;
  return own / all;
}

Judged JudgedOf(const Fault& fault, const std::string& exercise, const scoring::AcceptableCut& r,
                const cutting::Volume& attempt, const scoring::ScoreResult& score) {
  Judged out;
  out.expected = ExpectedMistakesOf(exercise, fault);
  out.found = score.mistakes;
  out.sentences = CheckSentences(r, attempt, score.measures, score.costs, score.mistakes);
  double off = 0;
  for (const scoring::Mistake& m : score.mistakes) off += m.points;
  for (const scoring::RegionCost& cost : score.costs) off -= cost.lost;
  out.sum_error = std::fabs(off);
  return out;
}

}  // namespace enamel::station::lab
