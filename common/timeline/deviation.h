#pragma once

#include <cstdint>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/cutting/volume.h"

// How far the surface of a tooth is from the reference's, cell by cell: format "ENTD", version 1
// (schemas/surface_timeline.md). Bounded, deterministic with one version of the packing library.
// Thread safety: functions, any thread.
namespace enamel::timeline {

// A cell has eight samples as corners and is named by the one with the least x, y and z. Surface
// nets (common/surface/surface.h) make one vertex in each that the surface passes through.
struct CellDeviation {
  ivec3 cell{0};
  int32_t deviation_um = 0;  // plus: more removed than in the reference

  bool operator==(const CellDeviation&) const = default;
};

struct Deviation {
  cutting::GridSpec spec;
  std::vector<CellDeviation> cells;  // by brick, and within a brick as its samples are
};

// `cells`: in any order. One outside the grid is left out: the surface there is the border's. If
// several name one cell, the last counts.
Bytes EncodeDeviation(const Deviation& deviation);
// Errors: kVersion; kInvalidInput for everything that the document does not allow.
Result<Deviation> DecodeDeviation(ByteView blob);

}  // namespace enamel::timeline
