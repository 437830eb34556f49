#include "server/jobs/surface_blob.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <set>

#include "common/timeline/deviation.h"
#include "tests/support/analytic_volume.h"

namespace enamel::server {
namespace {

struct Decoded {
  uint16_t version = 0, flags = 0;
  std::vector<dvec3> position_mm;
  std::vector<dvec3> normal;
  std::vector<uint8_t> tissue;
  std::vector<float> deviation_mm;
  std::vector<std::array<uint32_t, 3>> triangles;
  bool whole = false;
};

// Reads the table of schemas/api/openapi.yaml line by line.
Decoded Decode(ByteView bytes) {
  ByteReader in(bytes);
  Decoded out;
  auto f32 = [&] { return std::bit_cast<float>(in.U32()); };
  auto pad = [&] {
    while (in.offset() % 4 != 0) in.U8();
  };
  EXPECT_EQ(AsText(in.Raw(4)), "ENTM");
  out.version = in.U16();
  out.flags = in.U16();
  uint32_t n = in.U32(), m = in.U32();
  dvec3 origin;
  for (int i = 0; i < 3; ++i) origin[i] = f32();
  double scale = f32();
  for (uint32_t v = 0; v < n; ++v) {
    dvec3 p;
    for (int i = 0; i < 3; ++i) p[i] = origin[i] + scale * in.U16();
    out.position_mm.push_back(p);
  }
  pad();
  for (uint32_t v = 0; v < n; ++v) {
    dvec3 d;
    for (int i = 0; i < 3; ++i) d[i] = static_cast<int8_t>(in.U8()) / 127.0;
    EXPECT_EQ(in.U8(), 0);
    out.normal.push_back(d);
  }
  for (uint32_t v = 0; v < n; ++v) out.tissue.push_back(in.U8());
  pad();
  if (out.flags & 1) {
    for (uint32_t v = 0; v < n; ++v) out.deviation_mm.push_back(f32());
  }
  for (uint32_t t = 0; t < m; ++t) {
    auto& triangle = out.triangles.emplace_back();
    for (uint32_t& v : triangle) v = in.U32();
  }
  out.whole = in.ok() && in.AtEnd();
  return out;
}

surface::Mesh Mesh() { return surface::ExtractSurface(test::Block(200'000, 1.3e-3, 1e-3)); }

TEST(EncodeSurfaceTest, ReadsBackWithinItsQuantisation) {
  surface::Mesh mesh = Mesh();
  std::vector<float> deviation(mesh.position_m.size(), 0.3e-3f);
  deviation[0] = std::nanf("");
  Decoded d = Decode(EncodeSurface(mesh, deviation));
  ASSERT_TRUE(d.whole);
  EXPECT_EQ(d.version, 1);
  ASSERT_EQ(d.position_mm.size(), mesh.position_m.size());
  for (size_t i = 0; i < d.position_mm.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(d.position_mm[i][k], mesh.position_m[i][k] * 1e3, 2.6 / 65535);
      EXPECT_NEAR(d.normal[i][k], mesh.normal[i][k], 0.5 / 127 + 1e-6);
    }
  }
  EXPECT_EQ(d.tissue, mesh.tissue);
  EXPECT_EQ(d.triangles, mesh.triangles);
  EXPECT_TRUE(std::isnan(d.deviation_mm[0]));
  EXPECT_NEAR(d.deviation_mm[1], 0.3, 1e-6);
}

TEST(EncodeSurfaceTest, WithoutDeviationTheFlagIsClear) {
  Decoded d = Decode(EncodeSurface(Mesh()));
  EXPECT_TRUE(d.whole);
  EXPECT_EQ(d.flags, 0);
  EXPECT_TRUE(d.deviation_mm.empty());
}

TEST(EncodeSurfaceTest, AnEmptySurfaceIsAHeader) {
  Bytes bytes = EncodeSurface({});
  EXPECT_EQ(bytes.size(), 32u);
  EXPECT_TRUE(Decode(bytes).whole);
}

TEST(EncodeSurfaceTest, EverySectionStartsAtAMultipleOfFour) {
  surface::Mesh odd;  // three vertices: 18 bytes of positions, 3 of tissue
  odd.position_m = {{0, 0, 0}, {1e-3f, 0, 0}, {0, 1e-3f, 0}};
  odd.normal.assign(3, {0, 0, 1});
  odd.tissue.assign(3, 1);
  odd.triangles = {{0, 1, 2}};
  EXPECT_EQ(EncodeSurface(odd).size(), 32u + 20 + 12 + 4 + 12);
}

// Corners on both sides: surface nets put a vertex there.
std::set<std::array<int, 3>> CrossedCells(const cutting::Volume& volume) {
  std::set<std::array<int, 3>> out;
  const ivec3 size = volume.spec().bricks * cutting::kBrickSide;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        int solid = 0;
        for (int i = 0; i < 8; ++i) {
          const ivec3 corner = ivec3(x, y, z) + ivec3(i & 1, i >> 1 & 1, i >> 2);
          const bool inside = corner.x < size.x && corner.y < size.y && corner.z < size.z;
          solid += inside && volume.PhiAt(corner) < 0;
        }
        if (solid != 0 && solid != 8) out.insert({x, y, z});
      }
    }
  }
  return out;
}

// A block whose faces go through samples, where a vertex lies on its cell's border, and a ball.
TEST(DeviationOfSurfaceTest, VerticesAreFoundInTheCellsThatTheyWereMadeIn) {
  cutting::GridSpec spec;
  spec.voxel_nm = 50'000;
  spec.bricks = ivec3(6);
  spec.origin_nm = {-1'200'000, -1'170'000, -1'190'000};
  const cutting::Volume ball = test::VolumeOf(
      spec, cutting::Tissue::kDentin, [](const dvec3& p) { return glm::length(p) - 0.9e-3; });
  for (const cutting::Volume& volume : {test::Block(100'000, 1e-3, 0.8e-3), ball}) {
    const surface::Mesh mesh = surface::ExtractSurface(volume);
    std::vector<float> deviation(mesh.position_m.size());
    for (size_t i = 0; i < deviation.size(); ++i) deviation[i] = mesh.position_m[i].z;
    auto found = DeviationOfSurface(EncodeSurface(mesh, deviation), volume.spec());
    ASSERT_TRUE(found.ok()) << found.status().message();
    const std::set<std::array<int, 3>> crossed = CrossedCells(volume);
    // Of the ball's a few lie nearer to a border than positions are rounded by.
    ASSERT_EQ(crossed.size(), mesh.position_m.size());
    EXPECT_GE(found->cells.size(), crossed.size() * 997 / 1000);
    size_t beside = 0;
    for (const timeline::CellDeviation& value : found->cells) {
      const ivec3& c = value.cell;
      beside += !crossed.contains({c.x, c.y, c.z});
      const double low_m = volume.spec().origin_m().z + c.z * volume.spec().voxel_m();
      EXPECT_GE(value.deviation_um, low_m * 1e6 - 1);
      EXPECT_LE(value.deviation_um, (low_m + volume.spec().voxel_m()) * 1e6 + 1);
    }
    EXPECT_LE(beside, crossed.size() * 3 / 1000);
    if (volume.spec().voxel_nm == 100'000) EXPECT_EQ(found->cells.size(), crossed.size());
  }
}

TEST(DeviationOfSurfaceTest, VerticesThatWereNotComparedAreLeftOut) {
  const cutting::Volume volume = test::Block(200'000, 1.3e-3, 1e-3);
  const surface::Mesh mesh = surface::ExtractSurface(volume);
  std::vector<float> deviation(mesh.position_m.size(), std::nanf(""));
  deviation[7] = -0.25e-3f;
  auto found = DeviationOfSurface(EncodeSurface(mesh, deviation), volume.spec());
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->cells.size(), 1u);
  EXPECT_EQ(found->cells[0].deviation_um, -250);
}

TEST(DeviationOfSurfaceTest, WhatIsNoSurfaceOrHasNoDeviationIsRefused) {
  const cutting::Volume volume = test::Block(200'000, 1.3e-3, 1e-3);
  const Bytes without = EncodeSurface(surface::ExtractSurface(volume));
  EXPECT_EQ(DeviationOfSurface(without, volume.spec()).status().code(), Code::kNotFound);
  const surface::Mesh mesh = Mesh();
  const Bytes whole = EncodeSurface(mesh, std::vector<float>(mesh.position_m.size(), 0.1f));
  const size_t needed = 32 + 15 * mesh.position_m.size();
  for (size_t n = 0; n < needed; n += n < 40 ? 1 : 997) {
    EXPECT_EQ(DeviationOfSurface({whole.data(), n}, volume.spec()).status().code(),
              Code::kInvalidInput)
        << n;
  }
}

}  // namespace
}  // namespace enamel::server
