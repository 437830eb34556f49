#include "station/devices/operators.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/math/trig.h"
#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"
#include "common/scene/tooth_number.h"
#include "station/devices/cavity_plan.h"
#include "station/devices/mistakes.h"
#include "station/devices/path_operator.h"
#include "station/devices/prepared_plan.h"
#include "station/devices/relief_plan.h"

namespace enamel::station {
namespace {

// Above the highest point near the target, for a hand of usual speed: force and cutting need half a
// second in free air (core/params.h), and he descends at 10 mm/s.
constexpr double kStartAbove_m = 8e-3;
// For a driven wrist and the fingers on it, about each axis: assumption.
constexpr double kHandAndWrist_kg_m2 = 1e-4;

using Extra = OperatorPreset::Extra;
constexpr OperatorPreset kPresets[] = {
    {"dentist", "cuts what the exercise asks for to about 0.02 mm", 8, 1, 1.0, 0.55e-3, 2.2, false},
    {.name = "graduate",
     .summary =
         "another hand, slower, other way round; a little off, as every hand but the dentist's",
     .rank = 7,
     .seed = 2,
     .speed_ratio = 0.85,
     .offered = false},
    {.name = "student",
     .summary = "errs as a good student does: a little off everywhere, and one mistake",
     .rank = 6,
     .seed = 7,
     .speed_ratio = 0.85},
    {.name = "fourth-year",
     .summary = "errs more than the student",
     .rank = 5,
     .seed = 3,
     .speed_ratio = 0.85,
     .offered = false},
    {.name = "third-year",
     .summary = "errs more than the fourth-year student",
     .rank = 4,
     .seed = 4,
     .speed_ratio = 0.85,
     .offered = false},
    {.name = "second-year",
     .summary = "errs more than the third-year student",
     .rank = 3,
     .seed = 5,
     .speed_ratio = 0.85,
     .offered = false},
    {.name = "first-year",
     .summary = "makes three mistakes, each one large",
     .rank = 2,
     .seed = 6,
     .speed_ratio = 0.85,
     .offered = false},
    {.name = "untrained",
     .summary = "makes four mistakes, each as large as they come",
     .rank = 1,
     .seed = 8,
     .speed_ratio = 0.85,
     .offered = false},
    {"student-deep-mesial",
     "a good hand whose one fault is that it cuts the mesial wall 0.3 mm too far", 0, 7, 0.85,
     0.5e-3, 1.8, true, Extra{.mesial_m = 0.3e-3}},
    {.name = "good",
     .summary = "walls and floor 0.04 to 0.08 mm off, another way with each seed",
     .seed = 21,
     .speed_ratio = 0.85,
     .offered = false,
     .misjudges_m = 0.04e-3},
    {.name = "shaky",
     .summary =
         "trembles six times as much as a calm hand, and walls and floor are 0.08 to 0.16 mm off",
     .seed = 11,
     .tremor_ratio = 6,
     .offered = false,
     .misjudges_m = 0.08e-3},
    {.name = "undercutter",
     .summary = "holds the bur 12 degrees askew: the lingual wall leans over the cavity",
     .seed = 22,
     .offered = false,
     .askew_deg = 12},
    {.name = "caries-leaver",
     .summary = "leaves the lowest 0.4 mm, and the caries there",
     .seed = 23,
     .extra = {.floor_m = -0.4e-3},
     .offered = false,
     .needs = cutting::Tissue::kCaries},
    {.name = "neighbour-nicker",
     .summary = "cuts the target, and 0.3 mm into the neighbour",
     .seed = 24,
     .offered = false,
     .nicks_neighbour = true,
     .needs = cutting::Tissue::kNeighbour},
    {.name = "hasty",
     .summary = "fast and hard; walls and floor 0.12 to 0.2 mm off",
     .seed = 12,
     .speed_ratio = 1.5,
     .rough_push_n = 3,
     .extra = {.mesial_m = 0.2e-3, .distal_m = -0.15e-3, .buccal_m = 0.12e-3, .floor_m = 0.2e-3},
     .offered = false},
    {.name = "too-shallow",
     .summary = "leaves the lowest 0.6 mm, and the caries there",
     .seed = 13,
     .extra = {.floor_m = -0.6e-3},
     .offered = false},
    {.name = "over-extender",
     .summary = "cuts every wall 0.35 mm too far",
     .seed = 14,
     .extra = {0.35e-3, 0.35e-3, 0.35e-3, 0.35e-3, 0},
     .offered = false},
    {.name = "clumsy",
     .summary = "every wall and the floor are off, and at the end the bur slips into the tooth",
     .seed = 15,
     .extra = {0.4e-3, 0.3e-3, -0.25e-3, 0.4e-3, 0.35e-3},
     .tremor_ratio = 4,
     .slips = true,
     .offered = false},
    {.name = "timid",
     .summary = "stops before the cavity is half done",
     .seed = 16,
     .speed_ratio = 0.6,
     .rough_push_n = 1.2,
     .plan_share = 0.35,
     .offered = false},
    {.name = "idle",
     .summary = "holds the handpiece and cuts nothing",
     .seed = 17,
     .plan_share = 0,
     .offered = false},
};

// How much too far a wall that faces `outward` is cut.
double ExtraAt_m(const Extra& e, int mesial_x, const glm::dvec2& outward) {
  const double mesially = mesial_x * outward.x;
  return std::max(mesially, 0.0) * e.mesial_m + std::max(-mesially, 0.0) * e.distal_m +
         std::max(outward.y, 0.0) * e.buccal_m + std::max(-outward.y, 0.0) * e.lingual_m;
}

// Each side by one to two times `by_m`, in either direction: a misjudgement is never zero.
Extra Misjudged(Extra extra, double by_m, uint64_t seed) {
  double* sides[] = {&extra.mesial_m, &extra.distal_m, &extra.buccal_m, &extra.lingual_m,
                     &extra.floor_m};
  for (uint64_t i = 0; i < 5; ++i) {
    const double draw = Draw(seed, i);
    *sides[i] += by_m * (draw < 0 ? draw - 1 : draw + 1);
  }
  return extra;
}

SideErrors Sum(const SideErrors& a, const SideErrors& b) {
  return {a.mesial_m + b.mesial_m, a.distal_m + b.distal_m, a.buccal_m + b.buccal_m,
          a.lingual_m + b.lingual_m, a.floor_m + b.floor_m};
}

// Whether a neighbour stands just beyond the target's side in x.
bool NeighbourBeside(const Bounds& extent, int side, double floor_m, double top_m,
                     const cutting::Volume& volume) {
  constexpr double kBeside_m = 0.4e-3;
  const cutting::GridSpec& spec = volume.spec();
  const double from = side > 0 ? extent.x1 : extent.x0 - kBeside_m;
  auto index = [&](double x, double y, double z) {
    const dvec3 at = (dvec3(x, y, z) - spec.origin_m()) / spec.voxel_m();
    return glm::clamp(ivec3(at), ivec3(0), spec.voxels() - 1);
  };
  const ivec3 lo = index(from, extent.y0, floor_m), hi = index(from + kBeside_m, extent.y1, top_m);
  for (int k = lo.z; k <= hi.z; ++k)
    for (int j = lo.y; j <= hi.y; ++j)
      for (int i = lo.x; i <= hi.x; ++i)
        if (volume.PhiAt({i, j, k}) < 0 &&
            volume.TissueAt({i, j, k}) == cutting::Tissue::kNeighbour)
          return true;
  return false;
}

// A neighbour shows where the tooth ends, and a contact that is not open is seen: on that side a
// person errs by a third. The wall opposite ends the caries of the contact, which is soft and dark:
// he leaves half as much of it.
void Guide(double& at_contact_m, double& opposite_m) {
  at_contact_m /= 3;
  if (opposite_m < 0) opposite_m /= 2;
}

// The person of this attempt: as his preset says, and with the mistakes that the seed draws.
OperatorPreset Erring(OperatorPreset preset, const Mistakes& mistakes) {
  preset.speed_ratio *= mistakes.speed_ratio;
  preset.rough_push_n *= mistakes.push_ratio;
  preset.tremor_ratio *= mistakes.tremor_ratio;
  return preset;
}

// The box about the whole target.
Bounds ExtentOf(const scene::CavityTarget& target, const dvec3& landmark_m) {
  const double hx = target.half_size_um[0] * 1e-6, hy = target.half_size_um[1] * 1e-6;
  return {landmark_m.x - hx, landmark_m.x + hx, landmark_m.y - hy, landmark_m.y + hy};
}

// A slip: from above the surface distal to the target a millimetre into it, and out. If the tooth
// is prepared all around, or to its distal side, into the middle.
Stroke SlipBeside(const Bounds& extent, int mesial_x, double out_m, bool all_around,
                  const cutting::Bur& bur, const cutting::Volume& volume) {
  constexpr double kDeep_m = 1e-3, kBeyondLeeway_m = 0.5e-3, kClear_m = 1e-3;
  const double y = 0.5 * (extent.y0 + extent.y1), middle = 0.5 * (extent.x0 + extent.x1),
               r = bur.radius_m;
  const double beside = 0.5 * (extent.x1 - extent.x0) + out_m + 2 * r + kBeyondLeeway_m;
  dvec3 at(all_around ? middle : middle - mesial_x * beside, y, 0);
  auto highest = [&] { return HighestSolid_m(volume, {at.x - r, at.x + r, at.y - r, at.y + r}); };
  at.z = highest();
  constexpr double kSide_m = 3e-3;  // lower than this beside it there is no face of the tooth
  if (at.z < HighestSolid_m(volume, extent) - kSide_m) {
    at.x = middle;
    at.z = highest();
  }
  const dvec3 up(0, 0, kClear_m), down(0, 0, -kDeep_m);
  Stroke slip;
  slip.points = {dvec3(middle, y, at.z) + up, at + up, at + down, at + up};
  slip.feed_m_per_s = 1e-3;
  slip.push_n = 2;
  return slip;
}

// Where a neighbour is nearest on the mesial side between the target's floor and its top: down
// along its face, `deep_m` in, and up again.
Stroke NickOf(const Bounds& extent, int mesial_x, double floor_m, double top_m, double deep_m,
              const cutting::Bur& bur, const cutting::Volume& volume) {
  constexpr double kClear_m = 1e-3, kDown_m = 0.8e-3;
  const cutting::GridSpec& spec = volume.spec();
  const dvec3 origin = spec.origin_m();
  const double h = spec.voxel_m(), y = 0.5 * (extent.y0 + extent.y1);
  const ivec3 n = spec.voxels();
  const int j = static_cast<int>((y - origin.y) / h);
  const int middle = static_cast<int>((0.5 * (extent.x0 + extent.x1) - origin.x) / h);
  dvec3 nearest(mesial_x, y, top_m);
  for (int k = std::max(0, static_cast<int>((floor_m - origin.z) / h)); k < n.z; ++k) {
    const double z = origin.z + h * k;
    for (int i = std::clamp(middle, 0, n.x - 1); z < top_m && i >= 0 && i < n.x; i += mesial_x) {
      if (volume.PhiAt({i, j, k}) >= 0) continue;
      if (volume.TissueAt({i, j, k}) != cutting::Tissue::kNeighbour) continue;
      const double x = origin.x + h * i;
      if (mesial_x * x < mesial_x * nearest.x) nearest = dvec3(x, y, z);
      break;
    }
  }
  const double clear =
      HighestSolid_m(volume, {extent.x0, extent.x1, extent.y0, extent.y1}) + kClear_m;
  const dvec3 in(nearest.x - mesial_x * (bur.radius_m - deep_m), y, nearest.z - kDown_m);
  const dvec3 before = in - dvec3(mesial_x * (deep_m + 0.1e-3), 0, 0);
  Stroke nick;
  nick.points = {dvec3(before.x, y, clear), before, in, before, dvec3(before.x, y, clear)};
  nick.feed_m_per_s = 1e-3;
  nick.push_n = 2;
  return nick;
}

Status CannotCut(const scene::Exercise& exercise, const std::string& why) {
  return Status(Code::kInvalidInput, "exercise '" + exercise.name + "': " + why, "half_size_um");
}

// Thickness of the layer that a relief's part removes: the median under a grid over its middle
// half.
double LayerOf_m(const scene::PreparationPart& part, const cutting::Volume& volume) {
  constexpr int kSteps = 4;
  const double h = volume.spec().voxel_m();
  std::vector<double> thick;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      const double x = (part.top_um[0] + 0.5 * part.half_size_um[0] * i / kSteps) * 1e-6;
      const double y = (part.top_um[1] + 0.5 * part.half_size_um[1] * j / kSteps) * 1e-6;
      thick.push_back(HighestSolid_m(volume, {x - h, x + h, y - h, y + h}) -
                      scene::ReliefAt(part, x, y).z_m);
    }
  }
  const auto middle = thick.begin() + static_cast<ptrdiff_t>(thick.size() / 2);
  std::nth_element(thick.begin(), middle, thick.end());
  return *middle;
}

