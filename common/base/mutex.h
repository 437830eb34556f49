#pragma once

#include <mutex>

// A mutex whose data the compiler checks: clang's -Wthread-safety refuses access to data that is
// ENAMEL_GUARDED_BY a mutex that is not held
// (https://clang.llvm.org/docs/ThreadSafetyAnalysis.html). ./check has it do so for every source
// that uses this (.ci/thread_safety). g++ ignores the words below. std::mutex itself cannot be
// used: libstdc++'s carries no annotations.
//
//    Mutex mutex_;
//    int count_ ENAMEL_GUARDED_BY(mutex_) = 0;
//    void Add() ENAMEL_REQUIRES(mutex_);  // call with mutex_ held
//    …
//    MutexLock lock(mutex_);
//
// To wait, a std::condition_variable_any takes the Mutex itself, held. Annotate the condition:
//    changed_.wait(mutex_, [this]() ENAMEL_REQUIRES(mutex_) { return count_ > 0; });
#if defined(__clang__)
#define ENAMEL_THREAD_SAFETY(attribute) __attribute__((attribute))
#else
#define ENAMEL_THREAD_SAFETY(attribute)
#endif
#define ENAMEL_GUARDED_BY(mutex) ENAMEL_THREAD_SAFETY(guarded_by(mutex))
#define ENAMEL_REQUIRES(...) ENAMEL_THREAD_SAFETY(requires_capability(__VA_ARGS__))

namespace enamel {

// Thread safety: what it is for. Not recursive.
class ENAMEL_THREAD_SAFETY(capability("mutex")) Mutex {
 public:
  // Named as std::condition_variable_any calls them; elsewhere a MutexLock does.
  void lock() ENAMEL_THREAD_SAFETY(acquire_capability()) { mutex_.lock(); }
  void unlock() ENAMEL_THREAD_SAFETY(release_capability()) { mutex_.unlock(); }

 private:
  std::mutex mutex_;
};

// Holds a Mutex as long as it lives.
class ENAMEL_THREAD_SAFETY(scoped_lockable) MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) ENAMEL_THREAD_SAFETY(acquire_capability(mutex)) : mutex_(mutex) {
    mutex_.lock();
  }
  ~MutexLock() ENAMEL_THREAD_SAFETY(release_capability()) { mutex_.unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex& mutex_;
};

}  // namespace enamel
