#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/cutting/bur.h"

// Which voxel is fine enough for which bur and for which wall. A bur is read at points three voxels apart
// (engagement.h), so that a small bur in coarse voxels has few. How the grid lies hardly matters; which way the bur
// travels does, as its points are not alike all around.
//
// Let A be the part of the surface that resists travel across the axis where half of the bur's height is in solid:
// the integral of 1 - n_z^2 over that half, all around. With voxels of h it holds N = A / (3 h)^2 points. The RMS of the
// force's error over all ways to travel is at most c / N, c by the bur's shape: evenly spread points converge like
// 1 / N. Found in cuts of 80 burs (sphere r 0.5 mm, the others 0.3 to 10 times as long as wide) with N from 6 to 40;
// tests/station/lab/cutting/voxel_limit_test.cpp cuts some of them again. Fewer points: not tried. More: below 3 %.
// Thread safety: functions, any thread. Real-time: nothing here is.
namespace enamel::cutting {

// Of the force. Beyond it graded work is refused and practice warned: a person tells 7 % of force apart
// (fidelity/feel.h), and a grade must not hang on which way a wall was cut.
inline constexpr double kMaxVoxelForceError = 0.10;

// Walls below it are not carried. A surface is where the distance changes its sign between two samples. It lies right
// if the inner one is nearer to it than to the wall's other side, and so everywhere in walls of two voxels and more. A
// wall of one voxel measures 100, 75 or 0 % of its thickness as the grid moves by quarters of a voxel, and one of half a
// voxel is left out in most places (tests/common/import/thin_walls_test.cpp).
inline constexpr double kThinnestWall_voxels = 2;

// The bound c / N, a share of the force.
double VoxelForceError(const Bur& bur, int32_t voxel_nm);
// The largest voxel that keeps it within kMaxVoxelForceError, in whole micrometres; 0: none, as a bur has no more
// than EngagementReader::kMaxPoints.
int32_t LargestVoxel_nm(const Bur& bur);

// "cylinder r 0.6 x 4 mm".
std::string BurText(const Bur& bur);
// Of a voxel that is too coarse for the bur: "voxels of 200 um are too coarse for the bur (sphere r 0.5 mm): its force
// is off by up to 38 %, and graded work may be off by 10 % at most. Use voxels of 102 um or less".
std::optional<std::string> WhyTooCoarse(const Bur& bur, int32_t voxel_nm, bool graded);

}  // namespace enamel::cutting
