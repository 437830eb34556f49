#pragma once

#include <optional>
#include <set>
#include <string>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/attempts/lease_owner.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

struct TimelineRow {
  Sha256 content;       // zero: not made
  bool waits = false;   // will be made, or is being made
  std::string problem;  // of the last try; empty: none failed
  bool asked = false;   // somebody wanted to see it before it was made
};

// Surface timelines (schemas/surface_timeline.md): what plays an attempt back. They follow from the
// recording alone, so nothing here writes an audit row. A scored attempt waits for its timeline;
// the timeline goes with the recording.
class TimelineRows {
 public:
  TimelineRows(Transactions& rows, Blobs& blobs, LeaseOwner& owner)
      : rows_(rows), blobs_(blobs), owner_(owner) {}

  // The attempt that waits for its timeline and that nobody else makes one of: of those that were
  // asked for the one that was asked for first, else the newest. The try is counted. After 3 tries
  // it no longer waits, until it is scored again.
  Result<std::optional<Uuid>> TakeTimeline();
  // A sign of life of the worker. One that is silent for a minute counts as dead.
  Status KeepTimeline(const Uuid& attempt);
  // Stopped before its end through no fault of its own: the try does not count.
  Status ReturnTimeline(const Uuid& attempt);
  // Made. `content`: kept with StoredBlobs::PutAttemptBlob. Errors: kConflict when the recording
  // was removed meanwhile.
  Status PutTimeline(const Uuid& attempt, const Sha256& content);
  // `again`: another try may help.
  Status FailTimeline(const Uuid& attempt, const std::string& problem, bool again);
  // Errors: kNotFound (not scored, or the recording was removed).
  Result<TimelineRow> TimelineOf(const Uuid& attempt);
  // The same for somebody who wants to see it. A worker then makes it before those that nobody
  // asked for.
  Result<TimelineRow> AskForTimeline(const Uuid& attempt);
  // The start tooth of a volume; zero: not made yet.
  Result<Sha256> StartToothOf(const Sha256& volume);
  Status PutStartTooth(const Sha256& volume, const Sha256& content);
  // Whether this is the content of a start tooth, and so nobody's.
  Result<bool> IsStartTooth(const Sha256& content);

 private:
  Transactions& rows_;
  Blobs& blobs_;
  LeaseOwner& owner_;
};

// Inside a transaction, for other rows.
//
// A scored attempt waits for its timeline, unless it has one already.
Status WaitForTimeline(Db& db, const Uuid& attempt);
// The timeline goes, its blob into `blobs`.
Status DropTimeline(Db& db, const Uuid& attempt, std::set<Sha256>& blobs);

}  // namespace enamel::server
