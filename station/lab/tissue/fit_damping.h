#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "station/lab/tissue/cut_fit.h"
#include "station/lab/tissue/load_fit.h"

// B, the Coulomb part and the threshold of real tissue from recorded cuts, per tissue: columns of
// text in, a table, a plot and a material profile out. Method and errors: cut_fit.h. Not for the
// tick; no state.
namespace enamel::station::lab {

// One tissue's fit.
struct DampingFit {
  std::string tissue;                              // "all" where the file has no tissue column
  size_t samples = 0, used = 0;                    // used: windows, cutting steadily
  double b_n_s_per_mm = 0, b_low = 0, b_high = 0;  // CutFit's b
  double offset_n = 0;                             // Coulomb's part, also where below 0
  double residual_rms_n = 0;
  double speed_max_mm_s = 0, force_max_n = 0;
  CutFit cut;                   // all of it
  std::optional<LoadFit> load;  // with windows enough
  std::string refused;          // why there is no fit; empty when there is one
};

struct DampingReport {
  double rate_hz = 0;              // median of the file's
  std::vector<std::string> notes;  // assumptions: units, columns, rows left out
  std::vector<DampingFit> fits;
};

// Columns by name, in upper or lower case: time_s, t_s, time or t (time_ms, t_ms: milliseconds);
// position_mm or x_mm, y_mm, z_mm (or _m; without a unit, metres are guessed from size, with a
// note); force_n or fx_n, fy_n, fz_n (or without unit, N); optionally axis_x, axis_y, axis_z (the
// bur's, in the frame of the positions) and tissue. Any order, any rate from 1 Hz, gaps allowed.
//
// Three columns of position give a matrix B, or B across and along the bur where its axis is known
// (`bur_axis`, zero: not known, or the columns, which come first); else, or where the directions of
// motion do not determine it, one B along the motion. One column of force is a magnitude along the
// cut, unless it and the one position both have signs. Force may be the hand's or the tooth's.
//
// Where the windows tell the exponent 1/2 from 1, tissue that is cut by load has it; where the bur's axis is known, the
// friction of its surface (load_fit.h). What the data does not hold is said, and left at B v.
//
// Errors (kInvalidInput): columns missing, no numbers, time that does not rise, impossible units
// (more than 1 m of travel, above 200 N, faster than 1 m/s): the message gives the value found. A
// tissue that cannot be fitted (no motion, no contact, fewer than 8 windows, force that falls with
// speed) is in the report with the reason.
Result<DampingReport> FitDamping(std::string_view csv, const dvec3& bur_axis = dvec3(0));

std::string DampingText(const DampingReport& report);
// Plot of force against speed with the fitted lines (schemas/lab_report.schema.json); `source`
// names the file.
std::string DampingPlot(const DampingReport& report, const std::string& source);

// The fit in the form of schemas/material.schema.json; `source` names the file. Requires: a tissue
// that could be fitted.
std::string MaterialText(const DampingReport& report, const std::string& source);

struct FitDampingOptions {
  std::string csv_path;
  std::string plot_path;      // page of the plot, ….html; not drawn when empty
  std::string material_path;  // material profile; not written when empty
  std::string bur_axis;       // "x,y,z" in the frame of the positions; empty: not known
};
// Program entry: reads the file (at most 256 MiB), prints the table, writes the chosen files. Exit
// code: 0 at least one tissue fitted, 1 otherwise (reason on stderr).
int RunFitDamping(const FitDampingOptions& options);

}  // namespace enamel::station::lab
