#include "station/mouth/gingiva.h"

#include <algorithm>
#include <cmath>

#include "station/mouth/patches.h"
#include "station/render/revolve.h"

namespace enamel::station::mouth {
namespace {

// Of the surface: from a tooth it first rounds over the margin, then falls like the alveolar process.
// At 1.25 mm from the tooth, the mean thickness of attached gingiva (Goaslind et al., J. Periodontol.
// 48, 1977), it has fallen 1.4 mm.
constexpr double kFall = 2.2, kRound_mm = 0.9;
// Over how much height two teeth's slopes blend (SmoothMax).
constexpr double kBlend_mm = 4 * kPapilla_mm;
// A ridge is about this much lower in the first months without a tooth (Schropp et al., Int. J.
// Periodontics Restorative Dent. 23, 2003: 0.7 to 1.4 mm in a year), and two round necks meet lower.
constexpr double kSunken_mm = 2;
// Just inside a tooth it is level, so that their line of meeting is smooth.
constexpr double kLevel_mm = 0.6;
// Beyond this distance from what is to be cut it may rise again, by so much per mm.
constexpr double kFree_mm = 0.7, kRise = 0.5, kSoftLimit_mm = 1;
// Attached gingiva is about this wide on a lower first molar's lingual side, from 1 to 9 mm (Lang &
// Löe, J. Periodontol. 43, 1972). Below it is mucosa, and then the fold to cheek and tongue.
constexpr double kAttached_mm = 4, kFold_mm = 12;
// The picture of the mouth ends in the dark this far from the ridge.
constexpr double kLit_mm = 3.5, kHalfWidth_mm = 17, kBeyondTeeth_mm = 7;

double SmoothMax(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0);
  return std::max(a, b) + h * h / (4 * k);
}

struct Polar {
  double angle = 0, from_tooth = 0;
};
Polar About(const Neck& neck, double x, double y) {
  return {std::atan2(y - neck.middle_mm.y, x - neck.middle_mm.x), FromTooth_mm(neck, x, y)};
}

// Over a neighbour's root it is closed and sunken, as after a tooth is lost: a crown may be left out.
double HeightAt(const Neck& neck, double x, double y) {
  const Polar at = About(neck, x, y);
  const double margin = neck.margin_mm.At(at.angle);
  if (at.from_tooth >= 0) {
    const double share = std::min(at.from_tooth / kScallops_mm, 1.0);
    return glm::mix(margin, neck.ridge_mm.At(at.angle), share * share * (3 - 2 * share)) -
           kFall * (std::hypot(at.from_tooth, kRound_mm) - kRound_mm);
  }
  const double out = std::clamp(
      1 + std::min(at.from_tooth + kLevel_mm, 0.0) / neck.radius_mm.At(at.angle), 0.0, 1.0);
  return glm::mix(neck.margin_mm.Mean() - kSunken_mm, margin, out * out);
}

}  // namespace

Gingiva::Gingiva(std::vector<Neck> necks, const Around& limit_mm)
    : necks_(std::move(necks)), limit_mm_(limit_mm) {
  floor_mm_ = necks_.at(0).margin_mm.Mean() - kFold_mm;
}

double HighestAt_mm(const Neck& own, const Around& limit_mm, double x, double y) {
  const Polar at = About(own, x, y);
  return limit_mm.At(at.angle) - kClearOfTarget_mm +
         kRise * std::max(at.from_tooth - kFree_mm, 0.0);
}

double Gingiva::Height_mm(double x, double y) const {
  double z = floor_mm_;
  for (const Neck& neck : necks_) z = SmoothMax(z, HeightAt(neck, x, y), kBlend_mm);
  // The lesser, rounded downward.
  return -SmoothMax(-z, -HighestAt_mm(necks_[0], limit_mm_, x, y), kSoftLimit_mm);
}

uint8_t Gingiva::MaterialAt(double x, double y, double z) const {
  double below = 1e3, out = 1e3;
  for (const Neck& neck : necks_) {
    const Polar at = About(neck, x, y);
    below = std::min(below, neck.ridge_mm.At(at.angle) - z);
    out = std::min(out, at.from_tooth);
  }
  // 0 to 1: pink to red; to 2: into the dark.
  const double shade = std::clamp((below - 0.5 * kAttached_mm) / kAttached_mm, 0.0, 1.0) +
                       std::clamp(std::max((out - kLit_mm) / (kHalfWidth_mm - 6 - kLit_mm),
                                           (below - 2 * kAttached_mm) / kAttached_mm),
                                  0.0, 1.0);
  return static_cast<uint8_t>(render::kGingiva +
                              std::lround(0.5 * shade * (render::kGingivaShades - 1)));
}

std::vector<render::GroupMesh> Gingiva::Pieces() const {
  double lo = 1e3, hi = -1e3;
  for (const Neck& neck : necks_) {
    lo = std::min(lo, neck.middle_mm.x - neck.radius_mm.Mean() - kBeyondTeeth_mm);
    hi = std::max(hi, neck.middle_mm.x + neck.radius_mm.Mean() + kBeyondTeeth_mm);
  }
  const int nx = static_cast<int>((hi - lo) / kSquare_mm),
            ny = static_cast<int>(2 * kHalfWidth_mm / kSquare_mm);
  const double y0 = necks_[0].middle_mm.y - kHalfWidth_mm;
  auto vertex = [&](int i, int j) {
    const double x = lo + kSquare_mm * i, y = y0 + kSquare_mm * j, z = Height_mm(x, y);
    constexpr double kSide = 0.5 * kSquare_mm;
    return VertexAt({x, y, z}, (Height_mm(x + kSide, y) - Height_mm(x - kSide, y)) / kSquare_mm,
                    (Height_mm(x, y + kSide) - Height_mm(x, y - kSide)) / kSquare_mm,
                    MaterialAt(x, y, z));
  };
  // None deep inside the first tooth, and none where the dark hides it.
  auto hidden = [&](int i, int j) {
    const double x = lo + kSquare_mm * (i + 0.5), y = y0 + kSquare_mm * (j + 0.5);
    return About(necks_[0], x, y).from_tooth < -2 * kLevel_mm ||
           MaterialAt(x, y, Height_mm(x, y)) >= render::kGingiva + render::kGingivaDark;
  };
  return Patches(nx, ny, vertex, hidden);
}

}  // namespace enamel::station::mouth
