#include "common/base/unix_time.h"

#include <atomic>
#include <limits>

namespace enamel {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;
using std::chrono::system_clock;

// The followed clock less the steady one; kNone: use the system's. One number, so that a reader
// never meets half of a change.
constexpr int64_t kNone = std::numeric_limits<int64_t>::min();
std::atomic<int64_t> before_steady_ns{kNone};

int64_t Ns(auto since) { return std::chrono::duration_cast<nanoseconds>(since).count(); }

}  // namespace

system_clock::time_point WallClock() {
  const int64_t before = before_steady_ns.load(std::memory_order_relaxed);
  if (before == kNone) return system_clock::now();
  const nanoseconds since(Ns(steady_clock::now().time_since_epoch()) + before);
  return system_clock::time_point(std::chrono::duration_cast<system_clock::duration>(since));
}

void FollowClock(system_clock::time_point at) {
  before_steady_ns.store(Ns(at.time_since_epoch()) - Ns(steady_clock::now().time_since_epoch()),
                         std::memory_order_relaxed);
}

void FollowSystemClock() { before_steady_ns.store(kNone, std::memory_order_relaxed); }

}  // namespace enamel
