#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/sha256.h"
#include "common/cutting/bur.h"
#include "common/cutting/tissue.h"
#include "common/haptics/force_law.h"
#include "common/math/vec.h"

// The documents of a graded attempt. Each has a JSON form with a schema
// (schemas/{scene,exercise,device_profile}.schema.json) and a format number. Readers refuse unknown
// members in documents that we author: a misspelt limit must not be silently ignored. Lengths in
// the JSON are integers in micrometres or nanometres, forces in millinewtons.
namespace enamel::scene {

// Scene frame: millimetre-scale, right-handed; +z towards whoever works; origin in the middle of
// the crown's bounding box. Which of the tooth's sides is up: Up. +x is mesial or distal, by the
// tooth's quadrant: MesialX (tooth_number.h). JSON: integers in um.
using PointUm = std::array<int32_t, 3>;

struct TissueSpec {
  cutting::Tissue tissue = cutting::Tissue::kAir;
  int32_t damping_mn_s_per_mm = 0;        // B across the bur's axis; 1 N s/mm = 1000 mN s/mm
  std::string provenance;                 // where the numbers are from
  int32_t axial_damping_mn_s_per_mm = 0;  // B along the bur's axis; 0: the same
  int32_t coulomb_mn = 0;                 // the bur does not cut below it
  // Tissue that is cut by load (cutting::TissueDamping) has m, v0 where m is not 1, and mu.
  cutting::FeedExponent feed_exponent = cutting::FeedExponent::kOne;
  int32_t feed_um_per_s = 0;
  int32_t bur_friction_permille = 0;
};

// A bur as documents name it. Members that a shape does not use are 0 (cutting/bur.h).
struct BurSpec {
  std::string name;  // of the offer in a scene: "fissure-10"; not in exercises
  cutting::BurShape shape = cutting::BurShape::kCylinder;
  int32_t radius_um = 0;
  int32_t length_um = 0;
  int32_t narrow_radius_um = 0;
  int32_t shank_radius_um = 0;
  int32_t neck_um = 0;
  // As on a box of burs, for people: the number of ISO 6360-1 in five groups of three digits
  // ("806 314 237 524 012", schemas/exercise.schema.json); may be empty. Only in exercises.
  std::string iso_number = {};

  cutting::Bur metric() const {
    return {shape,
            radius_um * 1e-6,
            length_um * 1e-6,
            narrow_radius_um * 1e-6,
            shank_radius_um * 1e-6,
            neck_um * 1e-6};
  }
  bool SameShapeAs(const BurSpec& o) const { return metric() == o.metric(); }
};

// A handpiece whose speed falls under load (core/handpiece.h). Stall torque 0: it does not.
struct HandpieceSpec {
  int32_t stall_un_m = 0;
  int32_t tangential_permille = 0;
  int32_t lag_us = 0;

  bool operator==(const HandpieceSpec&) const = default;
};

// Touch cues (haptics/touch_cues.h): the largest force of the knock on contact and of the bur's
// chatter, and the energy the hand may draw from both: at once, and added with time. Default: none.
struct TouchCueSpec {
  int32_t contact_mn = 0, chatter_mn = 0, energy_uj = 0, power_uw = 0;

  bool operator==(const TouchCueSpec&) const = default;
};

// What keeps the work dry. Only the picture shows it: no force and no score knows it.
enum class Isolation : uint8_t { kNone, kRubberDam };

// The stump that a part of outline kStump leaves in its middle: a rectangle with rounded corners
// whose middle and half sizes change evenly from the foot, on the part's floor, to the table.
struct Stump {
  struct Section {
    std::array<int32_t, 2> middle_um{};  // from the part's middle
    std::array<int32_t, 2> half_um{};

    bool operator==(const Section&) const = default;
  };
  Section foot, table;
  int32_t table_below_um = 0;  // the opening
  int32_t corner_um = 0;       // radius

  bool operator==(const Stump&) const = default;
};

// A floor that follows the tooth: its depth below the part's opening on a square grid about the
// part's middle, an odd number of points along x and y, x first; bilinear between them and level
// beyond the outermost.
struct Relief {
  int32_t step_um = 0;  // 0: there is none, the floor is level
  std::array<int32_t, 2> count{};
  std::vector<int32_t> below_um;

  bool operator==(const Relief&) const = default;
};

// One upright hollow of a preparation, open at the top: a box, a disc, a polygon, or all of a box
// but a stump. Documents of scenes know boxes and discs only.
struct PreparationPart {
  enum class Outline { kBox, kDisc, kPolygon, kStump };
  Outline outline = Outline::kBox;
  PointUm top_um{};                       // middle of the opening
  std::array<int32_t, 2> half_size_um{};  // box: half length x, half width y; disc: radius, radius
  int32_t depth_um = 0;                   // floor below the opening
  // Polygon: its corners from top_um in x and y, counter-clockwise; half_size_um is not used.
  std::vector<std::array<int32_t, 2>> corners_um = {};
  Stump stump = {};
  // In place of the level floor, of a stump in place of its table. depth_um is no less anywhere.
  Relief relief = {};

