#include "common/scene/plan.h"

#include <algorithm>
#include <array>
#include <string>

#include "common/cutting/voxel_limit.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/cell.h"
#include "common/scene/delay.h"
#include "common/scene/json/json.h"
#include "common/scene/own_friction.h"
#include "common/scene/rate.h"

namespace enamel::scene {
namespace {

constexpr int32_t kMinCueRate_hz = 300;
constexpr int64_t kStartHeight_nm = 8'000'000;  // plan.h: where count 0 is

Status Refuse(std::string message, std::string field) {
  return Status(Code::kInvalidInput, std::move(message), std::move(field));
}

Status CheckRate(const Exercise& exercise, const DeviceProfile& profile) {
  if (exercise.rate_hz <= profile.rate_hz.value) return Status::Ok();
  return Refuse("exercise '" + exercise.name + "' runs at " + std::to_string(exercise.rate_hz) +
                    " Hz, device profile '" + profile.name + "' carries at most " +
                    std::to_string(profile.rate_hz.value) + " Hz: use another device or exercise",
                "rate_hz");
}

// Slower loops cannot carry the waves (haptics/touch_cues.h): a cue that is promised must come.
Status CheckTouchCues(const Exercise& exercise) {
  if (exercise.touch_cues == TouchCueSpec{} || exercise.rate_hz >= kMinCueRate_hz) return {};
  return Refuse("exercise '" + exercise.name + "' has touch cues and runs at " +
                    std::to_string(exercise.rate_hz) + " Hz: they need at least " +
                    std::to_string(kMinCueRate_hz) + " Hz; raise rate_hz or leave touch_cues out",
                "touch_cues");
}

// K <= 2 b_rot f/(d + 1)^2 and c_rot >= K rho: the same for turning (haptics/README.md, "Torque").
Status CheckTorque(const Exercise& exercise, const DeviceProfile& profile) {
  if (!profile.torque) return Status::Ok();
  const TorqueSpec& t = *profile.torque;
  const int64_t k = t.coupling_un_m_per_rad.value, cell = t.orientation_cell_urad.value;
  const int64_t delay = profile.bus_delay_ticks.value;
  const int64_t allowed = PassiveTorque_un_m_per_rad(profile, exercise.rate_hz, delay);
  const std::string who = "device profile '" + profile.name + "': torque stiffness K = ";
  if (k > allowed) {
    return Refuse(who + std::to_string(k) +
                      " uN m/rad is above the passive limit 2 b_rot f/(d + 1)^2 = " +
                      std::to_string(allowed) + " uN m/rad at " + std::to_string(exercise.rate_hz) +
                      " Hz and " + std::to_string(delay) + " ticks of delay: set at most " +
                      std::to_string(allowed),
                  "coupling_un_m_per_rad");
  }
  const int64_t needed = (k * cell + 999'999) / 1'000'000;
  if (t.friction_un_m.value < needed) {
    return Refuse(who + std::to_string(k) + " uN m/rad needs friction c_rot of K rho = " +
                      std::to_string(needed) + " uN m, found " +
                      std::to_string(t.friction_un_m.value) + ": set K to at most " +
                      std::to_string(t.friction_un_m.value * 1'000'000 / cell) +
                      ", or c_rot to at least " + std::to_string(needed) + " if the device has it",
                  "friction_un_m");
  }
  const int64_t least = (2 * k * cell + 999'999) / 1'000'000;
  if (t.peak_un_m.value < least) {
    return Refuse(who + std::to_string(k) + " uN m/rad needs a peak of 2 K rho = " +
                      std::to_string(least) + " uN m, found " + std::to_string(t.peak_un_m.value) +
                      ": lower K, or take a profile without torque",
                  "peak_un_m");
  }
  return Status::Ok();
}

Status CheckScene(const Scene& scene, const Exercise& exercise) {
  // The canonical text's hash: two scenes are one if their documents have the same bytes.
  if (!exercise.scene.IsZero() && exercise.scene != HashSha256(AsBytes(ToJson(scene)))) {
    return Status(Code::kConflict,
                  "exercise '" + exercise.name + "' is for the scene " + exercise.scene.Hex() +
                      ", '" + scene.name + "' is another or a changed one",
                  "scene_sha256");
  }
  if (scene.landmarks.count(exercise.target.landmark) == 0) {
    return Refuse("exercise '" + exercise.name + "' hangs from landmark '" +
                      exercise.target.landmark + "', which scene '" + scene.name +
                      "' does not have",
                  "landmark");
  }
  if (scene.tissues.empty()) {
    return Refuse("scene '" + scene.name + "' names no tissue: nothing could be cut", "tissues");
  }
  for (const TissueSpec& t : scene.tissues) {
    if (t.tissue == cutting::Tissue::kAir || t.damping_mn_s_per_mm <= 0) {
      return Refuse("scene '" + scene.name + "': tissue " +
                        std::string(cutting::TissueName(t.tissue)) +
                        " needs a damping above 0, found " + std::to_string(t.damping_mn_s_per_mm) +
                        " mN s/mm",
                    "tissues");
    }
    if (t.feed_exponent != cutting::FeedExponent::kOne && t.feed_um_per_s <= 0) {
      return Refuse("scene '" + scene.name + "': tissue " +
                        std::string(cutting::TissueName(t.tissue)) +
                        " is cut by load and needs the feed that its damping is meant at, found " +
                        std::to_string(t.feed_um_per_s) + " um/s",
                    "tissues");
    }
  }
  return Status::Ok();
}

std::string BurText(const BurSpec& bur) {
  std::string text = std::string(cutting::BurShapeName(bur.shape)) + " of radius " +
                     std::to_string(bur.radius_um) + " um and length " +
                     std::to_string(bur.length_um) + " um";
  if (bur.narrow_radius_um != 0) {
    text += ", narrow end " + std::to_string(bur.narrow_radius_um) + " um";
  }
  if (bur.shank_radius_um != 0) text += ", shank " + std::to_string(bur.shank_radius_um) + " um";
  return text;
}

// A scene that offers no burs takes any.
Status CheckBur(const Scene& scene, const Exercise& exercise, const BurSpec& wanted) {
  std::string offered;
  for (const BurSpec& bur : scene.burs) {
    if (bur.SameShapeAs(wanted)) return Status::Ok();
    offered += (offered.empty() ? "" : ", ") + bur.name + " (" + BurText(bur) + ")";
  }
  if (scene.burs.empty()) return Status::Ok();
  return Refuse("exercise '" + exercise.name + "' is done with a " + BurText(wanted) +
                    ", which scene '" + scene.name + "' does not offer: it has " + offered,
                "bur");
}

// The coupling's stiffness at half the bur's height, as an angle: Kc (h/2)^2; 1 N/m (1 m)^2 = 1 N
// m/rad.
int32_t RotationalKc(int32_t kc_mn_per_mm, cutting::BurShape shape, int32_t radius_nm,
                     int32_t length_nm) {
  double arm_m = 0.5e-9 * (shape == cutting::BurShape::kSphere ? 2.0 * radius_nm : length_nm);
  // Fits: the stiffest Kc on the longest bur that ValidateParams lets pass gives 1e8.
  return static_cast<int32_t>(kc_mn_per_mm * arm_m * arm_m * 1e6 + 0.5);
}

core::OtherBur Compile(const BurSpec& bur, int32_t kc_mn_per_mm) {
  core::OtherBur out;
  out.shape = bur.shape;
  out.radius_nm = bur.radius_um * 1000;
  out.length_nm = bur.length_um * 1000;
  out.narrow_radius_nm = bur.narrow_radius_um * 1000;
  out.shank_radius_nm = bur.shank_radius_um * 1000;
  out.neck_nm = bur.neck_um * 1000;
  out.rotational_kc_un_m_per_rad =
      RotationalKc(kc_mn_per_mm, out.shape, out.radius_nm, out.length_nm);
  return out;
}

core::CoreParams Compile(const Scene& scene, const Exercise& exercise,
                         const DeviceProfile& profile) {
  core::CoreParams p;
  p.rate_hz = static_cast<uint32_t>(exercise.rate_hz);
  p.law = exercise.law;
  p.kc_mn_per_mm = static_cast<int32_t>(profile.coupling_mn_per_mm.value);
  p.resolution_nm.fill(CountNm(profile));
  const TipCellNm cell = TipCellOf(profile);
  p.cell_half_nm.fill(cell.half_nm);
  p.cell_ball_nm = cell.ball_nm;
  p.spring_on_board = profile.board_spring.has_value();
  if (HasMotors(profile)) {
    p.friction_mn.fill(static_cast<int32_t>(profile.friction_mn.value));
    p.friction_measured = profile.friction_of_unit;
  }
  const PointUm& landmark = scene.landmarks.at(exercise.target.landmark);
  for (size_t i = 0; i < 3; ++i) p.device_origin_nm[i] = int64_t{landmark[i]} * 1000;
  p.device_origin_nm[2] += kStartHeight_nm;
  p.peak_force_mn = static_cast<int32_t>(profile.peak_force_mn.value);
  p.soft_start_ticks = static_cast<uint32_t>(exercise.rate_hz / 2);
  p.bur_shape = exercise.bur_shape;
  p.bur_radius_nm = exercise.bur_radius_um * 1000;
  p.bur_length_nm = exercise.bur_length_um * 1000;
  p.bur_narrow_radius_nm = exercise.bur_narrow_radius_um * 1000;
  p.shank_radius_nm = exercise.bur_shank_radius_um * 1000;
  p.neck_nm = exercise.bur_neck_um * 1000;
  p.handpiece_stall_un_m = exercise.handpiece.stall_un_m;
  p.handpiece_tangential_permille = exercise.handpiece.tangential_permille;
  p.handpiece_lag_us = exercise.handpiece.lag_us;
  p.rotational_kc_un_m_per_rad =
      RotationalKc(p.kc_mn_per_mm, p.bur_shape, p.bur_radius_nm, p.bur_length_nm);
  for (const BurSpec& bur : exercise.other_burs) {
    p.other_burs.push_back(Compile(bur, p.kc_mn_per_mm));
  }
  // Where the hand feels it, what the device can bear.
  if (profile.torque) {
    p.rotational_kc_un_m_per_rad =
        static_cast<int32_t>(profile.torque->coupling_un_m_per_rad.value);
    for (core::OtherBur& bur : p.other_burs) {
      bur.rotational_kc_un_m_per_rad = p.rotational_kc_un_m_per_rad;
    }
    p.peak_torque_un_m = static_cast<int32_t>(profile.torque->peak_un_m.value);
    p.rotation_cell_urad = static_cast<int32_t>(profile.torque->orientation_cell_urad.value);
  }
  for (const TissueSpec& t : scene.tissues) {
    auto i = static_cast<size_t>(t.tissue);
    p.damping_mn_s_per_mm[i] = t.damping_mn_s_per_mm;
    p.axial_damping_mn_s_per_mm[i] = t.axial_damping_mn_s_per_mm;
    p.coulomb_mn[i] = t.coulomb_mn;
    p.feed_exponent[i] = t.feed_exponent;
    p.feed_um_per_s[i] = t.feed_um_per_s;
    p.bur_friction_permille[i] = t.bur_friction_permille;
    // The spindle's load is then the drag itself.
    if (t.bur_friction_permille > 0) p.handpiece_tangential_permille = 0;
  }
  p.bus_delay_ticks = static_cast<uint32_t>(profile.bus_delay_ticks.value);
  p.contact_cue_mn = exercise.touch_cues.contact_mn;
  p.chatter_cue_mn = exercise.touch_cues.chatter_mn;
  p.cue_energy_nj = exercise.touch_cues.energy_uj * 1000;
  p.cue_power_nw = exercise.touch_cues.power_uw * 1000;
  return p;
}

}  // namespace

Result<core::CoreParams> CompilePlan(const Scene& scene, const Exercise& exercise,
                                     const DeviceProfile& profile) {
  ENAMEL_RETURN_IF_ERROR(CheckRate(exercise, profile));
  ENAMEL_RETURN_IF_ERROR(CheckTouchCues(exercise));
  ENAMEL_RETURN_IF_ERROR(CheckCoupling(profile, exercise.rate_hz, profile.bus_delay_ticks.value));
  ENAMEL_RETURN_IF_ERROR(CheckTorque(exercise, profile));
  ENAMEL_RETURN_IF_ERROR(CheckScene(scene, exercise));
  for (const BurSpec& bur : exercise.burs()) {
    ENAMEL_RETURN_IF_ERROR(CheckBur(scene, exercise, bur));
  }
  // Last, and asked again in the core's own terms: a plan that the core refuses is never handed
  // out.
  core::CoreParams params = Compile(scene, exercise, profile);
  ENAMEL_RETURN_IF_ERROR(core::ValidateParams(params));
  return params;
}

std::optional<std::string> WhyTooCoarse(const Exercise& exercise, int32_t voxel_nm) {
  for (const BurSpec& bur : exercise.burs()) {
    if (auto why = cutting::WhyTooCoarse(bur.metric(), voxel_nm, exercise.graded)) return why;
  }
  return std::nullopt;
}

Status CheckVolume(const Scene& scene, const cutting::Volume& volume) {
  if (scene.voxel_nm != volume.spec().voxel_nm) {
    return Status(Code::kConflict,
                  "scene '" + scene.name + "' says voxels of " + std::to_string(scene.voxel_nm) +
                      " nm, its volume has " + std::to_string(volume.spec().voxel_nm) +
                      ": they do not belong together",
                  "voxel_nm");
  }
  auto held_m3 = cutting::SolidVolume_m3(volume);
  std::array<bool, cutting::kTissueCount> named{};
  for (const TissueSpec& t : scene.tissues) named[static_cast<size_t>(t.tissue)] = true;
  for (size_t t = 1; t < held_m3.size(); ++t) {
    // Both ways: a tissue without a damping would be cut like air, and one that is nowhere hides a
    // mistake.
    if (named[t] == (held_m3[t] > 0)) continue;
    std::string tissue(cutting::kTissueNames[t]);
    return Status(Code::kConflict,
                  "scene '" + scene.name + "': " +
                      (named[t] ? "it names " + tissue +
                                      ", of which its volume holds none: leave "
                                      "it out of 'tissues'"
                                : "its volume holds " + tissue +
                                      ", which it does not name: add it "
                                      "to 'tissues' with its damping"),
                  "tissues");
  }
  return Status::Ok();
}

}  // namespace enamel::scene
