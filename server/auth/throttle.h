#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "server/training/types.h"

namespace enamel::server::auth {

// Slows guessing down without locking anybody out. A *place* is an address block (AddressBlock); a
// place is *known* for a login that signed in from it within 30 days (and since the server began).
//
//   failures of        free  then                          who waits
//   a login at a place    5  0.5 s, doubled up to 60 s     that login there
//                            (known: up to 4 s)
//   a login anywhere     20  0.5 s, doubled up to 4 s      that login, but neither where it is
//                                                          known nor at a place's first try
//                                                          (100 such places)
//   a place              30  0.5 s, doubled up to 4 s      logins that failed there before
//                            a try each 0.25 s             the other logins there, held for it
//                                                          and refused beyond 2 s; not known ones
//
// So a room whose students mistype waits for nobody's mistakes but one's own, and whoever guesses
// from elsewhere cannot keep the owner out of where the owner works. A login's success takes its
// own failures away, and two of the place's (once in 15 minutes, so that nobody makes guesses free
// with an account of their own). Failures are forgotten after 15 minutes without one.
//
// What this leaves a guesser from one address, of N logins: N + some 250 tries in 15 minutes. Who
// shares an address with a guesser who keeps all its tries taken has to try again, unless it is
// known. Times are of a clock that only goes forward. Bounded: 20 000 counters and as many known
// places; the oldest go first. Thread safety: any thread.
class Throttle {
 public:
  static constexpr int64_t kLongestHoldMs = 2000;

  // How many ms to hold this try before its password is looked at, 0 to kLongestHoldMs; what was
  // promised to others counts. Errors: Throttled.
  Result<int64_t> Admit(const std::string& login, const std::string& address, UnixMs now_ms);
  void Failed(const std::string& login, const std::string& address, UnixMs now_ms);
  void Succeeded(const std::string& login, const std::string& address, UnixMs now_ms);

 private:
  struct Counter {
    uint32_t failures = 0;
    uint32_t first_tries = 0;  // of a login anywhere: places let through for being new
    UnixMs last_ms = 0;
    UnixMs next_try_ms = 0;  // of a place: when the next held try may go on
  };
  using Counters = std::unordered_map<std::string, Counter>;
  struct Rule {
    uint32_t free;   // failures before any delay
    int64_t max_ms;  // longest delay
  };
  Counter* Find(const std::string& key, UnixMs now_ms) ENAMEL_REQUIRES(mutex_);
  int64_t WaitMs(const std::string& key, const Rule& rule, UnixMs now_ms) ENAMEL_REQUIRES(mutex_);
  int64_t WaitOfStranger(const std::string& login, const std::string& place, UnixMs now_ms)
      ENAMEL_REQUIRES(mutex_);
  Result<int64_t> Hold(const std::string& place, UnixMs now_ms) ENAMEL_REQUIRES(mutex_);
  void Add(const std::string& key, UnixMs now_ms) ENAMEL_REQUIRES(mutex_);
  bool IsKnown(const std::string& key, UnixMs now_ms) const ENAMEL_REQUIRES(mutex_);
  template <typename Map>
  static void Forget(Map& map, int64_t after_ms, UnixMs now_ms);

  Mutex mutex_;
  Counters counters_ ENAMEL_GUARDED_BY(mutex_);
  // last_ms: last success
  std::unordered_map<std::string, Counter> known_ ENAMEL_GUARDED_BY(mutex_);
};

// kUnavailable, field "throttled", with the seconds to wait in the message.
Status Throttled(int64_t wait_ms);
// The seconds that Throttled said; none for any other status: 0.
int64_t RetryAfterSeconds(const Status& status);

}  // namespace enamel::server::auth
