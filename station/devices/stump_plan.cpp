#include <algorithm>
#include <cmath>

#include "common/scene/preparation.h"
#include "station/devices/cavity_plan.h"
#include "station/devices/relief_plan.h"

namespace enamel::station {
namespace {

constexpr double kClear_m = 1.0e-3;  // above the highest solid, between air and work
constexpr double kAirFeed_m_per_s = 10e-3;
constexpr double kRoughFeed_m_per_s = 4e-3;
constexpr double kFinishFeed_m_per_s = 4e-3;
constexpr double kStock_m = 0.12e-3;          // left by roughing
constexpr double kOverlap = 1.3;              // of the tip's radius, from round to round
constexpr double kContour_m = 0.25e-3;        // height of what a contour finishes
constexpr double kNeighbourGap_m = 0.2e-3;    // that the bur keeps: as far as a hand strays
constexpr double kPushBesideNeighbour = 0.5;  // of what it is elsewhere, so that it strays less
constexpr double kTableRows_m = 0.6e-3;       // from row to row, roughly and to finish
constexpr double kTableFinishRows_m =
    0.3e-3;  // a flat end leaves ridges of 0.1 mm on a slope of 20 degrees
constexpr double kWhereWide_m = 4e-3;  // above the tip: where crowns are widest

// Bounds of the tooth's solid, and of the room between its neighbours, from `z_m` upward.
struct Surroundings {
  Bounds tooth{0, 0, 0, 0};
  Bounds room{-1, 1, -1, 1};
};

Surroundings LookAround(const cutting::Volume& volume, const scene::PreparationPart& part,
                        double z_m) {
  const cutting::GridSpec& spec = volume.spec();
  const dvec3 origin = spec.origin_m();
  const double h = spec.voxel_m();
  const double x = part.top_um[0] * 1e-6, y = part.top_um[1] * 1e-6;
  Surroundings out;
  out.tooth = {x, x, y, y};
  const ivec3 n = spec.voxels();
  for (int k = std::max(0, static_cast<int>((z_m - origin.z) / h)); k < n.z; ++k)
    for (int j = 0; j < n.y; ++j)
      for (int i = 0; i < n.x; ++i) {
        if (volume.PhiAt({i, j, k}) >= 0) continue;
        const dvec3 p = origin + dvec3(i, j, k) * h;
        if (volume.TissueAt({i, j, k}) != cutting::Tissue::kNeighbour) {
          Bounds& b = out.tooth;
          b = {std::min(b.x0, p.x), std::max(b.x1, p.x), std::min(b.y0, p.y), std::max(b.y1, p.y)};
        } else if (p.x > x) {  // neighbours stand along x
          out.room.x1 = std::min(out.room.x1, p.x);
        } else {
          out.room.x0 = std::max(out.room.x0, p.x);
        }
      }
  return out;
}

// The highest place of a stump's top within its walls.
double TableTop_m(const PartCut& cut) {
  const scene::PreparationPart& part = cut.part;
  if (part.relief.step_um == 0) return (part.top_um[2] - part.stump.table_below_um) * 1e-6;
  const scene::Stump::Section& s = part.stump.table;
  double top = -1;
  constexpr int kPlaces = 40;
  for (int j = -kPlaces; j <= kPlaces; ++j)
    for (int i = -kPlaces; i <= kPlaces; ++i) {
      const double x = part.top_um[0] + s.middle_um[0] + s.half_um[0] * i / double{kPlaces};
      const double y = part.top_um[1] + s.middle_um[1] + s.half_um[1] * j / double{kPlaces};
      top = std::max(top, scene::ReliefAt(part, x * 1e-6, y * 1e-6).z_m);
    }
  return top;
}

class Planner {
 public:
  Planner(const PartCut& cut, const cutting::Bur& bur, const cutting::Volume& volume,
          const CavityPlanOptions& options)
      : cut_(cut),
        options_(options),
        bur_(bur),
        tip_m_(bur.shape == cutting::BurShape::kCone ? bur.narrow_radius_m : bur.radius_m),
        foot_z_((cut.part.top_um[2] - cut.part.depth_um) * 1e-6 - cut.lower_m),
        table_z_(TableTop_m(cut) - cut.lower_m),
        around_(LookAround(volume, cut.part, foot_z_)),
        above_table_(LookAround(volume, cut.part, table_z_)) {
    const double side = (bur.radius_m - tip_m_) / std::max(bur.length_m, 1e-3);
    const double wide = tip_m_ + side * kWhereWide_m + kNeighbourGap_m;
    const Bounds& room = around_.room;
    room_ = {room.x0 + wide, room.x1 - wide, room.y0 + wide, room.y1 - wide};
    top_ = HighestSolid_m(volume, above_table_.tooth);
  }

