#pragma once

#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/timeline/samples.h"

// The bricks of a tooth whose triangles change in an attempt, as they are before the first tick
// (schemas/surface_timeline.md, "The part that changes"). Bounded, deterministic with one version
// of the packing library. Thread safety: functions, any thread. Not real-time.
namespace enamel::timeline {

struct Changing {
  enum Flags : uint8_t {
    kTissue = 7,
    kSampled = 8,
    kLabelled = 16,
    kTriangles = 32,  // without it a brick is there only for its neighbours' triangles
  };
  std::vector<int32_t> bricks;               // rising
  std::vector<uint8_t> flags;                // of each
  std::vector<Samples> samples;              // of the sampled ones, in order
  std::vector<cutting::BrickLabels> labels;  // of the labelled ones, in order
};

// `triangles`: per brick of the grid, whether its triangles change.
Changing ChangingOf(const cutting::Volume& initial, const std::vector<uint8_t>& triangles);
Bytes EncodeChanging(const Changing& changing);
// Errors: kInvalidInput for everything that the document does not allow.
Result<Changing> DecodeChanging(ByteView blob, const cutting::GridSpec& spec);

// Per brick of the grid, whether it or one of its 26 neighbours is set.
std::vector<uint8_t> WithNeighbours(const std::vector<uint8_t>& set, const ivec3& bricks);

}  // namespace enamel::timeline
