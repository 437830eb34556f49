#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "common/base/result.h"
#include "server/auth/failure_counters.h"
#include "server/storage/store_pool.h"
#include "server/training/types.h"

namespace enamel::server::auth {

// Where a try to sign in comes from.
struct Origin {
  std::string address;
  // What nobody else can name, and then is the place whatever the address: a browser that has a
  // device token, a session, a chair. Empty: none.
  std::string party{};
  bool known = false;  // the login has signed in with the party
};

// What Throttle lets a try do.
struct Admission {
  int64_t hold_ms = 0;       // before its password is checked: 0 to kLongestHoldMs
  Line line = Line::kUsual;  // where it then waits for a hashing thread
};

// Slows guessing down without locking anybody out. A *place* is an address block (AddressBlock), or
// the party of an Origin; a *site* is an AddressSite. A place is *known* for a login that signed in
// from it within 30 days (and since the server began, where it counts in memory). A browser that
// the login signed in with is known for as long, wherever it is (device_tokens.h).
//
//   failures of        free  then                          who waits
//   a login at a place    5  0.5 s, doubled up to 60 s     that login there
//                            (known: up to 4 s)
//   a login anywhere     20  0.5 s, doubled up to 4 s      that login, but neither where it is
//                                                          known nor at a place's first two tries:
//                                                          one each 0.5 s is free, held for it and
//                                                          refused beyond 2 s
//   a place              30  0.5 s, doubled up to 4 s      logins that failed there before
//                            a try each 0.25 s             the other logins there, held for it
//                                                          and refused beyond 2 s; not known ones
//   a site              120  as of a place                 as of a place
//
// So a room whose students mistype waits for nobody's mistakes but one's own, and whoever guesses
// from elsewhere cannot keep the owner out: where the owner works, because it is known, and at a
// new place, because its first two tries do not wait for guesses that failed elsewhere. Of those who wait for
// a hashing thread, places with hardly a failure go before the others.
//
// A success takes the login's failures at that place away, and two of the place's (once in 15
// minutes, so that nobody makes guesses free with an account of their own). Failures are forgotten
// after 15 minutes without one.
//
// What this leaves a guesser of N logins in 15 minutes: from one address N + some 250 tries, from
// one site four times as many; of one login from a thousand addresses some 2 000.
// Who shares an address with a guesser who keeps all its tries taken has to try again, unless it is
// known. Servers that count in one store (SharedCounters) leave as much, however many they are.
// Times are of one clock; what is counted a minute later than now is forgotten, as by a clock that
// was set back. Thread safety: any thread. Blocks where the counters do.
class Throttle {
 public:
  static constexpr int64_t kLongestHoldMs = 2000;

  // Counts in this server's memory.
  Throttle() : Throttle(std::make_unique<MemoryCounters>()) {}
  explicit Throttle(std::unique_ptr<FailureCounters> counters) : counters_(std::move(counters)) {}

  // How this try may proceed; times promised to others count. Errors: Throttled, and those of the
  // counters.
  Result<Admission> Admit(const std::string& login, const Origin& origin, UnixMs now_ms);
  // Errors: those of the counters. A failure that was not counted must not be answered as one.
  Status Failed(const std::string& login, const Origin& origin, UnixMs now_ms);
  Status Succeeded(const std::string& login, const Origin& origin, UnixMs now_ms);

 private:
  std::unique_ptr<FailureCounters> counters_;
};

// kUnavailable, field "throttled", with the seconds to wait as retry_after_s().
Status Throttled(int64_t wait_ms);

}  // namespace enamel::server::auth
