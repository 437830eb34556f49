#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "common/scoring/mistakes/contact.h"
#include "common/surface/surface.h"

// An acceptable cut R (an exercise's own target, or a reference in use), and what it alone fixes for
// every attempt: the regions of its surface, and for a point of the tooth the region that is nearest
// and how far off R's surface it lies. No surface of an attempt and no fit enters, so that a larger
// fault can only add to a region's measures (fault_volumes.h).
//
// Deterministic: + - * / sqrt in fixed orders. Thread safety: const after construction. Not real-time.
namespace enamel::scoring {

// Nobody pays for less: an examiner's eye just sees 0.1 mm (a minute of arc at 0.3 m).
inline constexpr double kLeeway_m = 0.1e-3;

// The part of a layer along R's surface between two distances from it, of even area.
struct Layer {
  double from_m = 0, to_m = 0;

  // `share` of a voxel's edge from the surface on, if that runs through the voxel. `distance_m`: of
  // its middle, below 0 on the other side of the surface.
  static Layer In(double distance_m, double voxel_m, double share) {
    const double from = distance_m > 0.5 * voxel_m ? distance_m - 0.5 * voxel_m : 0;
    return {from, from + share * voxel_m};
  }
  double thickness_m() const { return to_m - from_m; }
  // Mean of ((delta - leeway)+)^2.
  double Moment_m2() const;
  // Share that is farther than the leeway.
  double Beyond() const;
};

enum class RegionKind : uint8_t {
  kFloor,      // of a cavity: faces the opening
  kWall,       // of a cavity, with its rim
  kTable,      // of a stump: its top; a cusp's part of it
  kAxialWall,  // of a stump: a quarter
  kMargin,     // of a stump: a quarter of the shoulder or chamfer
  kFace,       // a third of a cut that has neither walls nor a stump
  kLineAngle,  // within kLineAngle_m of another of these
};
inline constexpr size_t kRegionKinds = 7;
// "floor", "wall", ...
std::string_view NameOf(RegionKind kind);
// Upright, of a cavity or a stump.
constexpr bool IsWall(RegionKind kind) {
  return kind == RegionKind::kWall || kind == RegionKind::kAxialWall;
}

// A wall or table that moves leaves a wedge in the cells of its neighbours across a sharp edge. A point whose
// distances from the two surfaces differ by less than this belongs to the edge, whose share falls from all to none
// within kLineAngleSoft_m to either side: a grid rounds an edge by half a voxel, each place of it another way. Chosen; the
// spread over places in the grid (enamel-lab grades --offsets) shows the second.
inline constexpr double kLineAngle_m = 0.35e-3, kLineAngleSoft_m = 0.2e-3;
// A task that leaves less over the pulp makes a hand touch it. Chosen.
inline constexpr double kPulpCover_m = 0.3e-3;
// Farther from R's surface nothing of a task lies.
inline constexpr double kDeepest_m = 6e-3;
struct Region {
  RegionKind kind = RegionKind::kFloor;
  // Stable, of ASCII letters: "wall_mesial", "floor", "floor_1" (of two the upper), "cusp_mesiobuccal".
  std::string name;
  double area_m2 = 0;

  bool operator==(const Region&) const = default;
};

// A piece of R's surface about 0.2 mm wide, of one region.
struct SurfacePiece {
  dvec3 at_m{0};    // its middle
  dvec3 normal{0};  // unit, out of the solid
  double area_m2 = 0;
  uint32_t region = 0;  // index into regions()
  // Within kLineAngle_m of a sharp edge, or beyond its region's border: there the surfaces that meet share what moved.
  bool at_edge = false;
};

// Which tooth, and how it lies.
struct ToothPlace {
  int tooth = 0;  // FDI number; 0: none
  scene::Up up = scene::Up::kOcclusal;
  double registration_m =
      0;  // R was laid on the tooth within it (uncertainty.h); 0: on the tooth's own grid
};

struct CutSurface;

class AcceptableCut {
 public:
  // `initial` and `prepared` (R) are kept, not copied. Requires: equal grids, nothing packed.
  AcceptableCut(const cutting::Volume& initial, const cutting::Volume& prepared,
                const ToothPlace& place);

  ~AcceptableCut();

