#include "common/scoring/movement/hand_figures.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace enamel::scoring {
namespace {

constexpr double kPpm = 1e6;
// Longer than this between two samples is a gap.
constexpr double kGap_s = 0.1;
constexpr double kMinNear_share = 1e-6;

int32_t Ppm(double part, double whole) {
  return whole > 0 ? static_cast<int32_t>(std::lround(kPpm * part / whole)) : 0;
}

// The middle one, of two the lower. Requires: not empty.
double Middle(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// One figure of a record: what is compared, how little spread counts as spread, and whether only
// lower values are unusual.
struct Figure {
  std::optional<double> (*of)(const HandRecord&);
  double floor;
  bool low_only;
};

constexpr Figure kFigures[] = {
    {[](const HandRecord& r) -> std::optional<double> {
       if (r.hand.tremor_nm == HandFigures::kNoTremor) return std::nullopt;
       return 1e-3 * r.hand.tremor_nm;
     },
     1, false},
    {[](const HandRecord& r) -> std::optional<double> { return 1e-4 * r.hand.still_ppm; }, 1,
     false},
    {[](const HandRecord& r) -> std::optional<double> { return 1e-4 * r.hand.late_ppm; }, 0.1,
     false},
    {[](const HandRecord& r) -> std::optional<double> { return 1e-4 * r.hand.gap_ppm; }, 0.1,
     false},
    {[](const HandRecord& r) -> std::optional<double> {
       if (!r.near_share) return std::nullopt;
       return std::log(std::max(*r.near_share, kMinNear_share));
     },
     0.1, true},
};

// Adds to `most` how far each record's figure is from the others'.
void Raise(std::span<const HandRecord> records, const Figure& figure, std::vector<double>& most) {
  std::vector<double> known;
  for (const HandRecord& record : records) {
    if (const auto value = figure.of(record)) known.push_back(*value);
  }
  if (known.empty()) return;
  const double middle = Middle(known);
  for (double& value : known) value = std::fabs(value - middle);
  const double spread = std::max(1.4826 * Middle(known), figure.floor);
  for (size_t i = 0; i < records.size(); ++i) {
    const auto value = figure.of(records[i]);
    if (!value || (figure.low_only && *value > middle)) continue;
    most[i] = std::max(most[i], std::fabs(*value - middle) / spread);
  }
}

}  // namespace

HandFigures FiguresOf(const ProcessRecorder& process) {
  HandFigures out;
  if (const auto tremor = process.tremor_m()) {
    out.tremor_nm = static_cast<int32_t>(std::lround(std::min(*tremor * 1e9, 1e9)));
  }
  double still_s = 0, all_s = 0;
  const auto& samples = process.samples();
  for (size_t i = 1; i < samples.size(); ++i) {
    const double step_s = samples[i].time_s - samples[i - 1].time_s;
    if (step_s <= 0 || step_s > kGap_s) continue;
    all_s += step_s;
    if (samples[i].way_m - samples[i - 1].way_m < kStill_m_s * step_s) still_s += step_s;
  }
  out.still_ppm = Ppm(still_s, all_s);
  const auto ticks = static_cast<double>(process.ticks());
  const auto gaps = static_cast<double>(process.gap_ticks());
  out.late_ppm = Ppm(static_cast<double>(process.late_ticks()), ticks);
  out.gap_ppm = Ppm(gaps, ticks + gaps);
  return out;
}

bool IsTooCalm(const HandFigures& figures) {
  return figures.tremor_nm != HandFigures::kNoTremor && 1e-3 * figures.tremor_nm < kMinTremor_um;
}

std::optional<size_t> UnusualRank(std::span<const HandRecord> records, size_t which) {
  if (records.size() < kMinRanked) return std::nullopt;
  std::vector<double> most(records.size(), 0);
  for (const Figure& figure : kFigures) Raise(records, figure, most);
  const auto above =
      std::count_if(most.begin(), most.end(), [&](double value) { return value > most[which]; });
  return 1 + static_cast<size_t>(above);
}

}  // namespace enamel::scoring
