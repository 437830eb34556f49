#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "common/base/mutex.h"
#include "common/protocol/remark.h"
#include "server/training/types.h"

namespace enamel::server {

// How far a remark to the chair has come.
enum class RemarkState { kWaiting, kSent, kShown };

struct SentRemark {
  protocol::Remark remark;
  uint64_t tick = 0;  // of the attempt, when it was sent
  RemarkState state = RemarkState::kWaiting;
  UnixMs shown_ms = 0;  // when the station said so; 0: it has not
};

// What is said to the chairs while attempts are made, until their stations have shown it
// (schemas/wire/README.md, "Remarks"). In memory: what was sent is kept as an annotation elsewhere.
//
// Bounded: at most kMostWaiting remarks of an attempt wait, kMostKept are known, and
// kMostAMinute sent within a minute; of kMostAttempts attempts (the one silent longest goes first).
// Thread safety: any thread.
class RemarkBoard {
 public:
  static constexpr size_t kMostWaiting = protocol::kMaxRemarks;
  static constexpr size_t kMostKept = 50;
  static constexpr size_t kMostAMinute = 10;
  static constexpr size_t kMostAttempts = 1024;

  // Whether one more may be sent to this attempt now. Errors: kConflict (kMostWaiting are not shown
  // yet), kUnavailable with field "throttled" (kMostAMinute).
  Status Admit(const Uuid& attempt, UnixMs now_ms) const;
  // Whatever Admit says: several senders may have been admitted at once.
  SentRemark Send(const Uuid& attempt, std::string text, std::string from, uint64_t tick,
                  UnixMs now_ms);
  // Those not known to be shown, oldest first, at most kMostWaiting: they are on their way now.
  std::vector<protocol::Remark> Take(const Uuid& attempt);
  // The station has shown this one and all before it; 0: none.
  void Shown(const Uuid& attempt, uint64_t id, UnixMs now_ms);
  // The attempt is over.
  void Remove(const Uuid& attempt);
  // Oldest first.
  std::vector<SentRemark> Of(const Uuid& attempt) const;

 private:
  // Most of the time nobody says anything: then a chunk is not worth a lock that all stations share.
  std::atomic<size_t> attempts_{0};  // changed under mutex_
  mutable Mutex mutex_;
  std::map<Uuid, std::deque<SentRemark>> sent_ ENAMEL_GUARDED_BY(mutex_);  // none is empty
};

}  // namespace enamel::server
