#include "common/measure/tick_cost.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "common/cutting/cutter.h"
#include "common/scene/builder.h"

namespace enamel::measure {
namespace {

using cutting::Tissue;

constexpr int32_t kCell_nm = 100;  // finer than any tick's travel here
constexpr double kEntry_m_s = 20e-3, kTravel_m = 6e-3, kMargin_m = 1e-3;
constexpr int kSettleTicks = 300;
constexpr double kLow = -0.70710678118654752;
constexpr int kNotEngaged = int{haptics::kFreeAir} | int{core::kSuspended};

double HeightOf(const CutCase& c) {
  return c.shape == cutting::BurShape::kSphere ? 2 * c.radius_m : c.length_m;
}

// The tip's place when the bur's axis is over x = 0.
dvec3 TipAtStart(const CutCase& c) {
  double height = HeightOf(c);
  if (c.sunk == Sunk::kLying) return {0, -0.5 * height, 0};
  return {0, 0, c.sunk == Sunk::kHalf ? -0.5 * height : -height};
}

// Solid for x > 0 and z < 0, as large as the way needs.
cutting::Volume MakeBlock(const CutCase& c, double travel_m) {
  double height = HeightOf(c);
  double half_y =
      (c.sunk == Sunk::kLying ? std::max(0.5 * height, c.radius_m) : c.radius_m) + kMargin_m;
  double deep = (c.sunk == Sunk::kLying ? c.radius_m : height) + kMargin_m;
  dvec3 lo(0, -half_y, -deep), hi(travel_m + c.radius_m + kMargin_m, half_y, 0);
  auto field = [=](const dvec3& p) {
    dvec3 q = glm::max(lo - p, p - hi);
    dvec3 out = glm::max(q, dvec3(0));
    double inside = std::min(std::max({q.x, q.y, q.z}), 0.0);
    return scene::FieldSample{std::sqrt(Dot(out, out)) + inside, Tissue::kGypsum, 1.0};
  };
  return scene::BuildVolume(scene::GridAround(lo, hi, c.voxel_nm), scene::Field(field),
                            scene::BuildThreads());
}

core::CoreParams MakeParams(const CutCase& c) {
  core::CoreParams p;
  p.rate_hz = c.rate_hz;
  p.law = haptics::LawKind::kGatedMaxwell;
  // A stiff spring in soft material: the bur stays within a few micrometres of the hand.
  p.kc_mn_per_mm = 1'000'000;
  p.damping_mn_s_per_mm.fill(500);
  p.resolution_nm.fill(kCell_nm);
  p.peak_force_mn = 100'000;
  p.soft_start_ticks = 1;
  p.bur_shape = c.shape;
  p.bur_radius_nm = static_cast<int32_t>(std::lround(c.radius_m * 1e9));
  p.bur_length_nm = static_cast<int32_t>(std::lround(c.length_m * 1e9));
  p.rotational_kc_un_m_per_rad = 100'000;
  return p;
}

core::TickInput InputAt(const CutCase& c, const dvec3& tip_m) {
  core::TickInput in;
  for (int i = 0; i < 3; ++i) {
    in.counts[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(tip_m[i] * 1e9 / kCell_nm));
  }
  // Lying: +z of the bur becomes +y of the scene.
  if (c.sunk == Sunk::kLying) in.orientation = ToQuantised(Quat{kLow, 0, 0, -kLow});
  in.flags = core::kBurOn;
  in.bur_speed_krpm = 200;
  return in;
}

struct Replayed {
  std::vector<double> us;  // per measured tick
  int64_t removed = 0;
  size_t engaged = 0;
  uint64_t state_hash = 0;
};

Replayed Replay(const CutPath& path) {
  core::Core core(path.params, path.block);
  Replayed out;
  out.us.reserve(path.inputs.size());
  for (size_t i = 0; i < path.inputs.size(); ++i) {
    auto from = std::chrono::steady_clock::now();
    core::TickOutput tick = core.Step(path.inputs[i]);
    std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - from;
    if (i < path.first_measured) continue;
    out.us.push_back(took.count());
    out.engaged += (tick.flags & kNotEngaged) == 0;
    for (int64_t units : tick.removed) out.removed += units;
  }
  out.state_hash = core.state_hash();
  return out;
}

}  // namespace

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  double sum = 0;
  for (double v : values) sum += v;
  auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), at, values.end());
  return {sum / static_cast<double>(values.size()), *at};
}

const char* SunkName(Sunk sunk) {
  return sunk == Sunk::kHalf ? "half" : sunk == Sunk::kWhole ? "whole" : "lying";
}

std::string BurText(const CutCase& c) {
  char text[80];
  std::string name(cutting::BurShapeName(c.shape));
  if (c.shape == cutting::BurShape::kSphere) {
    std::snprintf(text, sizeof text, "%s r %g mm", name.c_str(), c.radius_m * 1e3);
  } else {
    std::snprintf(text, sizeof text, "%s r %g x %g mm", name.c_str(), c.radius_m * 1e3,
                  c.length_m * 1e3);
  }
  return text;
}

CutPath MakeCutPath(const CutCase& c, size_t ticks) {
  const double step = c.speed_m_s / c.rate_hz, entry_step = kEntry_m_s / c.rate_hz;
  const double start = -(c.radius_m + 0.5e-3), inside = c.radius_m + 0.5e-3;
  size_t measured = std::min(ticks, static_cast<size_t>(kTravel_m / step));
  CutPath path;
  path.params = MakeParams(c);
  dvec3 tip = TipAtStart(c);
  auto add = [&](double x) { path.inputs.push_back(InputAt(c, tip + dvec3(x, 0, 0))); };
  double x = start;
  for (int i = 0; i < 4; ++i) add(x);
  for (; x < inside; x += entry_step) add(x);
  for (int i = 0; i < kSettleTicks; ++i, x += step) add(x);
  path.first_measured = path.inputs.size();
  for (size_t i = 0; i < measured; ++i, x += step) add(x);
  path.block = MakeBlock(c, x);
  return path;
}

TickCost MeasureTicks(const CutCase& c, size_t ticks, int replays,
                      const std::function<void(int, int)>& progress) {
  CutPath path = MakeCutPath(c, ticks);
  TickCost cost;
  cost.replays = replays;
  std::vector<double> least, raw;
  for (int r = 0; r < replays; ++r) {
    if (progress) progress(r, replays);
    Replayed one = Replay(path);
    if (least.empty()) least = one.us;
    for (size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], one.us[i]);
    raw.insert(raw.end(), one.us.begin(), one.us.end());
    cost.replays_agree &= r == 0 || one.state_hash == cost.state_hash;
    cost.state_hash = one.state_hash;
    double voxel_m = path.block.spec().voxel_m();
    cost.removed_mm3 = cutting::RemovedUnitsToM3(one.removed, voxel_m) * 1e9;
    cost.engaged_share = static_cast<double>(one.engaged) / static_cast<double>(one.us.size());
  }
  cost.ticks = least.size();
  Spread own = SpreadOf(std::move(least)), as_it_came = SpreadOf(std::move(raw));
  cost.mean_us = own.mean;
  cost.p99_us = own.p99;
  cost.raw_mean_us = as_it_came.mean;
  cost.raw_p99_us = as_it_came.p99;
  return cost;
}

}  // namespace enamel::measure
