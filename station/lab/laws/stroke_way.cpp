#include "station/lab/laws/stroke_way.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::lab {
namespace {

constexpr double kDepth_m = 2e-3;          // of the bur in the block
constexpr double kFeed_m_per_s = 0.43e-3;  // of the paper's cuts
constexpr double kLead_s = 0.5;            // recorded before what a case is about
constexpr double kHandMass_kg = 0.2, kHandDamping_n_s_per_m = 10, kAcross_n_per_m = 500;
constexpr double kRamp_s = 0.4;  // in which a hand begins to push
// Off the grid's planes.
const dvec3 kOff(13e-6, -9e-6, 3e-6);

}  // namespace

const cutting::Bur& StrokeBur() {
  static const cutting::Bur kBur{cutting::BurShape::kCylinder, 0.6e-3, 4e-3};
  return kBur;
}

StrokeWay WayOf(StrokeCase c, const DeviceModel& m) {
  const double r = StrokeBur().radius_m, side = -1.5e-3;
  const dvec3 outside = kOff + dvec3(side - r - 0.1e-3, 0, -kDepth_m);
  const dvec3 inside = kOff + dvec3(side + 0.5e-3, 0, -kDepth_m);
  const double diagonal = std::sqrt(0.5);
  const dvec3 d(diagonal, -diagonal, 0), n(diagonal, diagonal, 0);
  const dvec3 corner = kOff + dvec3(side, side, -kDepth_m);
  StrokeWay w;
  switch (c) {
    case StrokeCase::kPress:
      w.start = kOff + dvec3(0, 0, 0.1e-3);
      w.legs = {{kOff + dvec3(0, 0, -0.5e-3), 0.5e-3}, {{}, 0, 0.4}};
      w.along = dvec3(0, 0, -1);
      break;
    case StrokeCase::kStroke:
      w.start = outside;
      w.legs = {{inside + dvec3(0.5e-3, 0, 0), kFeed_m_per_s}, {{}, 0, 0.4}};
      break;
    case StrokeCase::kReverse:
      w.start = outside;
      w.legs = {{inside, kFeed_m_per_s}, {outside, kFeed_m_per_s}};
      w.record_from = 1;
      w.leaves = w.withdraws = true;
      break;
    case StrokeCase::kLift:
      w.start = outside;
      w.legs = {{inside, kFeed_m_per_s}, {inside + dvec3(0, 0, 3e-3), 20e-3}};
      w.record_from = 1;
      w.along = dvec3(0, 0, 1);
      w.leaves = w.withdraws = true;
      break;
    case StrokeCase::kNick:
      // Past the upright edge, catching a quarter of a millimetre of it.
      w.start = corner - n * (r - 0.25e-3) - d * 1.2e-3;
      w.legs = {{corner - n * (r - 0.25e-3) + d * 1.2e-3, 2e-3}, {{}, 0, 0.2}};
      w.along = d;
      w.leaves = true;
      break;
    case StrokeCase::kSlipOut: {
      // Through the corner; the hand is led into it, then pushes.
      const dvec3 line = corner + n * 0.3e-3;
      w.start = line - d * 1.4e-3;
      w.legs = {{line - d * 0.9e-3, kFeed_m_per_s}};
      w.along = d;
      w.push = d * std::min(1.2, 0.8 * m.continuous_force_n);
      w.push_end_m = 2.5e-3;
      w.leaves = true;
      break;
    }
  }
  return w;
}

LegHand::LegHand(const StrokeWay& way) : way_(way) {
  double t = 0;
  dvec3 from = way.start;
  for (const StrokeLeg& leg : way.legs) {
    const bool moves = leg.speed_m_per_s > 0;
    const double length = moves ? glm::length(leg.to - from) : 0;
    Part part{t, moves ? length / leg.speed_m_per_s : leg.hold_s, from, moves ? leg.to : from};
    if (moves)
      part.direction = (leg.to - from) / length;
    else if (!parts_.empty())
      part.direction = parts_.back().direction;
    parts_.push_back(part);
    t += part.lasts_s;
    from = part.to;
  }
  end_s_ = t;
}

double LegHand::mass_kg() const { return kHandMass_kg; }

Grip LegHand::At(double t_s) {
  Grip grip;
  if (pushing(t_s)) {
    const dvec3 d = glm::normalize(way_.push);
    dvec3 off = tip_ - parts_.back().to;
    off -= d * Dot(off, d);
    const double share = std::min(1.0, (t_s - end_s_) / kRamp_s);
    grip.force_n = d * led_with_n_ * (1 - share) + way_.push * share - off * kAcross_n_per_m;
    grip.damping_n_s_per_m = kHandDamping_n_s_per_m;
    return grip;
  }
  grip.prescribed = true;
  const Part& p = PartAt(t_s);
  const double share = p.lasts_s > 0 ? std::clamp((t_s - p.from_s) / p.lasts_s, 0.0, 1.0) : 1;
  grip.equilibrium_m = p.from + (p.to - p.from) * share;
  return grip;
}

dvec3 LegHand::DirectionAt(double t_s) const {
  return pushing(t_s) ? glm::normalize(way_.push) : PartAt(t_s).direction;
}

double LegHand::record_from_s() const {
  return way_.record_from == 0 ? 0 : parts_[way_.record_from].from_s - kLead_s;
}

void LegHand::Feels(const dvec3& tip_m, const dvec3& r_n, double t_s) {
  tip_ = tip_m;
  if (!pushing(t_s)) led_with_n_ = std::max(0.0, Dot(r_n, DirectionAt(t_s)));
}

const LegHand::Part& LegHand::PartAt(double t_s) const {
  for (const Part& p : parts_) {
    if (t_s <= p.from_s + p.lasts_s + 1e-12) return p;
  }
  return parts_.back();
}

}  // namespace enamel::station::lab
