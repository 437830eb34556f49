#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
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

// Finds the values. Thread safety: const.
class DeviationByCell {
 public:
  explicit DeviationByCell(const Deviation& deviation);
  // Nothing where the cell was not compared or lies outside the grid.
  std::optional<int32_t> At_um(const ivec3& cell) const;

 private:
  std::optional<uint64_t> NumberOf(const ivec3& cell) const;

  cutting::GridSpec spec_;
  std::unordered_map<uint64_t, int32_t> um_;
};

// What is known at a surface's vertices (m; NaN: nothing), by the cells that they were made in
// (surface::ExtractSurface), in whole um.
Deviation DeviationOf(const cutting::GridSpec& spec, std::span<const ivec3> cells,
                      std::span<const float> deviation_m);

// `cells`: in any order. One outside the grid is left out: the surface there is the border's. If
// several name one cell, the last counts.
Bytes EncodeDeviation(const Deviation& deviation);
// Errors: kVersion; kInvalidInput for everything that the document does not allow.
Result<Deviation> DecodeDeviation(ByteView blob);

}  // namespace enamel::timeline
