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
// and compiled. Its ticket is empty until Workplace::TakeTicket; one that is resumed has its own.
struct PreparedAttempt {
  Sha256 exercise_hash, profile_hash;  // content addresses of the documents
  Uuid assignment;                     // that the ticket is asked for; zero: none
  scene::Scene scene;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  cutting::Volume volume;  // the tooth before the first cut
  trace::Header header;
  HandsAllowed hands = HandsAllowed::kAny;  // that its ticket admits, as far as it says
  protocol::AttemptFacts
      facts;  // as it will be begun; one that is resumed has its own in the spool
  // Of an attempt that goes on after a crash: the core where the spool's chunks end, with the tooth
  // as it was then; otherwise null.
  std::unique_ptr<core::Core> core;
  trace::ChainState place;     // where their chain stands
  uint32_t gap_ticks = 0;      // that passed since and were not recorded; as of Begin
  bool clock_stepped = false;  // this computer's clock was changed since: at least so many
  // What an attached device's delay was taken to be (UseDelayOf); none: it is the profile's, by
  // construction.
  std::optional<scene::DelayUsed> delay;
  // Held from before its ticket was asked for until it begins (Workplace::MakeReady).
  std::optional<RecordingLock> lock;

  const Uuid& attempt() const { return header.ticket.attempt; }
  double voxel_m() const { return volume.spec().voxel_m(); }
};

// Writes into the header what holds the tool; before the ticket, which is asked for with it. Errors:
// kForbidden when a ticket taken before does not admit it (a school's list of devices is the
// server's to know), kConflict when a resumed attempt was begun with another kind.
Status UseHandOf(PreparedAttempt& prepared, const Device& device);

}  // namespace enamel::station
