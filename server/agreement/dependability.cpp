#include <algorithm>
#include <cmath>

#include "server/agreement/agreement.h"
#include "server/agreement/bootstrap.h"
#include "server/agreement/mean_squares.h"

namespace enamel::server {
namespace {

// Unbiased estimates, also where they are below 0: of the variance of work, and of the error of the
// markers' mean, which is 0 at least. Φ and Φ(λ) are of these two. Were a component cut off at 0
// for one of them alone, it could fall below the other.
struct Components {
  double work = 0, error = 0;
};

Components ComponentsOf(const MeanSquares& s) {
  const double marker = (s.columns - s.rest) / s.n;
  return {(s.rows - s.rest) / s.k, (marker + s.rest) / s.k};
}

// `right`'s share of itself and the error. It rises with `right`. At -error it turns over: no share
// of a variance is there.
double Share(double right, double error) {
  return right + error > 0 ? std::max(-1.0, right / (right + error)) : -1.0;
}

double Phi(const MeanSquares& s) {
  const Components c = ComponentsOf(s);
  return Share(c.work, c.error);
}

double PhiAt(const MeanSquares& s, double cut) {
  const Components c = ComponentsOf(s);
  // The square of an estimated distance is too large by the variance of the mean. Less that, it is
  // unbiased; it is cut off at 0, for no cut score is nearer to the mean than the mean. So Φ(λ) is
  // least at the mean, and is Φ there.
  const double of_mean = std::max(0.0, (s.rows + s.columns - s.rest) / (s.n * s.k));
  const double away = std::max(0.0, (s.mean - cut) * (s.mean - cut) - of_mean);
  return Share(c.work + away, c.error);
}

}  // namespace

Result<Agreement> Dependability(const MarkTable& marks) {
  ENAMEL_ASSIGN_OR_RETURN(const Agreement single, Icc21(marks));
  ENAMEL_ASSIGN_OR_RETURN(const MeanSquares s, MeanSquaresOf(marks));
  const auto k = static_cast<double>(marks[0].size());
  // Spearman and Brown; it rises with the single mark's, so the ends are the ends.
  auto mean = [k](double one) { return k * one / (1 + (k - 1) * one); };
  // Below -1 / (k - 1) it turns over: no share of a variance is there.
  auto end = [&](double one) { return one > -1 / (k - 1) ? std::max(-1.0, mean(one)) : -1.0; };
  return Agreement{Phi(s), {end(single.interval.low), end(single.interval.high)}};
}

Result<Agreement> DependabilityAt(const MarkTable& marks, double cut) {
  if (!std::isfinite(cut)) return Status(Code::kInvalidInput, "expected a cut score", "cut");
  ENAMEL_ASSIGN_OR_RETURN(const MeanSquares s, MeanSquaresOf(marks));
  const auto interval = BootstrapInterval(
      marks.size(), [&](const std::vector<size_t>& drawn) -> std::optional<double> {
        MarkTable again;
        for (size_t i : drawn) again.push_back(marks[i]);
        const auto of = MeanSquaresOf(again);
        return of.ok() ? std::optional(PhiAt(*of, cut)) : std::nullopt;
      });
  if (!interval) {
    return Status(Code::kInvalidInput,
                  "expected more work that is marked differently; too many draws of it are alike");
  }
  return Agreement{PhiAt(s, cut), *interval};
}

}  // namespace enamel::server
