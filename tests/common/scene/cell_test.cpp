#include "common/scene/cell.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/haptics/guard.h"
#include "common/math/vec.h"

namespace enamel::scene {
namespace {

// splitmix64.
class Random {
 public:
  double Uniform() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  double Signed() { return 2 * Uniform() - 1; }
  dvec3 Direction() {
    for (;;) {
      const dvec3 v{Signed(), Signed(), Signed()};
      const double l = glm::length(v);
      if (l > 0.1 && l < 1) return v / l;
    }
  }

 private:
  uint64_t state_ = 7;
};

DeviceProfile Profile(int64_t resolution_nm, bool joints, int32_t count_nm, int32_t noise) {
  DeviceProfile p;
  p.resolution_nm.value = resolution_nm;
  p.cell = CellSpec{joints, count_nm, noise, "test"};
  return p;
}

// What a device reads at `x`: its joints' cell, off by counts of noise, and rounded by the driver. Metres.
dvec3 Read(const DeviceProfile& p, const glm::dmat3& joints, const dvec3& x, Random& random) {
  const double delta = static_cast<double>(p.resolution_nm.value) * 1e-9;
  const double count = p.cell->count_nm * 1e-9;
  dvec3 q = joints * x / delta;
  for (int i = 0; i < 3; ++i) {
    q[i] = std::round(q[i]);
    q[i] += std::round(random.Signed() * (p.cell->noise_counts + 0.49));
  }
  const dvec3 at = glm::transpose(joints) * q * delta;
  return glm::round(at / count) * count;
}

// Whatever the joints' pose: no reading is farther from the truth than the cell's support, in any direction;
// and some come near it.
TEST(CellTest, HoldsEveryReadingOfEveryLattice) {
  for (const DeviceProfile& p :
       {Profile(9'000, true, 500, 0), Profile(9'000, true, 9'000, 0), Profile(9'000, true, 500, 1),
        Profile(9'000, false, 9'000, 0), Profile(9'001, false, 500, 2)}) {
    const TipCellNm cell = TipCellOf(p);
    haptics::TipCell tip;
    tip.half_m = dvec3(cell.half_nm * 1e-9);
    tip.ball_m = cell.ball_nm * 1e-9;
    Random random;
    double closest = 0;
    for (int lattice = 0; lattice < 200; ++lattice) {
      glm::dmat3 joints(1);
      if (p.cell->joints) {
        const dvec3 x = random.Direction(), y = glm::normalize(glm::cross(random.Direction(), x));
        joints = glm::transpose(glm::dmat3(x, y, glm::cross(x, y)));
      }
      for (int i = 0; i < 200; ++i) {
        const dvec3 x = dvec3{random.Signed(), random.Signed(), random.Signed()} * 1e-4;
        const dvec3 off = x - Read(p, joints, x, random), u = random.Direction();
        const double share = std::fabs(Dot(u, off)) / tip.Support(u);
        ASSERT_LE(share, 1 + 1e-9);
        closest = std::max(closest, share);
      }
    }
    EXPECT_GT(closest, 0.6) << p.resolution_nm.value << " " << p.cell->joints;
  }
}

TEST(CellTest, WithoutACellOfItsOwnAProfileRecordsWhatItCounts) {
  DeviceProfile p;
  p.resolution_nm.value = 9'001;
  EXPECT_EQ(CountNm(p), 9'001);
  EXPECT_EQ(TipCellOf(p), (TipCellNm{4'501, 0}));
  EXPECT_EQ(CellSupportNm(p), 4'501);
}

// c >= Kc S covers the support along every way, with friction along the axes or at joints turned any way.
TEST(CellTest, FrictionAlongItsOwnAxesPaysForTheCell) {
  Random random;
  for (const DeviceProfile& p : {Profile(9'000, true, 500, 0), Profile(9'000, true, 9'000, 1),
                                 Profile(9'000, false, 9'000, 1)}) {
    const TipCellNm cell = TipCellOf(p);
    haptics::TipCell tip;
    tip.half_m = dvec3(cell.half_nm * 1e-9);
    tip.ball_m = cell.ball_nm * 1e-9;
    for (int i = 0; i < 2000; ++i) {
      glm::dmat3 rubs(1);
      if (p.cell->joints) {
        const dvec3 x = random.Direction(), y = glm::normalize(glm::cross(random.Direction(), x));
        rubs = glm::transpose(glm::dmat3(x, y, glm::cross(x, y)));
      }
      const dvec3 way = random.Direction(), along = glm::abs(rubs * way);
      EXPECT_GE(CellSupportNm(p) * 1e-9 * (along.x + along.y + along.z),
                tip.Support(way) * (1 - 1e-12));
    }
  }
}

}  // namespace
}  // namespace enamel::scene
