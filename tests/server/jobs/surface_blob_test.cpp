#include "server/jobs/surface_blob.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

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

cutting::Volume Block() { return test::Block(200'000, 1.3e-3, 1e-3); }
surface::Mesh Mesh() { return surface::ExtractSurface(Block()); }

TEST(EncodeSurfaceTest, ReadsBackWithinItsQuantisation) {
  const CelledSurface surface = CelledSurfaceOf(Block());
  const surface::Mesh& mesh = surface.mesh;
  std::vector<float> deviation(mesh.position_m.size(), 0.3004e-3f);
  deviation[0] = std::nanf("");
  Decoded d = Decode(
      EncodeSurface(surface, timeline::DeviationOf(Block().spec(), surface.cell, deviation)));
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
  EXPECT_EQ(d.deviation_mm[1], 0.3f) << "whole micrometres";
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

// What is kept of a surface is enough to make it again, to the bit.
TEST(EncodeSurfaceTest, IsMadeAgainOfTheVolumeAndTheStoredDeviation) {
  cutting::GridSpec spec;
  spec.voxel_nm = 50'000;
  spec.bricks = ivec3(6);
  spec.origin_nm = {-1'200'000, -1'170'000, -1'190'000};
  const cutting::Volume ball = test::VolumeOf(
      spec, cutting::Tissue::kDentin, [](const dvec3& p) { return glm::length(p) - 0.9e-3; });
  // The block's faces go through samples, where a vertex lies on its cell's border.
  for (const cutting::Volume& volume : {test::Block(100'000, 1e-3, 0.8e-3), ball}) {
    const CelledSurface surface = CelledSurfaceOf(volume);
    std::vector<float> deviation(surface.cell.size());
    for (size_t i = 0; i < deviation.size(); ++i) deviation[i] = surface.mesh.position_m[i].z;
    const auto by_cell = timeline::DeviationOf(volume.spec(), surface.cell, deviation);
    EXPECT_EQ(by_cell.cells.size(), surface.cell.size());
    const auto stored = timeline::DecodeDeviation(timeline::EncodeDeviation(by_cell));
    ASSERT_TRUE(stored.ok());
    EXPECT_EQ(EncodeSurface(CelledSurfaceOf(volume), *stored), EncodeSurface(surface, by_cell));
  }
}

TEST(DeviationOfTest, VerticesThatWereNotComparedAreLeftOut) {
  const CelledSurface surface = CelledSurfaceOf(Block());
  std::vector<float> deviation(surface.cell.size(), std::nanf(""));
  deviation[7] = -0.25e-3f;
  const auto found = timeline::DeviationOf(Block().spec(), surface.cell, deviation);
  ASSERT_EQ(found.cells.size(), 1u);
  EXPECT_EQ(found.cells[0].cell, surface.cell[7]);
  EXPECT_EQ(found.cells[0].deviation_um, -250);
}

}  // namespace
}  // namespace enamel::server
