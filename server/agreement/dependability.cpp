#include <algorithm>
#include <cmath>

#include "server/agreement/agreement.h"
#include "server/agreement/bootstrap.h"
#include "server/agreement/mean_squares.h"

namespace enamel::server {
namespace {

// None: nothing differs.
std::optional<double> PhiAt(const MeanSquares& s, double cut) {
  // A component below 0 is an estimate of one near 0.
  const double work = std::max(0.0, (s.rows - s.rest) / s.k);
  const double marker = std::max(0.0, (s.columns - s.rest) / s.n);
  const double of_mean = work / s.n + marker / s.k + s.rest / (s.n * s.k);
  const double away = std::max(0.0, (s.mean - cut) * (s.mean - cut) - of_mean);
  const double error = (marker + s.rest) / s.k;
  if (!(work + away + error > 0)) return std::nullopt;
  return (work + away) / (work + away + error);
}

}  // namespace

Result<Agreement> Dependability(const MarkTable& marks) {
  ENAMEL_ASSIGN_OR_RETURN(const Agreement single, Icc21(marks));
  const auto k = static_cast<double>(marks[0].size());
  // Spearman and Brown; it rises with the single mark's, so the ends are the ends.
  auto mean = [k](double one) { return k * one / (1 + (k - 1) * one); };
  // Below -1 / (k - 1) it turns over: no share of a variance is there.
  auto end = [&](double one) { return one > -1 / (k - 1) ? std::max(-1.0, mean(one)) : -1.0; };
  return Agreement{end(single.value), {end(single.interval.low), end(single.interval.high)}};
}

Result<Agreement> DependabilityAt(const MarkTable& marks, double cut) {
  if (!std::isfinite(cut)) return Status(Code::kInvalidInput, "expected a cut score", "cut");
  ENAMEL_ASSIGN_OR_RETURN(const MeanSquares s, MeanSquaresOf(marks));
  const auto value = PhiAt(s, cut);
  const auto interval = BootstrapInterval(
      marks.size(), [&](const std::vector<size_t>& drawn) -> std::optional<double> {
        MarkTable again;
        for (size_t i : drawn) again.push_back(marks[i]);
        const auto of = MeanSquaresOf(again);
        return of.ok() ? PhiAt(*of, cut) : std::nullopt;
      });
  if (!value || !interval) {
    return Status(Code::kInvalidInput,
                  "expected more work that is marked differently; too many draws of it are alike");
  }
  return Agreement{*value, *interval};
}

}  // namespace enamel::server
