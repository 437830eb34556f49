#include "common/timeline/parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "common/cutting/tissue.h"
#include "common/surface/surface.h"
#include "common/timeline/changing.h"
#include "common/timeline/player.h"
#include "tests/common/timeline/ball_cut.h"

namespace enamel::timeline {
namespace {

using cutting::kBrickVoxels;
using test::Golden;

using Place = std::array<uint32_t, 3>;
using Edge = std::pair<Place, Place>;

struct Parts {
  Bytes end, still, changing;
};
Parts PartsOf(const Bytes& file) {
  const Head head = *DecodeHead(file);
  const auto at = file.begin() + static_cast<ptrdiff_t>(head.bytes());
  const auto still = at + head.end_bytes, changing = still + head.still_bytes;
  return {{at, still}, {still, changing}, {changing, changing + head.changing_bytes}};
}

// A reader's triangles of the bricks that change.
void AddTriangles(const cutting::Volume& tooth, const Changing& changing,
                  std::vector<std::array<Place, 3>>& out) {
  const dvec3 origin = tooth.spec().origin_m();
  for (size_t i = 0; i < changing.bricks.size(); ++i) {
    if (!(changing.flags[i] & Changing::kTriangles)) continue;
    const surface::Mesh mesh = surface::ExtractBrick(tooth, changing.bricks[i]);
    std::vector<Place> places;
    for (const glm::vec3& p : mesh.position_m) {
      const dvec3 steps = ((dvec3(p) - origin) / tooth.spec().voxel_m() + 1.0) * 64.0;
      places.push_back({static_cast<uint32_t>(std::lround(steps.x)),
                        static_cast<uint32_t>(std::lround(steps.y)),
                        static_cast<uint32_t>(std::lround(steps.z))});
    }
    for (const auto& [a, b, c] : mesh.triangles) out.push_back({places[a], places[b], places[c]});
  }
}
void AddTriangles(const PartMesh& mesh, std::vector<std::array<Place, 3>>& out) {
  for (const auto& [a, b, c] : mesh.Triangles()) {
    out.push_back({mesh.vertices[a].at, mesh.vertices[b].at, mesh.vertices[c].at});
  }
}

// Edges that are passed more often one way than the other: where there is a gap.
size_t OpenEdges(const std::vector<std::array<Place, 3>>& triangles) {
  std::map<Edge, int> passed;
  for (const auto& t : triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const Place &from = t[k], &to = t[(k + 1) % 3];
      if (from < to) ++passed[{from, to}];
      if (to < from) --passed[{to, from}];
    }
  }
  return static_cast<size_t>(
      std::ranges::count_if(passed, [](const auto& edge) { return edge.second != 0; }));
}

TEST(PartsGoldenTest, PartsAreWhatTheDocumentSays) {
  const Bytes file = Golden("surface_timeline.entl");
  const Head head = *DecodeHead(file);
  EXPECT_EQ(head.cut, (CutBall{{0, 0, 950}, 552}));
  const Parts parts = PartsOf(file);
  const uint8_t enamel = 1, dentin = 2;
  PartMesh still, end;
  still.vertices = {{{2227, 1312, 1312}, {127, 0}, enamel},
                    {{1312, 2227, 1312}, {0, 127}, enamel},
                    {{1312, 397, 1312}, {0, -127}, enamel},
                    {{397, 1312, 1312}, {-127, 0}, enamel},
                    {{1312, 1312, 397}, {127, 127}, enamel}};
  still.strips = {0, 1, 2, 3, 4, 1, 0, PartMesh::kNewStrip, 0, 2, 4};
  end.vertices = {{{1769, 1312, 1769}, {63, 0}, enamel},
                  {{1312, 1769, 1769}, {0, 63}, enamel},
                  {{855, 855, 1769}, {-42, -42}, dentin}};
  end.strips = {0, 1, 2};
  EXPECT_EQ(still.Triangles(),
            (std::vector<std::array<uint32_t, 3>>{
                {0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 1}, {4, 1, 0}, {0, 2, 4}}));
  EXPECT_EQ(*DecodeMesh(parts.still), still);
  EXPECT_EQ(*DecodeMesh(parts.end), end);
  EXPECT_EQ(*DecodeMesh(EncodeMesh(still)), still);

  auto player = Player::Open(Golden("surface_timeline.entb"), file);
  ASSERT_TRUE(player.ok()) << player.status().message();
  auto changing = DecodeChanging(parts.changing, head.spec);
  ASSERT_TRUE(changing.ok()) << changing.status().message();
  ASSERT_EQ(changing->bricks.size(), 100u);
  size_t slot = 0;
  for (size_t i = 0; i < 100; ++i) {
    const int32_t brick = changing->bricks[i];
    EXPECT_EQ(brick, static_cast<int32_t>(i) + 25);
    EXPECT_EQ((changing->flags[i] & Changing::kTriangles) != 0, brick >= 50);
    if (changing->flags[i] & Changing::kSampled) {
      EXPECT_EQ(changing->samples[slot++], player->BrickSamples(brick)) << brick;
    }
  }
  EXPECT_EQ(slot, changing->samples.size());
}

class PartsTest : public ::testing::Test {
 protected:
  PartsTest() {
    RecorderOptions options;
    options.frame_ticks = 10;
    cut_ = std::make_unique<test::BallCut>(options);
    file_ = cut_->Record(80, [](int, const cutting::Volume&) {});
    const Parts parts = PartsOf(file_);
    still_ = *DecodeMesh(parts.still);
    end_ = *DecodeMesh(parts.end);
    changing_ = *DecodeChanging(parts.changing, DecodeHead(file_)->spec);
  }

