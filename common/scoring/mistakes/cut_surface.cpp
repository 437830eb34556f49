#include "common/scoring/mistakes/cut_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "common/scene/tooth_number.h"
#include "common/scoring/mistakes/around.h"

namespace enamel::scoring {
namespace {

// Up: within 53 degrees of the way in. Walls of crowns stand steeper than 70, cusps' slopes are
// flatter than 45.
constexpr double kUp = 0.6;
// Between surfaces that meet in a line angle: cosine of 40 degrees. Round corners turn by less over
// kLineAngle_m.
constexpr double kSharp = 0.766;
// A cut that faces up to this share has no walls worth the name. Boxes have 0.27 to 0.45, a veneer 0.9.
constexpr double kFaceShare = 0.65;
// A smaller region is part of the line angles.
constexpr double kLeastArea_m2 = 0.3e-6;
// Floors: a smaller part is a shelf at the rim. A higher step is another floor.
constexpr double kLeastOfLargest = 0.1, kStep_m = 0.2e-3;
constexpr double kFar_m = -1e9;
// Beyond the band of the line angles by more than a coarse grid's triangle.
constexpr double kFarFromEdge_m = kLineAngle_m + 0.15e-3;
// Normals are means over kSmooth_m: the steps of a bur's path are finer. Chosen.
constexpr double kSmooth_m = 0.2e-3, kPiece_m = 0.2e-3;
// Two regions of one surface share what lies nearer to their border than this, so that no grid's triangles decide. Chosen.
constexpr double kBorder_m = 0.25e-3;

enum Class : uint8_t { kUpward, kMesial, kDistal, kBuccal, kLingual };
// By Class. In a cavity of the buccal face (scene::Up::kBuccal) the gingival wall takes the place of the buccal wall.
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

dvec3 Unit(const dvec3& v) {
  const double length = std::sqrt(Dot(v, v));
  return length > 0 ? v / length : dvec3(0, 0, 1);
}

// Names the surface's triangles, one property after the other.
class Divider {
 public:
  Divider(const surface::Mesh& cut, const ToothPlace& place)
      : cut_(cut), place_(place), mesial_x_(scene::MesialX(place.tooth)) {
    const size_t n = cut.triangles.size();
    at_.resize(n), normal_.resize(n), area_.resize(n), class_.resize(n);
    region_.assign(n, nullptr);
    for (size_t i = 0; i < n; ++i) {
      std::array<dvec3, 3> p;
      for (size_t k = 0; k < 3; ++k) p[k] = dvec3(cut.position_m[cut.triangles[i][k]]);
      const dvec3 twice = glm::cross(p[1] - p[0], p[2] - p[0]);
      at_[i] = (p[0] + p[1] + p[2]) / 3.0;
      area_[i] = 0.5 * std::sqrt(Dot(twice, twice));
      normal_[i] = 0.5 * twice;
    }
    Smooth();
    Classify();
    MakeFamilies();
  }

  double MeanArea_m2() const {
    return std::accumulate(area_.begin(), area_.end(), 0.0) / static_cast<double>(area_.size());
  }
  using Families = std::array<std::optional<surface::DistanceQuery>, CutSurface::kFamilies>;
  Families Surfaces() const {
    Families out;
    for (size_t f = 0; f < out.size(); ++f) {
      out[f] = QueryOf(cut_, [&](size_t i) { return out_.family[i] == f; });
    }
    return out;
  }
  // `surfaces`: of the same cut, in triangles of any size.
  CutSurface Take(Families surfaces) {
    out_.of_family = std::move(surfaces);
    FindEdges();
    Divide();
    return std::move(out_);
  }

 private:
  void Smooth() {
    const Around around(at_, kSmooth_m);
    std::vector<dvec3> out(at_.size(), dvec3(0));
    for (size_t i = 0; i < at_.size(); ++i) {
      around.Of(i, [&](uint32_t j, double weight) { out[i] += weight * normal_[j]; });
      out[i] = Unit(out[i]);
    }
    normal_ = std::move(out);
  }

