#include "common/cutting/brick_kernel.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

namespace enamel::cutting {

#if defined(__x86_64__)
Kernels Avx2Kernels() noexcept;
#endif

KernelBur KernelBurOf(const Bur& bur, double voxel_m) noexcept {
  const double middle = 0.5 * bur.height_m(), inv_h = 1 / voxel_m;
  auto f = [](double v) { return static_cast<float>(v); };
  Profile profile = ProfileOf(bur);
  KernelBur out;
  // A border or height is n . p, so it moves with the origin by n's share and is divided by the
  // voxel. "No border" (-1e30, profile.cpp) stays finite in single precision down to the smallest
  // voxel.
  for (const ProfilePiece& p : profile.pieces()) {
    KernelBur::Piece& k = out.pieces[out.count++];
    double at_z = p.at[1] - middle;
    for (int i = 0; i < 2; ++i) {
      k.first[i] = f(p.first[i]);
      k.last[i] = f(p.last[i]);
      k.region[i][0] = f(p.region[i][0]);
      k.region[i][1] = f(p.region[i][1]);
      k.region[i][2] = f((p.region[i][2] - p.region[i][1] * middle) * inv_h);
    }
    k.at[0] = f(p.at[0] * inv_h);
    k.at[1] = f(at_z * inv_h);
    k.radius = f(p.radius * inv_h);
    k.height = f((p.first[0] * p.at[0] + p.first[1] * at_z) * inv_h);
    k.arc = p.arc;
    k.on_axis = p.arc && p.at[0] == 0;
  }
  return out;
}

Kernels BestKernels() noexcept {
#if defined(__x86_64__)
  static const Kernels kBest = [] {
    // tests/determinism runs both kernels on one machine by it and compares all their bits.
    const char* simd = std::getenv("ENAMEL_SIMD");
    bool off = simd != nullptr && std::string_view(simd) == "off";
    return !off && __builtin_cpu_supports("avx2") ? Avx2Kernels() : GenericKernels();
  }();
  return kBest;
#else
  return GenericKernels();
#endif
}

}  // namespace enamel::cutting
