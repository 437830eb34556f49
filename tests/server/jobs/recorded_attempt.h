#pragma once

#include <functional>
#include <vector>

#include "common/scene/types.h"
#include "common/trace/trace.h"

// A small class I exercise on a soft practice block, and recorded attempts at it made by stepping
// the core along a path, signed and sealed like a station's.
namespace enamel::test {

struct PathOptions {
  double mesial_extra_mm = 0;  // how much farther out the mesial wall is cut
  double pace = 1;             // of every stroke
  uint32_t gap_ticks = 0;      // lost in the middle
  bool late = false;           // marks some ticks late
  size_t bur = 0;              // that is taken after 0.15 s, in the air
  uint64_t wander =
      0;  // not 0: strokes, pauses, gaps, late ticks and suspensions at random, of this seed
};

struct Recording {
  Bytes header;
  std::vector<Bytes> chunks;
  trace::Seal seal;
};

// The documents that a store must hold before an attempt, and a station's recording of one; built
// once.
class World {
 public:
  static const World& Get();
  // At another rate of 1 to 8 kHz, with the coupling of 1 kHz.
  World(int32_t rate_hz, int32_t damping_mn_s_per_mm, haptics::LawKind law);
  // An attempt of this id, recorded at the station of this id.
  Recording Record(const Uuid& attempt, const Uuid& station, const PathOptions& path = {}) const;
  // Signs the (changed) ticks of a chunk again, with the head it had.
  Bytes Resign(ByteView chunk, const std::function<void(trace::Tick&)>& change) const;

  scene::Scene scene;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  cutting::Volume volume;
  Bytes volume_blob;
  core::CoreParams params;
  trace::KeyPair station_key = trace::NewKeyPair();
};

}  // namespace enamel::test
