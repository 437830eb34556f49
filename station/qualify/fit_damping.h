#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

// B of real tissue from recorded cuts: force against speed, R = B V + R0, per tissue.
namespace enamel::station::qualify {

// One tissue's fit.
struct DampingFit {
  std::string tissue;                              // "all" where the file has no tissue column
  size_t samples = 0, used = 0;                    // used: in contact and moving
  double b_n_s_per_mm = 0, b_low = 0, b_high = 0;  // 95 % interval
  double offset_n = 0;  // R0, mean: what is not proportional to speed (friction of the cut)
  double residual_rms_n = 0;
  double speed_max_mm_s = 0, force_max_n = 0;
  std::vector<std::pair<double, double>> points;  // speed mm/s, force N, one per block
  std::string refused;                            // why there is no fit; empty when there is one
};

struct DampingReport {
  double rate_hz = 0;              // median of the file's
  std::vector<std::string> notes;  // what was assumed: units, columns, rows left out
  std::vector<DampingFit> fits;
};

// Columns by name, case aside: time_s, t_s, time or t (time_ms, t_ms: milliseconds); position_mm or
// x_mm, y_mm, z_mm (or _m, or bare: metres guessed from size, and said); force_n or fx_n, fy_n,
// fz_n (or bare, N); tissue optional. Any order, any rate, gaps allowed.
//
// Method: position and force are averaged over blocks of at least 50 ms (two samples or more),
// speed is the block-to-block difference; only consecutive blocks of one tissue, in contact (force
// above 5 % of its largest, or 0.02 N) and moving (above 5 % of its highest speed). Speed and force
// are taken along the motion. Least squares with offset where speeds spread by a factor of two,
// through the origin otherwise. The interval is Student's over blocks, the residuals' lag-one
// correlation taken out of the count of independent ones.
//
// Errors (kInvalidInput): columns missing, no numbers, time that does not rise, units that cannot
// be (more than 1 m of travel, above 200 N, faster than 1 m/s): the message says what was found. A
// tissue that cannot be fitted alone (no motion, no contact, fewer than 8 blocks, force that falls
// with speed) is in the report with the reason.
Result<DampingReport> FitDamping(std::string_view csv);

std::string DampingText(const DampingReport& report);
// Force against speed with the fitted lines, SVG.
std::string DampingPlot(const DampingReport& report);

// What was fitted, as schemas/material.schema.json has it; `source` names the file. Requires: a
// tissue that could be fitted.
std::string MaterialText(const DampingReport& report, const std::string& source);

struct FitDampingOptions {
  std::string csv_path;
  std::string svg_path;       // plot; not written when empty
  std::string material_path;  // material profile; not written when empty
};
// Program entry: reads the file (at most 256 MiB), prints the table, writes what is asked for.
// Exit code: 0 at least one tissue fitted, 1 otherwise (said on stderr).
int RunFitDamping(const FitDampingOptions& options);

}  // namespace enamel::station::qualify
