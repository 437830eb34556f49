#pragma once

#include <cstdio>
#include <cstdlib>

// CHECK is for bugs in our own code: always on, aborts with the place. Anything that depends on
// input, a peer, a file or a learner returns a Status instead (result.h).
#define ENAMEL_CHECK(condition)                                                          \
  do {                                                                                   \
    if (!(condition)) {                                                                  \
      std::fprintf(stderr, "%s:%d: CHECK failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                      \
    }                                                                                    \
  } while (false)

#ifdef NDEBUG
#define ENAMEL_DCHECK(condition) \
  do {                           \
  } while (false)
#else
#define ENAMEL_DCHECK(condition) ENAMEL_CHECK(condition)
#endif

// Marks every function reachable from the haptic tick: no allocation, lock, log, throw, clock read
// or unbounded loop inside. Checked by AllocationGuard tests and, on Clang >= 20, by the compiler.
#if defined(__clang__) && __clang_major__ >= 20
#define ENAMEL_REALTIME [[clang::nonblocking]]
#else
#define ENAMEL_REALTIME
#endif
