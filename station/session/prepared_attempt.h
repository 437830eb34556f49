#pragma once

#include <memory>
#include <optional>

#include "common/core/core.h"
#include "common/cutting/volume.h"
#include "common/scene/delay.h"
#include "common/scene/types.h"
#include "common/trace/trace.h"
#include "station/devices/device.h"
#include "station/spool/spool.h"

namespace enamel::station {

// Everything an attempt needs before its first tick: documents fetched, checked against each other,
// and compiled. The ticket is empty until Workplace::TakeTicket; a resumed attempt has its own.
struct PreparedAttempt {
  Sha256 exercise_hash, profile_hash;  // content addresses of the documents
  Uuid assignment;                     // for the ticket's request; zero: none
  scene::Scene scene;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  cutting::Volume volume;  // the tooth before the first cut
  trace::Header header;
  HandsAllowed hands = HandsAllowed::kAny;  // as far as the ticket gives them
  // The ticket's. The start of a resumed attempt is signed already.
  ChairTerms terms;
  protocol::AttemptFacts
      facts;  // as it will be begun; one that is resumed has its own in the spool
  // For an attempt resumed after a crash: the core at the end of the spool's chunks, with the tooth
  // in that state; otherwise null.
  std::unique_ptr<core::Core> core;
  trace::ChainState place;     // end of the chain of its chunks
  uint32_t gap_ticks = 0;      // that passed since without being recorded; as of Begin
  bool clock_stepped = false;  // this computer's clock was changed since: gap_ticks is a minimum
  // The delay assumed for an attached device (UseDelayOf); none: the profile's, by construction.
  std::optional<scene::DelayUsed> delay;
  // Held from before the ticket's request until the attempt begins (Workplace::MakeReady).
  std::optional<RecordingLock> lock;

  const Uuid& attempt() const { return header.ticket.attempt; }
  double voxel_m() const { return volume.spec().voxel_m(); }
};

// Writes the device that holds the tool into the header; call before the ticket's request, which
// contains it. Errors: kForbidden when a ticket taken in advance does not admit it (only the server
// knows a school's list of devices), kConflict when a resumed attempt was begun with another kind.
Status UseHandOf(PreparedAttempt& prepared, const Device& device);

}  // namespace enamel::station
