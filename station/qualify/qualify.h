#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

// Qualification of device profiles, force laws, estimators and loop rates: what a user runs to see
// error against run time and stability on stiff and extreme cases. Prints tables, writes JSON rows
// and one self-contained HTML report with SVG plots.
namespace enamel::station::qualify {

struct QualifyOptions {
  std::string profile = "phantom_desktop";  // of QualifyProfiles, a file, or "all"
  std::vector<std::string> suites = {
      "all"};  // paper | hand | map | strokes | rates | laws | estimators | extreme | adversary | random | cutting | all
  bool quick = false;      // under a minute on two cores; still B = 6.5 at 1 kHz
  std::string json_path;   // rows are written here when not empty
  std::string report_dir;  // report.html and its plots are written here when not empty
  std::string recordings = "../shared/data/motion";  // hand: CSV files of people's motions
  int cases = 600;                                   // random
  int64_t adversary_ticks = 0;                       // 0: 1e9, or 2e6 with quick
  uint64_t seed = 1;
  int threads = 2;
  std::FILE* out = nullptr;                        // tables; nullptr: nothing printed
  std::FILE* progress = nullptr;                   // one line, rewritten
  std::function<void(const std::string&)> errors;  // told why nothing was done; may be empty
};

// Runs the suites asked for. Returns a program's exit code: 0 done and no proved case violated, 1
// the options are wrong or a file cannot be written (said on errors), 2 a case that is proved
// passive was not. Blocks for minutes; uses `threads` threads. Deterministic but for ns_per_tick
// and pareto.
int RunQualify(const QualifyOptions& options);

}  // namespace enamel::station::qualify
