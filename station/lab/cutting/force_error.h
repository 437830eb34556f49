#pragma once

#include <cstdint>

#include "common/cutting/bur.h"

namespace enamel::station::lab {

// RMS over ways to travel of the force's error in a groove, a share of B v of the front (cutting_error.h):
// what common/cutting/voxel_limit.h bounds. Takes a second or less. Deterministic.
double MeasureForceError(const cutting::Bur& bur, int32_t voxel_nm);

}  // namespace enamel::station::lab
