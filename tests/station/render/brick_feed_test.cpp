#include "station/render/brick_feed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <thread>

#include "common/cutting/cutter.h"
#include "station/render/materials.h"
#include "station/render/mesher.h"
#include "station/render/revolve.h"

namespace enamel::station::render {
namespace {

using cutting::GridSpec;
using cutting::Tissue;
using cutting::Volume;

Volume SolidBlock(const ivec3& bricks) {
  GridSpec spec{50'000, bricks, {}};
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) volume.SetUniform(b, Tissue::kEnamel);
  volume.Reserve();
  return volume;
}

void Paint(Volume& volume, int brick, int16_t value) {
  ASSERT_TRUE(volume.Materialise(brick));
  volume.MutablePhi(brick).phi.fill(value);
}

TEST(BrickFeedTest, SendsABrickOnceAsItIsWhenItsTurnComes) {
  Volume volume = SolidBlock({4, 1, 1});
  BrickFeed feed(4, 16);
  Paint(volume, 2, 100);
  int32_t touched[] = {2, 2};
  feed.Mark(touched);
  Paint(volume, 2, 200);
  feed.Mark(touched);
  EXPECT_EQ(feed.Send(volume, 8), 1u);
  std::vector<int16_t> got;
  feed.Drain([&](const BrickUpdate& u) {
    EXPECT_EQ(u.brick, 2);
    got.push_back(u.phi.phi[0]);
  });
  EXPECT_EQ(got, std::vector<int16_t>{200});
}

TEST(BrickFeedTest, FullRingLosesNothing) {
  Volume volume = SolidBlock({8, 4, 1});
  BrickFeed feed(32, 4);
  for (int32_t b = 0; b < 32; ++b) {
    Paint(volume, b, static_cast<int16_t>(b));
    feed.Mark({&b, 1});
  }
  EXPECT_EQ(feed.Send(volume, 100), 4u);
  EXPECT_EQ(feed.Send(volume, 100), 0u);
  EXPECT_EQ(feed.dirty_count(), 28u);
  std::vector<int32_t> order;
  while (feed.dirty_count() > 0 || feed.sent() > order.size()) {
    feed.Drain([&](const BrickUpdate& u) {
      EXPECT_EQ(u.phi.phi[0], u.brick);
      order.push_back(u.brick);
    });
    feed.Send(volume, 3);
  }
  EXPECT_EQ(order.size(), 32u);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

// Triangles of the exact surface in each group of 4 x 4 x 4 bricks.
std::vector<size_t> ExactPerGroup(const Volume& volume) {
  ivec3 bricks = volume.spec().bricks, groups = (bricks + 3) / 4;
  std::vector<size_t> out(static_cast<size_t>(groups.x * groups.y * groups.z));
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    ivec3 g = ivec3(b % bricks.x, b / bricks.x % bricks.y, b / (bricks.x * bricks.y)) / 4;
    out[static_cast<size_t>((g.z * groups.y + g.y) * groups.x + g.x)] +=
        surface::ExtractBrick(volume, b).triangles.size();
  }
  return out;
}

class MesherFollowsTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(mesher_.WaitIdle(std::chrono::seconds(30))); }
  // A slot along x, sent as the tick sends it.
  void Cut() {
    cutting::Cutter cutter(volume_, {cutting::BurShape::kSphere, 0.5e-3, 0});
    cutting::RemovedUnits removed{};
    cutting::Pose pose;
    for (int i = 0; i < 40; ++i) {
      pose.tip_m = dvec3(0.2e-3 + 0.05e-3 * i, 1.2e-3, 2.0e-3);
      ASSERT_TRUE(cutter.Cut(pose, removed));
      feed_.Mark(cutter.touched());
      feed_.Send(volume_, 4);
    }
    while (feed_.dirty_count() > 0) {
      if (feed_.Send(volume_, 4) == 0) std::this_thread::yield();
    }
    ASSERT_TRUE(mesher_.WaitIdle(std::chrono::seconds(30)));
  }

  Volume volume_ = SolidBlock({6, 6, 6});
  BrickFeed feed_{volume_.spec().brick_count(), 8};
  Mesher mesher_{volume_, feed_};
};

TEST_F(MesherFollowsTest, WhatWasCutIsExactAcrossThreadsAndTheRestHasFewerTriangles) {
  std::vector<size_t> exact = ExactPerGroup(volume_), got(mesher_.group_count());
  for (const GroupMesh& m : mesher_.TakeReady()) {
    got[m.group] = m.indices.size() / 3;
    EXPECT_LT(m.coarse.size(), m.indices.size() + 1);
    EXPECT_FALSE(m.coarse.empty());
  }
  for (size_t g = 0; g < got.size(); ++g) EXPECT_EQ(got[g] > 0, exact[g] > 0);
  EXPECT_LT(std::accumulate(got.begin(), got.end(), size_t{0}),
            std::accumulate(exact.begin(), exact.end(), size_t{0}) / 2);

  Cut();
  std::vector<size_t> now = ExactPerGroup(volume_);
  std::vector<bool> renewed(got.size());
  for (const GroupMesh& m : mesher_.TakeReady()) {
    renewed[m.group] = true;
    EXPECT_EQ(m.indices.size() / 3, now[m.group]) << m.group;
  }
  for (size_t g = 0; g < got.size(); ++g) EXPECT_TRUE(renewed[g] || now[g] == exact[g]) << g;
}

