#include "station/devices/operators.h"

#include <algorithm>
#include <array>

#include "station/devices/cavity_plan.h"
#include "station/devices/path_operator.h"

namespace enamel::station {
namespace {

constexpr double kStartAbove_m = 2e-3;  // of the highest point near the cavity
// Of a driven wrist and the fingers on it, about each axis: assumption.
constexpr double kHandAndWrist_kg_m2 = 1e-4;

constexpr std::array<OperatorPreset, 3> kPresets = {{
    {"dentist", "cuts the exercise's box to about a third of a voxel", 0, 1, 1.0, 0.55e-3, 2.2,
     false},
    {"student", "the same box, another hand: slower, other layers, other way round", 0, 7, 0.85,
     0.5e-3, 1.8, true},
    {"student-deep-mesial", "like student, and cuts the mesial wall 0.3 mm too far", 0.3e-3, 7,
     0.85, 0.5e-3, 1.8, true},
}};

BoxCut BoxOf(const scene::CavityTarget& target, const scene::PointUm& landmark,
             double mesial_extra_m) {
  BoxCut box;
  box.centre_m = dvec3(landmark[0], landmark[1], landmark[2]) * 1e-6;
  box.distal_m = target.half_size_um[0] * 1e-6;
  box.mesial_m = box.distal_m + mesial_extra_m;
  box.lingual_m = box.buccal_m = target.half_size_um[1] * 1e-6;
  box.depth_m = target.depth_um * 1e-6;
  return box;
}

// He has got used to the device in his hand: how stiff it is, how much its friction holds back.
HandParams HandFor(const PlantParams& plant, const core::CoreParams& params, uint64_t seed) {
  HandParams hand;
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
  auto it = std::find_if(kPresets.begin(), kPresets.end(),
                         [&](const OperatorPreset& p) { return p.name == name; });
  return it == kPresets.end() ? nullptr : &*it;
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
  BoxCut box = BoxOf(exercise.target, landmark->second, preset.mesial_extra_m);
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
  double top = HighestSolid_m(volume, box.centre_m.x - box.distal_m, box.centre_m.x + box.mesial_m,
                              box.centre_m.y - box.lingual_m, box.centre_m.y + box.buccal_m);
  dvec3 start(box.centre_m.x, box.centre_m.y, std::max(top, box.centre_m.z) + kStartAbove_m);
  PlantParams plant = PlantOf(profile, params);
  HandParams hand = HandFor(plant, params, seed != 0 ? seed : preset.seed);
  auto op = std::make_unique<PathOperator>(std::string(preset.name), std::move(plan), hand, start);
  return std::make_unique<SimulatedDevice>(plant, std::move(op));
}

}  // namespace enamel::station
