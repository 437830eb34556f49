#include "station/render/brick_feed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "common/cutting/cutter.h"
#include "station/render/mesher.h"

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

size_t TrianglesReady(Mesher& mesher, std::vector<size_t>& per_group) {
  per_group.resize(mesher.group_count());
  for (const GroupMesh& m : mesher.TakeReady()) per_group[m.group] = m.indices.size() / 3;
  size_t sum = 0;
  for (size_t n : per_group) sum += n;
  return sum;
}

TEST(MesherTest, FollowsTheCutAcrossThreads) {
  Volume volume = SolidBlock({6, 6, 6});
  BrickFeed feed(volume.spec().brick_count(), 8);
  Mesher mesher(volume, feed);
  ASSERT_TRUE(mesher.WaitIdle(std::chrono::seconds(30)));
  std::vector<size_t> per_group;
  EXPECT_EQ(TrianglesReady(mesher, per_group), surface::ExtractSurface(volume).triangles.size());

  cutting::Cutter cutter(volume, {cutting::BurShape::kSphere, 0.5e-3, 0});
  cutting::RemovedUnits removed{};
  cutting::Pose pose;
  for (int i = 0; i < 40; ++i) {
    pose.tip_m = dvec3(0.2e-3 + 0.05e-3 * i, 1.2e-3, 2.0e-3);
    ASSERT_TRUE(cutter.Cut(pose, removed));
    feed.Mark(cutter.touched());
    feed.Send(volume, 4);
  }
  while (feed.dirty_count() > 0) {
    if (feed.Send(volume, 4) == 0) std::this_thread::yield();
  }
  ASSERT_TRUE(mesher.WaitIdle(std::chrono::seconds(30)));
  EXPECT_EQ(TrianglesReady(mesher, per_group), surface::ExtractSurface(volume).triangles.size());
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

}  // namespace
}  // namespace enamel::station::render
