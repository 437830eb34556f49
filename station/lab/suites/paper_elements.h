#pragma once

#include <span>
#include <string>
#include <vector>

#include "station/lab/laws/model.h"

// The paper beside ours: every equation, table and figure of
//
//   G. Liu, Y. Zhang, D. Wang, W. T. Townsend, "Stable haptic interaction using a damping model to implement a
//   realistic tooth-cutting simulation for dental training", Virtual Reality 12 (2008) 99-106,
//   doi:10.1007/s10055-008-0094-x,
//
// with what is printed, what we find, how, and a verdict that is computed from the two. `enamel-lab paper` and
// docs/paper.md show it. Units: those of the paper (mm, N/mm, N s/mm) where a name says so. Thread safety: any
// thread; deterministic; about three seconds.
namespace enamel::station::lab {

// What the paper prints of a device.
struct PrintedDevice {
  const char* profile;  // of ShippedProfiles
  const char* name;     // as in the paper
  double resolution_mm, max_stiffness_n_per_mm, rate_hz;
  double table1_b_n_s_per_mm, table1_force_n;
  double table2_measured_n_s_per_mm, table2_computed_n_s_per_mm;
  double table3_kc_n_per_mm, table3_force_n;
};

struct PrintedTissue {
  const char* name;
  double force_n, least_b_n_s_per_mm, most_b_n_s_per_mm;
};

// The paper's numbers. Tests change one and see the verdict follow.
struct PrintedPaper {
  std::vector<PrintedDevice> devices = {
      {"omega3", "Omega 3DOF", .009, 12, 1000, .0051, .28, .0051, .006, 10, 3.7},
      {"phantom_desktop", "Phantom Desktop", .01, 3.5, 1000, .0016, .13, .0022, .00175, 2.5, .8},
      {"bhhd3", "BHhd 3DOF", .02, 5, 1000, .003, .15, .003, .0025, 4, 1.1}};
  std::vector<PrintedTissue> tissues = {{"enamel", 2.8, 6.1, 11.3}, {"dentin", .9, 3.8, 6.5}};
  double b_n_s_per_mm = 6.5;    // chosen for enamel
  double speed_mm_per_s = .48;  // largest measured
  double eq16_mm_per_s = .5;    // "maximum operating speed", for table 2
  double table3_mm_per_s = 2;   // "> 2"
  double figure7_mm_per_s[2] = {.5, .2};
  double figure8_mm_per_s = .4, figure8_error_n = .1;
  double figure9_n = 3.7;
};

enum class PaperVerdict {
  kReproduced,
  kRemark,          // reproduced with a remark
  kContradicts,     // contradicts itself; the remark has the derivation
  kNotReproducible  // from what is printed
};
const char* NameOf(PaperVerdict verdict);

struct PaperElement {
  std::string element;  // "equation 16", "table 1, Omega 3DOF", "figure 8", "measured cutting"
  std::string says;     // the equation, or what the element shows
  std::string printed, ours, how;
  PaperVerdict verdict = PaperVerdict::kReproduced;
  std::string remark;
  std::string command;  // prints our figure
};

// Thirty: the measured cutting, equations 1 to 17, tables 1 to 3 for three devices, figures 7 to 9.
// Requires: `printed.devices` are those of the paper, in its order.
std::vector<PaperElement> PaperElements(const PrintedPaper& printed);

// Errors that rounding to `resolution_m` makes on a steady motion with tremor, as multiples of the unit in
// brackets. Equations 5 to 11 bound them by 1, 2, 2, 2 and 4.
struct RoundingErrors {
  double position = 0;  // [delta]
  double step = 0;      // of a position's change [delta]
  double speed = 0;     // [delta f]
  double force = 0;     // of eq. 1 [B delta f]
  double change = 0;    // of a force's change, beyond B |dV| [B delta f]
  double at_rest = 0;   // share of ticks whose measured position did not change
};
RoundingErrors ErrorsOfRounding(double resolution_m, double rate_hz, double speed_m_per_s);

// Largest |dF| of eq. 1 if each of three positions is wrong by +-delta, less 4 B f delta, over B |dV|: the factor of
// |dV| in eq. 11, which prints 4.
double FactorOfSpeedChange(double resolution_m, double rate_hz, double speed_change_m_per_s);

}  // namespace enamel::station::lab
