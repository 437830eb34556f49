#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/training/types.h"

namespace enamel::server {

// What goes on now and has to be known at all servers of a school: remarks on their way to chairs, and which
// stations are connected where.
// A part of Store (store.h), which says what holds for all parts.
class LiveStore {
 public:
  virtual ~LiveStore() = default;

  // Of the attempts that are being made: what was said at their chairs since then, oldest first
  // (JudgingStore::AddAnnotation).
  virtual Result<std::vector<ChairRemark>> ChairRemarks(UnixMs since_ms) = 0;
  // How far these have come. What is further already stays so; one that was deleted stays deleted.
  virtual Status MoveRemarks(const std::vector<ChairRemark>& moved) = 0;

  // A server that has not called KeepLinks for so long has none.
  static constexpr UnixMs kServerSilentMs = 20'000;
  // Of this server: these have come, or their `shows_remarks` is another now, and these are gone. Also with
  // nothing new, to be heard. Errors: kNotFound (it was silent for so long that others deleted what it had
  // said, and nothing is kept of this call: say all of it again with `anew`).
  virtual Status KeepLinks(const std::vector<StationLink>& come, const std::vector<Uuid>& gone,
                           bool anew) = 0;
  // Those of the other servers. A station may be connected to two for a while.
  virtual Result<std::vector<StationLink>> LinksElsewhere() = 0;
};

}  // namespace enamel::server
