#pragma once

#include <cstdint>
#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

// `enamel-station replay`: re-runs the core on an exported recording and compares every tick's
// witness. The volume comes from the station's cache or from a file.
struct ReplayOptions {
  std::filesystem::path data, trace, volume, json;
  std::filesystem::path surface;  // PLY of the tooth at the moment reached; empty: none
  uint64_t to_tick = UINT64_MAX;  // ticks stepped; UINT64_MAX: all, re-run from the first
  bool keyframes = true;          // use and keep TRACE.keyframes (schemas/trace_format.md)
};
// Without to_tick it verifies every tick and the seal. With to_tick it starts at the keyframe
// before. Prints what it found. Errors: kConflict if the recording disagrees with the core, its
// chain or its seal; those of the trace's and the volume's readers.
Status ReplayTrace(const ReplayOptions& options);

}  // namespace enamel::station
