#include "station/lab/cutting/tick_cost.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "common/cutting/cutter.h"
#include "common/scene/builder.h"

namespace enamel::station::lab {
namespace {

using cutting::Tissue;

constexpr int32_t kCell_nm = 1;  // far finer than the spring's stretch here
constexpr double kEntry_m_s = 20e-3, kTravel_m = 6e-3, kMargin_m = 1e-3;
constexpr int kSettleTicks = 300;
constexpr double kLow = -0.70710678118654752;
constexpr int kNotEngaged = int{haptics::kFreeAir} | int{core::kSuspended};

// The tip when the bur's axis is over x = 0; of a plunge, when the tip is in the block's top.
dvec3 TipAtStart(const CutCase& c) {
  double height = c.bur.height_m();
  if (c.plunge) return {c.bur.radius_m + kMargin_m, 0, 0};
  if (c.sunk == Sunk::kLying) return {0, -0.5 * height, 0};
  return {0, 0, c.sunk == Sunk::kHalf ? -0.5 * height : -height};
}

// Turned by about 33 degrees about an axis that is not a symmetry of the grid; as an input to the
// core has it, so that bur and block are turned alike.
Quat TurnOf(const CutCase& c) {
  return c.oblique ? FromQuantised(ToQuantised(Quat{0.17, 0.11, 0.23, 1}.Normalised())) : Quat{};
}

// Solid for x > 0 and z < 0, as large as the path needs.
cutting::Volume MakeBlock(const CutCase& c, double travel_m) {
  double radius = c.bur.radius_m, height = c.bur.height_m();
  bool lying = c.sunk == Sunk::kLying;
  double half_y = (lying ? std::max(0.5 * height, radius) : radius) + kMargin_m;
  double deep = (lying ? radius : height) + kMargin_m;
  dvec3 lo(0, -half_y, -deep), hi(travel_m + radius + kMargin_m, half_y, 0);
  if (c.plunge) lo.z = -(travel_m + kMargin_m), hi.x = 2 * (radius + kMargin_m);
  BlockFrame frame(TurnOf(c));
  auto field = [=](const dvec3& scene) {
    dvec3 p = frame.ToBlock(scene);
    dvec3 q = glm::max(lo - p, p - hi);
    dvec3 out = glm::max(q, dvec3(0));
    double inside = std::min(std::max({q.x, q.y, q.z}), 0.0);
    return scene::FieldSample{std::sqrt(Dot(out, out)) + inside, Tissue::kGypsum, 1.0};
  };
  dvec3 least(1), most(-1);
  for (int i = 0; i < 8; ++i) {
    dvec3 corner = frame.ToScene({i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z});
    least = glm::min(least, corner);
    most = glm::max(most, corner);
  }
  cutting::GridSpec grid = scene::GridAround(least, most, c.voxel_nm);
  for (int i = 0; i < 3; ++i)
    grid.origin_nm[static_cast<size_t>(i)] -= std::llround(c.grid_at[i] * c.voxel_nm);
  return scene::BuildVolume(grid, scene::Field(field), scene::BuildThreads());
}

int32_t Nanometres(double m) { return static_cast<int32_t>(std::lround(m * 1e9)); }

core::CoreParams MakeParams(const CutCase& c) {
  core::CoreParams p;
  p.rate_hz = c.rate_hz;
  p.law = haptics::kDefaultLaw;
  // A stiff spring in soft material: the bur stays within a micrometre of the hand.
  p.kc_mn_per_mm = 1'000'000;
  p.damping_mn_s_per_mm.fill(50);
  p.resolution_nm.fill(kCell_nm);
  p.peak_force_mn = 100'000;
  p.soft_start_ticks = 1;
  p.bur_shape = c.bur.shape;
  p.bur_radius_nm = Nanometres(c.bur.radius_m);
  p.bur_length_nm = Nanometres(c.bur.length_m);
  p.bur_narrow_radius_nm = Nanometres(c.bur.narrow_radius_m);
  p.rotational_kc_un_m_per_rad = 100'000;
  return p;
}

core::TickInput InputAt(const CutCase& c, const dvec3& tip_m) {
  core::TickInput in;
  Quat turn = TurnOf(c);
  dvec3 at = BlockFrame(turn).ToScene(tip_m);
  for (int i = 0; i < 3; ++i) {
    in.counts[static_cast<size_t>(i)] = static_cast<int32_t>(std::lround(at[i] * 1e9 / kCell_nm));
  }
  // Lying: +z of the bur becomes +y of the block.
  Quat own = c.sunk == Sunk::kLying ? Quat{kLow, 0, 0, -kLow} : Quat{};
  const Quat spun{0, 0, std::sin(c.spun_rad / 2), std::cos(c.spun_rad / 2)};
  in.orientation = ToQuantised(turn * own * spun);
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

std::vector<CutCase> BurCases() {
  using cutting::BurShape;
  const cutting::Bur burs[] = {
      {BurShape::kCylinder, 0.6e-3, 4e-3},       {BurShape::kSphere, 0.5e-3, 0},
      {BurShape::kCone, 0.8e-3, 4e-3, 0.4e-3},   {BurShape::kInvertedCone, 0.6e-3, 1.2e-3, 0.4e-3},
      {BurShape::kPear, 0.6e-3, 2.5e-3, 0.3e-3}, {BurShape::kFlame, 0.6e-3, 4e-3, 0.3e-3},
      {BurShape::kWheel, 1.2e-3, 1e-3}};
  std::vector<CutCase> out;
  for (const cutting::Bur& bur : burs) {
    CutCase c;
    c.bur = bur;
    out.push_back(c);
  }
  return out;
}

CutPath MakeCutPath(const CutCase& c, size_t ticks) {
  const double step = c.speed_m_s / c.rate_hz, entry_step = kEntry_m_s / c.rate_hz;
  // From outside the block until the whole bur is in it: only then do all ticks cut the same.
  const double front = c.plunge ? 0 : c.bur.radius_m;
  const double start = -(front + 0.5e-3), inside = c.plunge ? c.bur.height_m() : front + 0.5e-3;
  const dvec3 way = c.plunge ? dvec3(0, 0, -1) : dvec3(1, 0, 0);
  size_t measured = std::min(ticks, static_cast<size_t>(kTravel_m / step));
  CutPath path;
  path.params = MakeParams(c);
  path.bur = core::BurOf(path.params);
  path.turn = TurnOf(c);
  path.plunge = c.plunge;
  path.speed_m_s = c.speed_m_s;
  auto add = [&](double x) { path.inputs.push_back(InputAt(c, TipAtStart(c) + way * x)); };
  double x = start;
  for (int i = 0; i < 4; ++i) add(x);
  for (; x < inside; x += entry_step) add(x);
  // At the measured speed: caches and the bur's lag behind the hand have settled.
  for (int i = 0; i < kSettleTicks; ++i, x += step) add(x);
  path.first_measured = path.inputs.size();
  for (size_t i = 0; i < measured; ++i, x += step) add(x);
  path.block = MakeBlock(c, x);
  return path;
}

TickCost TimeTicks(const CutPath& path, int replays,
                   const std::function<void(int, int)>& progress) {
  TickCost cost;
  cost.replays = replays;
  std::vector<double> least, raw;
  for (int r = 0; r < replays; ++r) {
    if (progress) progress(r, replays);
    Replayed one = Replay(path);
    if (least.empty()) least = one.us;
    for (size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], one.us[i]);
    // Besides the minimum of the replays: the times seen by a person at this computer.
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

}  // namespace enamel::station::lab