  void Classify() {
    double up = 0, all = 0, wall = 0;
    dvec3 middle(0);
    for (size_t i = 0; i < at_.size(); ++i) {
      all += area_[i];
      if (normal_[i].z > kUp)
        up += area_[i];
      else
        middle += area_[i] * at_[i], wall += area_[i];
    }
    is_face_ = up > kFaceShare * all;
    if (wall > 0) middle_ = middle / wall;
    double outward = 0;
    for (size_t i = 0; i < at_.size(); ++i) {
      const dvec3 out = at_[i] - middle_;
      if (normal_[i].z <= kUp) outward += area_[i] * (normal_[i].x * out.x + normal_[i].y * out.y);
    }
    out_.is_stump = !is_face_ && outward > 0;
    for (size_t i = 0; i < at_.size(); ++i) {
      class_[i] = is_face_ || normal_[i].z > kUp ? kUpward : SideOf(normal_[i]);
    }
    if (!is_face_ && !out_.is_stump) GiveShelvesToWalls();
  }
  // A cavity's wall faces away from the side that it is on.
  Class SideOf(const dvec3& n) const {
    const double side = out_.is_stump ? 1 : -1;
    if (std::fabs(n.x) >= std::fabs(n.y)) return side * mesial_x_ * n.x > 0 ? kMesial : kDistal;
    return side * n.y > 0 ? kBuccal : kLingual;
  }
  // At some places of the grid the triangles along a rim face up.
  void GiveShelvesToWalls() {
    int parts = 0;
    const std::vector<int> part = UpwardParts(parts);
    std::vector<double> area(static_cast<size_t>(parts));
    for (size_t i = 0; i < at_.size(); ++i) {
      if (part[i] >= 0) area[static_cast<size_t>(part[i])] += area_[i];
    }
    const double least_m2 = LeastFloor_m2(area);
    for (size_t i = 0; i < at_.size(); ++i) {
      if (part[i] >= 0 && area[static_cast<size_t>(part[i])] < least_m2)
        class_[i] = SideOf(normal_[i]);
    }
  }
  double LeastFloor_m2(const std::vector<double>& area) const {
    const double largest = area.empty() ? 0 : *std::ranges::max_element(area);
    return std::max(kLeastArea_m2, out_.is_stump ? 0 : kLeastOfLargest * largest);
  }

  void MakeFamilies() {
    out_.family.resize(at_.size());
    for (size_t i = 0; i < at_.size(); ++i) {
      out_.family[i] = out_.is_stump && class_[i] != kUpward ? kMesial : class_[i];
    }
  }

  // How far each triangle is from another family across a sharp edge, at most kFarFromEdge_m.
  void FindEdges() {
    const Around around(at_, kFarFromEdge_m);
    to_edge_m_.assign(at_.size(), kFarFromEdge_m);
    for (size_t i = 0; i < at_.size(); ++i) {
      const uint8_t own = out_.family[i];
      std::array<bool, CutSurface::kFamilies> sharp{};
      around.Of(i, [&](uint32_t j, double) {
        const uint8_t other = out_.family[j];
        if (other != own && Dot(normal_[i], normal_[j]) < kSharp) sharp[other] = true;
      });
      for (size_t f = 0; f < sharp.size(); ++f) {
        if (!sharp[f]) continue;
        to_edge_m_[i] = out_.of_family[f]->Distance_m(at_[i], to_edge_m_[i]);
        if (to_edge_m_[i] <= kLineAngle_m) out_.meets[own][f] = out_.meets[f][own] = true;
      }
    }
  }

  // The number of the connected upward surface that each triangle belongs to; -1 for walls.
  std::vector<int> UpwardParts(int& count) const {
    std::vector<uint32_t> parent(cut_.position_m.size());
    std::iota(parent.begin(), parent.end(), 0U);
    auto root = [&](uint32_t v) {
      while (parent[v] != v) v = parent[v] = parent[parent[v]];
      return v;
    };
    auto counts = [&](size_t i) { return class_[i] == kUpward; };
    for (size_t i = 0; i < at_.size(); ++i) {
      if (!counts(i)) continue;
      const auto& t = cut_.triangles[i];
      parent[root(t[1])] = root(t[0]);
      parent[root(t[2])] = root(t[0]);
    }
    std::unordered_map<uint32_t, int> number;
    std::vector<int> out(at_.size(), -1);
    for (size_t i = 0; i < at_.size(); ++i) {
      if (!counts(i)) continue;
      out[i] = number.try_emplace(root(cut_.triangles[i][0]), static_cast<int>(number.size()))
                   .first->second;
    }
    count = static_cast<int>(number.size());
    return out;
  }