  std::vector<Move> Make() {
    OffTheTop();
    if (cut_.part.relief.step_um != 0) IntoTheRelief(bur_);
    AroundTheWalls();
    Contours();
    Finish();
    return std::move(moves_);
  }

 private:
  void Go(std::vector<dvec3> points, double feed, double push, double tolerance, bool bur_on) {
    at_ = points.back();
    moves_.emplace_back(
        Stroke{std::move(points), feed * options_.speed_ratio, push, tolerance, bur_on});
  }
  // Through the air above a point, and down to it.
  void GoTo(const dvec3& p) {
    const double clear = std::max(top_, p.z) + kClear_m;
    std::vector<dvec3> way;
    if (!moves_.empty()) way.emplace_back(at_.x, at_.y, clear);
    way.emplace_back(p.x, p.y, clear);
    Go(std::move(way), kAirFeed_m_per_s, 0.5, 2e-4, false);
    Go({p}, kAirFeed_m_per_s, 0.5, 2e-4, true);
  }
  void GoRound(const Outline& outline, double z, double feed, double push) {
    // The walls are cut in beyond their middle: there is nothing left to go round.
    if (outline.empty()) return;
    std::vector<dvec3> c = CornersAt(outline, z, options_.clockwise);
    c.push_back(c[0]);
    if (at_.z != z) GoTo(c[0]);
    Go(std::move(c), feed, push, 1e-4, true);
  }

  // The walls at a height, this far out.
  Outline Walls(double z, double out_m) const {
    const Outline walls = SectionOf(cut_.part, z + cut_.lower_m);
    return Moved(walls, [&](const glm::dvec2& outward) { return out_m - cut_.deeper_m(outward); });
  }
  // Rounds of the tip that clear from `inner` out to beyond the tooth, outermost first.
  std::vector<Outline> RoundsFrom(const Outline& inner, const Bounds& tooth) const {
    if (inner.empty()) return {};
    std::vector<Outline> out = {inner};
    for (;;) {
      const Bounds b = BoundsOf(out.back());
      const bool beyond = b.x0 - tip_m_ < tooth.x0 && b.x1 + tip_m_ > tooth.x1 &&
                          b.y0 - tip_m_ < tooth.y0 && b.y1 + tip_m_ > tooth.y1;
      if (beyond || out.size() > 20) break;
      out.push_back(Grown(out.back(), kOverlap * tip_m_));
    }
    for (Outline& o : out) o = Within(o, room_);
    std::reverse(out.begin(), out.end());
    return out;
  }
  // Whether a neighbour keeps the round from going farther out.
  bool IsBesideNeighbour(const Outline& round) const {
    if (round.empty()) return false;
    constexpr double kAt_m = 1e-6;
    const Bounds b = BoundsOf(round);
    return b.x0 < room_.x0 + kAt_m || b.x1 > room_.x1 - kAt_m;
  }
  int Layers(double from, double to, double layer) const {
    return std::max(1, static_cast<int>(std::ceil((from - to) / layer)));
  }

  // The table, from outside inward.
  void OffTheTop() {
    const Bounds& b = above_table_.tooth;
    const double inside = 0.5 * std::min(b.x1 - b.x0, b.y1 - b.y0);
    const Outline outer = RectangleOf(b);
    const int layers = Layers(top_, table_z_, options_.layer_m);
    for (int i = 1; i <= layers; ++i) {
      const double z = top_ + (table_z_ - top_) * i / layers;
      for (double in = 0; in < inside; in += kOverlap * tip_m_)
        GoRound(Within(Grown(outer, -in), room_), z, kRoughFeed_m_per_s, options_.rough_push_n);
    }
  }

