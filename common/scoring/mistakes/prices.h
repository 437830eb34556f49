#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/mistakes/fault_volumes.h"

// Points of a cut: what each region's measures cost. A region pays its dearest measure, once; a cut
// costs the sum over its regions. Every measure only grows with its set of voxels and every price only grows with its
// measure, so a larger or a further fault never earns points. Where one voxel holds something left and something taken
// too far, the voxel has their difference.
//
// A price of a measure M is  p M / sqrt(1 + (M p / most)^2):  p points where M is 1 and small against most / p,
// `most` points at most, and no corner between.
// Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

// Kinds of damage to the whole, beside the kinds of regions.
namespace whole {
inline constexpr std::string_view kElsewhere = "elsewhere", kNeighbour = "neighbour",
                                  kPulp = "pulp", kCaries = "caries", kContact = "contact",
                                  kNotDone = "not_done";
}  // namespace whole
// "mm" of regions and a neighbour, "mm3" elsewhere and of the pulp, "%" of caries, of a third of a contact and of the
// part of the task that was not done; empty: no kind has this name.
std::string_view UnitOf(std::string_view kind);

// The measures of one region, or of the whole.
struct RegionMeasure {
  std::string name;  // Region::name; Contact::Third::name; of the rest of the whole its kind
  std::string kind;  // NameOf(RegionKind), or one of the whole's
  // In UnitOf(kind); a region's as an even layer, beyond the leeway.
  double over = 0, left = 0;
  double uncertainty = 0;  // standard, of the one that is not 0, or of each

  bool operator==(const RegionMeasure&) const = default;
};
// The regions' measures in the order of r.regions(), then the whole's.
std::vector<RegionMeasure> MeasuresOf(const AcceptableCut& r, const FaultVolumes& faults);

// An examiner's demand.
enum class State : uint8_t { kAcceptable, kModify, kRedo };
inline constexpr size_t kStates = 3;
std::string_view NameOf(State state);  // "acceptable"

struct RegionCost {
  bool over = false;  // else what was left is the dearer
  double lost = 0;    // points
  State state = State::kAcceptable;

  bool operator==(const RegionCost&) const = default;
};
struct CutCost {
  std::vector<RegionCost> rows;  // of the measures, in their order
  double sum = 0;                // of them; may be above 100
  // Standard, of the sum: the measures' uncertainties times the slopes of their prices, as if each erred by itself.
  double uncertainty = 0;
};

double PriceOf(const scene::RubricPrice& price, double measure, double size);

// What was not done costs only the part that its regions do not pay already.
// Errors: kInvalidInput where a kind has no price.
Result<CutCost> CostOf(std::span<const RegionMeasure> measures,
                       const std::vector<scene::RubricPrice>& prices);

// Errors: kInvalidInput naming "prices[2].most" where a kind is unknown or stands twice, a size or price is not finite or
// not above 0, a side is missing, `most` is below `points`, or the points of the states do not rise.
Status ValidatePrices(const std::vector<scene::RubricPrice>& prices, const std::string& where);

}  // namespace enamel::scoring
