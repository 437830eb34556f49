#include "station/render/tooth_looks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/math/ramp.h"
#include "station/render/materials.h"

namespace enamel::station::render {
namespace {

using cutting::Tissue;

// What scatters `scattered` times per mm with a mean cosine of `forward` turns that share back; two
// fluxes exchange 3/4 of it (van Gemert, Star, Lasers Life Sci. 1, 1987).
constexpr double Exchanged_per_mm(double scattered, double forward) {
  return 0.75 * scattered * (1 - forward);
}
// Zijp, ten Bosch, Groenhuis, J. Dent. Res. 74, 1995, 1891-1898.
constexpr double kEnamel_per_mm = Exchanged_per_mm(6.6, 0.68);
// Fried et al., Appl. Opt. 34, 1995, 1278-1285: 260 to 280 per cm, 0.93.
constexpr double kDentin_per_mm = Exchanged_per_mm(27, 0.93);

// 1 / (1 + S t) of the light passes a layer t that absorbs nothing (Kubelka, J. Opt. Soc. Am. 38,
// 1948); what comes back from the ground passes it twice.
double PassesTwice(double per_mm, double thickness_m) {
  const double passes = 1 / (1 + per_mm * 1e3 * thickness_m);
  return passes * passes;
}

// How deep a layer's ground still shows.
constexpr double kThickestEnamel_m = 3e-3, kThickestDentin_m = 1.2e-3;
constexpr double kStep_m = 0.2e-3;
// Light spreads sideways on its way: the mean of five ways, four of them aslant.
constexpr int kWays = 5;
constexpr double kAslant = 0.5;  // sine of that angle
// Darkness is behind a layer only where it ends away from the light: cosine of both faces.
constexpr double kBehind = -0.4;

// Reach of the diffuse border of a lesion. No source of how wide it is was found.
constexpr double kLesionReach_m = 0.35e-3;

// Grooves are as narrow as this.
constexpr double kGroove_m = 0.15e-3;

// A vertex of an uncut surface is within 0.1 voxel of it (surface.h, radii from 0.25 mm).
constexpr double kUncutWithin = 0.3;

struct Frame {
  dvec3 u, v;
};
Frame FrameOf(const dvec3& n) {
  const dvec3 u =
      glm::normalize(glm::cross(n, std::abs(n.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  return {u, glm::cross(n, u)};
}

uint8_t ToByte(double v) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(v, 0.0, 1.0)));
}

dvec3 ColourOf(Tissue tissue) { return dvec3(TissueColour(tissue)); }

// Of a lesion by its share around a point; `sound` is the colour without it.
dvec3 CariesColour(double share, const dvec3& sound, double enamel) {
  const LesionColours colours = Lesion();
  const dvec3 edge = glm::mix(dvec3(colours.soft), dvec3(colours.chalk), enamel);
  dvec3 out = glm::mix(sound, edge, Ramp(share, 0.05, 0.4));
  out = glm::mix(out, dvec3(colours.soft), Ramp(share, 0.35, 0.8));
  return glm::mix(out, ColourOf(Tissue::kCaries), Ramp(share, 0.65, 1));
}

}  // namespace

Look LookOf(const dvec3& albedo, double gloss) {
  Look out;
  for (size_t i = 0; i < 3; ++i) {
    out.root_albedo[i] = ToByte(std::sqrt(std::max(albedo[static_cast<int>(i)], 0.0)));
  }
  out.gloss = ToByte(gloss);
  return out;
}

double ShareThroughEnamel(double thickness_m) { return PassesTwice(kEnamel_per_mm, thickness_m); }

// The mean of light exchanges kEnamel_per_mm, shorter waves more. This power comes near the two figures
// that 1 mm of human enamel was measured to have: translucency parameter 18.7 (Yu, Ahn, Lee, Acta Odontol.
// Scand. 67, 2009, 57-64) and opalescence 22.9 (Lee, Dent. Mater. J. 35, 2016). Wavelengths: of
// sRGB's primaries. Over dentin all colours pass alike: the picture's dentin is more saturated than
// natural dentin, and would shine through pink.
dvec3 EnamelOverDark(double thickness_m) {
  constexpr double kPower = 2.6;
  static const dvec3 by_colour(std::pow(550.0 / 612, kPower), std::pow(550.0 / 549, kPower),
                               std::pow(550.0 / 465, kPower));
  const dvec3 x = kEnamel_per_mm * 1e3 * thickness_m * by_colour;
  return x / (1.0 + x);
}

ToothLooks::ToothLooks(const cutting::Volume& now, const cutting::Volume* uncut)
    : now_(now), uncut_(uncut), voxel_m_(now.spec().voxel_m()) {
  MarkNear();
}

void ToothLooks::MarkNear() {
  const cutting::GridSpec& spec = now_.spec();
  near_.resize(static_cast<size_t>(spec.brick_count()));
  auto bit = [](uint8_t tissue) { return static_cast<uint8_t>(1 << tissue); };
  for (int b = 0; b < spec.brick_count(); ++b) {
    uint8_t& has = near_[static_cast<size_t>(b)];
    if (!now_.HasLabels(b)) {
      has = bit(static_cast<uint8_t>(now_.UniformTissue(b)));
      continue;
    }
    for (const uint8_t label : now_.Labels(b).tissue) has |= bit(label);
  }
  // As far as a way leads, axis by axis.
  const double reach_m = std::max(kThickestDentin_m, kLesionReach_m);
  const int reach = static_cast<int>(std::ceil(reach_m / (cutting::kBrickSide * voxel_m_)));
  const std::array<int, 3> strides = {1, spec.bricks.x, spec.bricks.x * spec.bricks.y};
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<uint8_t> before = near_;
    for (int b = 0; b < spec.brick_count(); ++b) {
      const int stride = strides[static_cast<size_t>(axis)];
      const int at = b / stride % spec.bricks[axis];
      for (int i = std::max(-reach, -at); i <= reach && at + i < spec.bricks[axis]; ++i) {
        near_[static_cast<size_t>(b)] |= before[static_cast<size_t>(b + i * stride)];
      }
    }
  }
}

