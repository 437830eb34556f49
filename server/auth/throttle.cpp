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
constexpr uint32_t kFirstTries = 100;
constexpr uint32_t kForgivenBySuccess = 2;

constexpr std::string_view kField = "throttled";
constexpr std::string_view kWords = "too many failed sign-ins; try again in ";

OfTry<std::string> NamesOf(const std::string& given, const std::string& address) {
  const std::string place = AddressBlock(address);
  // Logins are attacker's text: bounded before they become names.
  const std::string login = given.substr(0, 64);
  const std::string login_here = login + "|" + place;
  return {"lb|" + login_here, "b|" + place, "l|" + login, "k|" + login_here};
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

// The rules of a login anywhere and of a place.
int64_t WaitOfStranger(OfTry<SignInCounter>& counters, UnixMs now_ms) {
  static constexpr Rule kLogin{20, 4'000}, kPlace{kPlaceFree, 4'000};
  const int64_t anywhere = WaitMs(counters.anywhere, kLogin, now_ms);
  if (!IsForgotten(counters.here, now_ms)) {
    return std::max(anywhere, WaitMs(counters.place, kPlace, now_ms));
  }
  // The owner at a new computer has not failed there yet. Such first tries are let through while a
  // login is under attack, a bounded number of them: an attacker with many addresses has them too.
  if (anywhere == 0 || counters.anywhere.first_tries >= kFirstTries) return anywhere;
  ++counters.anywhere.first_tries;
  return 0;
}

// How long the place's next try is held; else how long to wait.
int64_t HoldAt(SignInCounter& place, UnixMs now_ms, int64_t& hold_ms) {
  if (IsForgotten(place, now_ms) || place.failures <= kPlaceFree) return 0;
  const int64_t turn_ms = std::max<int64_t>(0, place.next_try_ms - now_ms);
  // The queue of this place is full: a late caller gets the time to come back instead of being
  // held.
  if (turn_ms > Throttle::kLongestHoldMs) return turn_ms - Throttle::kLongestHoldMs;
  hold_ms = turn_ms;
  place.next_try_ms = now_ms + turn_ms + kTryEveryMs;
  return 0;
}

int64_t WaitOf(OfTry<SignInCounter>& counters, UnixMs now_ms, int64_t& hold_ms) {
  static constexpr Rule kHere{5, 60'000}, kHereKnown{5, 4'000};
  const bool known = !IsForgotten(counters.known, now_ms);
  const int64_t here = WaitMs(counters.here, known ? kHereKnown : kHere, now_ms);
  if (known || here > 0) return here;
  const int64_t stranger = WaitOfStranger(counters, now_ms);
  return stranger > 0 ? stranger : HoldAt(counters.place, now_ms, hold_ms);
}

void Add(SignInCounter& counter, UnixMs now_ms) {
  if (IsForgotten(counter, now_ms)) counter = {};
  ++counter.failures;
  counter.last_ms = now_ms;
  counter.until_ms = now_ms + kForgetMs;
}

}  // namespace

Status Throttled(int64_t wait_ms) {
  return Status(Code::kUnavailable,
                std::string(kWords) + std::to_string((wait_ms + 999) / 1000) + " s",
                std::string(kField));
}

int64_t RetryAfterSeconds(const Status& status) {
  std::string_view text = status.message();
  int64_t seconds = 0;
  if (status.field() != kField || !text.starts_with(kWords)) return 0;
  text.remove_prefix(kWords.size());
  std::from_chars(text.data(), text.data() + text.size(), seconds);
  return seconds;
}

Result<int64_t> Throttle::Admit(const std::string& given, const std::string& address,
                                UnixMs now_ms) {
  int64_t wait_ms = 0, hold_ms = 0;
  ENAMEL_RETURN_IF_ERROR(
      counters_->Apply(NamesOf(given, address), now_ms, [&](OfTry<SignInCounter>& counters) {
        hold_ms = 0;
        wait_ms = WaitOf(counters, now_ms, hold_ms);
      }));
  if (wait_ms > 0) return Throttled(wait_ms);
  return hold_ms;
}

Status Throttle::Failed(const std::string& given, const std::string& address, UnixMs now_ms) {
  return counters_->Apply(NamesOf(given, address), now_ms, [&](OfTry<SignInCounter>& counters) {
    Add(counters.place, now_ms);
    Add(counters.here, now_ms);
    Add(counters.anywhere, now_ms);
  });
}

Status Throttle::Succeeded(const std::string& given, const std::string& address, UnixMs now_ms) {
  return counters_->Apply(NamesOf(given, address), now_ms, [&](OfTry<SignInCounter>& counters) {
    SignInCounter& known = counters.known;
    counters.here = counters.anywhere = {};
    // Once in a quarter of an hour for each person: somebody with one good password cannot pay for
    // guesses at others' with it.
    if (known.until_ms != 0 && now_ms - known.last_ms <= kForgetMs) return;
    uint32_t& failures = counters.place.failures;
    failures -= std::min(failures, kForgivenBySuccess);
    known.last_ms = now_ms;
    known.until_ms = now_ms + kForgetKnownMs;
  });
}

}  // namespace enamel::server::auth