  // Clears what is lower on the table than its highest place: in rows, layer by layer, and once
  // more in closer ones. The walls' rounds clear the area beside the table.
  void IntoTheRelief(const cutting::Bur& bur) {
    const ReliefTips tips(cut_, bur);
    Bounds over = BoundsOf(Walls(table_z_, tip_m_));
    over = {std::max(over.x0, room_.x0), std::min(over.x1, room_.x1), std::max(over.y0, room_.y0),
            std::min(over.y1, room_.y1)};
    const auto rough = RowsOver(tips, over, kTableRows_m, kStock_m, options_.clockwise);
    double lowest = table_z_;
    for (const auto& row : rough)
      for (const dvec3& p : row) lowest = std::min(lowest, p.z);
    top_ = table_z_;
    const int layers = Layers(table_z_, lowest, options_.layer_m);
    for (int i = 1; i <= layers; ++i) {
      const double above = table_z_ + (lowest - table_z_) * (i - 1) / layers;
      const double z = table_z_ + (lowest - table_z_) * i / layers;
      for (const auto& row : rough) RowInLayer(row, z, above);
    }
    for (auto& row : RowsOver(tips, over, kTableFinishRows_m, 0, !options_.clockwise)) {
      if (at_ != row.front()) Near(row.front());
      Go(std::move(row), kFinishFeed_m_per_s, options_.finish_push_n, 1e-4, true);
    }
  }
  // The stretches of a row that the layer above has left.
  void RowInLayer(const std::vector<dvec3>& row, double z, double above) {
    std::vector<dvec3> way;
    auto cut = [&] {
      if (way.size() > 1) {
        Near(way.front());
        Go(way, kRoughFeed_m_per_s, options_.rough_push_n, 1e-4, true);
      }
      way.clear();
    };
    for (const dvec3& p : row) {
      if (p.z < above) {
        way.emplace_back(p.x, p.y, std::max(p.z, z));
      } else {
        cut();
      }
    }
    cut();
  }
  // To a nearby place: just over the table, and down.
  void Near(const dvec3& p) {
    const double clear = table_z_ + 0.3e-3;
    Go({dvec3(at_.x, at_.y, clear), dvec3(p.x, p.y, clear), p}, kAirFeed_m_per_s, 0.5, 2e-4, true);
  }

  void AroundTheWalls() {
    top_ = table_z_;
    const int layers = Layers(table_z_, foot_z_, options_.layer_m);
    for (int i = 1; i <= layers; ++i) {
      const double z = table_z_ + (foot_z_ - table_z_) * i / layers;
      for (const Outline& round : RoundsFrom(Walls(z, tip_m_ + kStock_m), around_.tooth)) {
        const double push = IsBesideNeighbour(round) ? kPushBesideNeighbour : 1;
        GoRound(round, z, kRoughFeed_m_per_s, push * options_.rough_push_n);
      }
    }
  }

  void Contours() {
    const int steps = Layers(table_z_, foot_z_, kContour_m);
    for (int i = 1; i < steps; ++i) {
      const double z = table_z_ + (foot_z_ - table_z_) * i / steps;
      GoRound(Walls(z, tip_m_), z, kFinishFeed_m_per_s, options_.finish_push_n);
    }
  }

  // The wall's foot and the shoulder until they are right.
  void Finish() {
    FinishRing wall = RingAlong(Walls(foot_z_, tip_m_), foot_z_, options_.clockwise, -1);
    GoTo(wall.corners[0]);
    wall.feed_m_per_s = kFinishFeed_m_per_s * options_.speed_ratio;
    wall.push_n = 0.8;
    wall.tolerance_m = 40e-6;
    moves_.emplace_back(std::move(wall));
    FinishRing shoulder;
    shoulder.corners = CornersAt(Walls(foot_z_, tip_m_ + 30e-6), foot_z_, options_.clockwise);
    SetUpFloor(shoulder);
    shoulder.feed_m_per_s = kFinishFeed_m_per_s * options_.speed_ratio;
    at_ = shoulder.corners[0];
    moves_.emplace_back(std::move(shoulder));
    Go({at_ + dvec3(0, 0, table_z_ - foot_z_ + kClear_m)}, kAirFeed_m_per_s, 0.5, 3e-4, true);
  }

  const PartCut& cut_;
  const CavityPlanOptions& options_;
  const cutting::Bur bur_;
  const double tip_m_, foot_z_, table_z_;
  const Surroundings around_, above_table_;
  Bounds room_;  // where the tip may be
  double top_ = 0;
  dvec3 at_{0};
  std::vector<Move> moves_;
};

}  // namespace

std::vector<Move> PlanStump(const PartCut& cut, const cutting::Bur& bur,
                            const cutting::Volume& volume, const CavityPlanOptions& options) {
  return Planner(cut, bur, volume, options).Make();
}

}  // namespace enamel::station
