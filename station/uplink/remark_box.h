#pragma once

#include <deque>
#include <optional>

#include "common/base/mutex.h"
#include "common/base/uuid.h"
#include "common/protocol/remark.h"

namespace enamel::station {

// Remarks to the chair of the attempt being made, between the uplink that receives them and whoever
// shows them (schemas/wire/README.md, "Remarks"). Each is given out once, by id, however often it
// comes. Bounded: kMaxRemarks wait; what comes meanwhile is sent again by the server. Thread safety:
// any thread. Real-time: never.
class RemarkBox {
 public:
  // This attempt is made from now on: what was for another is gone. The same one again (resumed):
  // nothing changes.
  void Begin(const Uuid& attempt);
  // Passed over: for another attempt, known already, without text.
  void Arrived(const Uuid& attempt, const protocol::Remark& remark);
  // The oldest that was not shown yet; stays it until Shown.
  std::optional<protocol::Remark> Next(const Uuid& attempt) const;
  // This one is before somebody's eyes.
  void Shown(const Uuid& attempt, uint64_t id);
  // The highest id that was shown; 0: none.
  uint64_t shown(const Uuid& attempt) const;

 private:
  mutable Mutex mutex_;
  Uuid attempt_ ENAMEL_GUARDED_BY(mutex_);
  std::deque<protocol::Remark> waiting_ ENAMEL_GUARDED_BY(mutex_);  // ids grow
  uint64_t newest_ ENAMEL_GUARDED_BY(mutex_) = 0;
  uint64_t shown_ ENAMEL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enamel::station