// An operator who leaves the bottom of a cavity leaves at most this share of a thin layer: with all
// of it left he would be the one who does nothing.
constexpr double kMaxOfLayerLeft = 0.6;

double FloorOver(double wanted_m, const scene::PreparationPart& part,
                 const cutting::Volume& volume) {
  return wanted_m < 0 ? std::max(wanted_m, -kMaxOfLayerLeft * LayerOf_m(part, volume)) : wanted_m;
}

// Lean of the bur's upper end to buccal; negative: to lingual. A stump's walls are inclined
// already, so there he leans towards the steeper one, far enough beyond it to make a noticeable
// undercut.
double AskewIn_deg(const scene::Preparation& shape, double askew_deg) {
  using PartOutline = scene::PreparationPart::Outline;
  constexpr double kUndercut_deg = 4, kDegPerRad = 57.29577951308232;
  if (askew_deg == 0 || shape.parts[0].outline != PartOutline::kStump) return askew_deg;
  const scene::PreparationPart& part = shape.parts[0];
  const scene::Stump::Section &foot = part.stump.foot, &table = part.stump.table;
  const double high_um = part.depth_um - part.stump.table_below_um;
  auto lean_deg = [&](int side) {
    const double out_um =
        side * (foot.middle_um[1] - table.middle_um[1]) + foot.half_um[1] - table.half_um[1];
    return std::atan2(out_um, high_um) * kDegPerRad;
  };
  const double buccal = lean_deg(1), lingual = lean_deg(-1);
  return buccal <= lingual ? std::max(askew_deg, buccal + kUndercut_deg)
                           : -std::max(askew_deg, lingual + kUndercut_deg);
}

