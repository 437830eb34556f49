#include "common/scoring/envelope.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/scoring/brick_samples.h"
#include "common/scoring/changed.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickVoxels;
using cutting::Volume;

constexpr double kNormal = 1.4826;  // 1 / Phi^-1(3/4): sigma per median absolute deviation

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

MetricPlace PlaceOf(const MetricValue& metric, const std::vector<double>& values) {
  MetricPlace out{metric.name, metric.unit, 0, 0, 0, 0, {}, 0};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  out.least = *least;
  out.most = *most;
  out.median = MedianOf(values);
  std::vector<double> apart;
  double below = 0;
  for (double value : values) {
    apart.push_back(std::fabs(value - out.median));
    below += value < metric.value ? 1 : value == metric.value ? 0.5 : 0;
  }
  out.spread = kNormal * MedianOf(std::move(apart));
  if (out.spread > 0) out.z = (metric.value - out.median) / out.spread;
  out.percentile = 100 * below / static_cast<double>(values.size());
  return out;
}

const MetricValue* Find(const MetricSet& set, const std::string& name) {
  auto found = std::ranges::find(set.values, name, &MetricValue::name);
  return found == set.values.end() ? nullptr : &*found;
}

std::vector<MetricPlace> PlacesOf(const MetricSet& metrics,
                                  const std::vector<EnvelopeMember>& members) {
  std::vector<MetricPlace> out;
  for (const MetricValue& metric : metrics.values) {
    std::vector<double> values;
    for (const EnvelopeMember& member : members) {
      if (const MetricValue* found = Find(member.metrics, metric.name)) {
        values.push_back(found->value);
      }
    }
    if (values.size() == members.size()) out.push_back(PlaceOf(metric, values));
  }
  return out;
}

// Volumes in 1/65536 of a voxel, so that sums are exact in any order.
class VoxelCount {
 public:
  VoxelCount(const Volume& initial, const Volume& attempt,
             const std::vector<EnvelopeMember>& members)
      : initial_(initial),
        attempt_(attempt),
        members_(members),
        attempt_changed_(initial, attempt),
        both_(members.size(), 0),
        each_(members.size(), 0),
        taken_by_(members.size() + 1, 0),
        removed_(members.size(), 0) {
    for (const EnvelopeMember& member : members) {
      member_changed_.emplace_back(initial, *member.final_volume);
    }
  }

  void CountInto(Envelope& out) {
    for (int b = 0; b < initial_.spec().brick_count(); ++b) AddBrick(b);
    const double h_m = initial_.spec().voxel_m();
    auto m3 = [&](int64_t units) { return static_cast<double>(units) * (h_m * h_m * h_m / 65536); };
    out.left_of_all_m3 = m3(left_);
    out.disputed_m3 = m3(disputed_);
    for (int64_t units : taken_by_) out.taken_by_m3.push_back(m3(units));
    for (size_t r = 0; r < members_.size(); ++r) {
      const int64_t sum = taken_ + each_[r];
      const double dice =
          sum > 0 ? 2 * static_cast<double>(both_[r]) / static_cast<double>(sum) : 1;
      out.members.push_back({members_[r].attempt, dice});
    }
    std::ranges::stable_sort(out.members, std::ranges::greater{}, &EnvelopeOverlap::dice);
  }

 private:
  void AddBrick(int b) {
    bool changed = attempt_changed_.Brick(b);
    for (const ChangedBricks& member : member_changed_) changed = changed || member.Brick(b);
    if (!changed) return;
    const BrickSamples before(initial_, b), after(attempt_, b);
    std::vector<BrickSamples> cuts;
    for (const EnvelopeMember& member : members_) cuts.emplace_back(*member.final_volume, b);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int32_t f0 = before.Solid(i);
      if (f0 != 0) AddVoxel(f0, std::min(f0, after.Solid(i)), cuts, i);
    }
  }

  // f0, fa: solid before and after the attempt. Within a voxel all cut from the same side: what
  // took less took a part of what took more.
  void AddVoxel(int32_t f0, int32_t fa, const std::vector<BrickSamples>& cuts, int i) {
    const int32_t own = f0 - fa;
    taken_ += own;
    for (size_t r = 0; r < cuts.size(); ++r) {
      // A surface may only recede: what a resampled cut has more of was not put there.
      removed_[r] = f0 - std::min(f0, cuts[r].Solid(i));
      each_[r] += removed_[r];
      both_[r] += std::min(own, removed_[r]);
    }
    std::sort(removed_.begin(), removed_.end(), std::greater<>());
    const int32_t most = removed_.front(), least = removed_.back();
    disputed_ += most - least;
    left_ += std::max(0, least - own);
    int32_t by_so_many = own;  // taken by k members or more
    for (size_t k = 0; k < removed_.size(); ++k) {
      const int32_t by_one_more = std::min(own, removed_[k]);
      taken_by_[k] += by_so_many - by_one_more;
      by_so_many = by_one_more;
    }
    taken_by_[removed_.size()] += by_so_many;
  }

  const Volume &initial_, &attempt_;
  const std::vector<EnvelopeMember>& members_;
  const ChangedBricks attempt_changed_;
  std::vector<ChangedBricks> member_changed_;
  int64_t left_ = 0, disputed_ = 0, taken_ = 0;
  std::vector<int64_t> both_, each_, taken_by_;
  std::vector<int32_t> removed_;  // of the voxel, by member; then the largest first
};

}  // namespace

Result<Envelope> PlaceInEnvelope(const Volume& initial, const Volume& attempt,
                                 const MetricSet& metrics,
                                 const std::vector<EnvelopeMember>& members) {
  if (members.size() < 2 || members.size() > kMaxEnvelopeMembers) {
    return Status(Code::kInvalidInput, "an envelope has 2 to " +
                                           std::to_string(kMaxEnvelopeMembers) +
                                           " references, found " + std::to_string(members.size()));
  }
  bool same = attempt.spec() == initial.spec();
  for (const EnvelopeMember& member : members) {
    ENAMEL_CHECK(member.final_volume != nullptr);
    same = same && member.final_volume->spec() == initial.spec();
  }
  if (!same) {
    return Status(Code::kInvalidInput,
                  "attempt and references have different grids (voxel size, origin or extent): "
                  "compare cuts of the same scene only");
  }
  Envelope out;
  VoxelCount(initial, attempt, members).CountInto(out);
  out.metrics = PlacesOf(metrics, members);
  return out;
}

}  // namespace enamel::scoring