  bool operator==(const PreparationPart&) const = default;
};

// A wanted shape: the union of its parts is what has to go. preparation.h makes the reference.
struct Preparation {
  std::string name;  // "cross"; also the landmark its exercise hangs from
  std::string title;
  std::vector<PreparationPart> parts;
};

// The side of the tooth that is up (+z): a hand that cannot turn its tool reaches a side by turning
// the tooth, as a model in its holder is turned at the chair. kOcclusal: +y is buccal. kBuccal
// (labial of front teeth): +y points to the root.
enum class Up : uint8_t { kOcclusal, kBuccal };

// A tooth (and what surrounds it) to work on.
struct Scene {
  std::string name;  // "molar-46"
  std::string title;
  int32_t tooth = 0;  // its FDI number (tooth_number.h); 0: no tooth
  Sha256 volume;      // content address of the volume blob (volume_blob.h)
  int32_t voxel_nm = 0;
  std::vector<TissueSpec> tissues;
  std::map<std::string, PointUm> landmarks;  // always has "occlusal_centre"
  std::vector<BurSpec> burs;                 // burs an exercise may ask for; none: any
  std::vector<Preparation> preparations;     // wanted shapes, by name
  Up up = Up::kOcclusal;
  std::string provenance;  // generated, or imported from which file (hash, licence)
};

// One number of a device profile and where it is from.
struct Sourced {
  int64_t value = 0;
  std::string source;  // "paper, table 3", "assumption", "datasheet", "measured 2026-…"
};

// The axes of rotation of a device that drives six axes (common/haptics/turning.h).
struct TorqueSpec {
  Sourced peak_un_m;
  Sourced coupling_un_m_per_rad;   // K used by the coupling
  Sourced damping_un_m_s_per_rad;  // b_rot of the device itself
  Sourced friction_un_m;           // c_rot, Coulomb
  // Largest angle between the true and the recorded orientation: sensors, driver, and the rounding
  // of the recording itself (core::kMinRotationCell_urad).
  Sourced orientation_cell_urad;
};

// How a device's positions come about (cell.h has what follows from it).
struct CellSpec {
  // Encoders count at the joints, so that the cells of space are a turned lattice; else along the axes.
  bool joints = false;
  int32_t count_nm = 0;      // edge of a recorded count: what the driver rounds the position to
  int32_t noise_counts = 0;  // an encoder's count may be off by so many
  std::string source;
};

// The coupling's spring where the device's own board runs it (common/board/board.h): at T = 1/rate_hz,
// d whole inner ticks from reading the encoders to the force that answers. These two, not the loop's
// rate and the bus's delay, bound Kc.
struct BoardSpringSpec {
  int32_t rate_hz = 0, delay_ticks = 0;
  std::string source;
};

struct DeviceProfile {
  std::string name;  // "phantom_desktop"
  std::string title;
  Sourced resolution_nm;            // delta: edge of the encoder's cell, of the coarsest axis
  Sourced max_stiffness_mn_per_mm;  // K at the stated rate
  Sourced coupling_mn_per_mm;       // Kc used by the coupling
  Sourced damping_mn_s_per_m;       // b of the device itself
  Sourced friction_mn;              // c
  Sourced mass_g;
  Sourced peak_force_mn;
  Sourced continuous_force_mn;
  Sourced rate_hz;
  Sourced bus_delay_ticks;
  bool delay_measured = false;     // bus_delay_ticks was, on a unit; false: delay.h assumes a tick
  bool friction_measured = false;  // friction_mn was, on a unit of this kind
  // friction_mn is this unit's own (WithFriction). No document holds this: a profile is for every unit of its kind.
  bool friction_of_unit = false;
  Sourced workspace_radius_um;
  // None: cells along the axes, recorded as they are counted, without noise.
  std::optional<CellSpec> cell;
  std::optional<BoardSpringSpec> board_spring;  // none: the station runs the spring
  // May be unknown: then the source is empty.
  Sourced axes{3, ""};               // that are driven: 3, or 6 with torque
  Sourced structural_mode_hz;        // lowest resonance between motor and tip
  Sourced thermal_time_constant_ms;  // of the motors: how long the peak may last
  // Damping that a current loop or shorted windings add: analog, so it pays as b does. No source:
  // none.
  Sourced electrical_damping_mn_s_per_m;
  std::optional<TorqueSpec> torque;  // none: no torque is sent

  // b of the limits: the device's own and the electrical.
  int64_t viscous_mn_s_per_m() const {
    return damping_mn_s_per_m.value + electrical_damping_mn_s_per_m.value;
  }
};

struct PreparedTooth;  // prepared_target.h

// The part of a tooth to cut: all that a prepared tooth lacks, or the union of its parts, or a box,
// axis-aligned in the scene frame, its top open. preparation.h has parts and box as geometry.
struct CavityTarget {
  std::string landmark = "occlusal_centre";  // the point the box hangs from
  PointUm half_size_um{};                    // half length x (mesio-distal), half width y; z unused
  int32_t depth_um = 0;                      // floor below the landmark
  int32_t leeway_side_um = 0;                // may go, beyond the walls
  int32_t leeway_bottom_um = 0;
  int32_t container_um = 0;  // must stay, beyond the leeway
  // Their top_um is from the landmark. The box above holds them all.
  std::vector<PreparationPart> parts;
  // Content address of a scene: the finished tooth, on the same voxels. Zero: there is none. With
  // it there are no parts; the box holds the solid to remove.
  Sha256 prepared{};
  // That tooth, once LoadPreparedTarget has read it.
  std::shared_ptr<const PreparedTooth> prepared_tooth = {};
};

struct RubricPoint {
  double value;
  double share;  // of the points, 0..1