  // None where R took nothing.
  const std::vector<Region>& regions() const;
  // A piece of the line angles lies where pieces of the surfaces that meet there lie too.
  const std::vector<SurfacePiece>& pieces() const;
  const cutting::Volume& initial() const { return initial_; }
  const cutting::Volume& prepared() const { return prepared_; }
  // R leaves a stump: the walls face away from their common middle.
  bool is_stump() const;
  // Standard uncertainty of where its surface and an attempt's lie (uncertainty.h).
  double surface_u_m() const { return surface_u_m_; }
  // The part of the task that is farther than kLeeway_m from R's surface.
  double task_beyond_m3() const { return task_beyond_m3_; }
  // How much touching the pulp is a fault, 0 to 1: 0 where R opens it or leaves less than the leeway over it, 1 where R
  // leaves kPulpCover_m. Without a step, since the grid decides whether a cut that just meets the pulp opens it.
  double pulp_counts() const { return pulp_counts_; }
  // nullptr: R is a stump, whose axial walls say it, or opens no contact.
  const Contact* contact() const { return contact_ ? &*contact_ : nullptr; }

  struct Nearest {
    double distance_m = 0;  // without a side
    // The nearest piece; near the border of its region, also a piece of the next region, and that one's share.
    uint32_t next_to = 0, beside = 0;
    double beside_share = 0;
    // Where the point is about as near to two surfaces that meet in a sharp edge, a piece of the edge, and its share.
    uint32_t edge = 0;
    double edge_share = 0;

    struct Payer {
      uint32_t piece = 0;
      double share = 0;
    };
    // The nearest pieces of the surface itself. The shares sum to 1, here and below.
    std::array<Payer, 2> Nearby() const {
      return {{{next_to, 1 - beside_share}, {beside, beside_share}}};
    }
    // The pieces that pay.
    std::array<Payer, 3> Payers() const {
      return {{{edge, edge_share},
               {next_to, (1 - edge_share) * (1 - beside_share)},
               {beside, (1 - edge_share) * beside_share}}};
    }
    // The piece that pays most.
    uint32_t piece() const { return edge_share > 0.5 ? edge : next_to; }
  };
  struct Found {
    Nearest nearest;
    uint32_t triangle = 0;
  };
  // Triangles of query_ and edges_ that a point nearby had.
  struct Guess {
    uint32_t triangle = surface::DistanceQuery::kNone, edge = surface::DistanceQuery::kNone;
  };
  // Looks up the nearest piece of R's surface for the voxels of one brick. One thread at a time.
  class Brick {
   public:
    // `limit_m`: beyond it there is none.
    Brick(const AcceptableCut& r, int brick, double limit_m);
    // `i`: the voxel, below cutting::kBrickVoxels.
    std::optional<Nearest> At(int i);
    dvec3 PointOf(int i) const;

   private:
    // Two or four voxels along each axis, about 0.2 mm. Where it is far from R's surface, one triangle stands for all.
    struct Block {
      bool known = false, far = false;
      std::optional<Found> middle;
    };
    const AcceptableCut& r_;
    Guess guess_;
    const double limit_m_, voxel_m_;
    const int16_t* const samples_;  // of R
    dvec3 first_m_{0};
    int side_ = 2;
    std::array<Block, 64> blocks_;
  };

 private:
  std::optional<Found> NearestTo(const dvec3& point_m, double limit_m, Guess& guess) const;
  void MarkRim(const surface::Mesh& whole, size_t inner);
  void MeasureTask();
  void FindPulp();

  const cutting::Volume &initial_, &prepared_;
  std::unique_ptr<CutSurface> surface_;
  std::optional<surface::DistanceQuery> query_;  // of R's cut surface, out to its rim
  std::vector<uint32_t> inner_;                  // of its triangles, the nearest of surface_
  std::vector<bool> at_rim_;                     // of its triangles, whether they touch the rim
  std::optional<surface::DistanceQuery> edges_;  // of the line angles
  std::vector<uint32_t> piece_of_edge_;          // of its triangles
  std::optional<Contact> contact_;
  double task_beyond_m3_ = 0, pulp_counts_ = 1, surface_u_m_ = 0;
};

}  // namespace enamel::scoring
