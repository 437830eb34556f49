#pragma once

#include <cstdint>
#include <string>

#include "common/cutting/bur.h"

// Whether a voxel is fine enough for a bur: how far off the force of a cut is, computed for this bur and this voxel.
namespace enamel::station::lab {

// RMS over grids that lie differently of the force's error in a groove, a share of B v of the front
// (cutting_error.h). Takes a second or less. Deterministic.
double VoxelForceError(const cutting::Bur& bur, int32_t voxel_nm);

// Beyond it graded work is refused, and practice warned: a person tells 7 % of force apart (fidelity/feel.h), and a
// grade must not hang on the grid.
inline constexpr double kMostVoxelForceError = 0.10;

enum class VoxelVerdict { kFine, kWarned, kRefused };
VoxelVerdict JudgeVoxel(double force_error, bool graded);
const char* VoxelVerdictName(VoxelVerdict verdict);  // "fine", "warned", "refused"
// "voxels of 200 um are too coarse for a sphere r 0.5 mm: its force is off by 51 %, and graded work may be off by 10 %
// at most. Use voxels of 100 um or less." `finer_nm`: a voxel that does, 0 when none is known.
std::string VoxelText(const cutting::Bur& bur, int32_t voxel_nm, double force_error, bool graded,
                      int32_t finer_nm);
// The largest of half of the voxel, a quarter and so on, to 25 um, that is fine for the bur; 0: none.
int32_t FinerVoxel_nm(const cutting::Bur& bur, int32_t voxel_nm);

}  // namespace enamel::station::lab