bool ToothLooks::IsNear(const dvec3& p, Tissue tissue) const {
  const cutting::GridSpec& spec = now_.spec();
  const dvec3 at = (p - spec.origin_m()) / (cutting::kBrickSide * voxel_m_);
  const ivec3 brick = glm::clamp(ivec3(at), ivec3(0), spec.bricks - 1);
  return near_[static_cast<size_t>(spec.BrickIndex(brick))] >> static_cast<uint8_t>(tissue) & 1;
}

bool ToothLooks::IsTooth(uint8_t tissue) {
  switch (static_cast<Tissue>(tissue)) {
    case Tissue::kEnamel:
    case Tissue::kDentin:
    case Tissue::kPulp:
    case Tissue::kCaries:
    case Tissue::kNeighbour:
      return true;
    default:
      return false;
  }
}

Tissue ToothLooks::SolidAt(const dvec3& p) const {
  const dvec3 at = (p - now_.spec().origin_m()) / voxel_m_ + 0.5;
  if (at.x < 0 || at.y < 0 || at.z < 0) return Tissue::kAir;
  const ivec3 voxel(at);
  return now_.PhiAt(voxel) < 0 ? now_.TissueAt(voxel) : Tissue::kAir;
}

// Where enamel ends the labels of voxels make a staircase. The shares of the tissues within some voxels
// around a point of the surface, just under it, give the same line without the steps.
ToothLooks::Mixed ToothLooks::MixedAround(const dvec3& p, const dvec3& n) const {
  constexpr double kReach = 3;  // voxels
  constexpr std::array<double, 2> kRings = {0.4, 1};
  constexpr int kOfRing = 8;
  const auto [u, v] = FrameOf(n);
  int enamel = 0, dentin = 0;
  Mixed out;
  for (const double ring : kRings) {
    for (int i = 0; i < kOfRing; ++i) {
      const double turn = 2 * std::numbers::pi * (i + ring) / kOfRing;
      const dvec3 at = p + kReach * ring * voxel_m_ * (std::cos(turn) * u + std::sin(turn) * v);
      const Tissue there = now_.TissueAtPoint(at);
      dentin += there == Tissue::kDentin;
      if (there != Tissue::kEnamel) continue;
      ++enamel;
      out.enamel_m += at;
    }
  }
  if (enamel > 0) out.enamel_m /= enamel;
  if (enamel + dentin > 0) out.enamel = static_cast<double>(enamel) / (enamel + dentin);
  out.known = enamel + dentin > 0;
  return out;
}