  // Which quarter about `middle`, of an extent of `half` along x and y.
  Class QuarterOf(const dvec3& p, const dvec3& middle, const dvec3& half) const {
    const double x = mesial_x_ * (p.x - middle.x) / half.x, y = (p.y - middle.y) / half.y;
    if (std::fabs(x) >= std::fabs(y)) return x > 0 ? kMesial : kDistal;
    return y > 0 ? kBuccal : kLingual;
  }

  std::string CuspAt(const dvec3& p, const dvec3& middle) const {
    if (scene::IsAnterior(place_.tooth) || !scene::IsToothNumber(place_.tooth)) return "table";
    const std::string side = p.y > middle.y ? "buccal" : "lingual";
    if (place_.tooth % 10 <= 5 && place_.tooth < 50) return "cusp_" + side;
    return (mesial_x_ * (p.x - middle.x) > 0 ? "cusp_mesio" : "cusp_disto") + side;
  }

  std::string ThirdAt(const dvec3& p, double from_y, double to_y) const {
    const double third = to_y > from_y ? 3 * (p.y - from_y) / (to_y - from_y) : 1.5;
    if (third > 1 && third < 2) return "face_middle";
    if (place_.up == scene::Up::kBuccal) return third >= 2 ? "face_cervical" : "face_incisal";
    return third >= 2 ? "face_buccal" : "face_lingual";
  }

  void Divide() {
    int parts = 0;
    const std::vector<int> part = UpwardParts(parts);
    std::vector<double> area(static_cast<size_t>(parts)), height(area.size());
    std::vector<double> top(area.size(), kFar_m);
    dvec3 lo(-kFar_m), hi(kFar_m);
    for (size_t i = 0; i < at_.size(); ++i) {
      if (class_[i] != kUpward || is_face_) lo = glm::min(lo, at_[i]), hi = glm::max(hi, at_[i]);
      if (part[i] < 0) continue;
      const auto k = static_cast<size_t>(part[i]);
      area[k] += area_[i];
      height[k] += area_[i] * at_[i].z;
      top[k] = std::max(top[k], at_[i].z);
    }
    const dvec3 half = glm::max(0.5 * (hi - lo), dvec3(1e-6));
    std::vector<size_t> floors;
    const double least_m2 = LeastFloor_m2(area);
    for (size_t k = 0; k < area.size(); ++k) {
      height[k] /= area[k];
      if (area[k] >= least_m2) floors.push_back(k);
    }
    std::ranges::sort(floors, [&](size_t a, size_t b) {
      return height[a] != height[b] ? height[a] > height[b] : a < b;
    });
    // Parts at one height are one floor, and so is all that is below the third.
    constexpr size_t kMostLevels = 4;
    std::vector<size_t> level(area.size());
    size_t levels = 0;
    for (size_t k = 0; k < floors.size(); ++k) {
      if (k == 0 || height[floors[k - 1]] - height[floors[k]] > kStep_m)
        levels = std::min(levels + 1, kMostLevels);
      level[floors[k]] = levels;
    }
    const int table = floors.empty() ? -1
                                     : static_cast<int>(*std::ranges::max_element(
                                           floors, {}, [&](size_t k) { return top[k]; }));
    dvec3 table_middle(0);
    double table_area = 0;
    for (size_t i = 0; i < at_.size(); ++i) {
      if (part[i] >= 0 && part[i] == table) {
        table_middle += area_[i] * at_[i], table_area += area_[i];
      }
    }
    if (table_area > 0) table_middle /= table_area;

    for (size_t i = 0; i < at_.size(); ++i) {
      if (class_[i] != kUpward) {
        if (out_.is_stump) {
          Name(i, RegionKind::kAxialWall, std::string("axial_") + kSides[class_[i]]);
        } else {
          const auto& sides = place_.up == scene::Up::kBuccal ? kSidesOfFace : kSides;
          Name(i, RegionKind::kWall, std::string("wall_") + sides[class_[i]]);
        }
        continue;
      }
      const auto floor = std::ranges::find(floors, static_cast<size_t>(part[i]));
      if (floor == floors.end()) continue;
      if (is_face_) {
        Name(i, RegionKind::kFace, ThirdAt(at_[i], lo.y, hi.y));
      } else if (!out_.is_stump) {
        Name(i, RegionKind::kFloor,
             levels == 1 ? "floor" : "floor_" + std::to_string(level[*floor]));
      } else if (part[i] == table) {
        Name(i, RegionKind::kTable, CuspAt(at_[i], table_middle));
      } else {
        Name(i, RegionKind::kMargin,
             std::string("margin_") + kSides[QuarterOf(at_[i], middle_, half)]);
      }
    }
    Number();
    ShareBorders();
    MakePieces();
  }

