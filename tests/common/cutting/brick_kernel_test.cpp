#include "common/cutting/brick_kernel.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/common/cutting/burs.h"

namespace enamel::cutting {
namespace {

using Samples = std::array<int16_t, 512>;
constexpr double kVoxel = 50e-6;

// Eight bricks in a row along x near a bur at some pose. All in voxels; bur frame from the body's
// middle.
struct Case {
  Bur bur;
  KernelBur kernel_bur;
  Profile profile;
  dmat3 steps;  // columns: dx, dy, dz
  dvec3 first;  // of the first brick
  CullJob cull{};
  std::array<int16_t, 8> lowest;

  explicit Case(const Bur& b) : bur(b), kernel_bur(KernelBurOf(b, kVoxel)), profile(ProfileOf(b)) {}

  dvec3 At(int brick, int n) const {
    return first + steps * dvec3(brick * 8 + (n & 7), (n >> 3) & 7, n >> 6);
  }
  // Exact distance, voxels.
  double Distance(const dvec3& p) const {
    return profile.Distance(std::sqrt(p.x * p.x + p.y * p.y) * kVoxel,
                            p.z * kVoxel + 0.5 * bur.height_m()) /
           kVoxel;
  }
};

BurFrame FrameOf(const dmat3& steps, const dvec3& first) {
  BurFrame f;
  for (int i = 0; i < 3; ++i) {
    f.first[i] = static_cast<float>(first[i]);
    f.dx[i] = static_cast<float>(steps[0][i]);
    f.dy[i] = static_cast<float>(steps[1][i]);
    f.dz[i] = static_cast<float>(steps[2][i]);
  }
  return f;
}

Case RandomCase(std::mt19937_64& random, const Bur& bur) {
  std::uniform_real_distribution<double> u(-1, 1);
  Case c(bur);
  Quat q = random() % 3 ? Quat{u(random), u(random), u(random), u(random)}.Normalised()
                        : Quat{0.05 * u(random), 0.05 * u(random), 0, 1}.Normalised();
  dmat3 m = q.Matrix();
  for (int i = 0; i < 3; ++i) c.steps[i] = dvec3(m[0][i], m[1][i], m[2][i]);
  // The row's middle is somewhere in the bur's box.
  dvec3 half(bur.radius_m / kVoxel, bur.radius_m / kVoxel, 0.5 * bur.height_m() / kVoxel);
  c.first = dvec3(u(random), u(random), u(random)) * half - c.steps * dvec3(32, 4, 4);
  c.cull.frame = FrameOf(c.steps, c.first);
  for (int k = 0; k < 4; ++k) {
    dvec3 to = c.steps * dvec3(3.5, k & 1 ? 3.5 : -3.5, k & 2 ? 3.5 : -3.5);
    c.cull.across = std::max(c.cull.across, static_cast<float>(std::hypot(to.x, to.y)));
    c.cull.along = std::max(c.cull.along, static_cast<float>(std::fabs(to.z)));
  }
  c.lowest.fill(-32767);
  return c;
}

Samples RandomSamples(std::mt19937_64& random) {
  Samples phi;
  for (auto& p : phi) {
    p = static_cast<int16_t>(
        random() % 5 ? std::max(-32767, static_cast<int>(static_cast<int16_t>(random()))) : 32767);
  }
  return phi;
}

BrickJob JobOf(const Case& c, int brick, int32_t cull) {
  return {FrameOf(c.steps, c.At(brick, 0)), cull, -32767};
}

double Wanted(double distance) {
  return distance > 2 ? -32767 : distance < -2.5 ? 32767 : -distance * 8192;
}
bool AtABandsEdge(double distance) {
  return std::fabs(distance - 2) < 1e-3 || std::fabs(distance + 2.5) < 1e-3;
}

TEST(BrickKernelTest, WidestAndGenericKernelsGiveTheSameBits) {
  if (BestKernels().cut == GenericKernels().cut)
    GTEST_SKIP() << "skipped: this processor has no wider kernel";
  std::mt19937_64 random(11);
  for (int i = 0; i < 300; ++i) {
    for (const Bur& bur : test::AllBurs()) {
      Case c = RandomCase(random, bur);
      CullResult narrow = GenericKernels().cull(c.kernel_bur, c.cull, c.lowest.data());
      CullResult wide = BestKernels().cull(c.kernel_bur, c.cull, c.lowest.data());
      for (int b = 0; b < 8; ++b) {
        ASSERT_EQ(narrow.pieces[b], wide.pieces[b]);
        if (narrow.pieces[b] == 0) continue;
        alignas(32) Samples p = RandomSamples(random), q = p, gone_p, gone_q;
        BrickJob job = JobOf(c, b, narrow.pieces[b]);
        BrickChange x = GenericKernels().cut(c.kernel_bur, job, p.data(), gone_p.data());
        BrickChange y = BestKernels().cut(c.kernel_bur, job, q.data(), gone_q.data());
        ASSERT_EQ(p, q);
        ASSERT_EQ(gone_p, gone_q);
        ASSERT_EQ(x.removed, y.removed);
        ASSERT_EQ(x.lowest, y.lowest);
        ASSERT_EQ(x.changed, y.changed);
      }
    }
  }
}

// Against the outline's exact distance in double precision, within the kernel's stated 1e-5 voxel
// (a tenth of a unit; one unit for truncation); and what is culled could not have changed.
TEST(BrickKernelTest, SamplesAreTheNegativeBurDistanceWhereThatIsLarger) {
  std::mt19937_64 random(5);
  int cut = 0, culled = 0;
  for (int i = 0; i < 200; ++i) {
    for (const Bur& bur : test::AllBurs()) {
      Case c = RandomCase(random, bur);
      CullResult cull = GenericKernels().cull(c.kernel_bur, c.cull, c.lowest.data());
      for (int b = 0; b < 8; ++b) {
        Samples before = RandomSamples(random);
        alignas(32) Samples phi = before;
        if (cull.pieces[b] != 0) {
          GenericKernels().cut(c.kernel_bur, JobOf(c, b, cull.pieces[b]), phi.data(), nullptr);
          ++cut;
        } else {
          before.fill(-32767);
          phi = before;
          ++culled;
        }
        for (int n = 0; n < 512; ++n) {
          double distance = c.Distance(c.At(b, n));
          if (AtABandsEdge(distance)) continue;
          auto s = static_cast<size_t>(n);
          ASSERT_NEAR(phi[s], std::max(Wanted(distance), static_cast<double>(before[s])), 1.7)
              << BurShapeName(bur.shape) << ", distance " << distance;
        }
      }
    }
  }
  EXPECT_GT(cut, 2000);
  EXPECT_GT(culled, 2000);
}

TEST(BrickKernelTest, BurThatMovedAwayFromABrickCouldNotHaveChangedIt) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> u(-1, 1);
  int spared = 0;
  for (int i = 0; i < 2000; ++i) {
    for (const Bur& bur : test::AllBurs()) {
      Case c = RandomCase(random, bur);
      // Where the samples were: turned a little about the bur's middle and shifted, at most one
      // voxel in all.
      double turn = i % 3 == 0 ? 0 : 0.3 / (bur.height_m() / kVoxel),
             shift = i % 4 == 0 ? 1e-3 : 0.5;
      Quat q = Quat{0.5 * turn * u(random), 0.5 * turn * u(random), 0.5 * turn * u(random), 1}
                   .Normalised();
      dmat3 rotate = q.Matrix();
      dvec3 moved = dvec3(u(random), u(random), i % 2 ? u(random) : 0.0) * shift;
      Case before = c;
      before.steps = rotate * c.steps;
      before.first = rotate * c.first + moved;
      dmat3 change = before.steps - c.steps;
      c.cull.motion = FrameOf(change, before.first - c.first);
      c.cull.has_motion = true;
      double turn2 = 0;
      for (int k = 0; k < 3; ++k) turn2 += glm::dot(change[k], change[k]);
      c.cull.turn = static_cast<float>(std::sqrt(turn2));
      CullJob still = c.cull;
      still.has_motion = false;
      CullResult with = GenericKernels().cull(c.kernel_bur, c.cull, c.lowest.data());
      CullResult without = GenericKernels().cull(c.kernel_bur, still, c.lowest.data());
      for (int b = 0; b < 8; ++b) {
        if (with.pieces[b] != 0 || without.pieces[b] == 0) continue;
        ++spared;
        for (int n = 0; n < 512; ++n) {
          double was = c.Distance(before.At(b, n)), is = c.Distance(c.At(b, n));
          if (AtABandsEdge(was) || AtABandsEdge(is)) continue;
          ASSERT_LE(Wanted(is), Wanted(was) + 1e-3)
              << BurShapeName(bur.shape) << " " << was << " -> " << is;
        }
      }
    }
  }
  EXPECT_GT(spared, 1000);
}

}  // namespace
}  // namespace enamel::cutting