ToothLooks::Ground ToothLooks::GroundBelow(Tissue own, const dvec3& p, const dvec3& way,
                                           double limit_m) const {
  for (double end = kStep_m; end <= limit_m; end += kStep_m) {
    const Tissue there = SolidAt(p + end * way);
    if (there == own) continue;
    double from = end - kStep_m, to = end;
    for (int i = 0; i < 4; ++i) {
      const double middle = 0.5 * (from + to);
      (SolidAt(p + middle * way) == own ? from : to) = middle;
    }
    return {there, voxel_m_ + to, p + to * way};
  }
  return {own, limit_m, p + limit_m * way};
}

template <typename Colour>
dvec3 ToothLooks::MeanOfWays(Tissue own, const dvec3& p, const dvec3& n, double limit_m,
                             Colour&& colour) const {
  const auto [u, v] = FrameOf(n);
  dvec3 sum(0);
  for (int i = 0; i < kWays; ++i) {
    const double turn = 0.5 * std::numbers::pi * i;
    const dvec3 aside = std::cos(turn) * u + std::sin(turn) * v;
    const dvec3 way = i == kWays - 1 ? -n : kAslant * aside - std::sqrt(1 - kAslant * kAslant) * n;
    sum += colour(GroundBelow(own, p, way, limit_m));
  }
  return sum / double{kWays};
}

dvec3 ToothLooks::EnamelColour(const dvec3& p, const dvec3& n, bool uncut) const {
  const dvec3 thick = ColourOf(Tissue::kEnamel);
  return MeanOfWays(Tissue::kEnamel, p, n, kThickestEnamel_m, [&](const Ground& ground) {
    switch (ground.tissue) {
      case Tissue::kDentin:
      case Tissue::kCaries:
        return glm::mix(thick, ColourOf(ground.tissue), ShareThroughEnamel(ground.at_m));
      case Tissue::kAir: {
        // The dark is the mouth's, behind an edge that has grown so. Light reaches both sides of a wall
        // that a bur left.
        const bool was_air = uncut_ == nullptr || uncut_->DistanceAt_m(ground.place_m) > -voxel_m_;
        if (!uncut || !was_air) return thick;
        const dvec3 out = now_.SlopeAtSample((ground.place_m - now_.spec().origin_m()) / voxel_m_);
        if (Dot(out, n) > kBehind * glm::length(out)) return thick;
        return thick * EnamelOverDark(ground.at_m);
      }
      default:
        return thick;
    }
  });
}

dvec3 ToothLooks::DentinColour(const dvec3& p, const dvec3& n) const {
  const dvec3 thick = ColourOf(Tissue::kDentin);
  if (!IsNear(p, Tissue::kPulp) && !IsNear(p, Tissue::kCaries)) return thick;
  return MeanOfWays(Tissue::kDentin, p, n, kThickestDentin_m, [&](const Ground& ground) {
    if (ground.tissue != Tissue::kPulp && ground.tissue != Tissue::kCaries) return thick;
    return glm::mix(thick, ColourOf(ground.tissue), PassesTwice(kDentin_per_mm, ground.at_m));
  });
}

