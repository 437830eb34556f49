#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/math/vec.h"
#include "common/scene/builder.h"
#include "common/scene/tooth_number.h"

// A tooth as an implicit body described by numbers: level sections stacked along its axis, an
// occlusal relief of cusps and ridges, roots, an enamel cap, a pulp with horns and canals. One
// description serves molars, premolars and incisors; teeth.h has the descriptions.
//
// A description's numbers are in millimetres; x mesial, y buccal (labial), z occlusal (incisal),
// whichever side of the jaw the tooth is on. What the functions below take and give is in the
// scene's frame, in which +x is mesial or distal by the tooth's number
// (common/scene/tooth_number.h), so that 36 is the mirror image of 46. Everything is a pure
// function of the point. Thread safety: any thread. Not real-time.
namespace enamel::scene {

inline constexpr size_t kSections = 9;  // samples along the axis

// Half extents of the crown and root trunk at z = first, first + step, ..., from a middle line at
// (0, middle_y); between samples a Catmull-Rom curve.
struct Sections {
  double first_z = 0, step_z = 0;
  std::array<double, kSections> mesial{}, distal{}, buccal{}, lingual{}, middle_y{};
  // Outline of a section: u^2 + v^2 + round u v = 1 in squares of the relative half extents.
  // 2: an ellipse; 0: a rounded rectangle.
  double round = 0.75;
  // How much narrower, of its width, it is at its lingual end than at its buccal one, and at its
  // distal end than at its mesial one. Needs round > 0.
  double lingual_taper = 0, distal_taper = 0;
};

// A round-topped cone, drawn out toward the fossa into a triangular ridge.
struct Cusp {
  double x = 0, y = 0, z = 0;  // tip
  double slope = 0.85;         // fall per mm across the triangular ridge
};

// A ridge whose height falls by `fall` per mm of sqrt(weight_x dx^2 + weight_y dy^2).
struct Ridge {
  double x = 0, y = 0, top = 0;
  double weight_x = 1, weight_y = 0.3, fall = 1;
};

enum class Face { kBuccal, kLingual, kMesial };

// A groove that runs down a face, at `at` along it (x, on a mesial face y). A wide one is also an
// incisor's lingual fossa or a depression.
struct SideGroove {
  Face face = Face::kBuccal;
  double at = 0, depth = 0.4, width = 0.42;
  double fade_from_z = -1.6, fade_to_z = 1.5;  // grows from nothing to full depth, upward
  double end_from_z = 99, end_to_z = 100;      // and vanishes again
};

// A groove in the relief along a straight line.
struct Fissure {
  double from_x = 0, from_y = 0, to_x = 0, to_y = 0;
  double depth = 0.3, width = 0.3;
};

// Along five points from the cervical line (0) to the apex (1).
struct Root {
  std::array<double, 5> x{}, y{};            // centre line
  std::array<double, 5> half_x{}, half_y{};  // of its oval section
  double groove = 0;                         // depth of the hollow on its mesial and distal faces
  double length = 14;
};

// A canal in a root: starts `offset_y` beside its centre line, ends `end_y` beside it.
struct Canal {
  size_t root = 0;
  double offset_y = 0, end_y = 0;
  double flat_y = 0;  // half length of its flat section at the top, for ribbon-shaped canals
  double radius = 0.42, apex_radius = 0.16;
};

struct Pulp {
  dvec3 middle{0}, half{1};  // chamber, between a box and an ellipsoid
  // Horns rise from the chamber toward the cusps: tip at cusp.xy * (lean_x, lean_y), `depth` below
  // the cusp.
  double lean_x = 0.72, lean_y = 0.62, depth = 5.15, radius = 0.5, tip_radius = 0.22;
  std::vector<Canal> canals;
};

struct EnamelCap {
  // On the side faces: thickness = side * h / (h + rise), h above the cervical line.
  double side = 2.45, rise = 1.9;
  // The dentin's relief under the cusps: share of the crown's height, lowered by drop.
  double relief = 0.55, drop = 0.35;
  // How far the cervical line rises towards the crown on the mesial and the distal face.
  double mesial_rise = 1, distal_rise = 0;
};

struct ToothShape {
  int fdi = 0;  // 46
  std::string name, title;
  double cervical_z = 0;
  Sections sections;
  std::vector<Cusp> cusps;
  std::vector<Ridge> ridges;
  double fossa_x = 0, fossa_y = 0;
  double relief_blend = 0.22;  // how round the grooves between cusps are
  double edge_blend = 0.9;     // how round the crown's shoulder is
  std::vector<SideGroove> grooves;
  std::vector<Fissure> fissures;
  double trunk_z = 0;  // where the root trunk ends and the roots part
  double trunk_blend = 1.6;
  std::vector<Root> roots;
  EnamelCap enamel;
  Pulp pulp;
  dvec3 lo{0}, hi{0};  // box that holds the whole tooth, x from distal to mesial

  // Along the scene's x, of a distance mesially; and back.
  double Along(double mesially) const { return MesialX(fdi) * mesially; }
};

// Signed distance (true near the surface) and tissue at a point in metres.
FieldSample ToothField(const ToothShape& shape, const dvec3& point_m);

// Height of the relief at (x, y), mm.
double OcclusalHeight_mm(const ToothShape& shape, double x, double y);
// Height of the cervical line at x, mm.
double CervicalHeight_mm(const ToothShape& shape, double x);
// The lowest point of the relief near the fossa, on the surface, metres; the middle of the incisal
// edge of a tooth without cusps.
dvec3 FossaBottom_m(const ToothShape& shape);
// First solid below (x, y) mm from above, metres; nullopt beside the tooth.
std::optional<dvec3> SurfaceBelow_m(const ToothShape& shape, double x, double y);
// The box that holds the whole tooth, in the scene's frame, metres: its least and its largest
// corner.
std::array<dvec3, 2> BoundsOf_m(const ToothShape& shape);
// Half extents of the section at height z, mm: mesial, distal, buccal, lingual (from x = 0 and
// y = 0).
std::array<double, 4> SectionAt_mm(const ToothShape& shape, double z);

}  // namespace enamel::scene
