#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <set>
#include <vector>

#include "common/base/mutex.h"
#include "common/protocol/remark.h"
#include "server/training/types.h"

namespace enamel::server {

// Remarks to the chairs of attempts in progress, until their stations have shown them
// (schemas/wire/README.md, "Remarks"). In memory; BoardKeeper keeps it in step with the store.
//
// Bounded: at most kMaxWaiting remarks of an attempt wait, kMaxKept are known, and kMaxAMinute
// sent within a minute; of kMaxAttempts attempts (the one silent longest is dropped first). Thread
// safety: any thread.
class RemarkBoard {
 public:
  static constexpr size_t kMaxWaiting = protocol::kMaxRemarks;
  static constexpr size_t kMaxKept = 50;
  static constexpr size_t kMaxAMinute = 10;
  static constexpr size_t kMaxAttempts = 1024;

  // Whether one more may be sent to this attempt now. Errors: kConflict (kMaxWaiting are not shown
  // yet), kUnavailable with field "throttled" (kMaxAMinute).
  Status Admit(const Uuid& attempt, UnixMs now_ms) const;
  // Takes the store's row, unless this board's has come further. Ignores Admit's limits: several
  // senders may have been admitted at once.
  void Put(const ChairRemark& remark);
  // Those not known to be shown, oldest first, at most kMaxWaiting: they are on their way now.
  std::vector<protocol::Remark> Take(const Uuid& attempt);
  // The station has shown this one and all before it; 0: none.
  void Shown(const Uuid& attempt, uint64_t id, UnixMs now_ms);
  // The attempt is over.
  void Remove(const Uuid& attempt);
  // Oldest first.
  std::vector<ChairRemark> Of(const Uuid& attempt) const;
  // Those that have come further than the store has them.
  std::vector<ChairRemark> Moved() const;
  // The store has these now.
  void Stored(const std::vector<ChairRemark>& moved);
  // Removes the attempts that are not among these and to which nothing was said since then.
  void KeepOnly(const std::set<Uuid>& attempts, UnixMs since_ms);

 private:
  struct Known {
    ChairRemark remark;
    RemarkState stored = RemarkState::kWaiting;
  };

  // Most of the time nobody says anything: then a chunk is not worth a lock that all stations
  // share.
  std::atomic<size_t> attempts_{0};  // changed under mutex_
  mutable Mutex mutex_;
  std::map<Uuid, std::deque<Known>> sent_ ENAMEL_GUARDED_BY(mutex_);  // none is empty; by id
};

}  // namespace enamel::server
