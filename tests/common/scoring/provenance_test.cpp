#include "common/scoring/movement/provenance.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/file.h"
#include "common/cutting/bur.h"
#include "common/cutting/cutter.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

// The golden blob's content by schemas/provenance.md.
Provenance Golden() {
  Provenance out;
  out.spec.voxel_nm = 100'000;
  out.spec.bricks = {2, 2, 1};
  out.spec.origin_nm = {-800'000, 0, 5'000};
  out.ticks = 100'000;
  out.bricks = {{0, 0, {uint64_t{1} | uint64_t{1} << 9, 0, 0, 0, 0, 0, 0, uint64_t{1} << 63}},
                {3, 3, {0, uint64_t{2}}}};
  out.tick = {70'000, 69'990, 5, 99'999};
  return out;
}

TEST(ProvenanceBlobTest, GoldenBlobDecodesToWhatItsDocumentSays) {
  auto bytes =
      ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/provenance.enpv");
  ASSERT_TRUE(bytes.ok());
  auto read = DecodeProvenance(*bytes);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(*read, Golden());
  EXPECT_EQ(read->TickOf({0, 0, 0}), 70'000u);
  EXPECT_EQ(read->TickOf({1, 1, 0}), 69'990u);
  EXPECT_EQ(read->TickOf({7, 7, 7}), 5u);
  EXPECT_EQ(read->TickOf({9, 8, 1}), 99'999u);
  EXPECT_FALSE(read->TickOf({1, 0, 0}));
  EXPECT_FALSE(read->TickOf({8, 0, 0}));
  EXPECT_FALSE(read->TickOf({-1, 0, 0}));
  EXPECT_FALSE(read->TickOf({0, 0, 8}));
}

TEST(ProvenanceBlobTest, NothingCutIsABlobToo) {
  Provenance nothing;
  nothing.spec = Golden().spec;
  auto back = DecodeProvenance(EncodeProvenance(nothing));
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(*back, nothing);
  Provenance some = Golden();
  some.complete = false;
  EXPECT_EQ(*DecodeProvenance(EncodeProvenance(some)), some);
}

TEST(ProvenanceBlobTest, EveryTruncationAndEveryExtraByteIsRefused) {
  Bytes blob = EncodeProvenance(Golden());
  for (size_t n = 0; n < blob.size(); ++n) {
    EXPECT_FALSE(DecodeProvenance({blob.data(), n}).ok()) << n;
  }
  blob.push_back(0);
  EXPECT_FALSE(DecodeProvenance(blob).ok());
}

TEST(ProvenanceBlobTest, WhatAFlippedBitLeavesReadableIsReadTheSameAgain) {
  const Bytes blob = EncodeProvenance(Golden());
  for (size_t bit = 0; bit < blob.size() * 8; ++bit) {
    Bytes bad = blob;
    bad[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
    auto read = DecodeProvenance(bad);
    if (!read.ok()) continue;
    size_t seen = 0;
    read->ForEach([&](const ivec3& voxel, uint32_t tick) {
      EXPECT_LT(tick, read->ticks);
      EXPECT_EQ(read->TickOf(voxel), tick);
      ++seen;
    });
    EXPECT_EQ(seen, read->tick.size());
    EXPECT_EQ(*DecodeProvenance(EncodeProvenance(*read)), *read);
  }
}

TEST(ProvenanceBlobTest, WhatCannotBeIsRefused) {
  auto refused = [](auto&& change, const char* says) {
    Provenance bad = Golden();
    change(bad);
    auto read = DecodeProvenance(EncodeProvenance(bad));
    ASSERT_FALSE(read.ok()) << says;
    EXPECT_NE(read.status().message().find(says), std::string::npos) << read.status().message();
  };
  refused([](Provenance& p) { p.ticks = 99'999; }, "of a recording of 99999");
  refused([](Provenance& p) { p.bricks[1].index = 0; }, "out of order");
  refused([](Provenance& p) { p.bricks[1].index = 4; }, "outside the grid");
  refused([](Provenance& p) { p.bricks[1].gone = {}; }, "nothing went");
  refused([](Provenance& p) { p.bricks[1].gone[0] = 7; }, "counts 4 voxels");
  refused([](Provenance& p) { p.spec.voxel_nm = 0; }, "voxel");
  refused([](Provenance& p) { p.spec.origin_nm[0] = INT64_MIN; }, "1 m away");
  Bytes newer = EncodeProvenance(Golden());
  newer[4] = 2;
  EXPECT_EQ(DecodeProvenance(newer).status().code(), Code::kVersion);
  Bytes flagged = EncodeProvenance(Golden());
  flagged[6] = 2;
  EXPECT_FALSE(DecodeProvenance(flagged).ok());
}

// A voxel's moment is that of the first tooth in which its centre is air, found here by looking at
// every voxel after every cut.
TEST(ProvenanceRecorderTest, EveryVoxelHasTheTickAtWhichItWent) {
  const cutting::Volume initial = MakeBlock(200'000);
  cutting::Volume volume = initial;
  volume.Reserve();
  cutting::Cutter cutter(volume, {cutting::BurShape::kCylinder, 0.5e-3, 4e-3});
  ProvenanceRecorder recorder(initial);
  const ivec3 size = initial.spec().voxels();
  auto index = [&](const ivec3& v) {
    return static_cast<size_t>((v.z * size.y + v.y) * size.x + v.x);
  };
  std::vector<int64_t> expected(index(size - 1) + 1, -1);
  auto each = [&](auto&& fn) {
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) fn(ivec3(x, y, z));
      }
    }
  };
  for (int tick = 0; tick < 40; ++tick) {
    if (tick % 3 == 2) {
      recorder.Add(volume, {});
      continue;
    }
    cutting::RemovedUnits removed{};
    // Down, then along: the later cuts meet the room of the earlier ones.
    cutting::Pose pose;
    pose.tip_m = {tick < 20 ? 0 : (tick - 20) * 1e-4, 0, tick < 20 ? -tick * 1e-4 : -2e-3};
    ASSERT_TRUE(cutter.Cut(pose, removed));
    recorder.Add(volume, cutter.touched());
    each([&](const ivec3& v) {
      if (expected[index(v)] < 0 && initial.PhiAt(v) < 0 && volume.PhiAt(v) >= 0) {
        expected[index(v)] = tick;
      }
    });
  }
  const Provenance found = recorder.Take();
  EXPECT_EQ(found.ticks, 40u);
  EXPECT_TRUE(found.complete);
  size_t gone = 0;
  each([&](const ivec3& v) {
    auto tick = found.TickOf(v);
    EXPECT_EQ(tick ? static_cast<int64_t>(*tick) : -1, expected[index(v)]);
    gone += tick.has_value();
  });
  EXPECT_EQ(gone, found.tick.size());
  EXPECT_GT(gone, 500u);
}

}  // namespace
}  // namespace enamel::scoring
