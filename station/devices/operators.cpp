#include "station/devices/operators.h"

#include <algorithm>
#include <iterator>

#include "station/devices/cavity_plan.h"
#include "station/devices/path_operator.h"

namespace enamel::station {
namespace {

constexpr double kStartAbove_m = 2e-3;  // of the highest point near the cavity
// Of a driven wrist and the fingers on it, about each axis: assumption.
constexpr double kHandAndWrist_kg_m2 = 1e-4;

using Extra = OperatorPreset::Extra;
constexpr OperatorPreset kPresets[] = {
    {"dentist", "cuts the exercise's box to about a third of a voxel", 9, 1, 1.0, 0.55e-3, 2.2,
     false},
    {"student", "the same box, another hand: slower, other layers, other way round", 9, 7, 0.85},
    {"student-deep-mesial", "like student, and cuts the mesial wall 0.3 mm too far", 6, 7, 0.85,
     0.5e-3, 1.8, true, Extra{.mesial_m = 0.3e-3}},
    {.name = "shaky",
     .summary = "trembles six times as much as a calm hand",
     .rank = 8,
     .seed = 11,
     .tremor_ratio = 6,
     .offered = false},
    {.name = "hasty",
     .summary = "fast and hard; walls and floor 0.12 to 0.2 mm off",
     .rank = 5,
     .seed = 12,
     .speed_ratio = 1.5,
     .rough_push_n = 3,
     .extra = {.mesial_m = 0.2e-3, .distal_m = -0.15e-3, .buccal_m = 0.12e-3, .floor_m = 0.2e-3},
     .offered = false},
    {.name = "too-shallow",
     .summary = "leaves the lowest 0.6 mm, and the caries there",
     .rank = 4,
     .seed = 13,
     .extra = {.floor_m = -0.6e-3},
     .offered = false},
    {.name = "over-extender",
     .summary = "cuts every wall 0.35 mm too far",
     .rank = 3,
     .seed = 14,
     .extra = {0.35e-3, 0.35e-3, 0.35e-3, 0.35e-3, 0},
     .offered = false},
    {.name = "clumsy",
     .summary = "every wall and the floor are off, and at the end the bur slips into the tooth",
     .rank = 2,
     .seed = 15,
     .extra = {0.4e-3, 0.3e-3, -0.25e-3, 0.4e-3, 0.35e-3},
     .tremor_ratio = 4,
     .slips = true,
     .offered = false},
    {.name = "timid",
     .summary = "stops before the cavity is half done",
     .rank = 1,
     .seed = 16,
     .speed_ratio = 0.6,
     .rough_push_n = 1.2,
     .plan_share = 0.35,
     .offered = false},
    {.name = "idle",
     .summary = "holds the handpiece and cuts nothing",
     .rank = 0,
     .seed = 17,
     .plan_share = 0,
     .offered = false},
};

BoxCut BoxOf(const scene::CavityTarget& target, const scene::PointUm& landmark,
             const Extra& extra) {
  BoxCut box;
  box.centre_m = dvec3(landmark[0], landmark[1], landmark[2]) * 1e-6;
  const double half_x = target.half_size_um[0] * 1e-6, half_y = target.half_size_um[1] * 1e-6;
  box.distal_m = half_x + extra.distal_m;
  box.mesial_m = half_x + extra.mesial_m;
  box.lingual_m = half_y + extra.lingual_m;
  box.buccal_m = half_y + extra.buccal_m;
  box.depth_m = target.depth_um * 1e-6 + extra.floor_m;
  return box;
}

// A slip: from above the tooth's surface beside the box a millimetre into it, and out.
Stroke SlipBeside(const BoxCut& box, const cutting::Bur& bur, const cutting::Volume& volume) {
  constexpr double kDeep_m = 1e-3, kBeyondLeeway_m = 0.5e-3, kClear_m = 1e-3;
  dvec3 at = box.centre_m - dvec3(box.distal_m + 2 * bur.radius_m + kBeyondLeeway_m, 0, 0);
  at.z = HighestSolid_m(volume, at.x - bur.radius_m, at.x + bur.radius_m, at.y - bur.radius_m,
                        at.y + bur.radius_m);
  const dvec3 up(0, 0, kClear_m), down(0, 0, -kDeep_m);
  Stroke slip;
  slip.points = {dvec3(box.centre_m.x, box.centre_m.y, at.z) + up, at + up, at + down, at + up};
  slip.feed_m_per_s = 1e-3;
  slip.push_n = 2;
  return slip;
}

// He has got used to the device in his hand: how stiff it is, how much its friction holds back.
HandParams HandFor(const PlantParams& plant, const core::CoreParams& params,
                   const OperatorPreset& preset, uint64_t seed) {
  HandParams hand;
  hand.tremor_m *= preset.tremor_ratio;
  hand.coupling_n_per_m = params.kc_mn_per_mm;
  double spring = 1 / (1 / hand.stiffness_n_per_m + 1 / hand.coupling_n_per_m);
  double held_back_n = plant.friction_n + 0.5 * hand.coupling_n_per_m * plant.resolution_m;
  hand.light_touch_m = 0.8 * held_back_n / spring;
  hand.back_off_m = 0.5 * hand.light_touch_m;
  hand.seed = seed;
  return hand;
}

}  // namespace

std::span<const OperatorPreset> OperatorPresets() { return kPresets; }

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
  plant.resolution_m = params.resolution_nm[0] * 1e-9;
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
    const OperatorPreset& preset, const scene::Scene& scene, const scene::Exercise& exercise,
    const scene::DeviceProfile& profile, const core::CoreParams& params,
    const cutting::Volume& volume, uint64_t seed) {
  auto landmark = scene.landmarks.find(exercise.target.landmark);
  if (landmark == scene.landmarks.end()) {
    return Status(Code::kInvalidInput,
                  "the exercise's box hangs from landmark '" + exercise.target.landmark +
                      "', which scene '" + scene.name + "' does not have",
                  "landmark");
  }
  cutting::Bur bur = exercise.bur().metric();
  BoxCut box = BoxOf(exercise.target, landmark->second, preset.extra);
  CavityPlanOptions options;
  options.layer_m = preset.layer_m;
  options.rough_push_n = preset.rough_push_n;
  options.speed_ratio = preset.speed_ratio;
  options.clockwise = preset.clockwise;
  if (!FitsInto(box, bur, options)) {
    return Status(
        Code::kInvalidInput,
        "exercise '" + exercise.name + "': a simulated operator cuts boxes at least " +
            std::to_string(static_cast<int>(2e6 * (bur.radius_m + options.wall_stock_m) + 1)) +
            " um wide with this bur, found half sizes " +
            std::to_string(exercise.target.half_size_um[0]) + " and " +
            std::to_string(exercise.target.half_size_um[1]) + " um",
        "half_size_um");
  }
  std::vector<Move> plan = PlanCavity(box, bur, volume, options);
  plan.resize(static_cast<size_t>(preset.plan_share * static_cast<double>(plan.size())));
  if (preset.slips) plan.emplace_back(SlipBeside(box, bur, volume));
  double top = HighestSolid_m(volume, box.centre_m.x - box.distal_m, box.centre_m.x + box.mesial_m,
                              box.centre_m.y - box.lingual_m, box.centre_m.y + box.buccal_m);
  dvec3 start(box.centre_m.x, box.centre_m.y, std::max(top, box.centre_m.z) + kStartAbove_m);
  PlantParams plant = PlantOf(profile, params);
  HandParams hand = HandFor(plant, params, preset, seed != 0 ? seed : preset.seed);
  auto op = std::make_unique<PathOperator>(std::string(preset.name), std::move(plan), hand, start);
  return std::make_unique<SimulatedDevice>(plant, std::move(op));
}

}  // namespace enamel::station