  cutting::Volume ToothAt(uint32_t frames) {
    Player player = *Player::Open(cut_->start(), file_);
    EXPECT_TRUE(player.Seek(frames).ok());
    return player.ToVolume();
  }

  std::unique_ptr<test::BallCut> cut_;
  Bytes file_;
  PartMesh still_, end_;
  Changing changing_;
};

TEST_F(PartsTest, WhatStaysAndWhatChangesJoinWithoutAGapAtEveryMoment) {
  for (uint32_t frames : {0, 3, 8}) {
    std::vector<std::array<Place, 3>> all;
    AddTriangles(still_, all);
    AddTriangles(ToothAt(frames), changing_, all);
    EXPECT_GT(all.size(), 1000u);
    EXPECT_EQ(OpenEdges(all), 0u) << "after " << frames << " frames";
  }
  std::vector<std::array<Place, 3>> coarse;
  AddTriangles(still_, coarse);
  AddTriangles(end_, coarse);
  EXPECT_EQ(OpenEdges(coarse), 0u) << "the coarse tooth";
}

TEST_F(PartsTest, WhatStaysIsOffByAtMostWhatTheHeaderSaysAndHasFewTriangles) {
  const size_t dense = surface::ExtractSurface(ToothAt(0)).triangles.size();
  EXPECT_LT(still_.Triangles().size() + end_.Triangles().size(), dense / 5);
  // The ball of 24 voxels about sample (32, 32, 32).
  const auto off = [&](const dvec3& steps) {
    const dvec3 d = steps / 64.0 - 33.0;
    return std::abs(std::sqrt(Dot(d, d)) - 24) * 50;
  };
  const auto place = [&](uint32_t v) {
    const Place& at = still_.vertices[v].at;
    return dvec3(at[0], at[1], at[2]);
  };
  double worst_um = 0;
  for (const auto& [a, b, c] : still_.Triangles()) {
    worst_um = std::max({worst_um, off(place(a)), off((place(a) + place(b) + place(c)) / 3.0)});
  }
  EXPECT_LT(worst_um, kTriangleError_um);
  EXPECT_GT(worst_um, 0.1);
}

// As the steps of its samples let them be: distances are kept within a voxel, in steps of 1/64.
TEST_F(PartsTest, NormalsOfWhatStaysAreThoseOfTheBall) {
  double worst = 1;
  for (const PartMesh::Vertex& vertex : still_.vertices) {
    const double x = vertex.normal[0] / 127.0, y = vertex.normal[1] / 127.0,
                 z = 1 - std::abs(x) - std::abs(y);
    const dvec3 n = z >= 0 ? dvec3(x, y, z)
                           : dvec3((1 - std::abs(y)) * (x < 0 ? -1 : 1),
                                   (1 - std::abs(x)) * (y < 0 ? -1 : 1), z);
    const dvec3 out = dvec3(vertex.at[0], vertex.at[1], vertex.at[2]) / 64.0 - 33.0;
    // Where the bur went in there is an edge.
    if (out.z > 4) continue;
    worst = std::min(worst, Dot(glm::normalize(n), glm::normalize(out)));
  }
  EXPECT_GT(worst, std::cos(2.5 * std::numbers::pi / 180));
}

TEST_F(PartsTest, ReadersNeedNoBrickThatIsNotListed) {
  // All others are noise.
  const cutting::Volume whole = ToothAt(0);
  cutting::Volume listed(whole.spec());
  std::array<int16_t, kBrickVoxels> noise;
  for (size_t i = 0; i < noise.size(); ++i) noise[i] = i % 3 == 0 ? -20000 : 20000;
  for (int b = 0; b < whole.spec().brick_count(); ++b) {
    listed.SetBrick(b, noise, {}, cutting::Tissue::kPulp);
  }
  size_t sampled = 0, labelled = 0;
  for (size_t i = 0; i < changing_.bricks.size(); ++i) {
    const uint8_t flags = changing_.flags[i];
    std::array<int16_t, kBrickVoxels> phi;
    phi.fill(PhiOf(flags & (Changing::kTissue | Changing::kLabelled) ? kDeep : kFarOut));
    if (flags & Changing::kSampled) {
      std::ranges::transform(changing_.samples[sampled++], phi.begin(), PhiOf);
    }
    std::span<const uint8_t> labels;
    if (flags & Changing::kLabelled) labels = changing_.labels[labelled++].tissue;
    listed.SetBrick(changing_.bricks[i], phi, labels,
                    static_cast<cutting::Tissue>(flags & Changing::kTissue));
  }
  size_t vertices = 0;
  for (size_t i = 0; i < changing_.bricks.size(); ++i) {
    if (!(changing_.flags[i] & Changing::kTriangles)) continue;
    const surface::Mesh expected = surface::ExtractBrick(whole, changing_.bricks[i]);
    const surface::Mesh found = surface::ExtractBrick(listed, changing_.bricks[i]);
    ASSERT_EQ(found.position_m, expected.position_m) << changing_.bricks[i];
    ASSERT_EQ(found.tissue, expected.tissue) << changing_.bricks[i];
    const auto wanted = surface::SmoothNormals(whole, expected),
               read = surface::SmoothNormals(listed, found);
    // A vertex on its cell's border counts to either side, but for rounding.
    for (size_t v = 0; v < wanted.size(); ++v) ASSERT_GT(glm::dot(read[v], wanted[v]), 0.9999f);
    vertices += expected.position_m.size();
  }
  EXPECT_GT(vertices, 1000u);
}

TEST_F(PartsTest, EveryBrickThatChangesAndItsNeighboursAreListed) {
  const cutting::Volume before = ToothAt(0), after = ToothAt(8);
  std::map<int32_t, uint8_t> listed;
  for (size_t i = 0; i < changing_.bricks.size(); ++i) {
    listed[changing_.bricks[i]] = changing_.flags[i];
  }
  size_t changed = 0;
  for (int b = 0; b < before.spec().brick_count(); ++b) {
    if (QuantiseBrick(before, b) == QuantiseBrick(after, b)) continue;
    ++changed;
    EXPECT_TRUE(listed[b] & Changing::kTriangles) << b;
  }
  EXPECT_GT(changed, 10u);
  EXPECT_LT(changing_.bricks.size(), 512u);
}

TEST_F(PartsTest, BricksThatAReferenceHasCutAreKeptInDetail) {
  RecorderOptions options;
  options.detailed = {64 * 1 + 8 * 4 + 4};  // below the ball's middle, where nothing was cut
  test::BallCut cut(options);
  const Bytes file = cut.Record(0, [](int, const cutting::Volume&) {});
  const Changing found = *DecodeChanging(PartsOf(file).changing, DecodeHead(file)->spec);
  size_t with_triangles = 0;
  for (uint8_t flags : found.flags) with_triangles += (flags & Changing::kTriangles) != 0;
  EXPECT_EQ(with_triangles, 27u);
}

TEST_F(PartsTest, NeighboursHaveFewerTrianglesThanTheTooth) {
  const auto triangles = [](cutting::Tissue tissue) {
    cutting::Volume ball = test::BallCut().initial();
    for (int b = 0; b < ball.spec().brick_count(); ++b) {
      if (ball.IsStored(b)) ball.SetBrick(b, ball.Phi(b).phi, {}, tissue);
    }
    const std::vector<uint8_t> none(static_cast<size_t>(ball.spec().brick_count()));
    return MeshesOf(Quantised(ball), none).still.Triangles().size();
  };
  EXPECT_LT(1.5 * static_cast<double>(triangles(cutting::Tissue::kNeighbour)),
            static_cast<double>(triangles(cutting::Tissue::kEnamel)));
}

TEST_F(PartsTest, TheBallAroundWhatWasRemovedIsInTheHead) {
  const CutBall found = DecodeHead(file_)->cut;
  // From x = −1.6 to about 1.56 mm, within the tooth of 1.2 mm about the origin; 0.5 mm about z = 0.6.
  EXPECT_NEAR(found.centre_um[0], 0, 60);
  EXPECT_NEAR(found.centre_um[2], 850, 300);
  EXPECT_GT(found.radius_um, 900);
  EXPECT_LT(found.radius_um, 1500);
}

TEST(PartsBlobTest, EveryTruncationExtraByteAndDamageIsRefusedOrHarmless) {
  const Bytes file = Golden("surface_timeline.entl");
  const cutting::GridSpec spec = DecodeHead(file)->spec;
  const Parts parts = PartsOf(file);
  const auto readable = [&](const Bytes& bytes, bool mesh) {
    return mesh ? DecodeMesh(bytes).ok() : DecodeChanging(bytes, spec).ok();
  };
  for (const auto& [part, mesh] :
       {std::pair(parts.still, true), {parts.end, true}, {parts.changing, false}}) {
    ASSERT_TRUE(readable(part, mesh));
    for (size_t n = 0; n < part.size(); n += n < 100 ? 1 : 61) {
      EXPECT_FALSE(readable({part.begin(), part.begin() + static_cast<ptrdiff_t>(n)}, mesh)) << n;
    }
    Bytes longer = part;
    longer.push_back(0);
    EXPECT_FALSE(readable(longer, mesh));
    // Counts that the bytes cannot hold.
    for (size_t at = 0; at < 4; ++at) {
      Bytes bad = part;
      bad[at] ^= 0x55;
      EXPECT_FALSE(readable(bad, mesh)) << at;
    }
    for (size_t at = 4; at < part.size(); ++at) {
      Bytes bad = part;
      bad[at] ^= 0xff;
      (void)readable(bad, mesh);
    }
  }
}

}  // namespace
}  // namespace enamel::timeline