// Part after part of the exercise's target, each in the volume left by the previous ones.
Result<std::vector<Move>> PlanTarget(const scene::Preparation& shape, const OperatorPreset& preset,
                                     const Extra& wrong, int mesial_x,
                                     const scene::Exercise& exercise, double top_m,
                                     const cutting::Volume& volume) {
  using PartOutline = scene::PreparationPart::Outline;
  const cutting::Bur bur = exercise.bur().metric();
  CavityPlanOptions options;
  options.layer_m = preset.layer_m;
  options.rough_push_n = preset.rough_push_n;
  options.speed_ratio = preset.speed_ratio;
  options.clockwise = preset.clockwise;
  const auto extra = [&](const glm::dvec2& outward) { return ExtraAt_m(wrong, mesial_x, outward); };
  if (!exercise.target.prepared.IsZero()) {
    const auto& tooth = exercise.target.prepared_tooth;
    if (!tooth) return CannotCut(exercise, "its prepared tooth was not loaded");
    return PlanPrepared({&tooth->volume, tooth->lo_m, tooth->hi_m, extra, wrong.floor_m}, bur,
                        volume, options);
  }
  std::vector<Move> plan;
  cutting::Volume left = volume;
  for (size_t i = 0; i < shape.parts.size(); ++i) {
    const scene::PreparationPart& part = shape.parts[i];
    std::vector<Move> moves;
    if (part.outline == PartOutline::kStump) {
      moves = PlanStump({part, extra, wrong.floor_m}, bur, left, options);
    } else if (part.relief.step_um != 0) {
      moves = PlanRelief({part, extra, FloorOver(wrong.floor_m, part, left)}, bur, left, options);
    } else {
      if (!IsConvex(OutlineOf(part))) {
        return CannotCut(exercise,
                         "a simulated operator cuts polygons without bays: cut it into several");
      }
      const HollowCut hollow{Moved(OutlineOf(part), extra),
                             (part.top_um[2] - part.depth_um) * 1e-6 - wrong.floor_m};
      if (!FitsInto(hollow, std::max(top_m, part.top_um[2] * 1e-6), bur, options)) {
        return CannotCut(exercise,
                         "a simulated operator needs more room beside this bur than part " +
                             std::to_string(i) + " of the target leaves: it is " +
                             std::to_string(static_cast<int>(2e6 * Inradius(hollow.walls))) +
                             " um wide, the bur " +
                             std::to_string(static_cast<int>(2e6 * bur.radius_m)) + " um");
      }
      moves = PlanCavity(hollow, bur, left, options);
    }
    plan.insert(plan.end(), moves.begin(), moves.end());
    if (i + 1 < shape.parts.size()) left = scene::Prepared(left, {shape.name, "", {part}});
  }
  return plan;
}

