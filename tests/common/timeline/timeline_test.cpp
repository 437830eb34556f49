#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "common/base/file.h"
#include "common/scene/builtin/builtin.h"
#include "common/surface/surface.h"
#include "common/timeline/deviation.h"
#include "common/timeline/player.h"
#include "common/timeline/recorder.h"
#include "common/timeline/start_tooth.h"
#include "tests/common/timeline/ball_cut.h"

namespace enamel::timeline {
namespace {

using cutting::kBrickVoxels;
using test::BallCut;
using test::Golden;

// The golden tooth of schemas/surface_timeline.md after `frames` frames.
int8_t GoldenSample(const ivec3& v, uint32_t frames) {
  const dvec3 p(v), middle(19.5);
  const auto length = [](const dvec3& d) { return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z); };
  double d = length(p - middle) - 14.3;
  for (uint32_t j = 0; j < frames; ++j) {
    d = std::max(d, 4 - length(p - dvec3(19.5, 19.5, 34 - 1.5 * j)));
  }
  return static_cast<int8_t>(std::clamp(std::floor(64 * d), -64.0, 63.0));
}

// Each sample is as it was; before the last segment, of the same level.
bool IsBrick(const Samples& found, const Samples& exact, const Player& player, uint32_t frames) {
  const Head& head = player.head();
  const bool last = frames == 0 || (frames - 1) / head.segment_frames + 1 == head.segments.size();
  return std::ranges::equal(found, exact, [last](int8_t a, int8_t b) {
    return last ? a == b : a >> kCoarse == b >> kCoarse;
  });
}

void ExpectGolden(const Player& player, uint32_t frames) {
  const ivec3 n = player.head().spec.bricks;
  for (int b = 0; b < n.x * n.y * n.z; ++b) {
    const ivec3 corner = ivec3(b % n.x, b / n.x % n.y, b / n.x / n.y) * 8;
    const Samples found = player.BrickSamples(b);
    Samples exact;
    for (int i = 0; i < kBrickVoxels; ++i) {
      exact[static_cast<size_t>(i)] =
          GoldenSample(corner + ivec3(i % 8, i / 8 % 8, i / 64), frames);
    }
    ASSERT_TRUE(IsBrick(found, exact, player, frames))
        << "after " << frames << " frames, brick " << b;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const ivec3 voxel = corner + ivec3(i % 8, i / 8 % 8, i / 64);
      if (found[static_cast<size_t>(i)] >= 0) continue;
      const dvec3 d = dvec3(voxel) - 19.5;
      ASSERT_EQ(player.TissueAt(voxel),
                std::sqrt(Dot(d, d)) < 9 ? cutting::Tissue::kDentin : cutting::Tissue::kEnamel);
    }
  }
}

TEST(SurfaceTimelineGoldenTest, ToothAtEveryFrameIsWhatTheDocumentSays) {
  auto player = Player::Open(Golden("surface_timeline.entb"), Golden("surface_timeline.entl"));
  ASSERT_TRUE(player.ok()) << player.status().message();
  ASSERT_EQ(player->head().frames(), 5u);
  for (uint32_t frames : {0, 1, 2, 3, 4, 5, 2, 5, 1, 0, 4, 3}) {
    ASSERT_TRUE(player->Seek(frames).ok());
    ExpectGolden(*player, frames);
  }
}

