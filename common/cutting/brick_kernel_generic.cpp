#include <cmath>

#include "common/cutting/brick_kernel.h"

namespace {

typedef float F8 __attribute__((vector_size(32)));
typedef int32_t I8 __attribute__((vector_size(32)));
typedef int16_t S8 __attribute__((vector_size(16)));
typedef int16_t S16 __attribute__((vector_size(32)));

// Root and pack lane by lane as the wide instructions do them: correctly rounded, and saturated.
inline F8 Sqrt8(F8 v) {
  for (int i = 0; i < 8; ++i) v[i] = std::sqrt(v[i]);
  return v;
}
inline S16 Pack(I8 a, I8 b) {
  S16 out = {};
  for (int i = 0; i < 16; ++i) {
    int32_t v = i < 8 ? a[i] : b[i - 8];
    out[i] = static_cast<int16_t>(v < -32768 ? -32768 : v > 32767 ? 32767 : v);
  }
  return out;
}
inline I8 PairSums(S16 v) {
  I8 out = {};
  for (int i = 0; i < 8; ++i) out[i] = int32_t{v[2 * i]} + int32_t{v[2 * i + 1]};
  return out;
}
// A comparison's lane is 0 or -1. The wide build looks at its sign, here it is the lowest bit.
inline int Mask(I8 v) {
  int out = 0;
  for (int i = 0; i < 8; ++i) out |= (v[i] & 1) << i;
  return out;
}
inline bool All(S16 v) {
  bool out = true;
  for (int i = 0; i < 16; ++i) out = out && v[i] != 0;
  return out;
}

#include "common/cutting/brick_kernel.inc"

}  // namespace

namespace enamel::cutting {

Kernels GenericKernels() noexcept { return {&Cull, &Cut}; }

}  // namespace enamel::cutting