// With errors that leave the bur no room, a person feels it, and errs less.
Result<std::vector<Move>> PlanAsFits(const scene::Preparation& shape, const OperatorPreset& preset,
                                     const Extra& wrong, const SideErrors& errs, int mesial_x,
                                     const scene::Exercise& exercise, double top_m,
                                     const cutting::Volume& volume) {
  constexpr double kLeast = 0.2;
  for (double share = 1;; share *= 0.5) {
    const Extra sides = Sum(wrong, Scaled(errs, share < kLeast ? 0 : share));
    auto plan = PlanTarget(shape, preset, sides, mesial_x, exercise, top_m, volume);
    if (plan.ok() || share < kLeast || LackAt(preset.rank) == 0) return plan;
  }
}

// The steps that his mistakes change and add.
std::vector<Move> WithMistakes(std::vector<Move> plan, const Mistakes& mistakes,
                               const scene::Preparation& shape, const scene::Exercise& exercise,
                               const Bounds& extent, const cutting::Volume& volume) {
  constexpr double kClear_m = 1e-3;
  const cutting::GridSpec& spec = volume.spec();
  const dvec3 far = spec.origin_m() + dvec3(spec.voxels()) * spec.voxel_m();
  const double clear =
      HighestSolid_m(volume, {spec.origin_m().x, far.x, spec.origin_m().y, far.y}) + kClear_m;
  if (mistakes.done_last) plan = OutOfOrder(std::move(plan), *mistakes.done_last, clear);
  if (mistakes.gouge) {
    const auto& tooth = exercise.target.prepared_tooth;
    plan.emplace_back(GougeStroke(*mistakes.gouge, extent, exercise.bur().metric(),
                                  tooth ? tooth->volume : scene::Prepared(volume, shape), clear));
  }
  return plan;
}

