#include "station/devices/mistakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/fidelity/random.h"

namespace enamel::station {
namespace {

constexpr double kAim_m = 0.24e-3, kLean_deg = 2, kPace = 0.4, kTremor = 3;
constexpr double kOneSide_m = 0.45e-3, kTilt_deg = 5, kGouge_m = 0.4e-3;

// A seed's numbers, more than are drawn: the next seed's follow them.
constexpr uint64_t kNumbers = 256, kSidesOfSeed = 8;

enum Kind : size_t { kOverExtension, kUntouched, kTilt, kGouge, kWrongOrder, kKinds };

size_t Below(fidelity::Random& random, size_t count) {
  return static_cast<size_t>(random.Uniform() * static_cast<double>(count));
}

// Which kinds a seed makes first.
std::array<size_t, kKinds> OrderOfKinds(fidelity::Random& random) {
  std::array<size_t, kKinds> out{};
  for (size_t i = 0; i < kKinds; ++i) out[i] = i;
  for (size_t i = kKinds; i-- > 1;) std::swap(out[i], out[Below(random, i + 1)]);
  return out;
}

bool CanBeDoneLast(const std::vector<Move>& plan, size_t i) {
  constexpr size_t kARound = 4;
  const auto* step = std::get_if<Stroke>(&plan[i]);
  return step && step->bur_on && step->points.size() >= kARound &&
         std::holds_alternative<Stroke>(plan[i + 1]);
}

// Through the air, to above a point.
Stroke WayTo(const dvec3& from, const dvec3& to, double clear_m) {
  Stroke way;
  way.points = {{from.x, from.y, clear_m}, {to.x, to.y, clear_m}};
  way.feed_m_per_s = 10e-3;
  way.push_n = 0.5;
  way.tolerance_m = 2e-4;
  way.bur_on = false;
  return way;
}

}  // namespace

double Draw(uint64_t seed, uint64_t side) {
  return fidelity::Random((seed * kSidesOfSeed + side) * fidelity::Random::kStep).Signed();
}

SideErrors Scaled(const SideErrors& errors, double by) {
  return {errors.mesial_m * by, errors.distal_m * by, errors.buccal_m * by, errors.lingual_m * by,
          errors.floor_m * by};
}

double LackAt(int rank) {
  constexpr double kKept = 0.75;
  return rank > 0 && rank < kFullSkill ? std::pow(kKept, rank - 1) : 0;
}

Mistakes MistakesOf(double lack, uint64_t seed) {
  Mistakes out;
  if (!(lack > 0)) return out;
  fidelity::Random random(seed * kNumbers * fidelity::Random::kStep);
  double* sides[] = {&out.sides.mesial_m, &out.sides.distal_m, &out.sides.buccal_m,
                     &out.sides.lingual_m, &out.sides.floor_m};
  constexpr size_t kSides = std::size(sides);
  for (double* side : sides) {
    const double u = random.Signed();
    *side = lack * kAim_m * (u < 0 ? u - 1 : u + 1);
  }
  out.lean_deg = lack * kLean_deg * random.Signed();
  out.speed_ratio = 1 + kPace * lack * random.Signed();
  out.push_ratio = 1 + kPace * lack * random.Signed();
  out.tremor_ratio = 1 + kTremor * lack;

  const auto kinds = OrderOfKinds(random);
  std::array<double, kKinds> size{};
  for (double& s : size) s = lack * (1.25 + 0.25 * random.Signed());
  const size_t over = Below(random, kSides), left = (over + 1 + Below(random, kSides - 1)) % kSides;
  const double lean_to = random.Signed() < 0 ? -1 : 1;
  const Gouge gouge{random.Signed(), random.Signed(), size[kGouge] * kGouge_m};
  const double which = 0.5 * (random.Signed() + 1);
  const auto count = std::min<size_t>(kKinds, 1 + static_cast<size_t>(3 * lack));
  for (size_t i = 0; i < count; ++i) {
    switch (kinds[i]) {
      case kOverExtension:
        *sides[over] = std::max(std::fabs(*sides[over]), size[kOverExtension] * kOneSide_m);
        break;
      case kUntouched:
        *sides[left] = -std::max(std::fabs(*sides[left]), size[kUntouched] * kOneSide_m);
        break;
      case kTilt:
        out.lean_deg = lean_to * size[kTilt] * kTilt_deg;
        break;
      case kGouge:
        out.gouge = gouge;
        break;
      default:
        out.done_last = which;
    }
  }
  return out;
}

Stroke GougeStroke(const Gouge& gouge, const Bounds& extent, const cutting::Bur& bur,
                   const cutting::Volume& prepared, double clear_m) {
  constexpr double kOfTheBox = 0.5;  // about its middle
  const double x = 0.5 * (extent.x0 + extent.x1 + kOfTheBox * gouge.at_x * (extent.x1 - extent.x0));
  const double y = 0.5 * (extent.y0 + extent.y1 + kOfTheBox * gouge.at_y * (extent.y1 - extent.y0));
  const double r = 0.5 * bur.radius_m;
  const double z = HighestSolid_m(prepared, {x - r, x + r, y - r, y + r});
  Stroke out;
  const dvec3 above(x, y, clear_m);
  out.points = {above, dvec3(x, y, z - gouge.deep_m), above};
  out.feed_m_per_s = 1e-3;
  out.push_n = 2;
  return out;
}

std::vector<Move> OutOfOrder(std::vector<Move> plan, double which, double clear_m) {
  std::vector<size_t> can;
  for (size_t i = 1; i + 1 < plan.size() && i < plan.size() / 2; ++i)
    if (CanBeDoneLast(plan, i) && std::holds_alternative<Stroke>(plan[i - 1])) can.push_back(i);
  const auto* end = plan.empty() ? nullptr : std::get_if<Stroke>(&plan.back());
  if (can.empty() || end == nullptr) return plan;
  const size_t i =
      can[std::min(can.size() - 1, static_cast<size_t>(which * static_cast<double>(can.size())))];
  const Stroke last = std::get<Stroke>(plan[i]);
  const dvec3 before = std::get<Stroke>(plan[i - 1]).points.back();
  const dvec3 next = std::get<Stroke>(plan[i + 1]).points.front();
  plan[i] = WayTo(before, next, clear_m);
  plan.emplace_back(
      WayTo(std::get<Stroke>(plan.back()).points.back(), last.points.front(), clear_m));
  plan.emplace_back(last);
  const dvec3 done = last.points.back();
  plan.emplace_back(WayTo(done, done, clear_m));
  return plan;
}

}  // namespace enamel::station
