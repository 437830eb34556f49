#include "station/mouth/rubber_dam.h"

#include <algorithm>
#include <cmath>

#include "station/mouth/gingiva.h"
#include "station/mouth/patches.h"
#include "station/render/revolve.h"

namespace enamel::station::mouth {
namespace {

// Makers' "heavy" sheet, which the textbooks advise.
constexpr double kThick_mm = 0.25;
// The picture has this much of the sheet beside the teeth; it fades where the picture of the gingiva
// ends too, and there it is so much lower, toward cheek and tongue.
constexpr double kBeside_mm = 17, kFull_mm = 8, kDrop_mm = 6;
// So far from a tooth the edge's height holds, or the squares would show where the two meet.
constexpr double kCollar_mm = kSquare_mm;
// Enough for 0.01 mm over 300 x 130 squares; over-relaxed as Young gives it for a square of that side
// (Trans. Am. Math. Soc. 76, 1954): 2 / (1 + sin(pi / 130)).
constexpr int kSweeps = 200;
constexpr double kRelaxation = 1.95;

// A sheet under tension, whose slopes are small, has no curvature where nothing holds it: its height
// solves Laplace's equation between the holes' edges and its border. What is to be cut stays above.
class Sheet {
 public:
  Sheet(std::span<const Neck> necks, const Around& limit_mm) : necks_(necks) {
    glm::dvec2 lo(1e3), hi(-1e3);
    for (const Neck& neck : necks) {
      lo = glm::min(lo, neck.middle_mm - neck.radius_mm.Mean());
      hi = glm::max(hi, neck.middle_mm + neck.radius_mm.Mean());
    }
    lo_ = lo - kBeside_mm;
    nx_ = static_cast<int>((hi.x - lo.x + 2 * kBeside_mm) / kSquare_mm);
    ny_ = static_cast<int>((hi.y - lo.y + 2 * kBeside_mm) / kSquare_mm);
    const auto count = static_cast<size_t>((nx_ + 1) * (ny_ + 1));
    z_.resize(count), highest_.resize(count), beside_.resize(count);
    for (int i = 0; i <= nx_; ++i) {
      for (int j = 0; j <= ny_; ++j) Begin(i, j, limit_mm);
    }
    for (int sweep = 0; sweep < kSweeps; ++sweep) Relax();
  }

  std::vector<render::GroupMesh> Pieces() const {
    auto vertex = [&](int i, int j) {
      auto z = [&](int a, int b) { return z_[At(std::clamp(a, 0, nx_), std::clamp(b, 0, ny_))]; };
      const glm::dvec2 p = Place(i, j);
      return VertexAt({p.x, p.y, z(i, j)}, (z(i + 1, j) - z(i - 1, j)) / (2 * kSquare_mm),
                      (z(i, j + 1) - z(i, j - 1)) / (2 * kSquare_mm), MaterialAt(i, j));
    };
    auto hidden = [&](int i, int j) {
      const glm::dvec2 p = Place(i, j);
      return FromTooth_mm(necks_[0], p.x, p.y) < -2 * kSquare_mm ||
             MaterialAt(i, j) >= render::kRubberDam + render::kRubberDamShades - 1;
    };
    return Patches(nx_, ny_, vertex, hidden);
  }

 private:
  glm::dvec2 Place(int i, int j) const { return lo_ + kSquare_mm * glm::dvec2(i, j); }
  size_t At(int i, int j) const { return static_cast<size_t>(i * (ny_ + 1) + j); }

  // The border and what a tooth fills are given; between them a first guess.
  void Begin(int i, int j, const Around& limit_mm) {
    const glm::dvec2 p = Place(i, j);
    double out = 1e3, margin = 0;
    for (const Neck& neck : necks_) {
      const double here = FromTooth_mm(neck, p.x, p.y);
      if (here >= out) continue;
      out = here;
      margin = neck.margin_mm.At(std::atan2(p.y - neck.middle_mm.y, p.x - neck.middle_mm.x));
    }
    const size_t at = At(i, j);
    beside_[at] = out;
    highest_[at] = HighestAt_mm(necks_[0], limit_mm, p.x, p.y);
    const bool border = i == 0 || j == 0 || i == nx_ || j == ny_;
    z_[at] = margin + kThick_mm - kDrop_mm * std::clamp((out - kCollar_mm) / kBeside_mm, 0.0, 1.0);
    if (border) z_[at] = necks_[0].margin_mm.Mean() - kDrop_mm;
    z_[at] = std::min(z_[at], highest_[at]);
  }

  void Relax() {
    for (int i = 1; i < nx_; ++i) {
      for (int j = 1; j < ny_; ++j) {
        const size_t at = At(i, j), next = static_cast<size_t>(ny_) + 1;
        if (beside_[at] <= kCollar_mm) continue;
        const double mean = 0.25 * (z_[at - 1] + z_[at + 1] + z_[at - next] + z_[at + next]);
        z_[at] = std::min(z_[at] + kRelaxation * (mean - z_[at]), highest_[at]);
      }
    }
  }

  uint8_t MaterialAt(int i, int j) const {
    const double faded =
        std::clamp((beside_[At(i, j)] - kFull_mm) / (kBeside_mm - kFull_mm), 0.0, 1.0);
    return static_cast<uint8_t>(render::kRubberDam +
                                std::lround(faded * (render::kRubberDamShades - 1)));
  }

  std::span<const Neck> necks_;
  glm::dvec2 lo_{0};
  int nx_ = 0, ny_ = 0;
  std::vector<double> z_, highest_, beside_;  // (nx + 1, ny + 1), y fastest; mm
};

}  // namespace

std::vector<render::GroupMesh> RubberDam(std::span<const Neck> necks, const Around& limit_mm) {
  return Sheet(necks, limit_mm).Pieces();
}

}  // namespace enamel::station::mouth
