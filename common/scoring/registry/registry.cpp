#include "common/scoring/registry/registry.h"

#include <algorithm>
#include <string>

#include "common/cutting/voxel_limit.h"
#include "common/scoring/uncertainty.h"

namespace enamel::scoring {
namespace {

const std::vector<Entry>& Registry() {
  static const std::vector<Entry> all = [] {
    std::vector<Entry> out;
    for (const auto part : {SurfaceMetrics(), CrownMetrics(), TaskMetrics(), RecordingMetrics()}) {
      out.insert(out.end(), part.begin(), part.end());
    }
    return out;
  }();
  return all;
}

}  // namespace

std::span<const MetricInfo> Metrics() {
  static const std::vector<MetricInfo> infos = [] {
    std::vector<MetricInfo> out;
    for (const Entry& entry : Registry()) out.push_back(entry.info);
    return out;
  }();
  return infos;
}

const MetricInfo* FindMetric(std::string_view name) {
  for (const MetricInfo& info : Metrics()) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

bool IsSeenOnTheTooth(std::string_view name) {
  return std::ranges::none_of(RecordingMetrics(),
                              [&](const Entry& entry) { return entry.info.name == name; });
}

MetricPlan MetricPlan::All() {
  MetricPlan plan;
  plan.groups_.set();
  return plan;
}

MetricPlan MetricPlan::For(const scene::Rubric& rubric) {
  MetricPlan plan;
  for (MetricGroup group : kBaseGroups) plan.Add(group);
  auto use = [&](const std::string& metric) {
    for (const Entry& entry : Registry()) {
      if (entry.info.name == metric) plan.Add(entry.group);
    }
  };
  for (const scene::RubricCriterion& criterion : rubric.criteria) use(criterion.metric);
  for (const scene::RubricCritical& critical : rubric.critical) use(critical.metric);
  for (const scene::RubricPrice& price : rubric.prices) {
    if (price.of == "wall" || price.of == "floor") {
      for (MetricGroup group : {MetricGroup::kWalls, MetricGroup::kOutline}) plan.Add(group);
    }
    if (price.of == "table" || price.of == "margin") plan.Add(MetricGroup::kCrown);
    if (price.of == "pulp" || price.of == "neighbour") plan.Add(MetricGroup::kCover);
  }
  return plan;
}

Disturbance DisturbanceOf(const ProcessRecorder& process) {
  auto percent = [](uint64_t part, uint64_t whole) {
    return Percent(static_cast<double>(part), static_cast<double>(whole));
  };
  return {percent(process.late_ticks(), process.ticks()),
          percent(process.gap_ticks(), process.ticks() + process.gap_ticks()),
          percent(process.bounded_ticks(), process.force_ticks())};
}

MetricSet Collect(const Measured& m, const MetricPlan& plan) {
  MetricSet out;
  const bool limited = DisturbanceOf(*m.process).limited_percent > kMaxLimited_percent;
  for (const Entry& entry : Registry()) {
    std::string name(entry.info.name);
    const bool of_path =
        entry.group == MetricGroup::kPathInTime || entry.group == MetricGroup::kPathByWay;
    const State state = !plan.Has(entry.group)             ? NoValue::kNotUsed
                        : of_path && !m.reference_recorded ? NoValue::kNotInTask
                                                           : entry.state(m);
    if (state) {
      out.missing.push_back({std::move(name), *state});
    } else {
      // Adding zero turns -0 into 0.
      MetricValue& v = out.values.emplace_back();
      v = {std::move(name), entry.value(m) + 0.0, std::string(entry.info.unit),
           limited && entry.info.at_limit != AtLimit::kSame};
      v.uncertainty = UncertaintyOf(v.name, v.unit, v.value, m);
      const double least_mm = cutting::kThinnestWall_voxels * m.voxel_m * kMm;
      if (entry.info.thickness && v.value < least_mm) v.below_grid = least_mm;
    }
  }
  return out;
}

}  // namespace enamel::scoring
