#include "station/loop/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace enamel::station {
namespace {

constexpr int kPriority = 80;  // above audio and network, below the kernel's own threads

}  // namespace

RealtimeGrant RequestRealtime() {
  RealtimeGrant grant;
  sched_param param{};
  param.sched_priority = kPriority;
  int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  grant.fifo = error == 0;
  if (!grant.fifo) {
    grant.refused = std::string("real-time priority refused (") + std::strerror(error) +
                    "): allow it with 'rtprio 80' in /etc/security/limits.d";
  }
  grant.memory_locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!grant.memory_locked) {
    if (!grant.refused.empty()) grant.refused += "; ";
    grant.refused += std::string("memory lock refused (") + std::strerror(errno) +
                     "): allow it with 'memlock unlimited' there";
  }
  return grant;
}

}  // namespace enamel::station
