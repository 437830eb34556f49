#pragma once

#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"

namespace enamel::server {

struct TimelineRow {
  Sha256 content;       // zero: not made
  bool waits = false;   // will be made, or is being made
  std::string problem;  // of the last try; empty: none failed
};

// Surface timelines (schemas/surface_timeline.md): what plays an attempt back. They follow from the
// recording alone, so nothing here writes an audit row. A scored attempt waits for its timeline;
// the timeline goes with the recording.
// A part of Store (store.h), which says what holds for all parts.
class TimelineStore {
 public:
  virtual ~TimelineStore() = default;

  // The newest attempt that waits for its timeline and that nobody else makes one of; the try is
  // counted. After 3 tries it no longer waits, until it is scored again.
  virtual Result<std::optional<Uuid>> TakeTimeline() = 0;
  // It is still being made. Who does not say so for a minute is taken for dead.
  virtual Status KeepTimeline(const Uuid& attempt) = 0;
  // Stopped before its end through no fault of its own: the try does not count.
  virtual Status ReturnTimeline(const Uuid& attempt) = 0;
  // Made. `content`: kept with BlobStore::PutAttemptBlob. Errors: kConflict when the recording was
  // removed meanwhile.
  virtual Status PutTimeline(const Uuid& attempt, const Sha256& content) = 0;
  // `again`: another try may help.
  virtual Status FailTimeline(const Uuid& attempt, const std::string& problem, bool again) = 0;
  // Errors: kNotFound (not scored, or the recording was removed).
  virtual Result<TimelineRow> TimelineOf(const Uuid& attempt) = 0;

  // The start tooth of a volume; zero: not made yet.
  virtual Result<Sha256> StartToothOf(const Sha256& volume) = 0;
  virtual Status PutStartTooth(const Sha256& volume, const Sha256& content) = 0;
  // Whether this is the content of a start tooth, and so nobody's.
  virtual Result<bool> IsStartTooth(const Sha256& content) = 0;
};

}  // namespace enamel::server
