#pragma once

#include <vector>

#include "common/base/bytes.h"
#include "common/base/keep_going.h"
#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/timeline/samples.h"

// The tooth before the first tick as the page reads it: format "ENTS", version 1
// (schemas/surface_timeline.md). The same for everybody who cuts this tooth.
// Thread safety: functions, any thread. Not real-time.
namespace enamel::timeline {

struct StartTooth {
  enum BrickFlags : uint8_t { kTissue = 7, kSampled = 8, kLabelled = 16 };

  cutting::GridSpec spec;
  // Per brick: its tissue, and whether it has samples or labels of its own. One without samples is
  // solid throughout; with nothing set, air.
  std::vector<uint8_t> bricks;
  std::vector<Samples> samples;              // of the sampled ones, in order
  std::vector<cutting::BrickLabels> labels;  // of the labelled ones, in order
};

StartTooth StartToothOf(const cutting::Volume& volume);
// Equal teeth give equal bytes with one version of zlib.
// Seconds: 1.1 for a molar of 0.1 mm, 4.3 of 0.05 mm.
Bytes EncodeStartTooth(const StartTooth& tooth, const KeepGoing& keep_going = {});
// Bounded. Errors: kVersion; kInvalidInput for everything that the document does not allow.
Result<StartTooth> DecodeStartTooth(ByteView blob);

}  // namespace enamel::timeline