TEST(SurfaceTimelineGoldenTest, HeadAndPosesAreWhatTheDocumentSays) {
  auto player = Player::Open(Golden("surface_timeline.entb"), Golden("surface_timeline.entl"));
  ASSERT_TRUE(player.ok()) << player.status().message();
  const Head& head = player->head();
  EXPECT_EQ(head.ticks, 450u);
  EXPECT_EQ(head.rate_hz, 1000u);
  EXPECT_EQ(head.frame_ticks, 100u);
  EXPECT_EQ(head.segment_frames, 2u);
  EXPECT_EQ(
      head.outlines,
      (std::vector<std::vector<OutlinePoint>>{{{0, 100'000}, {400'000, 200'000}, {4'000'000, 0}}}));
  ASSERT_EQ(head.segments.size(), 3u);
  for (int k = 0; k < 5; ++k) {
    auto poses = player->Poses(static_cast<size_t>(k / 2));
    ASSERT_TRUE(poses.ok()) << poses.status().message();
    const FramePose expected{{0, -5 * k, 1450 - 150 * k},
                             {0, static_cast<int8_t>(k), 127},
                             k % 2 == 1,
                             static_cast<uint32_t>(k)};
    EXPECT_EQ((*poses)[static_cast<size_t>(k % 2)], expected) << k;
  }
}

// Samples of all bricks.
std::vector<Samples> All(const cutting::Volume& volume) {
  std::vector<Samples> out;
  for (int b = 0; b < volume.spec().brick_count(); ++b) out.push_back(QuantiseBrick(volume, b));
  return out;
}

// 80 ticks, 7 in a frame. `seen`: gets the samples after each frame.
Bytes RecordWatched(BallCut& cut, std::map<uint32_t, std::vector<Samples>>& seen) {
  seen[0] = All(cut.initial());
  return cut.Record(80, [&](int ticks, const cutting::Volume& volume) {
    if (ticks % 7 == 0 || ticks == 80) seen[static_cast<uint32_t>((ticks + 6) / 7)] = All(volume);
  });
}

// As many key frames are read for a moment as its segment's place before the last has bits.
class SurfaceTimelineSegmentTest : public ::testing::TestWithParam<uint32_t> {};

TEST_P(SurfaceTimelineSegmentTest, EveryFrameHasTheVolumesSamplesAsTheyAreQuantised) {
  RecorderOptions options;
  options.frame_ticks = 7;
  options.segment_frames = GetParam();
  options.change_frames = 1;
  BallCut cut(options);
  std::map<uint32_t, std::vector<Samples>> seen;
  const Bytes file = RecordWatched(cut, seen);
  auto player = Player::Open(cut.start(), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  ASSERT_EQ(player->head().frames(), 12u);
  ASSERT_EQ(seen.size(), 13u);
  ASSERT_NE(seen[12], seen[0]) << "nothing was cut";
  for (uint32_t frames : {0, 3, 4, 12, 11, 7, 8, 1, 12, 0}) {
    ASSERT_TRUE(player->Seek(frames).ok());
    for (int b = 0; b < 512; ++b) {
      ASSERT_TRUE(
          IsBrick(player->BrickSamples(b), seen[frames][static_cast<size_t>(b)], *player, frames))
          << frames << " frames, brick " << b;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lengths, SurfaceTimelineSegmentTest, ::testing::Values(1u, 3u, 12u));

// 12 frames, 5 in a segment: the tooth changes in frames 3, 5, 8, 10 and 12.
TEST(SurfaceTimelineTest, BetweenItsChangesTheToothStays) {
  RecorderOptions options;
  options.frame_ticks = 7;
  options.segment_frames = 5;
  options.change_frames = 3;
  BallCut cut(options);
  std::map<uint32_t, std::vector<Samples>> seen;
  const Bytes file = RecordWatched(cut, seen);
  auto player = Player::Open(cut.start(), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  constexpr uint32_t kLook[] = {0, 0, 0, 3, 3, 5, 5, 5, 8, 8, 10, 10, 12};
  for (uint32_t frames : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 4, 11, 1}) {
    ASSERT_TRUE(player->Seek(frames).ok());
    for (int b = 0; b < 512; ++b) {
      ASSERT_TRUE(IsBrick(player->BrickSamples(b), seen[kLook[frames]][static_cast<size_t>(b)],
                          *player, frames))
          << frames << " frames, brick " << b;
    }
  }
  EXPECT_TRUE(seen[5] != seen[3] && seen[8] != seen[5]);
}

TEST(SurfaceTimelineTest, SamplesKeepTheirSideAndAreOffByAtMostAHundredAndTwentyEighthOfAVoxel) {
  for (int phi = -32767; phi <= 32767; ++phi) {
    const int8_t q = Quantise(phi);
    ASSERT_EQ(q < 0, phi < 0) << phi;
    if (std::abs(phi) >= 8192) continue;
    ASSERT_LE(std::abs(PhiOf(q) - phi), 64) << phi;
  }
}

TEST(SurfaceTimelineTest, CoarseSamplesKeepTheirSideAndAreOffByAtMostAThirtySecondOfAVoxel) {
  for (int q = kDeep; q <= kFarOut; ++q) {
    const int8_t found = FromLevel(q >> kCoarse, kCoarse);
    EXPECT_EQ(found < 0, q < 0) << q;
    EXPECT_LE(std::abs(found - q), q < kDeep + 4 || q > kFarOut - 4 ? 3 : 2) << q;
    EXPECT_EQ(FromLevel(found >> kCoarse, kCoarse), found) << q;
    EXPECT_EQ(FromLevel(q, 0), q);
  }
}

// The surface made of what was decoded, against that of the volume itself. Along the surface a
// vertex may move: where an edge runs in it, what it crosses at is rounding.
struct Off {
  size_t vertices = 0;
  double across_m = 0, turned_cos = 1;
};

void MeasureSurface(const Player& player, const cutting::Volume& last, Off& out) {
  const cutting::Volume decoded = player.ToVolume();
  auto& [vertices, worst, turned] = out;
  for (int b = 0; b < 512; ++b) {
    const surface::Mesh expected = surface::ExtractBrick(last, b);
    const surface::Mesh found = surface::ExtractBrick(decoded, b);
    ASSERT_EQ(found.position_m.size(), expected.position_m.size()) << b;
    ASSERT_EQ(found.triangles.size(), expected.triangles.size()) << b;
    const std::vector<glm::vec3> normals = surface::SmoothNormals(last, expected),
                                 read = surface::SmoothNormals(decoded, found);
    for (size_t v = 0; v < expected.position_m.size(); ++v) {
      const glm::vec3 off = found.position_m[v] - expected.position_m[v];
      worst = std::max(worst, double{std::fabs(glm::dot(off, expected.normal[v]))});
      turned = std::min(turned, double{glm::dot(read[v], normals[v])});
    }
    vertices += expected.position_m.size();
  }
  std::printf("%zu vertices: off by %.4f voxel, normals by %.1f degrees\n", vertices, worst / 50e-6,
              std::acos(turned) * 180 / 3.14159265);
}

TEST(SurfaceTimelineTest, SurfaceHasTheSameVerticesWithinAFiftiethOfAVoxel) {
  BallCut cut;
  cutting::Volume last;
  const Bytes file = cut.Record(80, [&](int, const cutting::Volume& volume) { last = volume; });
  auto player = Player::Open(cut.start(), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  ASSERT_TRUE(player->Seek(player->head().frames()).ok());
  Off off;
  ASSERT_NO_FATAL_FAILURE(MeasureSurface(*player, last, off));
  EXPECT_GT(off.vertices, 5000u);
  EXPECT_LT(off.across_m, 0.02 * 50e-6);
  EXPECT_GT(off.turned_cos, std::cos(0.035));
}

// Before the last segment.
TEST(SurfaceTimelineTest, WhileItIsPlayedTheSurfaceIsWithinATwentiethOfAVoxel) {
  RecorderOptions options;
  options.frame_ticks = 10;
  options.segment_frames = 4;
  BallCut cut(options);
  cutting::Volume then;
  const Bytes file = cut.Record(80, [&](int ticks, const cutting::Volume& volume) {
    if (ticks == 40) then = volume;
  });
  auto player = Player::Open(cut.start(), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  ASSERT_TRUE(player->Seek(4).ok());
  Off off;
  ASSERT_NO_FATAL_FAILURE(MeasureSurface(*player, then, off));
  EXPECT_GT(off.vertices, 5000u);
  EXPECT_LT(off.across_m, 0.05 * 50e-6);
  EXPECT_GT(off.turned_cos, std::cos(0.16));
}

TEST(SurfaceTimelineTest, PosesSayWhereTheBurIsAndHowLongAFrameTook) {
  RecorderOptions options;
  options.frame_ticks = 10;
  BallCut cut(options);
  const Bytes file = cut.Record(25, [](int, const cutting::Volume&) {});
  auto player = Player::Open(cut.start(), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  auto poses = player->Poses(0);
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  ASSERT_EQ(poses->size(), 3u);
  // Tick 9: x = -1.6 + 0.36 mm. The ball's axis is the scene's z.
  EXPECT_EQ((*poses)[0].tip_um[0], -1240);
  EXPECT_EQ((*poses)[2].tip_um[0], -640);
  EXPECT_EQ((*poses)[1].axis, (std::array<int8_t, 3>{0, 0, 127}));
  EXPECT_TRUE((*poses)[0].turning);
  EXPECT_FALSE((*poses)[1].turning);
  for (const FramePose& pose : *poses) EXPECT_EQ(pose.gap_ticks, 2u);
  // A ball's outline is a half circle.
  for (const OutlinePoint& point : player->head().outlines.at(0)) {
    const double z = point.z_nm - 500'000.0;
    EXPECT_NEAR(std::sqrt(z * z + double{1.0} * point.radius_nm * point.radius_nm), 500'000, 20);
  }
}

TEST(SurfaceTimelineTest, EachBurHasAnOutlineAndEachPoseSaysWhichItIs) {
  RecorderOptions options;
  options.frame_ticks = 10;
  options.burs = {{cutting::BurShape::kSphere, 0.5e-3},
                  {cutting::BurShape::kCylinder, 0.4e-3, 2e-3, 0, 0.8e-3, 1e-3}};
  BallCut cut(options);
  const Bytes file = cut.Record(25, [](int, const cutting::Volume&) {});
  auto player = Player::Open(cut.start(), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  const auto& outlines = player->head().outlines;
  ASSERT_EQ(outlines.size(), 2u);
  EXPECT_EQ(outlines[0].size() + 2, outlines[1].size()) << "one has a shank";
  for (const auto& outline : outlines) EXPECT_EQ(outline.front().z_nm, 0);
  EXPECT_EQ(outlines[1][12].radius_nm, 400'000);
  auto poses = player->Poses(0);
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  ASSERT_EQ(poses->size(), 3u);
  EXPECT_EQ((*poses)[0].bur, 0);
  EXPECT_TRUE((*poses)[0].turning);
  EXPECT_EQ((*poses)[1].bur, 1);
  EXPECT_FALSE((*poses)[1].turning);
  EXPECT_EQ((*poses)[2].bur, 1);
}

TEST(SurfaceTimelineGoldenTest, AnOutlineThatDoesNotBeginAtTheTipIsRefused) {
  Bytes file = Golden("surface_timeline.entl");
  ASSERT_TRUE(DecodeHead(file).ok());
  constexpr size_t kOutline = 136;
  file[kOutline] = 1;
  EXPECT_EQ(DecodeHead(file).status().code(), Code::kInvalidInput);
}

TEST(SurfaceTimelineTest, AnAttemptWithoutATickIsATimelineToo) {
  BallCut cut;
  const Bytes file = cut.Record(0, [](int, const cutting::Volume&) {});
  auto player = Player::Open(cut.start(), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  EXPECT_EQ(player->head().frames(), 0u);
  EXPECT_TRUE(player->Seek(0).ok());
}

TEST(SurfaceTimelineTest, BuiltInToothComesBackWithItsTissues) {
  auto built = scene::BuildBuiltinScene("molar", 200'000);
  ASSERT_TRUE(built.ok()) << built.status().message();
  const Bytes start = EncodeStartTooth(StartToothOf(built->volume));
  auto tooth = DecodeStartTooth(start);
  ASSERT_TRUE(tooth.ok()) << tooth.status().message();
  EXPECT_EQ(EncodeStartTooth(*tooth), start);
  Recorder recorder(built->volume, HashSha256(start), {});
  auto player = Player::Open(start, recorder.Finish(built->volume));
  ASSERT_TRUE(player.ok()) << player.status().message();
  const surface::Mesh expected = surface::ExtractSurface(built->volume);
  const surface::Mesh found = surface::ExtractSurface(player->ToVolume());
  ASSERT_EQ(found.triangles.size(), expected.triangles.size());
  // Which corner is the nearest may change where two are equally near.
  size_t others = 0;
  for (size_t v = 0; v < expected.tissue.size(); ++v)
    others += found.tissue[v] != expected.tissue[v];
  EXPECT_LT(others, expected.tissue.size() / 200);
  // Solid inside keeps its tissue, which a cut lays open.
  const ivec3 n = built->volume.spec().voxels();
  for (int z = 0; z < n.z; z += 3) {
    for (int y = 0; y < n.y; y += 3) {
      for (int x = 0; x < n.x; x += 3) {
        const ivec3 v(x, y, z);
        if (built->volume.PhiAt(v) >= 0) continue;
        ASSERT_EQ(player->TissueAt(v), built->volume.TissueAt(v)) << x << " " << y << " " << z;
      }
    }
  }
}

// Cells (i, j, k) that the golden tooth's surface at its end passes through, next to what was cut.
std::vector<CellDeviation> GoldenDeviation() {
  std::vector<CellDeviation> out;
  for (int b = 0; b < 125; ++b) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const ivec3 cell = ivec3(b % 5, b / 5 % 5, b / 25) * 8 + ivec3(i % 8, i / 8 % 8, i / 64);
      if (cell.x == 39 || cell.y == 39 || cell.z == 39) continue;
      int solid = 0;
      bool cut = false;
      for (int c = 0; c < 8; ++c) {
        const ivec3 corner = cell + ivec3(c & 1, c >> 1 & 1, c >> 2);
        solid += GoldenSample(corner, 5) < 0;
        cut |= GoldenSample(corner, 5) != GoldenSample(corner, 0);
      }
      if (solid == 0 || solid == 8 || !cut) continue;
      out.push_back({cell, 100 * (cell.z - 24) + 10 * (cell.x - 19) - (cell.y - 19)});
    }
  }
  return out;
}

TEST(DeviationTest, GoldenFileIsWhatTheDocumentSays) {
  auto found = DecodeDeviation(Golden("surface_timeline.endv"));
  ASSERT_TRUE(found.ok()) << found.status().message();
  EXPECT_EQ(found->spec.voxel_nm, 100'000);
  EXPECT_EQ(found->spec.bricks, ivec3(5));
  EXPECT_GT(found->cells.size(), 100u);
  EXPECT_EQ(found->cells, GoldenDeviation());
}

TEST(DeviationTest, WhatIsWrittenIsReadInWhateverOrderItCame) {
  Deviation made = *DecodeDeviation(Golden("surface_timeline.endv"));
  const std::vector<CellDeviation> cells = made.cells;
  std::ranges::reverse(made.cells);
  // Beyond the grid there is no cell; the surface at its border is nobody's work.
  made.cells.push_back({ivec3(-1, 3, 3), 5});
  made.cells.push_back({ivec3(3, 3, 40), 5});
  auto found = DecodeDeviation(EncodeDeviation(made));
  ASSERT_TRUE(found.ok()) << found.status().message();
  EXPECT_EQ(found->cells, cells);
  made.cells = {{ivec3(1), -2'000'000'000}, {ivec3(2), 2'000'000'000}};
  EXPECT_EQ(DecodeDeviation(EncodeDeviation(made))->cells, made.cells);
}

TEST(DeviationTest, DamageIsRefused) {
  const Bytes file = Golden("surface_timeline.endv");
  for (size_t n = 0; n < file.size(); ++n)
    EXPECT_FALSE(DecodeDeviation({file.data(), n}).ok()) << n;
  const auto changed = [&](size_t at, uint8_t value) {
    Bytes out = file;
    out[at] = value;
    return out;
  };
  EXPECT_EQ(DecodeDeviation(changed(4, 2)).status().code(), Code::kVersion);
  EXPECT_FALSE(DecodeDeviation(changed(6, 1)).ok());
  // Bricks and values, as the head counts them.
  for (size_t at = 48; at < 56; ++at) {
    EXPECT_FALSE(DecodeDeviation(changed(at, static_cast<uint8_t>(file[at] + 1))).ok()) << at;
  }
  for (size_t at = 64; at < file.size(); ++at) {
    (void)DecodeDeviation(changed(at, static_cast<uint8_t>(file[at] ^ 0xff)));
  }
}

TEST(SurfaceTimelineBlobTest, EveryTruncationAndEveryExtraByteIsRefused) {
  const Bytes start = Golden("surface_timeline.entb"), file = Golden("surface_timeline.entl");
  for (size_t n = 0; n < file.size(); n += n < 300 ? 1 : 61) {
    EXPECT_FALSE(Player::Open(start, {file.data(), n}).ok()) << n;
  }
  for (size_t n = 0; n < start.size(); n += n < 100 ? 1 : 61) {
    EXPECT_FALSE(DecodeStartTooth({start.data(), n}).ok()) << n;
  }
  const auto longer = [](Bytes bytes) {
    bytes.push_back(0);
    return bytes;
  };
  EXPECT_FALSE(DecodeStartTooth(longer(start)).ok());
  EXPECT_FALSE(Player::Open(start, longer(file)).ok());
}

TEST(SurfaceTimelineBlobTest, DamageIsToldOfTheFileThatHasIt) {
  Bytes start = Golden("surface_timeline.entb");
  start[60] ^= 0xff;  // in its first section
  const Status damaged = DecodeStartTooth(start).status();
  EXPECT_TRUE(damaged.message().starts_with("start tooth: section 'bricks'")) << damaged.message();
}

TEST(SurfaceTimelineBlobTest, OtherVersionsFlagsAndTeethAreRefusedByName) {
  const Bytes start = Golden("surface_timeline.entb"), file = Golden("surface_timeline.entl");
  const auto changed = [](Bytes bytes, size_t at, uint8_t value) {
    bytes[at] = value;
    return bytes;
  };
  EXPECT_EQ(DecodeHead(changed(file, 4, 2)).status().code(), Code::kVersion);
  EXPECT_EQ(DecodeStartTooth(changed(start, 4, 2)).status().code(), Code::kVersion);
  EXPECT_EQ(DecodeHead(changed(file, 6, 1)).status().code(), Code::kInvalidInput);
  EXPECT_EQ(DecodeStartTooth(changed(start, 6, 1)).status().code(), Code::kInvalidInput);
  // Byte 48 is the first of the start tooth's hash.
  const Status other =
      Player::Open(start, changed(file, 48, static_cast<uint8_t>(file[48] ^ 1))).status();
  EXPECT_EQ(other.code(), Code::kConflict) << other.message();
}

TEST(SurfaceTimelineBlobTest, ClaimsThatTheBytesCannotHoldAreRefused) {
  const Bytes start = Golden("surface_timeline.entb"), file = Golden("surface_timeline.entl");
  // The number of bricks in the last key frame, and the size of its changes, unpacked.
  const size_t last = 136 + 3 * 8 + 2 * 20;
  for (size_t at : {last + 12, last + 16}) {
    for (int byte = 0; byte < 4; ++byte) {
      Bytes bad = file;
      bad[at + static_cast<size_t>(byte)] ^= 0x55;
      auto player = Player::Open(start, bad);
      EXPECT_FALSE(player.ok() && player->Seek(5).ok()) << at << " " << byte;
    }
  }
}

}  // namespace
}  // namespace enamel::timeline
