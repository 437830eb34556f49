#pragma once

#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include "tests/support/allocation_guard.h"

// Counts the current thread's actions that a tick must not make: allocations (allocation_guard.h),
// locks and waits of pthreads, reads, writes, polls and sleeps. Include in exactly one file of a
// test program, instead of allocation_guard.h: it interposes on the C library's functions. Under a
// sanitizer, which interposes on them itself, only allocations are counted.
namespace enamel::testing_support {

inline thread_local size_t blocking_calls = 0;

// The C library's own function of this name.
template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

class TickGuard {
 public:
  TickGuard() { blocking_calls = 0; }
  size_t allocations() const { return guard_.count(); }
  size_t blocking() const { return blocking_calls; }

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  static constexpr bool kSeesBlocking = false;
#else
  static constexpr bool kSeesBlocking = true;
#endif

 private:
  AllocationGuard guard_;
};

}  // namespace enamel::testing_support

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define ENAMEL_COUNTED(name, parameters, arguments, ...)                              \
  extern "C" int name parameters __VA_ARGS__ {                                        \
    static auto* const next = enamel::testing_support::Next<int parameters>(#name);   \
    if (enamel::testing_support::counting) ++enamel::testing_support::blocking_calls; \
    return next arguments;                                                            \
  }

ENAMEL_COUNTED(pthread_mutex_lock, (pthread_mutex_t * m), (m), noexcept)
ENAMEL_COUNTED(pthread_rwlock_rdlock, (pthread_rwlock_t * m), (m), noexcept)
ENAMEL_COUNTED(pthread_rwlock_wrlock, (pthread_rwlock_t * m), (m), noexcept)
ENAMEL_COUNTED(pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), (c, m))
ENAMEL_COUNTED(pthread_cond_clockwait,
               (pthread_cond_t * c, pthread_mutex_t* m, clockid_t k, const timespec* t),
               (c, m, k, t))
ENAMEL_COUNTED(poll, (pollfd * f, nfds_t n, int t), (f, n, t))
ENAMEL_COUNTED(nanosleep, (const timespec* t, timespec* left), (t, left))
ENAMEL_COUNTED(clock_nanosleep, (clockid_t k, int flags, const timespec* t, timespec* left),
               (k, flags, t, left))

#define ENAMEL_COUNTED_IO(name, parameters, arguments)                                  \
  extern "C" ssize_t name parameters {                                                  \
    static auto* const next = enamel::testing_support::Next<ssize_t parameters>(#name); \
    if (enamel::testing_support::counting) ++enamel::testing_support::blocking_calls;   \
    return next arguments;                                                              \
  }

ENAMEL_COUNTED_IO(read, (int f, void* data, size_t n), (f, data, n))
ENAMEL_COUNTED_IO(write, (int f, const void* data, size_t n), (f, data, n))
#undef ENAMEL_COUNTED
#undef ENAMEL_COUNTED_IO
#endif
