#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <string>

#include "server/storage/store.h"

namespace enamel::server::auth {

// A refused caller. `why` and `what` are our words, never a peer's.
struct TurnedAway {
  std::string
      why;  // "password", "pin", "pin_locked", "disabled", "one-time", "throttled", "busy", "forbidden"
  std::string address;  // of the peer
  std::string via;      // "page" or "station"
  std::string login;    // as typed; only looked up, never kept
  Uuid person;          // when it is known already
  std::string what;     // which request, of a signed-in person's; else empty
};

// Writes refusals to the log and the audit trail: `session.refused` for sign-ins and passwords,
// `request.refused` for requests without the right to them. The object is the person, or "nobody".
// A login that names nobody is not kept: it may be a password typed into the wrong field, and a
// hash of it could be guessed like one.
//
// Rows of the audit trail are permanent, so there are few. Of one person's refusals at one address
// block for one reason within 15 minutes, the 1st, 10th, 100th, … makes a row with the count. At
// most kMaxRows are made in 15 minutes; the last of them says ("many") that only the metrics have
// the rest. That is 10 000 rows, 3 MB, a day at most. Each row is also a log line.
//
// All work happens on a thread of its own: the refused caller neither waits for the disk nor learns
// from the time whether a login exists. While kMaxWaiting wait, more are dropped. Thread safety:
// any thread. Destruction writes everything noted before.
class RefusalTrail {
 public:
  static constexpr int64_t kWindowMs = 15 * 60 * 1000;
  static constexpr size_t kMaxRows = 100;
  static constexpr size_t kMaxWaiting = 256;

  // `elapsed_ms`: a clock that only goes forward.
  RefusalTrail(Store& store, std::function<int64_t()> elapsed_ms);
  ~RefusalTrail();

  void Note(TurnedAway refused);
  // Waits until everything noted is written: for tests.
  void Settle();

 private:
  void Take(const TurnedAway& refused, int64_t now_ms);
  void Write(const TurnedAway& refused, const Uuid& person, uint64_t count);

  Store& store_;
  const std::function<int64_t()> elapsed_ms_;
  std::atomic<size_t> waiting_{0};
  // On the thread of `pool_`:
  std::map<std::string, uint64_t> counts_;  // in this window, by reason, address block and person
  int64_t window_begin_ms_ = 0;
  size_t rows_ = 0;

  boost::asio::thread_pool pool_{1};  // last: its thread uses the others
};

}  // namespace enamel::server::auth
