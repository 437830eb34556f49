#pragma once

#include <vector>

#include "common/core/core.h"
#include "common/cutting/volume.h"
#include "common/trace/trace.h"

// A small recording made from nothing but constants: fixed keys, ids and a scripted hand.
namespace enamel::trace::sample {

KeyPair ServerKeys();
KeyPair StationKeys();
Header MakeHeader();

// Enamel below z = 0, dentin below z = -0.4 mm, 6.4 mm wide and 3.2 mm deep, voxels of 0.1 mm.
cutting::Volume MakeBlock();

// Inputs of a hand that reaches the block, cuts into it along an oblique path with a little tremor,
// lifts, and lets go of the pedal; deterministic, integers only after the last rounding.
std::vector<core::TickInput> CutInputs(size_t ticks);

// Six ticks that use every column, with negative values, a gap, a fault and extremes.
std::vector<Tick> OddTicks();

struct Recording {
  Header header;
  std::vector<Tick> ticks;
  std::vector<Bytes> chunks;
  Seal seal;
};
// Runs a core on the inputs and records them, `per_chunk` ticks to a chunk.
Recording Record(const std::vector<core::TickInput>& inputs, size_t per_chunk);

}  // namespace enamel::trace::sample