TEST_F(MesherFollowsTest, WhatWasCutGetsCoarseTrianglesOnceItRestsAndStaysExact) {
  (void)mesher_.TakeReady();
  Cut();
  std::vector<size_t> now = ExactPerGroup(volume_);
  std::set<size_t> cut, coarse;
  auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while ((cut.empty() || coarse != cut) && std::chrono::steady_clock::now() < until) {
    for (const GroupMesh& m : mesher_.TakeReady()) {
      EXPECT_EQ(m.indices.size() / 3, now[m.group]);
      cut.insert(m.group);
      if (m.coarse.empty()) continue;
      coarse.insert(m.group);
      EXPECT_LT(m.coarse.size(), m.indices.size());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_FALSE(cut.empty());
  EXPECT_EQ(coarse, cut);
}

TEST(MesherTest, LeavesOutOnlyTrianglesThatFaceAway) {
  Volume volume = SolidBlock({10, 10, 10});
  BrickFeed feed(volume.spec().brick_count(), 8);
  Mesher mesher(volume, feed);
  ASSERT_TRUE(mesher.WaitIdle(std::chrono::seconds(30)));
  std::vector<GroupMesh> groups = mesher.TakeReady();
  size_t left_out = 0;
  for (glm::vec3 eye : {glm::vec3(20, 2, 2), glm::vec3(-20, -9, 4), glm::vec3(2, 2, 9)}) {
    for (const GroupMesh& g : groups) {
      if (MayFace(g.bounds, eye)) continue;
      ++left_out;
      for (size_t i = 0; i < g.indices.size(); i += 3) {
        glm::vec3 p[3];
        for (size_t k = 0; k < 3; ++k) {
          const GpuVertex& v = g.vertices[g.indices[i + k]];
          p[k] = {v.position_mm[0], v.position_mm[1], v.position_mm[2]};
        }
        ASSERT_LE(glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), eye - p[0]), 1e-6f);
      }
    }
  }
  EXPECT_GE(left_out, 3u);
}

// The share of enamel's colour in a vertex's, of enamel's and dentin's.
double EnamelShare(const GpuVertex& v) {
  const double root = v.look.root_albedo[2] / 255.0;
  const double enamel = TissueColour(Tissue::kEnamel).b, dentin = TissueColour(Tissue::kDentin).b;
  return (root * root - dentin) / (enamel - dentin);
}

// Enamel over dentin; their border rises by a voxel in ten.
TEST(MesherTest, ThereIsNoStaircaseWhereEnamelEnds) {
  Volume volume = SolidBlock({12, 8, 9});
  const GridSpec spec = volume.spec();
  constexpr int kMiddle = 24, kPerVoxel = 10;
  for (int b = 0; b < spec.brick_count(); ++b) {
    ASSERT_TRUE(volume.Materialise(b));
    const int x0 = b % spec.bricks.x * 8, z0 = b / (spec.bricks.x * spec.bricks.y) * 8;
    std::array<uint8_t, cutting::kBrickVoxels> labels;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const int x = x0 + i % 8, z = z0 + i / 64;
      labels[static_cast<size_t>(i)] =
          static_cast<uint8_t>(z >= kMiddle + x / kPerVoxel ? Tissue::kEnamel : Tissue::kDentin);
    }
    volume.SetBrick(b, volume.Phi(b).phi, labels, static_cast<Tissue>(labels[0]));
  }
  BrickFeed feed(spec.brick_count(), 8);
  Mesher mesher(volume, feed);
  ASSERT_TRUE(mesher.WaitIdle(std::chrono::seconds(30)));
  size_t between = 0;
  for (const GroupMesh& g : mesher.TakeReady()) {
    for (const GpuVertex& v : g.vertices) {
      const double over =
          v.position_mm[2] / 0.05 - kMiddle + 0.5 - (v.position_mm[0] / 0.05) / kPerVoxel;
      const double enamel = EnamelShare(v);
      // A little dentin is seen farther off, aslant through enamel.
      const bool mixed = enamel > 0.02 && enamel < 0.95;
      // On the sides along which the border rises: through the others dentin shows.
      if (!mixed || v.normal[0] != 0 || v.normal[2] != 0) continue;
      // Not near the faces through which a way leaves.
      if (std::abs(v.position_mm[0] - 2.4f) > 0.6f || std::abs(over) > 10) continue;
      EXPECT_LT(std::abs(over), 5);
      ++between;
      EXPECT_NEAR(enamel, std::clamp(0.5 + over / 6, 0.0, 1.0), 0.3) << over;
    }
  }
  EXPECT_GT(between, 200u);
}

}  // namespace
}  // namespace enamel::station::render
