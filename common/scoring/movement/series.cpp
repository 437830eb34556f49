#include "common/scoring/movement/series.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace enamel::scoring {
namespace {

// The shortest text of a value rounded to a number of decimals.
void AppendNumber(std::string& out, double value, double per_unit) {
  double rounded = std::round(value * per_unit) / per_unit + 0.0;  // no "-0"
  char text[40];
  out.append(text, std::to_chars(text, text + sizeof text, rounded).ptr);
}

template <typename Items, typename Append>
void AppendList(std::string& out, const Items& items, Append append) {
  out += '[';
  bool first = true;
  for (const auto& item : items) {
    if (!first) out += ',';
    first = false;
    append(item);
  }
  out += ']';
}

double Norm(const dvec3& v) { return std::sqrt(Dot(v, v)); }

}  // namespace

SeriesRecorder::SeriesRecorder(const core::CoreParams& params, double voxel_m,
                               uint64_t expected_ticks)
    : params_(params),
      voxel_m_(voxel_m),
      step_ticks_(static_cast<uint32_t>(
          std::max<uint64_t>(1, (expected_ticks + kMaxSteps - 1) / kMaxSteps))) {}

double SeriesRecorder::Bound_n(const core::TickOutput& output) const {
  return output.flags & core::kSuspended ? 0 : params_.peak_force_mn * 1e-3;
}

void SeriesRecorder::Add(const trace::Tick& tick, const core::TickOutput& output) {
  time_ticks_ += tick.input.gap_ticks;
  if (steps_.empty() || steps_.back().ticks == step_ticks_) {
    steps_.emplace_back().t_s = static_cast<double>(time_ticks_) / params_.rate_hz;
  }
  // Whole numbers, in the core's units: the sum is exact.
  for (size_t t = 0; t < removed_.size(); ++t) removed_[t] += output.removed[t];
  Step& step = steps_.back();
  const double force = Norm(output.pressed_n());
  // The largest of a step, so that a peak of a few ticks is seen.
  if (force > Norm(step.force_n)) step.force_n = output.pressed_n();
  step.force_sum_n += force;
  step.computed_n = std::max(step.computed_n, Norm(output.force_computed_n));
  step.late += (tick.input.flags & core::kLateTick) != 0 ? 1 : 0;
  step.bound_n = Bound_n(output);
  step.anchor_m = output.anchor.tip_m;
  step.removed = removed_;
  ++step.ticks;
  ++time_ticks_;
}

std::vector<double> SeriesRecorder::Cumulative_mm3(size_t tissue) const {
  std::vector<double> out;
  for (const Step& s : steps_) {
    int64_t units = s.removed[tissue];
    out.push_back(cutting::RemovedUnitsToM3(units, voxel_m_) * 1e9);
  }
  return out;
}

std::string SeriesRecorder::ToJson(const std::function<double(const dvec3&)>& pulp_m,
                                   std::optional<double> felt_error) const {
  std::string out = "{\"rate_hz\":" + std::to_string(params_.rate_hz) +
                    ",\"step_ticks\":" + std::to_string(step_ticks_);
  if (felt_error) {
    out += ",\"felt_error\":";
    AppendNumber(out, *felt_error, 1e3);
  }
  auto column = [&](const char* name, double per_unit, auto value) {
    out += std::string(",\"") + name + "\":";
    AppendList(out, steps_, [&](const Step& s) { AppendNumber(out, value(s), per_unit); });
  };
  // Decimals: 0.1 ms, 1 mN, 0.000001 mm3, 0.1 um. Beyond them the file would only grow.
  column("t_s", 1e4, [](const Step& s) { return s.t_s; });
  column("force_n", 1e3, [](const Step& s) { return Norm(s.force_n); });
  column("force_mean_n", 1e3, [](const Step& s) { return s.force_sum_n / s.ticks; });
  column("computed_n", 1e3, [](const Step& s) { return s.computed_n; });
  column("late_ticks", 1, [](const Step& s) { return s.late; });
  column("bound_n", 1e3, [](const Step& s) { return s.bound_n; });
  if (pulp_m) column("pulp_mm", 1e3, [&](const Step& s) { return pulp_m(s.anchor_m) * 1e3; });
  column("removed_mm3", 1e6, [&](const Step& s) {
    int64_t units = 0;
    for (int64_t u : s.removed) units += u;
    return cutting::RemovedUnitsToM3(units, voxel_m_) * 1e9;
  });
  out += ",\"removed_by_tissue\":{";
  bool first = true;
  for (size_t t = 0; t < removed_.size(); ++t) {
    if (removed_[t] == 0) continue;
    if (!first) out += ',';
    first = false;
    out += "\"" + std::string(cutting::kTissueNames[t]) + "\":";
    AppendList(out, Cumulative_mm3(t), [&](double v) { AppendNumber(out, v, 1e6); });
  }
  out += '}';
  auto vectors = [&](const char* name, double per_unit, auto value) {
    out += std::string(",\"") + name + "\":";
    AppendList(out, steps_, [&](const Step& s) {
      const dvec3 v = value(s);
      AppendList(out, std::array<double, 3>{v.x, v.y, v.z},
                 [&](double x) { AppendNumber(out, x, per_unit); });
    });
  };
  vectors("anchor_mm", 1e4, [](const Step& s) { return s.anchor_m * 1e3; });
  vectors("force_vector_n", 1e3, [](const Step& s) { return s.force_n; });
  out += '}';
  return out;
}

}  // namespace enamel::scoring
