#include "common/scoring/mistakes/cut_surface.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/scene/tooth_number.h"
#include "common/scoring/mistakes/around.h"

namespace enamel::scoring {
namespace {

using enum Facing;

// Between surfaces that meet in a line angle: cosine of 40 degrees. Round corners turn by less over
// kLineAngle_m.
constexpr double kSharp = 0.766;
// A higher step is another floor.
constexpr double kStep_m = 0.2e-3;
constexpr double kFar_m = -1e9;
// Beyond the band of the line angles by more than a coarse grid's triangle.
constexpr double kFarFromEdge_m = kLineAngle_m + 0.15e-3;
constexpr double kPiece_m = 0.2e-3;
// Two regions of one surface share what lies nearer to their border than this, so that no grid's triangles decide. Chosen.
constexpr double kBorder_m = 0.25e-3;

// By Facing. In a cavity of the buccal face (scene::Up::kBuccal) the gingival wall takes the place of the buccal wall.
constexpr const char* kSides[] = {"", "mesial", "distal", "buccal", "lingual"};
constexpr const char* kSidesOfFace[] = {"", "mesial", "distal", "gingival", "occlusal"};

// The border between two families runs along triangles: the grid's place moves it by the size of larger ones.
constexpr double kFine_m2 = 0.003e-6;

// Each triangle in four.
surface::Mesh Quartered(surface::Mesh mesh) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  auto middle = [&](uint32_t a, uint32_t b) {
    const auto next = static_cast<uint32_t>(mesh.position_m.size());
    const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), next);
    if (is_new) mesh.position_m.push_back((mesh.position_m[a] + mesh.position_m[b]) * 0.5F);
    return found->second;
  };
  const auto whole = std::move(mesh.triangles);
  mesh.triangles.clear();
  for (const auto& [a, b, c] : whole) {
    const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    mesh.triangles.insert(mesh.triangles.end(),
                          {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return mesh;
}

// Names the surface's triangles, one property after the other.
class Divider {
 public:
  explicit Divider(const FacingSurface& surface)
      : s_(surface), region_(surface.at_m.size(), nullptr) {}

  // `surfaces`: of the same cut, in triangles of any size.
  CutSurface Take(FacingSurface::Families surfaces) {
    out_.of_family = std::move(surfaces);
    out_.family = s_.family;
    out_.is_stump = s_.is_stump;
    FindEdges();
    Divide();
    return std::move(out_);
  }

 private:
  // How far each triangle is from another family across a sharp edge, at most kFarFromEdge_m.
  void FindEdges() {
    const Around around(s_.at_m, kFarFromEdge_m);
    to_edge_m_.assign(s_.at_m.size(), kFarFromEdge_m);
    for (size_t i = 0; i < s_.at_m.size(); ++i) {
      const uint8_t own = s_.family[i];
      std::array<bool, kFamilies> sharp{};
      around.Of(i, [&](uint32_t j, double) {
        const uint8_t other = s_.family[j];
        if (other != own && Dot(s_.normal[i], s_.normal[j]) < kSharp) sharp[other] = true;
      });
      for (size_t f = 0; f < sharp.size(); ++f) {
        if (!sharp[f]) continue;
        to_edge_m_[i] = out_.of_family[f]->Distance_m(s_.at_m[i], to_edge_m_[i]);
        if (to_edge_m_[i] <= kLineAngle_m) out_.meets[own][f] = out_.meets[f][own] = true;
      }
    }
  }

  // Which quarter about `middle`, of an extent of `half` along x and y.
  Facing QuarterOf(const dvec3& p, const dvec3& middle, const dvec3& half) const {
    const double x = s_.mesial_x * (p.x - middle.x) / half.x, y = (p.y - middle.y) / half.y;
    if (std::fabs(x) >= std::fabs(y)) return x > 0 ? kMesial : kDistal;
    return y > 0 ? kBuccal : kLingual;
  }

  std::string CuspAt(const dvec3& p, const dvec3& middle) const {
    if (scene::IsAnterior(s_.place.tooth) || !scene::IsToothNumber(s_.place.tooth)) return "table";
    const std::string side = p.y > middle.y ? "buccal" : "lingual";
    if (s_.place.tooth % 10 <= 5 && s_.place.tooth < 50) return "cusp_" + side;
    return (s_.mesial_x * (p.x - middle.x) > 0 ? "cusp_mesio" : "cusp_disto") + side;
  }

  std::string ThirdAt(const dvec3& p, double from_y, double to_y) const {
    const double third = to_y > from_y ? 3 * (p.y - from_y) / (to_y - from_y) : 1.5;
    if (third > 1 && third < 2) return "face_middle";
    if (s_.place.up == scene::Up::kBuccal) return third >= 2 ? "face_cervical" : "face_incisal";
    return third >= 2 ? "face_buccal" : "face_lingual";
  }

  void Divide() {
    int parts = 0;
    const std::vector<int> part = s_.UpwardParts(parts);
    std::vector<double> area(static_cast<size_t>(parts)), height(area.size());
    std::vector<double> top(area.size(), kFar_m);
    dvec3 lo(-kFar_m), hi(kFar_m);
    for (size_t i = 0; i < s_.at_m.size(); ++i) {
      if (s_.faces[i] != kUpward || s_.is_face)
        lo = glm::min(lo, s_.at_m[i]), hi = glm::max(hi, s_.at_m[i]);
      if (part[i] < 0) continue;
      const auto k = static_cast<size_t>(part[i]);
      area[k] += s_.area_m2[i];
      height[k] += s_.area_m2[i] * s_.at_m[i].z;
      top[k] = std::max(top[k], s_.at_m[i].z);
    }
    const dvec3 half = glm::max(0.5 * (hi - lo), dvec3(1e-6));
    std::vector<size_t> floors;
    const double least_m2 = s_.LeastFloor_m2(area);
    for (size_t k = 0; k < area.size(); ++k) {
      height[k] /= area[k];
      if (area[k] >= least_m2) floors.push_back(k);
    }
    std::ranges::sort(floors, [&](size_t a, size_t b) {
      return height[a] != height[b] ? height[a] > height[b] : a < b;
    });
    // Parts at one height are one floor, and so is all that is below the third.
    constexpr size_t kMaxLevels = 4;
    std::vector<size_t> level(area.size());
    size_t levels = 0;
    for (size_t k = 0; k < floors.size(); ++k) {
      if (k == 0 || height[floors[k - 1]] - height[floors[k]] > kStep_m)
        levels = std::min(levels + 1, kMaxLevels);
      level[floors[k]] = levels;
    }
    const int table = floors.empty() ? -1
                                     : static_cast<int>(*std::ranges::max_element(
                                           floors, {}, [&](size_t k) { return top[k]; }));
    dvec3 table_middle(0);
    double table_area = 0;
    for (size_t i = 0; i < s_.at_m.size(); ++i) {
      if (part[i] >= 0 && part[i] == table) {
        table_middle += s_.area_m2[i] * s_.at_m[i], table_area += s_.area_m2[i];
      }
    }
    if (table_area > 0) table_middle /= table_area;

    for (size_t i = 0; i < s_.at_m.size(); ++i) {
      if (s_.faces[i] != kUpward) {
        if (s_.is_stump) {
          Name(i, RegionKind::kAxialWall, std::string("axial_") + kSides[size_t(s_.faces[i])]);
        } else {
          const auto& sides = s_.place.up == scene::Up::kBuccal ? kSidesOfFace : kSides;
          Name(i, RegionKind::kWall, std::string("wall_") + sides[size_t(s_.faces[i])]);
        }
        continue;
      }
      const auto floor = std::ranges::find(floors, static_cast<size_t>(part[i]));
      if (floor == floors.end()) continue;
      if (s_.is_face) {
        Name(i, RegionKind::kFace, ThirdAt(s_.at_m[i], lo.y, hi.y));
      } else if (!s_.is_stump) {
        Name(i, RegionKind::kFloor,
             levels == 1 ? "floor" : "floor_" + std::to_string(level[*floor]));
      } else if (part[i] == table) {
        Name(i, RegionKind::kTable, CuspAt(s_.at_m[i], table_middle));
      } else {
        Name(i, RegionKind::kMargin,
             std::string("margin_") + kSides[size_t(QuarterOf(s_.at_m[i], s_.middle_m, half))]);
      }
    }
    Number();
    ShareBorders();
    MakePieces();
  }

  // The mean of the regions within kBorder_m, of which the two largest count.
  void ShareBorders() {
    beside_.assign(s_.at_m.size(), nullptr);
    out_.beside_share.assign(s_.at_m.size(), 0);
    const Around around(s_.at_m, kBorder_m);
    const Named* const edge = &named_.at("~");
    std::vector<Named*> own(s_.at_m.size());
    for (size_t i = 0; i < s_.at_m.size(); ++i) {
      own[i] = region_[i];
      if (region_[i] == edge) continue;
      std::vector<std::pair<Named*, double>> near;
      around.Of(i, [&](uint32_t j, double weight) {
        if (region_[j] == edge || !(weight > 0) || Dot(s_.normal[i], s_.normal[j]) < kSharp) return;
        auto found = std::ranges::find(near, region_[j], &std::pair<Named*, double>::first);
        if (found == near.end()) found = near.insert(found, {region_[j], 0});
        found->second += s_.area_m2[j] * weight;
      });
      if (near.size() < 2) continue;
      std::ranges::sort(near, [](const auto& a, const auto& b) {
        return a.second != b.second ? a.second > b.second : a.first->number < b.first->number;
      });
      own[i] = near[0].first;
      beside_[i] = near[1].first;
      out_.beside_share[i] = near[1].second / (near[0].second + near[1].second);
    }
    region_ = std::move(own);
  }

  struct Named {
    RegionKind kind = RegionKind::kFloor;
    double area_m2 = 0;
    uint32_t number = 0;
  };
  void Name(size_t triangle, RegionKind kind, const std::string& name) {
    const auto found = named_.try_emplace(name, Named{kind}).first;
    found->second.area_m2 += s_.area_m2[triangle] * OutsideBand(triangle);
    region_[triangle] = &found->second;
  }

  // How much of a triangle lies outside the band of the line angles: the band ends within triangles.
  double OutsideBand(size_t triangle) const {
    const double across = std::sqrt(2 * s_.area_m2[triangle]);
    if (!(across > 0)) return 1;
    return std::clamp(0.5 + (to_edge_m_[triangle] - kLineAngle_m) / across, 0.0, 1.0);
  }

  // By name, so that no order of triangles shows; the line angles last.
  void Number() {
    Named& edge = named_.try_emplace("~", Named{RegionKind::kLineAngle}).first->second;
    for (size_t i = 0; i < s_.at_m.size(); ++i) {
      const bool small = region_[i] == nullptr || region_[i]->area_m2 < kMinArea_m2;
      edge.area_m2 += s_.area_m2[i] * (small ? 1 : 1 - OutsideBand(i));
      if (small) region_[i] = &edge;
    }
    for (auto& [name, named] : named_) {
      const bool is_edge = &named == &edge;
      if (is_edge ? named.area_m2 <= 0 : named.area_m2 < kMinArea_m2) continue;
      named.number = static_cast<uint32_t>(out_.regions.size());
      out_.regions.push_back({named.kind, is_edge ? "line_angles" : name, named.area_m2});
    }
  }

  void MakePieces() {
    out_.piece.resize(s_.at_m.size());
    out_.edge_piece.assign(s_.at_m.size(), kNoPiece);
    out_.beside.assign(s_.at_m.size(), kNoPiece);
    const Named& edge = named_.at("~");
    for (size_t i = 0; i < s_.at_m.size(); ++i) {
      if (region_[i] == &edge) {
        out_.piece[i] = out_.edge_piece[i] = AddToPiece(i, edge.number, 1);
        continue;
      }
      out_.piece[i] = AddToPiece(i, region_[i]->number, 1 - out_.beside_share[i]);
      if (beside_[i] != nullptr)
        out_.beside[i] = AddToPiece(i, beside_[i]->number, out_.beside_share[i], true);
      if (OutsideBand(i) < 1) out_.edge_piece[i] = AddToPiece(i, edge.number, 1);
    }
    for (size_t k = 0; k < out_.pieces.size(); ++k) {
      SurfacePiece& piece = out_.pieces[k];
      piece.at_edge = out_.regions[piece.region].kind == RegionKind::kLineAngle ||
                      2 * banded_m2_[k] > piece.area_m2;
      piece.at_m /= piece.area_m2 > 0 ? piece.area_m2 : 1;
      piece.normal = Unit(piece.normal);
    }
  }
  // `shared`: with the region that the triangle lies in.
  uint32_t AddToPiece(size_t triangle, uint32_t region, double share, bool shared = false) {
    const auto next = static_cast<uint32_t>(out_.pieces.size());
    const auto [found, is_new] =
        numbers_.try_emplace({CellOf(s_.at_m[triangle], kPiece_m), region}, next);
    if (is_new) {
      out_.pieces.push_back({dvec3(0), dvec3(0), 0, region});
      banded_m2_.push_back(0);
    }
    SurfacePiece& piece = out_.pieces[found->second];
    const double area_m2 = s_.area_m2[triangle] * share;
    piece.at_m += area_m2 * s_.at_m[triangle];
    piece.normal += area_m2 * s_.normal[triangle];
    piece.area_m2 += area_m2;
    banded_m2_[found->second] += area_m2 * (shared ? 1 : 1 - OutsideBand(triangle));
    return found->second;
  }

  const FacingSurface& s_;
  std::map<std::string, Named> named_;
  std::vector<Named*> region_;  // of each triangle; null: none of its own
  std::vector<Named*> beside_;  // null: none
  std::vector<double> to_edge_m_;
  std::map<std::pair<Cell, uint32_t>, uint32_t> numbers_;  // of pieces
  std::vector<double> banded_m2_;  // of each piece, within the band or shared
  CutSurface out_;
};

}  // namespace

CutSurface DivideSurface(const surface::Mesh& cut, const ToothPlace& place) {
  const FacingSurface surface(cut, place);
  if (!(surface.MeanArea_m2() > kFine_m2)) return Divider(surface).Take(surface.Surfaces());
  const surface::Mesh fine = Quartered(cut);
  return Divider(surface).Take(FacingSurface(fine, place).Surfaces());
}

}  // namespace enamel::scoring
