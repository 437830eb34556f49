#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace enamel::station::lab {

// Selects measurements and their options; app/qualify.h runs them.
struct QualifyOptions {
  std::string profile = "phantom_desktop";  // of ShippedProfiles, a file, or "all"
  std::vector<std::string> suites = {
      "all"};  // paper | hand | map | strokes | pecks | withdrawal | calibration | watch | laws | front | estimators | extreme | adversary | random | cutting | all
  bool quick = false;     // under a minute on two cores; still B = 6.5 at 1 kHz
  std::string json_path;  // rows are written here when not empty
  std::string report;     // a page (….html) or a folder, when not empty: report/draw.h
  std::string
      motion;  // hand, strokes, watch: a CSV file of a person's motion, or a folder of them; empty: generated
  std::string calibration;  // calibration: a document of `enamel-station calibrate`; empty: none
  int cases = 600;          // random
  int64_t adversary_ticks = 0;  // 0: 1e9, or 2e6 with quick
  uint64_t seed = 1;
  int threads = 2;
  std::FILE* out = nullptr;       // tables; nullptr: nothing printed
  std::FILE* progress = nullptr;  // one line, rewritten
  std::function<void(const std::string&)>
      errors;  // called with the reason if nothing was done; may be empty
};

}  // namespace enamel::station::lab
