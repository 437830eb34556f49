#include "common/cutting/brick_kernel.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "common/cutting/bur.h"

namespace enamel::cutting {
namespace {

using Samples = std::array<int16_t, 512>;

struct Case {
  BrickFrame frame;
  Samples phi;
};

Case RandomCase(std::mt19937_64& random, bool sphere) {
  std::uniform_real_distribution<float> u(-1, 1);
  Quat q = Quat{u(random), u(random), u(random), u(random)}.Normalised();
  dmat3 m = q.Matrix();
  Case c;
  c.frame.sphere = sphere;
  c.frame.radius = 10 + 2 * u(random);
  c.frame.half_length = sphere ? c.frame.radius : 30;
  for (int i = 0; i < 3; ++i) {
    c.frame.first[i] = 12 * u(random);
    c.frame.dx[i] = static_cast<float>(m[i].x);
    c.frame.dy[i] = static_cast<float>(m[i].y);
    c.frame.dz[i] = static_cast<float>(m[i].z);
  }
  for (auto& p : c.phi) p = static_cast<int16_t>(random() % 5 ? random() : 32767);
  c.frame.lowest = -32768;
  return c;
}

TEST(BrickKernelTest, WidestAndGenericKernelsGiveTheSameBits) {
  if (BestBrickKernel() == &CutBrickGeneric) GTEST_SKIP() << "skipped: this processor has no wider kernel";
  std::mt19937_64 random(11);
  for (int i = 0; i < 2000; ++i) {
    Case a = RandomCase(random, i % 2 == 0), b = a;
    std::array<int32_t, 512> gone_a, gone_b;
    BrickChange x = CutBrickGeneric(a.frame, a.phi.data(), gone_a.data());
    BrickChange y = BestBrickKernel()(b.frame, b.phi.data(), gone_b.data());
    ASSERT_EQ(a.phi, b.phi);
    ASSERT_EQ(gone_a, gone_b);
    ASSERT_EQ(x.removed, y.removed);
    ASSERT_EQ(x.lowest, y.lowest);
    ASSERT_EQ(x.changed, y.changed);
  }
}

// Against the bur's exact distance in double precision, within the kernel's stated 1e-5 voxel (a
// tenth of a unit; one unit for truncation).
TEST(BrickKernelTest, SamplesAreTheNegativeBurDistanceWhereThatIsLarger) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 400; ++i) {
    bool sphere = i % 2 == 0;
    Case c = RandomCase(random, sphere);
    Samples before = c.phi;
    CutBrickGeneric(c.frame, c.phi.data(), nullptr);
    Bur bur{sphere ? BurShape::kSphere : BurShape::kCylinder, c.frame.radius, 2 * c.frame.half_length};
    for (int n = 0; n < 512; ++n) {
      dvec3 p;
      for (int k = 0; k < 3; ++k) {
        p[k] = double{c.frame.first[k]} + (n & 7) * double{c.frame.dx[k]} + ((n >> 3) & 7) * double{c.frame.dy[k]} +
               (n >> 6) * double{c.frame.dz[k]};
      }
      p.z += c.frame.half_length;
      double inside = -bur.Distance(p);
      if (std::fabs(inside + 2) < 1e-3 || std::fabs(inside - 2.5) < 1e-3) continue;
      double expected = inside < -2 ? -32767 : inside > 2.5 ? 32767 : inside * 8192;
      expected = std::max(expected, static_cast<double>(before[static_cast<size_t>(n)]));
      ASSERT_NEAR(c.phi[static_cast<size_t>(n)], expected, 1.6);
    }
  }
}

}  // namespace
}  // namespace enamel::cutting