  // The mean of the regions within kBorder_m, of which the two largest count.
  void ShareBorders() {
    beside_.assign(at_.size(), nullptr);
    out_.beside_share.assign(at_.size(), 0);
    const Around around(at_, kBorder_m);
    const Named* const edge = &named_.at("~");
    std::vector<Named*> own(at_.size());
    for (size_t i = 0; i < at_.size(); ++i) {
      own[i] = region_[i];
      if (region_[i] == edge) continue;
      std::vector<std::pair<Named*, double>> near;
      around.Of(i, [&](uint32_t j, double weight) {
        if (region_[j] == edge || !(weight > 0) || Dot(normal_[i], normal_[j]) < kSharp) return;
        auto found = std::ranges::find(near, region_[j], &std::pair<Named*, double>::first);
        if (found == near.end()) found = near.insert(found, {region_[j], 0});
        found->second += area_[j] * weight;
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
    found->second.area_m2 += area_[triangle] * OutsideBand(triangle);
    region_[triangle] = &found->second;
  }

  // How much of a triangle lies outside the band of the line angles: the band ends within triangles.
  double OutsideBand(size_t triangle) const {
    const double across = std::sqrt(2 * area_[triangle]);
    if (!(across > 0)) return 1;
    return std::clamp(0.5 + (to_edge_m_[triangle] - kLineAngle_m) / across, 0.0, 1.0);
  }

  // By name, so that no order of triangles shows; the line angles last.
  void Number() {
    Named& edge = named_.try_emplace("~", Named{RegionKind::kLineAngle}).first->second;
    for (size_t i = 0; i < at_.size(); ++i) {
      const bool small = region_[i] == nullptr || region_[i]->area_m2 < kLeastArea_m2;
      edge.area_m2 += area_[i] * (small ? 1 : 1 - OutsideBand(i));
      if (small) region_[i] = &edge;
    }
    for (auto& [name, named] : named_) {
      const bool is_edge = &named == &edge;
      if (is_edge ? named.area_m2 <= 0 : named.area_m2 < kLeastArea_m2) continue;
      named.number = static_cast<uint32_t>(out_.regions.size());
      out_.regions.push_back({named.kind, is_edge ? "line_angles" : name, named.area_m2});
    }
  }

  void MakePieces() {
    out_.piece.resize(at_.size());
    out_.edge_piece.assign(at_.size(), kNoPiece);
    out_.beside.assign(at_.size(), kNoPiece);
    const Named& edge = named_.at("~");
    for (size_t i = 0; i < at_.size(); ++i) {
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
        numbers_.try_emplace({CellOf(at_[triangle], kPiece_m), region}, next);
    if (is_new) {
      out_.pieces.push_back({dvec3(0), dvec3(0), 0, region});
      banded_m2_.push_back(0);
    }
    SurfacePiece& piece = out_.pieces[found->second];
    const double area_m2 = area_[triangle] * share;
    piece.at_m += area_m2 * at_[triangle];
    piece.normal += area_m2 * normal_[triangle];
    piece.area_m2 += area_m2;
    banded_m2_[found->second] += area_m2 * (shared ? 1 : 1 - OutsideBand(triangle));
    return found->second;
  }

  const surface::Mesh& cut_;
  const ToothPlace place_;
  const int mesial_x_;
  bool is_face_ = false;
  dvec3 middle_{0};
  std::vector<dvec3> at_, normal_;
  std::vector<double> area_;
  std::vector<Class> class_;
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
  Divider divider(cut, place);
  if (!(divider.MeanArea_m2() > kFine_m2)) return divider.Take(divider.Surfaces());
  const surface::Mesh fine = Quartered(cut);
  return divider.Take(Divider(fine, place).Surfaces());
}

}  // namespace enamel::scoring
