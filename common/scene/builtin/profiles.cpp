#include "common/scene/builtin/builtin.h"

// Sources: "paper" is Liu et al. 2008 (Virtual Reality 12:99-106).
namespace enamel::scene {
namespace {

constexpr const char* kDampingSource =
    "assumption: K T/2 at 1 kHz, so that the paper's stiffness is the largest passive one";
constexpr const char* kMassSource = "assumption: effective mass at the tip, not measured";
constexpr const char* kFrictionSource = "assumption: Coulomb friction at the tip, not measured";
constexpr const char* kDelaySource = "assumption: force is out before the next tick";
// Table 3 of the paper prints 3.7, 0.8 and 1.1 N as "maximum continuous output force". That is what
// its limiter gave in one experiment, not what the motors bear for long: it is no source for these.
constexpr const char* kSheetSource =
    "published by the manufacturer; not measured, not checked against this unit";

// Every device here counts at its joints, and drivers give metres: the station rounds them to this.
CellSpec JointCells(int32_t count_nm) {
  return {true, count_nm, 0, "encoders count at the joints; their noise was not measured"};
}

DeviceProfile Omega3() {
  DeviceProfile p;
  p.name = "omega3";
  p.title = "Omega 3DOF";
  p.resolution_nm = {9'000, "paper, device table (0.009 mm)"};
  p.max_stiffness_mn_per_mm = {12'000, "paper, device table (12 N/mm)"};
  p.coupling_mn_per_mm = {10'000, "paper, table 3 (Kc 10 N/mm)"};
  p.damping_mn_s_per_m = {6'000, kDampingSource};
  p.friction_mn = {90, kFrictionSource};
  p.mass_g = {250, kMassSource};
  p.peak_force_mn = {12'000, "CHAI3D's device list (omega.3, 12 N)"};
  p.continuous_force_mn = {12'000, kSheetSource};
  p.rate_hz = {1'000, "paper, device table"};
  p.bus_delay_ticks = {0, kDelaySource};
  p.workspace_radius_um = {75'000, "CHAI3D's device list (omega.3, 75 mm)"};
  p.cell = JointCells(500);
  return p;
}

DeviceProfile PhantomDesktop() {
  DeviceProfile p;
  p.name = "phantom_desktop";
  p.title = "Phantom Desktop";
  p.resolution_nm = {10'000, "paper, device table (0.01 mm)"};
  p.max_stiffness_mn_per_mm = {3'500, "paper, device table (3.5 N/mm)"};
  p.coupling_mn_per_mm = {2'500, "paper, table 3 (Kc 2.5 N/mm)"};
  p.damping_mn_s_per_m = {1'750, kDampingSource};
  p.friction_mn = {25, kFrictionSource};
  p.mass_g = {45, kMassSource};
  p.peak_force_mn = {7'900, "CHAI3D's device list (Phantom Desktop, 7.9 N)"};
  p.continuous_force_mn = {1'750, kSheetSource};
  p.rate_hz = {1'000, "paper, device table"};
  p.bus_delay_ticks = {0, kDelaySource};
  p.workspace_radius_um = {100'000, "CHAI3D's device list (Phantom Desktop, 100 mm)"};
  p.cell = JointCells(500);
  return p;
}

DeviceProfile Bhhd3() {
  DeviceProfile p;
  p.name = "bhhd3";
  p.title = "BHhd 3DOF";
  p.resolution_nm = {20'000, "paper, device table (0.02 mm)"};
  p.max_stiffness_mn_per_mm = {5'000, "paper, device table (5 N/mm)"};
  p.coupling_mn_per_mm = {4'000, "paper, table 3 (Kc 4 N/mm)"};
  p.damping_mn_s_per_m = {2'500, kDampingSource};
  p.friction_mn = {80, kFrictionSource};
  p.mass_g = {150, kMassSource};
  p.peak_force_mn = {8'000,
                     "assumption: no published figure; between the other two devices' scale"};
  p.continuous_force_mn = {
      1'750, "assumption: not known, no published figure; the least of the other two devices'"};
  p.rate_hz = {1'000, "paper, device table"};
  p.bus_delay_ticks = {0, kDelaySource};
  p.workspace_radius_um = {75'000, "assumption: no published figure"};
  p.cell = JointCells(500);
  return p;
}

// A device that drives all six axes.
DeviceProfile Sigma7() {
  constexpr const char* kList = "CHAI3D's device list (sigma.7)";
  DeviceProfile p;
  p.name = "sigma7";
  p.title = "sigma.7";
  p.resolution_nm = {1'500, "assumption: 0.0015 mm; no published figure was at hand"};
  p.max_stiffness_mn_per_mm = {4'000, "CHAI3D's device list (sigma.7, 4000 N/m)"};
  p.coupling_mn_per_mm = {3'600, "chosen: below the listed stiffness"};
  p.damping_mn_s_per_m = {
      2'000, "assumption: K T/2 at 1 kHz, so that the listed stiffness is the largest passive one"};
  p.friction_mn = {80, kFrictionSource};
  p.mass_g = {400, kMassSource};
  p.peak_force_mn = {12'000, "CHAI3D's device list (sigma.7, 12 N)"};
  p.continuous_force_mn = {12'000, "assumption: as the peak; no published figure was at hand"};
  p.rate_hz = {1'000, "assumption: one tick per millisecond"};
  p.bus_delay_ticks = {0, kDelaySource};
  p.workspace_radius_um = {70'000, "CHAI3D's device list (sigma.7), rounded down"};
  p.axes = {6, kList};
  p.torque.emplace();
  p.torque->peak_un_m = {200'000, "CHAI3D's device list (sigma.7, torque 0.2 N m)"};
  p.torque->coupling_un_m_per_rad = {800'000, "chosen: below CHAI3D's 1 N m/rad for the sigma.7"};
  p.torque->damping_un_m_s_per_rad = {
      500, "assumption: K T/2 at 1 kHz, so that CHAI3D's 1 N m/rad is the largest passive one"};
  p.torque->friction_un_m = {1'000, "assumption: Coulomb friction of the wrist, not measured"};
  p.torque->orientation_cell_urad = {
      300, "assumption: half the diagonal of cells of 0.013 degrees, and the recording's rounding"};
  p.cell = JointCells(50);
  return p;
}

// Of the arms below, no source gives these. The figures are the least that carry Kc, or the least of the
// devices above: AskedFor lists them until a unit is measured.
constexpr const char* kAskedFriction =
    "asked for: not published; the least that carries Kc with this cell, until calibrate measures "
    "a unit";
constexpr const char* kAskedMass =
    "asked for: not published, motors included; the least of the devices above until calibrate "
    "measures a unit";
constexpr const char* kAskedContinuous =
    "asked for: not published; the least of the devices above until somebody asks the maker";
constexpr const char* kAskedDamping =
    "asked for: not published; K T/2 at 1 kHz, so that the listed stiffness is the largest passive "
    "one, until calibrate measures a unit";
constexpr const char* kExchangeSource =
    "its protocol: the answer to one tick's force is read in the next; the bus itself was not "
    "measured";
constexpr const char* kPassiveSource = "2 b f/(d + 1)^2 of b and d";

// WoodenHaptics and Polhem: arms of capstans and bodies, dimensions from haptikfabrikenapi.h. `farthest`
// says for which body's count the tip moves most.
DeviceProfile WoodenArm(const char* name, const char* title, int64_t cell_nm, const char* farthest,
                        int64_t k_mn_per_mm, int64_t friction_mn, int64_t radius_um) {
  constexpr const char* kList = "haptikfabrikenapi.h, configuration of this model";
  DeviceProfile p;
  p.name = name;
  p.title = title;
  p.resolution_nm = {cell_nm, farthest};
  p.max_stiffness_mn_per_mm = {k_mn_per_mm, kList};
  p.coupling_mn_per_mm = {k_mn_per_mm / 4, kPassiveSource};
  p.damping_mn_s_per_m = {k_mn_per_mm / 2, kAskedDamping};
  p.friction_mn = {friction_mn, kAskedFriction};
  p.mass_g = {45, kAskedMass};
  p.peak_force_mn = {5'000, kList};
  p.continuous_force_mn = {1'750, kAskedContinuous};
  p.rate_hz = {1'000, "its protocol: an exchange a millisecond"};
  p.bus_delay_ticks = {1, kExchangeSource};
  p.workspace_radius_um = {radius_um, kList};
  p.cell = JointCells(500);
  return p;
}

DeviceProfile WoodenHapticsV2015() {
  return WoodenArm("woodenhaptics_v2015", "WoodenHaptics", 64'200,
                   "2000 counts a turn, 12:1, 0.245 m of body c: 0.0642 mm", 1'000, 15, 100'000);
}

DeviceProfile PolhemV1() {
  return WoodenArm("polhem_v1", "Polhem, HID", 54'700,
                   "2000 counts a turn, 10:1, 0.174 m of body b: 0.0547 mm", 800, 10, 100'000);
}

DeviceProfile PolhemV3() {
  return WoodenArm("polhem_v3", "Polhem v3, serial", 72'500,
                   "4096 counts a turn, 175:28.8, 0.287 m from the axis of body a: 0.0725 mm",
                   2'000, 32, 150'000);
}

DeviceProfile Touch() {
  constexpr const char* kList = "CHAI3D's device list (Touch: 3.3 N, 400 N/m, 75 mm)";
  DeviceProfile p;
  p.name = "touch";
  p.title = "3D Systems Touch";
  p.resolution_nm = {55'000, kSheetSource};
  p.max_stiffness_mn_per_mm = {400, kList};
  p.coupling_mn_per_mm = {100, kPassiveSource};
  p.damping_mn_s_per_m = {200, kAskedDamping};
  p.friction_mn = {10, kAskedFriction};
  p.mass_g = {45, kSheetSource};
  p.peak_force_mn = {3'300, kList};
  p.continuous_force_mn = {880, kSheetSource};
  p.rate_hz = {1'000, "its library: a servo frame a millisecond"};
  p.bus_delay_ticks = {1,
                       "asked for: the force that answers one servo frame's pose goes out in the "
                       "next; the line was not measured, until calibrate measures a unit"};
  p.workspace_radius_um = {75'000, kList};
  p.cell = JointCells(500);
  return p;
}

// Through a service and its USB line, so a tick more of delay than the arms above.
DeviceProfile Inverse3() {
  DeviceProfile p;
  p.name = "inverse3";
  p.title = "Haply Inverse3";
  p.resolution_nm = {10'000, kSheetSource};
  p.max_stiffness_mn_per_mm = {2'000,
                               "asked for: not published; a guess until calibrate measures a unit"};
  p.coupling_mn_per_mm = {222, kPassiveSource};
  p.damping_mn_s_per_m = {1'000, kAskedDamping};
  p.friction_mn = {10, kAskedFriction};
  p.mass_g = {45, kAskedMass};
  p.peak_force_mn = {10'000, kSheetSource};
  p.continuous_force_mn = {3'300, kSheetSource};
  p.rate_hz = {1'000, "its protocol: an exchange whenever it is asked, here each millisecond"};
  p.bus_delay_ticks = {2,
                       "asked for: its protocol has a tick, the answer to one tick's force is read "
                       "in the next; a tick for the service and USB, until calibrate measures a "
                       "unit with the force_gate filter that it is used with"};
  p.workspace_radius_um = {
      100'000, "asked for: not published as a radius; a guess until somebody measures a unit"};
  p.cell = JointCells(500);
  return p;
}

// The maker has published no figure of a MinVerse. Force, stiffness and workspace are the least of the other
// devices', so that none is too much for it.
DeviceProfile MinVerse() {
  constexpr const char* kAsked =
      "asked for: not published; the least of the devices above until somebody asks the maker";
  DeviceProfile p = Inverse3();
  p.name = "minverse";
  p.title = "Haply MinVerse";
  p.resolution_nm = {10'000,
                     "asked for: not published; as an Inverse3's until calibrate measures a unit"};
  p.max_stiffness_mn_per_mm = {400, kAsked};
  p.coupling_mn_per_mm = {44, kPassiveSource};
  p.damping_mn_s_per_m = {200, kAskedDamping};
  p.peak_force_mn = {3'300, kAsked};
  p.continuous_force_mn = {880, kAsked};
  p.workspace_radius_um = {40'000, kAsked};
  return p;
}

DeviceProfile TouchX() {
  DeviceProfile p = Touch();
  p.name = "touch_x";
  p.title = "3D Systems Touch X";
  p.resolution_nm = {23'000, kSheetSource};
  p.max_stiffness_mn_per_mm = {
      1'480, "published by the manufacturer (1.48 N/mm, the least of three axes); not measured"};
  p.coupling_mn_per_mm = {370, kPassiveSource};
  p.damping_mn_s_per_m = {740, kAskedDamping};
  p.friction_mn = {10, kAskedFriction};
  p.mass_g = {45, kSheetSource};
  p.peak_force_mn = {7'900, kSheetSource};
  p.continuous_force_mn = {1'750, kSheetSource};
  p.workspace_radius_um = {
      60'000, "published by the manufacturer (160 x 120 x 120 mm); half of the shortest side"};
  return p;
}

DeviceProfile Falcon() {
  DeviceProfile p;
  p.name = "falcon";
  p.title = "Novint Falcon";
  p.resolution_nm = {54'500,
                     "1280 counts a turn, 110:14.25: up to 0.0545 mm of the tip within 40 mm"};
  p.max_stiffness_mn_per_mm = {3'000, "CHAI3D's device list (Falcon, 3000 N/m)"};
  p.coupling_mn_per_mm = {333, kPassiveSource};
  p.damping_mn_s_per_m = {1'500, kAskedDamping};
  p.friction_mn = {16, kAskedFriction};
  p.mass_g = {45, kAskedMass};
  p.peak_force_mn = {
      4'800,
      "its motor values, up to 4096 at 10000 a N m: what they give in each direction within 40 mm; "
      "CHAI3D's device list has 8 N"};
  p.continuous_force_mn = {1'750, kAskedContinuous};
  p.rate_hz = {1'000, "its protocol: an exchange a millisecond"};
  p.bus_delay_ticks = {2,
                       "asked for: its protocol has a tick, the answer to one tick's force is read "
                       "in the next; a tick for its serial chip, which waits up to 1 ms, until "
                       "calibrate measures a unit"};
  p.workspace_radius_um = {40'000, "CHAI3D's device list (Falcon, 40 mm)"};
  p.cell = JointCells(500);
  return p;
}

// Wrists without motors: three axes are driven.
DeviceProfile OmegaWithWrist(const char* name, const char* title) {
  constexpr const char* kList = "CHAI3D's device list (omega.3, .6, .7: 12 N, 5000 N/m, 75 mm)";
  DeviceProfile p;
  p.name = name;
  p.title = title;
  p.resolution_nm = {10'000, kSheetSource};
  p.max_stiffness_mn_per_mm = {5'000, kList};
  p.coupling_mn_per_mm = {1'250, kPassiveSource};
  p.damping_mn_s_per_m = {2'500, kAskedDamping};
  p.friction_mn = {12, kAskedFriction};
  p.mass_g = {45, kAskedMass};
  p.peak_force_mn = {12'000, kList};
  p.continuous_force_mn = {12'000, kSheetSource};
  p.rate_hz = {1'000, "assumption: one tick per millisecond"};
  p.bus_delay_ticks = {1,
                       "asked for: its library returns when a force is on its way; the line was "
                       "not measured, until calibrate measures a unit"};
  p.workspace_radius_um = {75'000, kList};
  p.cell = JointCells(500);
  return p;
}

// Devices without motors. Nothing is felt, so nothing can be unstable: the numbers choose how
// closely the bur follows the hand (10 N/mm: 0.3 mm behind it at 3 N) and satisfy the same premises
// as a real device's.
DeviceProfile Pointer() {
  constexpr const char* kNoMotors = "chosen: no motors, the force is computed and shown, not felt";
  DeviceProfile p;
  p.name = "pointer";
  p.title = "Mouse or 6-DoF mouse, no force";
  p.resolution_nm = {5'000, "chosen: a fifth of a pixel at the usual magnification"};
  p.max_stiffness_mn_per_mm = {12'000, kNoMotors};
  p.coupling_mn_per_mm = {10'000, kNoMotors};
  p.damping_mn_s_per_m = {12'000, kNoMotors};
  p.friction_mn = {30, kNoMotors};
  p.mass_g = {100, kNoMotors};
  p.peak_force_mn = {3'000, "chosen: about what cutting enamel takes (paper: 2.8 N)"};
  p.continuous_force_mn = {3'000, kNoMotors};
  p.rate_hz = {8'000, kNoMotors};
  p.bus_delay_ticks = {0, kNoMotors};
  p.workspace_radius_um = {30'000, kNoMotors};
  return p;
}

}  // namespace

bool HasMotors(const DeviceProfile& profile) { return profile.name != "pointer"; }

std::vector<DeviceProfile> BuiltinProfiles() {
  return {Omega3(),
          PhantomDesktop(),
          Bhhd3(),
          Pointer(),
          WoodenHapticsV2015(),
          PolhemV1(),
          PolhemV3(),
          Inverse3(),
          MinVerse(),
          Touch(),
          TouchX(),
          Falcon(),
          OmegaWithWrist("omega6", "omega.6"),
          OmegaWithWrist("omega7", "omega.7"),
          Sigma7()};
}

}  // namespace enamel::scene