// Joints that no axis of the scene is along, as an arm's are in most of its poses: a rotation in whole sevenths.
const dmat3 kArm = glm::transpose(dmat3(dvec3(2, 3, 6), dvec3(6, 2, -3), dvec3(-3, 6, -2)) / 7.0);

// He is used to the device in his hand: its stiffness and its friction.
HandParams HandFor(const PlantParams& plant, const core::CoreParams& params,
                   const OperatorPreset& preset, double askew_deg, uint64_t seed) {
  HandParams hand;
  hand.tremor_m *= preset.tremor_ratio;
  hand.coupling_n_per_m = params.kc_mn_per_mm;
  double spring = 1 / (1 / hand.stiffness_n_per_m + 1 / hand.coupling_n_per_m);
  double held_back_n =
      plant.friction_n + hand.coupling_n_per_m * core::TipCellOf(params).Support(dvec3(0, 0, 1));
  hand.light_touch_m = 0.8 * held_back_n / spring;
  hand.back_off_m = 0.5 * hand.light_touch_m;
  hand.seed = seed;
  const SinCos half = SinCosOfTurns(askew_deg / 720);
  hand.orientation = {-half.sin, 0, 0, half.cos};
  return hand;
}

}  // namespace

std::span<const OperatorPreset> OperatorPresets() { return kPresets; }

bool HasUseFor(const OperatorPreset& preset, const scene::Scene& scene,
               const scene::Exercise& exercise) {
  if (preset.askew_deg != 0 && exercise.bur_shape == cutting::BurShape::kSphere) return false;
  return preset.needs == cutting::Tissue::kAir ||
         std::any_of(scene.tissues.begin(), scene.tissues.end(),
                     [&](const scene::TissueSpec& t) { return t.tissue == preset.needs; });
}

const OperatorPreset* FindOperator(std::string_view name) {
  auto it = std::find_if(std::begin(kPresets), std::end(kPresets),
                         [&](const OperatorPreset& p) { return p.name == name; });
  return it == std::end(kPresets) ? nullptr : it;
}

