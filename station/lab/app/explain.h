#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"

namespace enamel::station::lab {

struct ExplainCommand {
  std::string scene = "builtin:molar";  // or a folder written by import
  std::string exercise;                 // name or its kind ("class-1"); empty: the scene's first
  std::string profile = "phantom_desktop";
  int voxel_um = 50;                    // of a built-in scene
  int memory_mb = 2147;                 // a built-in scene may take
  bool window = false, replay = false;  // purpose of the attempt
  std::optional<double> budget_us;      // of a tick
  std::filesystem::path json;
};

// Prints every part of an attempt's plan: kept or left out, why, and what it costs or saves on this
// machine, measured now: with it and without it take turns, and a difference as small as the plan's from
// itself is called noise. Then how far off the bur's force is at this voxel
// (common/cutting/voxel_limit.h). With a budget also: the voxel size, law and rate that fit it and
// are felt best, for practice, from the joint front of suites/joint_front.h measured now, why, and what the next halving
// costs and buys; for a graded exercise, whether this machine can
// run its fixed settings. Errors: those of the scene; kUnavailable when a graded exercise does not
// fit, or nothing does; kInvalidInput ("voxel_um") when a graded exercise's voxel is too coarse for its bur.
Status ExplainScene(const ExplainCommand& options);

}  // namespace enamel::station::lab