// Points of the unit ball, at as many depths and directions as there are points: those of a lattice would
// cross a straight border many at a time.
std::array<dvec3, 48> BallPoints() {
  std::array<dvec3, 48> points;
  constexpr double kGolden = 0.6180339887498949;
  for (size_t i = 0; i < points.size(); ++i) {
    const double place = static_cast<double>(i);
    const double z = 1 - 2 * (place + 0.5) / static_cast<double>(points.size());
    const double turn = 2 * std::numbers::pi * kGolden * place, ring = std::sqrt(1 - z * z);
    const double radius = std::cbrt(std::fmod((place + 0.5) * 0.7548776662466927, 1.0));
    points[i] = radius * dvec3(ring * std::cos(turn), ring * std::sin(turn), z);
  }
  return points;
}

double ToothLooks::CariesAround(const dvec3& p) const {
  static const auto points = BallPoints();
  int caries = 0, all = 0;
  for (const dvec3& point : points) {
    const Tissue there = now_.TissueAtPoint(p + kLesionReach_m * point);
    caries += there == Tissue::kCaries;
    all += there != Tissue::kAir;
  }
  return all == 0 ? 0 : static_cast<double>(caries) / all;
}

bool ToothLooks::IsUncut(const dvec3& surface_m) const {
  return uncut_ == nullptr || std::abs(uncut_->DistanceAt_m(surface_m)) < kUncutWithin * voxel_m_;
}

double ToothLooks::Concavity(const dvec3& surface_m, const dvec3& n) const {
  const double reach_m = std::clamp(kGroove_m, 2 * voxel_m_, 3.5 * voxel_m_);
  const auto [u, v] = FrameOf(n);
  const Tissue own = now_.TissueAtPoint(surface_m - voxel_m_ * n);
  const double here = now_.DistanceAt_m(surface_m);
  double most = 0;
  for (int i = 0; i < 4; ++i) {
    const double turn = 0.25 * std::numbers::pi * i;
    const dvec3 aside = reach_m * (std::cos(turn) * u + std::sin(turn) * v);
    const dvec3 a = surface_m + aside, b = surface_m - aside;
    const double bent = 2 * here - now_.DistanceAt_m(a) - now_.DistanceAt_m(b);
    if (bent <= most) continue;
    // Two teeth that touch make a groove too.
    const bool one = now_.TissueAtPoint(a) == own && now_.TissueAtPoint(b) == own;
    if (one) most = bent;
  }
  return most / (reach_m * reach_m);
}

Look ToothLooks::At(const dvec3& surface_m, const dvec3& n, Tissue tissue) const {
  const dvec3 p = surface_m - voxel_m_ * n;
  const Mixed around = MixedAround(p, n);
  const double enamel = around.known ? around.enamel : tissue == Tissue::kEnamel;
  const bool uncut = IsUncut(surface_m);
  dvec3 colour = ColourOf(tissue);
  double gloss = TissueGloss(tissue);
  if (tissue == Tissue::kEnamel || tissue == Tissue::kDentin) {
    const bool enamel_here = !around.known || now_.TissueAtPoint(p) == Tissue::kEnamel;
    colour = enamel < 1 ? DentinColour(p, n) : dvec3(0);
    if (enamel > 0) {
      colour = glm::mix(colour, EnamelColour(enamel_here ? p : around.enamel_m, n, uncut), enamel);
    }
    gloss = glm::mix(TissueGloss(Tissue::kDentin), TissueGloss(Tissue::kEnamel), enamel);
  }
  if (tissue != Tissue::kPulp && IsNear(p, Tissue::kCaries)) {
    const double caries = CariesAround(p);
    colour = CariesColour(caries, colour, enamel);
    gloss = glm::mix(gloss, TissueGloss(Tissue::kCaries), Ramp(caries, 0, 0.4));
  }
  const bool grows_grooves =
      tissue == Tissue::kNeighbour || (tissue == Tissue::kEnamel && enamel == 1);
  if (uncut && grows_grooves) {
    const double stain =
        kMaxStained * Ramp(Concavity(surface_m, n), kGrooveFrom_per_m, kGrooveFull_per_m);
    colour = glm::mix(colour, dvec3(StainColour()), stain);
  }
  return LookOf(colour, uncut || tissue == Tissue::kPulp ? gloss : kCutGloss * gloss);
}

}  // namespace enamel::station::render
