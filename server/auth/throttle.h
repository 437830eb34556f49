#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>

#include "common/base/result.h"
#include "server/training/types.h"

namespace enamel::server::auth {

// Slows guessing down without locking anybody out: after some free failures each further one
// doubles the time until the next try is looked at, up to a bound. Counted per address block (IPv4
// /24, IPv6 /64), per login from that block, and (later and milder, so that a stranger cannot keep
// the owner out) per login from anywhere. Failures are forgotten after 15 minutes without one, or
// by a success. Times are of a clock that
// only goes forward. Bounded: at most 20 000 counters; the oldest go first. Thread safety: any
// thread.
class Throttle {
 public:
  // kUnavailable with field "throttled" and the seconds to wait in the message.
  Status Check(const std::string& login, const std::string& address, UnixMs now_ms);
  void Failed(const std::string& login, const std::string& address, UnixMs now_ms);
  void Succeeded(const std::string& login, const std::string& address);

 private:
  struct Counter {
    uint32_t failures = 0;
    UnixMs last_ms = 0;
  };
  struct Rule {
    uint32_t free;   // failures before any delay
    int64_t max_ms;  // longest delay
  };
  static int64_t WaitMs(const Counter& counter, const Rule& rule, UnixMs now_ms);
  void Add(const std::string& key, UnixMs now_ms);  // with mutex_ held
  void Forget(UnixMs now_ms);                       // with mutex_ held

  std::mutex mutex_;
  std::unordered_map<std::string, Counter> counters_;  // guarded by mutex_
};

// "203.0.113.7" -> "203.0.113.0/24"; "2001:db8:1:2::3" -> "2001:db8:1:2::/64"; other text as it is.
std::string AddressBlock(const std::string& address);

}  // namespace enamel::server::auth
