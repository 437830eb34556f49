#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>

// Counts the current thread's allocations while a guard is alive, to prove that a real-time
// function makes none. Include in exactly one file of a test program: it replaces global operator
// new.
namespace enamel::testing_support {

inline thread_local bool counting = false;
inline thread_local size_t allocations = 0;

class AllocationGuard {
 public:
  AllocationGuard() {
    allocations = 0;
    counting = true;
  }
  ~AllocationGuard() { counting = false; }
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;
  size_t count() const { return allocations; }
};

inline void* CountedAllocate(size_t size, size_t alignment) {
  if (counting) ++allocations;
  void* out = nullptr;
  if (alignment <= alignof(std::max_align_t))
    out = std::malloc(size == 0 ? 1 : size);
  else
    out = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (out == nullptr) throw std::bad_alloc();
  return out;
}

}  // namespace enamel::testing_support

void* operator new(size_t size) {
  return enamel::testing_support::CountedAllocate(size, alignof(std::max_align_t));
}
void* operator new[](size_t size) {
  return enamel::testing_support::CountedAllocate(size, alignof(std::max_align_t));
}
void* operator new(size_t size, std::align_val_t a) {
  return enamel::testing_support::CountedAllocate(size, static_cast<size_t>(a));
}
void* operator new[](size_t size, std::align_val_t a) {
  return enamel::testing_support::CountedAllocate(size, static_cast<size_t>(a));
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }
void operator delete[](void* p, size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, size_t, std::align_val_t) noexcept { std::free(p); }
