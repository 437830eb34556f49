#pragma once

#include <functional>

#include "common/scene/types.h"
#include "tests/support/memory_store.h"

// A small class I exercise on a soft practice block, and recorded attempts at it made by stepping
// the core along a path, signed and sealed like a station's.
namespace enamel::test {

struct PathOptions {
  double mesial_extra_mm = 0;  // how much farther out the mesial wall is cut
  double pace = 1;             // of every stroke
  uint32_t gap_ticks = 0;      // lost in the middle
  bool late = false;           // marks some ticks late
  uint64_t wander =
      0;  // not 0: strokes, pauses, gaps, late ticks and suspensions at random, of this seed
  uint32_t core_version =
      core::kCoreVersion;  // as a station of that version would have recorded it
};

// Everything the store must hold before an attempt; built once, copied into each test's store.
class World {
 public:
  static const World& Get();
  // At another rate of 1 to 8 kHz, with the coupling of 1 kHz.
  World(int32_t rate_hz, int32_t damping_mn_s_per_mm, haptics::LawKind law);
  void AddTo(MemoryStore& store) const;
  // Records an attempt and adds it, sealed, to the store.
  Uuid Record(MemoryStore& store, const PathOptions& path = {}, bool as_reference = false) const;
  // Recorded as a reference; with its row in the store.
  Uuid RecordReference(MemoryStore& store) const;
  // Signs the (changed) ticks of a chunk again, with the head it had.
  Bytes Resign(ByteView chunk, const std::function<void(trace::Tick&)>& change) const;
  void SetReference(MemoryStore& store, const Uuid& attempt) const;

  scene::Scene scene;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  cutting::Volume volume;
  core::CoreParams params;
  Uuid exercise_id = Uuid::New(), station_id = Uuid::New();
  trace::KeyPair station_key = trace::NewKeyPair();

 private:
  Bytes volume_blob_;
};

}  // namespace enamel::test