  bool operator==(const RubricPoint&) const = default;
};

// The price of a kind of region, or of a kind of damage (scoring/mistakes/prices.h). With M the measure in
// units of `over` or `left`, a fault costs points * M / sqrt(1 + (M * points / most)^2).
struct RubricPrice {
  std::string of;  // price_kinds.h
  // Sizes of what was cut too far and of what was left that cost about `points`, in the kind's unit. 0: the kind lacks
  // that side.
  double over = 0, left = 0;
  double points = 0, most = 0;
  // An examiner asks for a change from the first number of points on, and for a new cut from the second.
  double modify_points = 0, redo_points = 0;
  std::string source;  // of the figures; "chosen": none was read

  bool operator==(const RubricPrice&) const = default;
};

// The cost of the hand's time, force or way.
struct RubricCriterion {
  std::string metric;  // a name from scoring/metrics.h that the finished tooth does not show
  std::string title;   // "Light hand"
  std::string unit;    // must equal the metric's unit
  double points = 0;   // the most that it costs
  std::vector<RubricPoint> map;  // share kept; piecewise linear in value, at least one, sorted
  std::string comment;           // shown where points are lost
  // Critical: when value exceeds this the whole score is 0.
  std::optional<double> fails_above;

  bool operator==(const RubricCriterion&) const = default;
};

// An error that no examiner would pass: the attempt is not acceptable, whatever else is right.
struct RubricCritical {
  std::string error;   // of scoring::CriticalErrors(): "contact_left"
  std::string metric;  // that shows it
  std::string unit;    // must equal the metric's
  // Committed beyond it: above where `above`, else below.
  double limit = 0;
  bool above = true;
  std::string source;  // of the limit

  bool operator==(const RubricCritical&) const = default;
};

// The restorative material that a preparation is for; kNone: the rubric names none.
// restoration.h has the names in documents.
enum class Restoration : uint8_t { kNone, kAmalgam, kComposite, kCeramic };

// What one material changes: prices and limits that count in place of the rubric's own.
struct RestorationTolerance {
  Restoration restoration = Restoration::kNone;
  std::string source;  // of the figures
  std::vector<RubricPrice> prices;
  struct Limit {
    std::string error, metric;  // of a critical error
    double limit = 0;           // on the side on which the critical error has its own

    bool operator==(const Limit&) const = default;
  };
  std::vector<Limit> critical = {};

  bool operator==(const RestorationTolerance&) const = default;
};

struct Rubric {
  std::string name;
  int32_t version = 1;
  std::vector<RubricPrice> prices;        // each kind once
  std::vector<RubricCriterion> criteria;  // of the hand
  std::vector<RubricCritical> critical = {};
  Restoration restoration = Restoration::kNone;
  // By material, each once; the one that `restoration` names counts.
  std::vector<RestorationTolerance> restorations = {};

  bool operator==(const Rubric&) const = default;
};

struct Exercise {
  std::string name;  // "class-1-occlusal"
  std::string title;
  std::string instructions;
  Sha256 scene;  // content address of the scene's JSON
  cutting::BurShape bur_shape = cutting::BurShape::kCylinder;
  int32_t bur_radius_um = 0;
  int32_t bur_length_um = 0;
  int32_t bur_narrow_radius_um = 0;
  int32_t bur_shank_radius_um = 0;
  int32_t bur_neck_um = 0;
  std::string bur_iso_number;
  // What the first bur may be changed for during the attempt; at most core::kMaxBurs - 1.
  std::vector<BurSpec> other_burs;
  HandpieceSpec handpiece;
  TouchCueSpec touch_cues;
  Isolation isolation = Isolation::kNone;
  haptics::LawKind law = haptics::kDefaultLaw;
  int32_t rate_hz = 1000;
  int32_t time_limit_s = 0;  // 0: none
  bool graded = true;        // score shown after release; practice shows at once
  CavityTarget target;
  Rubric rubric;

  BurSpec bur() const {
    return {{},
            bur_shape,
            bur_radius_um,
            bur_length_um,
            bur_narrow_radius_um,
            bur_shank_radius_um,
            bur_neck_um,
            bur_iso_number};
  }
  // All of them, in the order of core::CoreParams::other_burs.
  std::vector<BurSpec> burs() const {
    std::vector<BurSpec> out = {bur()};
    out.insert(out.end(), other_burs.begin(), other_burs.end());
    return out;
  }
};

}  // namespace enamel::scene
