#include "common/import/tissues.h"

#include <algorithm>
#include <cmath>

#include "common/import/tooth_size.h"
#include "common/math/ramp.h"
#include "common/mesh/triangle_tree.h"

namespace enamel::import {
namespace {

using cutting::Tissue;

// Assumptions (tissues.h). They must give a class I cavity that meets enamel first and keeps clear
// of the pulp (RealCrownTest.ClassOneCavityOnAMolar...).
constexpr double kCell_mm = 0.25;
constexpr int kMaxCells = 96;        // along an axis
constexpr double kOutside_mm = 1.0;  // depths beyond this above the surface are cut off
constexpr double kGumCosine = 0.85;
constexpr double kLow = 0.4;  // of the crown's height: a hole above is a scanner's gap
constexpr double kOnCap_mm = 1e-3;
// Proximal enamel at the largest diameter: 1.22 to 1.39 mm, SD 0.18, in upper first premolars (Munhoz et al. 2012, Braz. J.
// Oral Sci. 11:1); 10 mm on both sides of four lower posterior teeth (Stroud et al. 1998, Angle Orthod. 68:141). The
// abstracts were read. The thickness at the top is chosen, so that the model has 1.3 mm at 0.6 of the height. The
// thickness is measured from the smoothed surface: a cusp has more and a fossa less.
constexpr double kFullEnamel_mm = 1.6;  // at the top of a molar or premolar
// Share of the height at which the thickness bends from steep to slow. Chosen.
constexpr double kBend = 0.5;
// So near to the gum, which is no surface of the enamel, the smoothed surface does not count.
constexpr double kGumFrom_mm = 0.5, kGumTo_mm = 1.0;
// Chosen, of the order that textbooks print.
constexpr double kFrontEnamel_mm = 1.35;  // as our own incisor's (scene/builtin/teeth.cpp)
constexpr double kPrimaryEnamel_mm = 1;   // about the same over a primary crown
constexpr double kEnamelOfWidth = 0.23;   // and never more than this of the crown's width
constexpr double kPulpOfDepth = 0.68;     // of the deepest point
// Roof of the chamber below the central fossa, of the mean crown's height: 2.9 mm in a first molar, and so 5.2 below its
// buccal cusp. Published are 6.3 mm, SD 0.9, at the level of the cervical line (Deutsch and Musikant 2004, J. Endod.
// 30:388). A scan ends at the gum above that line: it would have no chamber.
constexpr double kRoofOfHeight = 2.9 / 7.5;
constexpr double kPulpFloor_mm = 0.4;  // dentin left below the chamber

constexpr double kMolarHeight_mm = 7.5;

double FullEnamel_mm(int tooth) {
  if (tooth > 50) return kPrimaryEnamel_mm;
  return tooth % 10 <= 3 ? kFrontEnamel_mm : kFullEnamel_mm;
}

double ClampedRatio(double v, double lo, double hi) {
  return std::clamp((v - lo) / (hi - lo), 0.0, 1.0);
}

}  // namespace

TissueModel::TissueModel(const mesh::Solid& solid, const dvec3* gum, const dvec3& lo_mm,
                         const dvec3& hi_mm, double fossa_mm, int tooth)
    : lo_(lo_mm),
      rise_(gum != nullptr ? -*gum : dvec3(0, 0, 1)),
      pulp_top_(fossa_mm - kRoofOfHeight * std::min(MeanSize(tooth).height_mm, kMolarHeight_mm)) {
  for (int i = 0; i < 3; ++i) {
    size_[i] = std::clamp(static_cast<int>((hi_mm[i] - lo_mm[i]) / kCell_mm) + 2, 4, kMaxCells);
    step_[i] = (hi_mm[i] - lo_mm[i]) / (size_[i] - 1);
  }
  const mesh::Triangles& boundary = solid.boundary;
  bottom_ = 1e300, top_ = -1e300;
  for (const auto& t : boundary.indices) {
    for (uint32_t i : t) {
      bottom_ = std::min(bottom_, Height(boundary.vertices[i]));
      top_ = std::max(top_, Height(boundary.vertices[i]));
    }
  }
  enamel_max_mm_ = std::min(FullEnamel_mm(tooth),
                            kEnamelOfWidth * std::min(hi_mm.x - lo_mm.x, hi_mm.y - lo_mm.y));
  SampleDepths(solid, gum);
  // A pulp chamber is rounder than the crown: fissures must not show in its roof.
  smooth_depth_ = depth_;
  for (int pass = 0; pass < 3; ++pass) Smooth(smooth_depth_);
  float deepest = *std::max_element(smooth_depth_.begin(), smooth_depth_.end());
  pulp_depth_ = kPulpOfDepth * static_cast<double>(deepest);
}

void TissueModel::SampleDepths(const mesh::Solid& solid, const dvec3* gum) {
  const mesh::Triangles& boundary = solid.boundary;
  // Closes the hole at the gum; pleated where the rim is wavy.
  const mesh::TriangleTree caps(mesh::Select(solid, true));
  auto closes_gum = [&](const dvec3& middle) {
    return Height(middle) < bottom_ + kLow * (top_ - bottom_) &&
           caps.Distance(middle, kOnCap_mm) < kOnCap_mm;
  };
  mesh::Triangles outer{boundary.vertices, {}}, base{boundary.vertices, {}};
  for (const auto& t : boundary.indices) {
    dvec3 n = glm::cross(boundary.vertices[t[1]] - boundary.vertices[t[0]],
                         boundary.vertices[t[2]] - boundary.vertices[t[0]]);
    const dvec3 middle =
        (boundary.vertices[t[0]] + boundary.vertices[t[1]] + boundary.vertices[t[2]]) / 3.0;
    const bool is_gum =
        gum != nullptr && (Dot(n, *gum) > kGumCosine * std::sqrt(Dot(n, n)) || closes_gum(middle));
    (is_gum ? base : outer).indices.push_back(t);
  }
  const mesh::TriangleTree outer_tree(outer), base_tree(base), whole(boundary);
  const double far = 2 * glm::length(step_ * dvec3(size_));
  mesh::SignedProbe side(whole, whole);
  uint32_t nearest_outer = 0, nearest_base = 0;
  for (int z = 0; z < size_.z; ++z)
    for (int y = 0; y < size_.y; ++y)
      for (int x = 0; x < size_.x; ++x) {
        dvec3 p = lo_ + step_ * dvec3(x, y, z);
        double d = side.Distance(p, kOutside_mm);
        bool inside = d < 0;
        if (inside) d = outer_tree.Distance(p, far, &nearest_outer);
        depth_.push_back(static_cast<float>(inside ? d : -d));
        gum_depth_.push_back(
            static_cast<float>(inside ? base_tree.Distance(p, kOutside_mm, &nearest_base) : 0));
      }
}

void TissueModel::Smooth(std::vector<float>& grid) const {
  const std::vector<float> in = grid;
  auto at = [&](int x, int y, int z) {
    x = std::clamp(x, 0, size_.x - 1), y = std::clamp(y, 0, size_.y - 1),
    z = std::clamp(z, 0, size_.z - 1);
    return in[static_cast<size_t>((z * size_.y + y) * size_.x + x)];
  };
  size_t i = 0;
  for (int z = 0; z < size_.z; ++z)
    for (int y = 0; y < size_.y; ++y)
      for (int x = 0; x < size_.x; ++x, ++i) {
        float sum = 0;
        for (int k = 0; k < 27; ++k) sum += at(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1);
        grid[i] = sum / 27;
      }
}

double TissueModel::Depth(const std::vector<float>& grid, const dvec3& p) const {
  dvec3 g = glm::clamp((p - lo_) / step_, dvec3(0), dvec3(size_ - 1) - 1e-9);
  ivec3 i(g);
  dvec3 f = g - dvec3(i);
  double sum = 0;
  for (int k = 0; k < 8; ++k) {
    int dx = k & 1, dy = k >> 1 & 1, dz = k >> 2;
    double w = (dx ? f.x : 1 - f.x) * (dy ? f.y : 1 - f.y) * (dz ? f.z : 1 - f.z);
    sum +=
        w * static_cast<double>(
                grid[static_cast<size_t>(((i.z + dz) * size_.y + i.y + dy) * size_.x + i.x + dx)]);
  }
  return sum;
}

double TissueModel::EnamelThickness(double height) const {
  double u = ClampedRatio(height, bottom_ + 0.06 * (top_ - bottom_), top_);
  return enamel_max_mm_ * (1 + kBend) * u / (u + kBend);
}

TissueModel::Sample TissueModel::At(const dvec3& p) const {
  // The border of enamel and dentin is smoother than the surface: it shows no fissures.
  const double gum_mm = Depth(gum_depth_, p), smooth = Ramp(gum_mm, kGumFrom_mm, kGumTo_mm);
  double enamel = EnamelThickness(Height(p)) - smooth * Depth(smooth_depth_, p) -
                  (1 - smooth) * Depth(depth_, p);
  double pulp =
      std::min({Depth(smooth_depth_, p) - pulp_depth_, gum_mm - kPulpFloor_mm, pulp_top_ - p.z});
  Tissue tissue = pulp > 0 ? Tissue::kPulp : enamel > 0 ? Tissue::kEnamel : Tissue::kDentin;
  // Both fields change by less than 3 mm per mm.
  double margin = std::min(std::abs(enamel), std::abs(pulp)) / 3 - 0.05;
  return {tissue, std::max(margin, 0.0)};
}

}  // namespace enamel::import
