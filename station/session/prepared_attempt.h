#pragma once

#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "common/trace/trace.h"

namespace enamel::station {

// Everything an attempt needs before its first tick: documents fetched, checked against each other,
// and compiled. Its ticket is empty until Workplace::TakeTicket.
struct PreparedAttempt {
  Sha256 exercise_hash, profile_hash;  // content addresses of the documents
  scene::Scene scene;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  cutting::Volume volume;  // the tooth before the first cut
  trace::Header header;

  const Uuid& attempt() const { return header.ticket.attempt; }
  double voxel_m() const { return volume.spec().voxel_m(); }
};

}  // namespace enamel::station
