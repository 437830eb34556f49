#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/base/result.h"
#include "common/core/core.h"
#include "common/scene/builtin/builtin.h"
#include "common/trace/trace.h"

namespace enamel::station::lab {

// A recorded attempt as a station would send it, made without a person: for measurements that
// depend on how long people cut and look.
struct Attempt {
  scene::BuiltScene built;
  scene::Exercise exercise;
  trace::Header header;
  std::vector<Bytes> chunks;  // of 500 ticks
  trace::Seal seal;
  double cutting_share = 0;  // of the ticks (cutting_ticks.h)
};

struct AttemptOptions {
  std::string scene = "molar";  // a built-in one
  int32_t voxel_nm = 50'000;
  uint64_t ticks = 120'000;  // at 1 kHz
  // Pause after each stroke with the bur lifted, in strokes. With 1.8 about a third of the ticks
  // cut.
  double pause_strokes = 1.8;
  // Deliberate excess: through the mesial wall, below the floor.
  double mesial_extra_m = 0, floor_extra_m = 0;
};

// A class I cavity on a built-in tooth with a Phantom Desktop: strokes along the box at 2 mm/s,
// layer by layer, reaching full depth at the end for any length. After each stroke the bur is
// lifted clear, pedal up, held with a tremor of 20 um at 9 Hz. The same options give the same bytes
// on one machine (libm is used for the tremor). `progress` (0..1) may be empty. Errors: those of
// the scene's builder and the plan's compiler.
Result<Attempt> RecordAttempt(const AttemptOptions& options,
                              const std::function<void(double)>& progress = {});

}  // namespace enamel::station::lab
