#include "server/auth/throttle.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

namespace enamel::server::auth {
namespace {

constexpr int64_t kForgetMs = 15 * 60 * 1000;
constexpr int64_t kFirstDelayMs = 500;
constexpr size_t kMaxCounters = 20'000;

std::string FromBlock(const std::string& block) { return "b|" + block; }
std::string LoginFromBlock(const std::string& login, const std::string& block) {
  return "lb|" + login + "|" + block;
}
std::string LoginAnywhere(const std::string& login) { return "l|" + login; }

// Logins are attacker's text: bounded before they become keys.
std::string Bounded(const std::string& login) { return login.substr(0, 64); }

}  // namespace

std::string AddressBlock(const std::string& address) {
  in_addr v4{};
  if (inet_pton(AF_INET, address.c_str(), &v4) == 1) {
    return address.substr(0, address.rfind('.')) + ".0/24";
  }
  in6_addr v6{};
  if (inet_pton(AF_INET6, address.c_str(), &v6) == 1) {
    std::fill(std::begin(v6.s6_addr) + 8, std::end(v6.s6_addr), uint8_t{0});
    std::array<char, INET6_ADDRSTRLEN> text{};
    inet_ntop(AF_INET6, &v6, text.data(), text.size());
    return std::string(text.data()) + "/64";
  }
  return address.substr(0, 64);
}

int64_t Throttle::WaitMs(const Counter& counter, const Rule& rule, UnixMs now_ms) {
  if (counter.failures <= rule.free || now_ms - counter.last_ms > kForgetMs) return 0;
  uint32_t doublings = std::min<uint32_t>(counter.failures - rule.free - 1, 20);
  int64_t delay = std::min(kFirstDelayMs << doublings, rule.max_ms);
  return std::max<int64_t>(0, counter.last_ms + delay - now_ms);
}

Status Throttle::Check(const std::string& login, const std::string& address, UnixMs now_ms) {
  static constexpr Rule kBlock{30, 60'000}, kLoginBlock{5, 60'000}, kLogin{20, 4'000};
  std::string block = AddressBlock(address);
  std::lock_guard lock(mutex_);
  int64_t wait = 0;
  auto consider = [&](const std::string& key, const Rule& rule) {
    auto at = counters_.find(key);
    if (at != counters_.end()) wait = std::max(wait, WaitMs(at->second, rule, now_ms));
  };
  consider(FromBlock(block), kBlock);
  consider(LoginFromBlock(Bounded(login), block), kLoginBlock);
  consider(LoginAnywhere(Bounded(login)), kLogin);
  if (wait == 0) return Status::Ok();
  return Status(
      Code::kUnavailable,
      "too many failed sign-ins; try again in " + std::to_string((wait + 999) / 1000) + " s",
      "throttled");
}

void Throttle::Add(const std::string& key, UnixMs now_ms) {
  Counter& counter = counters_[key];
  if (now_ms - counter.last_ms > kForgetMs) counter.failures = 0;
  ++counter.failures;
  counter.last_ms = now_ms;
}

void Throttle::Forget(UnixMs now_ms) {
  std::erase_if(counters_,
                [&](const auto& entry) { return now_ms - entry.second.last_ms > kForgetMs; });
  while (counters_.size() > kMaxCounters) {
    auto oldest = std::min_element(
        counters_.begin(), counters_.end(),
        [](const auto& a, const auto& b) { return a.second.last_ms < b.second.last_ms; });
    counters_.erase(oldest);
  }
}

void Throttle::Failed(const std::string& login, const std::string& address, UnixMs now_ms) {
  std::string block = AddressBlock(address);
  std::lock_guard lock(mutex_);
  Add(FromBlock(block), now_ms);
  Add(LoginFromBlock(Bounded(login), block), now_ms);
  Add(LoginAnywhere(Bounded(login)), now_ms);
  if (counters_.size() > kMaxCounters) Forget(now_ms);
}

void Throttle::Succeeded(const std::string& login, const std::string& address) {
  std::lock_guard lock(mutex_);
  counters_.erase(LoginFromBlock(Bounded(login), AddressBlock(address)));
  counters_.erase(LoginAnywhere(Bounded(login)));
}

}  // namespace enamel::server::auth
