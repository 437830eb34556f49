#include "server/auth/throttle.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "server/auth/address_block.h"

namespace enamel::server::auth {
namespace {

constexpr int64_t kForgetMs = 15 * 60 * 1000;
constexpr int64_t kForgetKnownMs = int64_t{30} * 24 * 60 * 60 * 1000;
constexpr int64_t kFirstDelayMs = 500;
constexpr int64_t kTryEveryMs = 250;
constexpr uint32_t kPlaceFree = 30;
constexpr uint32_t kFirstTries = 100;
constexpr uint32_t kForgivenBySuccess = 2;
constexpr size_t kMaxCounters = 20'000;

constexpr std::string_view kField = "throttled";
constexpr std::string_view kWords = "too many failed sign-ins; try again in ";

std::string AtPlace(const std::string& place) { return "b|" + place; }
std::string LoginAtPlace(const std::string& login, const std::string& place) {
  return "lb|" + login + "|" + place;
}
std::string LoginAnywhere(const std::string& login) { return "l|" + login; }

// Logins are attacker's text: bounded before they become keys.
std::string Bounded(const std::string& login) { return login.substr(0, 64); }

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

Throttle::Counter* Throttle::Find(const std::string& key, UnixMs now_ms) {
  auto at = counters_.find(key);
  if (at == counters_.end() || now_ms - at->second.last_ms > kForgetMs) return nullptr;
  return &at->second;
}

int64_t Throttle::WaitMs(const std::string& key, const Rule& rule, UnixMs now_ms) {
  const Counter* counter = Find(key, now_ms);
  if (counter == nullptr || counter->failures <= rule.free) return 0;
  // 20 doublings are beyond every rule's longest wait; more would overflow.
  uint32_t doublings = std::min<uint32_t>(counter->failures - rule.free - 1, 20);
  int64_t delay = std::min(kFirstDelayMs << doublings, rule.max_ms);
  return std::max<int64_t>(0, counter->last_ms + delay - now_ms);
}

bool Throttle::IsKnown(const std::string& key, UnixMs now_ms) const {
  auto at = known_.find(key);
  return at != known_.end() && now_ms - at->second.last_ms <= kForgetKnownMs;
}

// The rules of a login anywhere and of a place.
int64_t Throttle::WaitOfStranger(const std::string& login, const std::string& place,
                                 UnixMs now_ms) {
  static constexpr Rule kLogin{20, 4'000}, kPlace{kPlaceFree, 4'000};
  int64_t anywhere = WaitMs(LoginAnywhere(login), kLogin, now_ms);
  if (Find(LoginAtPlace(login, place), now_ms) != nullptr) {
    return std::max(anywhere, WaitMs(AtPlace(place), kPlace, now_ms));
  }
  if (anywhere == 0) return 0;
  Counter& counter = counters_[LoginAnywhere(login)];
  // The owner at a new computer has not failed there yet. Such first tries are let through while a
  // login is under attack, a bounded number of them: an attacker with many addresses has them too.
  return ++counter.first_tries <= kFirstTries ? 0 : anywhere;
}

Result<int64_t> Throttle::Hold(const std::string& place, UnixMs now_ms) {
  Counter* counter = Find(AtPlace(place), now_ms);
  if (counter == nullptr || counter->failures <= kPlaceFree) return int64_t{0};
  int64_t hold = std::max<int64_t>(0, counter->next_try_ms - now_ms);
  // The queue of this place is as long as it may be; who came too late is told when to come back
  // instead of being kept.
  if (hold > kLongestHoldMs) return Throttled(hold - kLongestHoldMs);
  counter->next_try_ms = now_ms + hold + kTryEveryMs;
  return hold;
}

Result<int64_t> Throttle::Admit(const std::string& given, const std::string& address,
                                UnixMs now_ms) {
  static constexpr Rule kHere{5, 60'000}, kHereKnown{5, 4'000};
  const std::string place = AddressBlock(address), login = Bounded(given);
  const std::string here = LoginAtPlace(login, place);
  MutexLock lock(mutex_);
  const bool known = IsKnown(here, now_ms);
  int64_t wait = WaitMs(here, known ? kHereKnown : kHere, now_ms);
  if (!known && wait == 0) wait = WaitOfStranger(login, place, now_ms);
  if (wait > 0) return Throttled(wait);
  if (known) return int64_t{0};
  return Hold(place, now_ms);
}

void Throttle::Add(const std::string& key, UnixMs now_ms) {
  Counter& counter = counters_[key];
  if (now_ms - counter.last_ms > kForgetMs) counter = {};
  ++counter.failures;
  counter.last_ms = now_ms;
}

template <typename Map>
void Throttle::Forget(Map& map, int64_t after_ms, UnixMs now_ms) {
  if (map.size() <= kMaxCounters) return;
  std::erase_if(map, [&](const auto& entry) { return now_ms - entry.second.last_ms > after_ms; });
  // Under a flood of new keys nothing is old enough: then the one longest silent goes.
  while (map.size() > kMaxCounters) {
    auto oldest = std::min_element(map.begin(), map.end(), [](const auto& a, const auto& b) {
      return a.second.last_ms < b.second.last_ms;
    });
    map.erase(oldest);
  }
}

void Throttle::Failed(const std::string& given, const std::string& address, UnixMs now_ms) {
  const std::string place = AddressBlock(address), login = Bounded(given);
  MutexLock lock(mutex_);
  Add(AtPlace(place), now_ms);
  Add(LoginAtPlace(login, place), now_ms);
  Add(LoginAnywhere(login), now_ms);
  Forget(counters_, kForgetMs, now_ms);
}

void Throttle::Succeeded(const std::string& given, const std::string& address, UnixMs now_ms) {
  const std::string place = AddressBlock(address), login = Bounded(given);
  const std::string here = LoginAtPlace(login, place);
  MutexLock lock(mutex_);
  counters_.erase(here);
  counters_.erase(LoginAnywhere(login));
  auto at = counters_.find(AtPlace(place));
  auto before = known_.find(here);
  // Once in a quarter of an hour for each person: somebody with one good password cannot pay for
  // guesses at others' with it.
  bool forgives = before == known_.end() || now_ms - before->second.last_ms > kForgetMs;
  if (forgives && at != counters_.end()) {
    at->second.failures -= std::min(at->second.failures, kForgivenBySuccess);
  }
  known_[here].last_ms = forgives ? now_ms : before->second.last_ms;
  Forget(known_, kForgetKnownMs, now_ms);
}

}  // namespace enamel::server::auth
