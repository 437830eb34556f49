#include "station/loop/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace enamel::station {
namespace {

constexpr int kPriority = 80;  // above audio and network, below the kernel's own threads

// The package installs the file; the units have the limits themselves.
constexpr char kAllowed[] =
    "/etc/security/limits.d/60-enamel.conf allows it to the group enamel-station: add the user to "
    "that group and sign in again; a systemd unit needs ";

void Add(std::string& text, const std::string& sentence) {
  if (!text.empty()) text += "; ";
  text += sentence;
}

bool LockMemory() {
  // With a limit, pages allocated later could not be locked and the allocation would fail.
  rlimit limit{};
  if (::geteuid() != 0 &&
      (::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY)) {
    errno = EPERM;
    return false;
  }
  return ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

int Pin(int cpu) {
  // CPU_SET writes beyond the set otherwise.
  if (cpu >= CPU_SETSIZE) return EINVAL;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu, &set);
  return ::pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

}  // namespace

RealtimeGrant RequestRealtime(const RealtimeRequest& request) {
  RealtimeGrant grant;
  sched_param param{};
  param.sched_priority = kPriority;
  // Only for the calling thread: drawing at this priority would delay the tick.
  int error = ::pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  grant.fifo = error == 0;
  if (!grant.fifo) {
    Add(grant.refused, std::string("real-time priority refused (") + std::strerror(error) +
                           "): other programs can make ticks late. " + kAllowed + "LimitRTPRIO=80");
  }
  grant.memory_locked = LockMemory();
  if (!grant.memory_locked) {
    Add(grant.refused, std::string("memory lock refused (") + std::strerror(errno) +
                           "): a swapped-out page can make a tick late. " + kAllowed +
                           "LimitMEMLOCK=infinity");
  }
  if (request.cpu >= 0) {
    error = Pin(request.cpu);
    grant.pinned = error == 0;
    if (!grant.pinned) {
      Add(grant.refused, "processor " + std::to_string(request.cpu) + " refused (" +
                             std::strerror(error) + "): name one this process may run on");
    }
  }
  return grant;
}

}  // namespace enamel::station
