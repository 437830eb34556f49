#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/cutting/volume.h"
#include "common/math/vec.h"

namespace enamel::station::render {

// What a vertex of a tooth does with light.
struct Look {
  std::array<uint8_t, 3> root_albedo{};  // the square root of the linear one; 255 = 1
  uint8_t gloss = 0;                     // 255 = 1

  bool operator==(const Look&) const = default;
};
// From a linear colour.
Look LookOf(const dvec3& albedo, double gloss);

// Light on a layer of enamel, by its thickness: red, green and blue.
// What of the colour seen over dentin is the dentin's.
double ShareThroughEnamel(double thickness_m);
// What comes back from a layer over nothing, as a share of what a thick layer gives.
dvec3 EnamelOverDark(double thickness_m);

// The curvature across a groove from which on it is stained, where the stain is full, and how much of the
// colour is then stain. No source of how dark fissures are on average was found.
inline constexpr double kGrooveFrom_per_m = 0.9e3, kGrooveFull_per_m = 3.2e3, kMaxStained = 0.65;

// The material of a tooth: what its surface looks like, from the volume alone, so that scanned teeth
// get the same as built-in ones:
//
// * enamel lets through what is below it: dentin, a lesion, the dark of the mouth behind an uncut edge;
// * dentin lets through the pulp and a lesion, where they are near;
// * a lesion goes from chalk white at its border in enamel by yellow-brown to brown, without steps;
// * narrow grooves of the uncut surface are stained: fissures and pits;
// * uncut enamel is wet and shines, what was cut is matt.
//
// Only bricks near a lesion or the pulp ask for them. Thread safety: reads the volumes only. Not
// real-time.
class ToothLooks {
 public:
  // `uncut`: the tooth before a bur touched it, or null where all of it counts as uncut. Both must
  // outlive this; no tissue of `now` changes.
  explicit ToothLooks(const cutting::Volume& now, const cutting::Volume* uncut = nullptr);

  static bool IsTooth(uint8_t tissue);
  // Of a vertex (surface::Mesh): a point of the surface, its normal, the tissue under it. Requires:
  // IsTooth(tissue).
  Look At(const dvec3& surface_m, const dvec3& normal, cutting::Tissue tissue) const;

 private:
  // Of enamel and dentin around a point.
  struct Mixed {
    bool known = false;  // there is some
    double enamel = 0;   // its share
    dvec3 enamel_m{0};   // its middle
  };
  // Where a layer ends.
  struct Ground {
    cutting::Tissue tissue;  // the layer's own: it does not end
    double at_m;             // below the surface
    dvec3 place_m;
  };
  void MarkNear();
  bool IsNear(const dvec3& p, cutting::Tissue tissue) const;
  // Air outside the surface too.
  cutting::Tissue SolidAt(const dvec3& p) const;
  Mixed MixedAround(const dvec3& p, const dvec3& n) const;
  // From a point a voxel inside, which is in tissue `own`.
  Ground GroundBelow(cutting::Tissue own, const dvec3& p, const dvec3& way, double limit_m) const;
  // The mean of colour(ground) over ways inward.
  template <typename Colour>
  dvec3 MeanOfWays(cutting::Tissue own, const dvec3& p, const dvec3& n, double limit_m,
                   Colour&& colour) const;
  dvec3 EnamelColour(const dvec3& p, const dvec3& n, bool uncut) const;
  dvec3 DentinColour(const dvec3& p, const dvec3& n) const;
  // The share of a lesion around a point: 1/2 at its border.
  double CariesAround(const dvec3& p) const;
  bool IsUncut(const dvec3& surface_m) const;
  // The largest curvature of the surface across a groove, 1/m; below 0 on a ridge.
  double Concavity(const dvec3& surface_m, const dvec3& n) const;

  const cutting::Volume& now_;
  const cutting::Volume* const uncut_;
  const double voxel_m_;
  std::vector<uint8_t> near_;  // per brick: a bit for each tissue near it
};

}  // namespace enamel::station::render
