#include "server/auth/throttle.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "server/auth/address_block.h"

namespace enamel::server::auth {
namespace {

constexpr int64_t kClockSlackMs = 60 * 1000;
constexpr int64_t kForgetMs = 15 * 60 * 1000;
constexpr int64_t kForgetKnownMs = int64_t{30} * 24 * 60 * 60 * 1000;
constexpr int64_t kFirstDelayMs = 500;
constexpr int64_t kTryEveryMs = 250;
constexpr uint32_t kPlaceFree = 30;
constexpr uint32_t kSiteFree = 4 * kPlaceFree;
// At a place: somebody who mistypes once is still let in at once.
constexpr uint32_t kFirstTriesHere = 2;
constexpr int64_t kFirstTryEveryMs = 500;
// Where more have failed lately, somebody probably guesses.
constexpr uint32_t kHardlyAFailure = 1;
constexpr uint32_t kForgivenBySuccess = 2;

OfTry<std::string> NamesOf(const std::string& given, const Origin& origin) {
  const std::string block = AddressBlock(origin.address), site = AddressSite(origin.address);
  const bool by_address = origin.party.empty();
  // No address block begins so.
  const std::string place = by_address ? block : "=" + origin.party;
  // Logins are attacker's text: bounded before they become names.
  const std::string login = given.substr(0, 64);
  return {"lb|" + login + "|" + place, "b|" + place, by_address && site != block ? "s|" + site : "",
          "l|" + login, "k|" + login + "|" + (origin.known ? block : place)};
}

struct Rule {
  uint32_t free;   // failures before any delay
  int64_t max_ms;  // longest delay
};

// Also counters of a later time than now: a clock that was set back must keep nobody out.
bool IsForgotten(const SignInCounter& counter, UnixMs now_ms) {
  return counter.until_ms == 0 || now_ms > counter.until_ms ||
         counter.last_ms > now_ms + kClockSlackMs;
}

int64_t WaitMs(const SignInCounter& counter, const Rule& rule, UnixMs now_ms) {
  if (IsForgotten(counter, now_ms) || counter.failures <= rule.free) return 0;
  // 20 doublings are beyond every rule's longest wait; more would overflow.
  uint32_t doublings = std::min<uint32_t>(counter.failures - rule.free - 1, 20);
  int64_t delay = std::min(kFirstDelayMs << doublings, rule.max_ms);
  return std::max<int64_t>(0, counter.last_ms + delay - now_ms);
}

// How long to wait for a turn of `counter`; none: the try is held until its turn.
int64_t HoldFor(SignInCounter& counter, int64_t every_ms, UnixMs now_ms, Admission& admission) {
  const int64_t turn_ms = std::max<int64_t>(0, counter.next_try_ms - now_ms);
  // The queue is full: a late caller gets the time to come back instead of being held.
  if (turn_ms > Throttle::kLongestHoldMs) return turn_ms - Throttle::kLongestHoldMs;
  admission.hold_ms = std::max(admission.hold_ms, turn_ms);
  counter.next_try_ms = now_ms + turn_ms + every_ms;
  return 0;
}

// The rule of a place, or of a site.
int64_t WaitAt(SignInCounter& place, const Rule& rule, bool failed_here, UnixMs now_ms,
               Admission& admission) {
  if (IsForgotten(place, now_ms) || place.failures <= rule.free) return 0;
  const int64_t wait_ms = failed_here ? WaitMs(place, rule, now_ms) : 0;
  return wait_ms > 0 ? wait_ms : HoldFor(place, kTryEveryMs, now_ms, admission);
}

// The rule of a login anywhere. The owner at a new computer has hardly tried there yet. Such tries
// have turns of their own, a bounded number of them: an attacker with many addresses has them too.
int64_t WaitAnywhere(OfTry<SignInCounter>& counters, UnixMs now_ms, Admission& admission) {
  static constexpr Rule kLogin{20, 4'000};
  const int64_t wait_ms = WaitMs(counters.anywhere, kLogin, now_ms);
  if (wait_ms == 0) return 0;
  SignInCounter& here = counters.here;
  if (IsForgotten(here, now_ms)) here = {};
  if (std::max(here.first_tries, here.failures) >= kFirstTriesHere) return wait_ms;
  // Also if this one is refused: whoever comes again and again from many places would otherwise
  // take each turn that there is.
  ++here.first_tries;
  here.last_ms = now_ms;
  here.until_ms = now_ms + kForgetMs;
  return HoldFor(counters.anywhere, kFirstTryEveryMs, now_ms, admission);
}

bool HasMoreFailures(const SignInCounter& counter, uint32_t than, UnixMs now_ms) {
  return !IsForgotten(counter, now_ms) && counter.failures > than;
}

int64_t WaitOf(OfTry<SignInCounter>& counters, bool known, UnixMs now_ms, Admission& admission) {
  static constexpr Rule kHere{5, 60'000}, kHereKnown{5, 4'000};
  static constexpr Rule kPlace{kPlaceFree, 4'000}, kSite{kSiteFree, 4'000};
  known = known || !IsForgotten(counters.known, now_ms);
  const int64_t here = WaitMs(counters.here, known ? kHereKnown : kHere, now_ms);
  if (known || here > 0) {
    admission.line = Line::kFirst;
    return here;
  }
  if (HasMoreFailures(counters.place, kHardlyAFailure, now_ms) ||
      HasMoreFailures(counters.site, kPlaceFree, now_ms)) {
    admission.line = Line::kLast;
  }
  const bool failed_here = HasMoreFailures(counters.here, 0, now_ms);
  // The login's turns come last: who is refused at its place takes none.
  int64_t wait_ms = WaitAt(counters.place, kPlace, failed_here, now_ms, admission);
  if (wait_ms == 0) wait_ms = WaitAt(counters.site, kSite, failed_here, now_ms, admission);
  return wait_ms > 0 ? wait_ms : WaitAnywhere(counters, now_ms, admission);
}

void Add(SignInCounter& counter, UnixMs now_ms) {
  if (IsForgotten(counter, now_ms)) counter = {};
  ++counter.failures;
  counter.last_ms = now_ms;
  counter.until_ms = now_ms + kForgetMs;
}

}  // namespace

Status Throttled(int64_t wait_ms) {
  const auto seconds = static_cast<int32_t>((wait_ms + 999) / 1000);
  return Status(Code::kUnavailable,
                "too many failed sign-ins; try again in " + std::to_string(seconds) + " s",
                "throttled")
      .RetryAfter(seconds);
}

Result<Admission> Throttle::Admit(const std::string& given, const Origin& origin, UnixMs now_ms) {
  int64_t wait_ms = 0;
  Admission admission;
  ENAMEL_RETURN_IF_ERROR(
      counters_->Apply(NamesOf(given, origin), now_ms, [&](OfTry<SignInCounter>& counters) {
        admission = {};
        wait_ms = WaitOf(counters, origin.known, now_ms, admission);
      }));
  if (wait_ms > 0) return Throttled(wait_ms);
  return admission;
}

Status Throttle::Failed(const std::string& given, const Origin& origin, UnixMs now_ms) {
  return counters_->Apply(NamesOf(given, origin), now_ms, [&](OfTry<SignInCounter>& counters) {
    for (SignInCounter* counter :
         {&counters.place, &counters.site, &counters.here, &counters.anywhere}) {
      Add(*counter, now_ms);
    }
  });
}

Status Throttle::Succeeded(const std::string& given, const Origin& origin, UnixMs now_ms) {
  return counters_->Apply(NamesOf(given, origin), now_ms, [&](OfTry<SignInCounter>& counters) {
    SignInCounter& known = counters.known;
    // Failures elsewhere stay: a success would open the login to as many guesses again.
    counters.here = {};
    // Once in a quarter of an hour for each person: somebody with one good password cannot pay for
    // guesses at others' with it.
    if (known.until_ms != 0 && now_ms - known.last_ms <= kForgetMs) return;
    for (SignInCounter* counter : {&counters.place, &counters.site}) {
      counter->failures -= std::min(counter->failures, kForgivenBySuccess);
    }
    known.last_ms = now_ms;
    known.until_ms = now_ms + kForgetKnownMs;
  });
}

}  // namespace enamel::server::auth
