#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/base/result.h"

// How well several people, or people and the computed score, agree about the same work: intraclass
// correlation, kappa, Bland and Altman's limits. Pure functions, any thread. Every figure comes
// with its interval of 95 %.
//
// What each is for:
//   ICC(2,1)   marks on a scale: how far one person's mark stands for that of another, who counts
//              as drawn at random from those who might mark. Being stricter throughout counts
//              against it.
//   ICC(3,k)   the same people's mean: how consistently they order the work. Being stricter
//              throughout does not count.
//   Φ, Φ(λ)    the same people's mean as a mark by itself, and as a decision at a cut score.
//   kappa      marks in a few classes (met, in part, not met), beyond what chance would give.
//   limits     by how much two ways of marking differ, in points.
// A correlation alone says nothing about the difference in points, and depends on how different
// the work is: show both.
//
// Sources: P. E. Shrout, J. L. Fleiss, Psychological Bulletin 86 (1979) 420 (ICC);
// K. O. McGraw, S. P. Wong, Psychological Methods 1 (1996) 30 (intervals);
// J. Cohen, Psychological Bulletin 70 (1968) 213 (weighted kappa); J. L. Fleiss, J. Cohen,
// B. S. Everitt, Psychological Bulletin 72 (1969) 323 (its error); J. J. Randolph, Joensuu
// Learning and Instruction Symposium (2005) (free-marginal kappa); J. M. Bland, D. G. Altman,
// Lancet 327 (1986) 307 (limits); R. L. Brennan, M. T. Kane, Journal of Educational Measurement 14
// (1977) 277 (dependability, at a cut score too).
namespace enamel::server {

struct Interval {
  double low = 0, high = 0;
};

struct Agreement {
  double value = 0;
  Interval interval;  // 95 %
};

// To show a coefficient, of which 1 is perfect: cut off after two decimals, or .996 would be shown
// as certain.
Agreement CutOff(const Agreement& coefficient);

// What was marked (rows) by whom (columns), all of the same width. No row may lack a mark:
// CompleteRows leaves out those that do.
using MarkTable = std::vector<std::vector<double>>;
MarkTable CompleteRows(const std::vector<std::vector<std::optional<double>>>& rows);

inline constexpr size_t kMaxMarkedWork = 10'000, kMaxMarkers = 100, kMaxClasses = 20;

// Errors of all: kInvalidInput when there are too few rows or columns, too many, a mark is not
// finite, or the figure has no value (all marks the same).

// Two-way random, absolute agreement, a single mark; two rows and two columns at least.
//   MSR, MSC, MSE: mean squares of rows, columns and the rest; n rows, k columns.
//   (MSR - MSE) / (MSR + (k - 1) MSE + k (MSC - MSE) / n)
Result<Agreement> Icc21(const MarkTable& marks);
// Two-way mixed, consistency, the mean of k marks: (MSR - MSE) / MSR.
Result<Agreement> Icc3k(const MarkTable& marks);

// How far the mean of these k markers' marks can be relied on, Φ for work crossed with markers:
// the share of work in the variance of the mean, being stricter throughout counting against it
// (ICC(2,k)). k ICC(2,1) / (1 + (k - 1) ICC(2,1)).
Result<Agreement> Dependability(const MarkTable& marks);
// Φ(λ), Brennan and Kane's index: how far it can be relied on for saying on which side of a cut
// score λ a piece of work is:
//   (work + d) / (work + d + error), with the unbiased estimates
//   work = (MSR - MSE) / k, error = ((MSC - MSE) / n + MSE) / k, which give Φ with d = 0, and
//   d = (mean - λ)^2 less the variance of the mean, (MSR + MSC - MSE) / (n k); each at least 0.
// Never below Φ, and Φ at λ = mean. Its interval by drawing the work again. Errors also:
// kInvalidInput with field "cut".
Result<Agreement> DependabilityAt(const MarkTable& marks, double cut);

// How much a disagreement of two classes weighs, by how far apart they stand.
enum class KappaWeights { kNone, kLinear, kQuadratic };

// Two markers. `counts[i][j]`: how often the first said class i and the second class j; classes in
// their order. 1 - sum(w o) / sum(w e), w the weights of disagreement, o the shares found, e those
// that chance would give with the same marginals.
Result<Agreement> WeightedKappa(const std::vector<std::vector<double>>& counts,
                                KappaWeights weights);
// The same with weights of the caller's, none below 0, 0 on the diagonal.
Result<Agreement> WeightedKappa(const std::vector<std::vector<double>>& counts,
                                const std::vector<std::vector<double>>& disagreement);

// Any number of markers, none bound to use each class a given number of times:
// (P - 1/q) / (1 - 1/q), P the mean share of pairs of markers that agree, q the classes.
// `counts[i][c]`: how many markers put work i into class c; every row has the same sum, two at
// least. Interval from the spread of the rows' shares, with Student's t.
Result<Agreement> FreeMarginalKappa(const std::vector<std::vector<double>>& counts);

struct LimitsOfAgreement {
  size_t pairs = 0;
  Agreement bias;       // mean of first - second
  double spread = 0;    // standard deviation of the differences
  Agreement low, high;  // bias -+ 1.96 spread: 95 of 100 differences lie between
};

// Two marks of each piece of work; three pieces at least. Valid where the difference does not grow
// with the mark and is roughly normal: draw it.
Result<LimitsOfAgreement> BlandAltman(const std::vector<double>& first,
                                      const std::vector<double>& second);

}  // namespace enamel::server
