#pragma once

#include <deque>
#include <optional>

#include "common/base/mutex.h"
#include "common/base/uuid.h"
#include "common/protocol/remark.h"

namespace enamel::station {

// Messages to the chair of the attempt being made, from the uplink that receives them to the code
// that shows them (schemas/wire/README.md, "Remarks"). Each is given out once, by id, however often
// it arrives. Bounded: kMaxRemarks wait; the server sends the rest again. Thread safety: any
// thread. Real-time: never.
class RemarkBox {
 public:
  // Sets the current attempt and discards messages for any other. The same attempt again (resumed)
  // changes nothing.
  void Begin(const Uuid& attempt);
  // Ignores messages for another attempt, known ones, and ones without text.
  void Arrived(const Uuid& attempt, const protocol::Remark& remark);
  // The oldest message not shown yet; remains it until Shown.
  std::optional<protocol::Remark> Next(const Uuid& attempt) const;
  // Somebody sees this message now.
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