PlantParams PlantOf(const scene::DeviceProfile& profile, const core::CoreParams& params) {
  PlantParams plant;
  plant.mass_kg = static_cast<double>(profile.mass_g.value) * 1e-3;
  plant.damping_n_s_per_m = static_cast<double>(profile.viscous_mn_s_per_m()) * 1e-3;
  plant.friction_n = static_cast<double>(profile.friction_mn.value) * 1e-3;
  plant.resolution_m = static_cast<double>(profile.resolution_nm.value) * 1e-9;
  plant.count_m = params.resolution_nm[0] * 1e-9;
  if (profile.cell && profile.cell->joints) plant.joints = kArm;
  plant.peak_force_n = params.peak_force_mn * 1e-3;
  plant.tick_s = 1.0 / params.rate_hz;
  if (profile.torque) {
    const scene::TorqueSpec& torque = *profile.torque;
    plant.inertia_kg_m2 = kHandAndWrist_kg_m2;
    plant.rotational_damping_n_m_s =
        static_cast<double>(torque.damping_un_m_s_per_rad.value) * 1e-6;
    plant.rotational_friction_n_m = static_cast<double>(torque.friction_un_m.value) * 1e-6;
    plant.orientation_cell_rad = static_cast<double>(torque.orientation_cell_urad.value) * 1e-6;
    plant.peak_torque_n_m = static_cast<double>(torque.peak_un_m.value) * 1e-6;
  }
  for (int i = 0; i < 3; ++i) {
    plant.origin_m[i] = static_cast<double>(params.device_origin_nm[static_cast<size_t>(i)]) * 1e-9;
  }
  return plant;
}

Result<std::unique_ptr<SimulatedDevice>> MakeSimulatedDevice(
    const OperatorPreset& described, const scene::Scene& scene, const scene::Exercise& exercise,
    const scene::DeviceProfile& profile, const core::CoreParams& params,
    const cutting::Volume& volume, uint64_t seed) {
  if (params.spring_on_board) {
    return Status(Code::kConflict,
                  "device profile '" + profile.name +
                      "' leaves the spring to the device's board (board_spring), which a simulated "
                      "device does not have: choose another profile",
                  "board_spring");
  }
  ENAMEL_ASSIGN_OR_RETURN(const scene::Preparation shape,
                          scene::TargetShape(scene, exercise.target));
  const scene::PointUm& at = scene.landmarks.at(exercise.target.landmark);
  const dvec3 landmark = dvec3(at[0], at[1], at[2]) * 1e-6;
  const int mesial_x = scene::MesialX(scene.tooth);
  const uint64_t used_seed = seed != 0 ? seed : described.seed;
  const Bounds extent = ExtentOf(exercise.target, landmark);
  const double lack = LackAt(described.rank);
  Mistakes mistakes = MistakesOf(lack, used_seed);
  const double floor = landmark.z - exercise.target.depth_um * 1e-6;
  // A stump's walls are cut away from the neighbours.
  if (lack > 0 && shape.parts[0].outline != scene::PreparationPart::Outline::kStump) {
    auto beside = [&](int side) {
      return NeighbourBeside(extent, side, floor, landmark.z, volume);
    };
    SideErrors& sides = mistakes.sides;
    if (beside(mesial_x)) Guide(sides.mesial_m, sides.distal_m);
    if (beside(-mesial_x)) Guide(sides.distal_m, sides.mesial_m);
  }
  const OperatorPreset preset = Erring(described, mistakes);
  const Extra wrong = preset.misjudges_m > 0
                          ? Misjudged(preset.extra, preset.misjudges_m, used_seed)
                          : preset.extra;
  ENAMEL_ASSIGN_OR_RETURN(
      std::vector<Move> plan,
      PlanAsFits(shape, preset, wrong, mistakes.sides, mesial_x, exercise, landmark.z, volume));
  plan.resize(static_cast<size_t>(preset.plan_share * static_cast<double>(plan.size())));
  if (preset.slips) {
    const bool all_around = shape.parts[0].outline == scene::PreparationPart::Outline::kStump;
    plan.emplace_back(SlipBeside(extent, mesial_x, preset.extra.distal_m, all_around,
                                 exercise.bur().metric(), volume));
  }
  if (preset.nicks_neighbour) {
    plan.emplace_back(
        NickOf(extent, mesial_x, floor, landmark.z, 0.3e-3, exercise.bur().metric(), volume));
  }
  const double top = HighestSolid_m(volume, extent);
  plan = WithMistakes(std::move(plan), mistakes, shape, exercise, extent, volume);
  const dvec3 start(0.5 * (extent.x0 + extent.x1), 0.5 * (extent.y0 + extent.y1),
                    std::max(top, landmark.z) + kStartAbove_m * std::max(1.0, preset.speed_ratio));
  PlantParams plant = PlantOf(profile, params);
  HandParams hand = HandFor(plant, params, preset,
                            AskewIn_deg(shape, preset.askew_deg) + mistakes.lean_deg, used_seed);
  auto op = std::make_unique<PathOperator>(std::string(preset.name), std::move(plan), hand, start);
  return std::make_unique<SimulatedDevice>(plant, std::move(op));
}

}  // namespace enamel::station
