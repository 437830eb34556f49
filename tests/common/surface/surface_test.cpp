#include "common/surface/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include "common/cutting/cutter.h"
#include "common/surface/brick_meshes.h"
#include "common/surface/ply.h"

namespace enamel::surface {
namespace {

using cutting::Bur;
using cutting::BurShape;
using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::kPhiLimit;
using cutting::kPhiPerVoxel;
using cutting::Tissue;
using cutting::Volume;

constexpr double kVoxel_m = 50e-6;

GridSpec Grid(const ivec3& bricks, std::array<int64_t, 3> origin_nm = {0, 0, 0}) {
  return GridSpec{50'000, bricks, origin_nm};
}

// Samples `distance` (voxels, of a point in voxel coordinates) into a volume.
Volume Sampled(const GridSpec& spec, const std::function<double(const dvec3&)>& distance,
               const std::function<Tissue(const dvec3&)>& tissue = {}) {
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    ivec3 first(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
                b / (spec.bricks.x * spec.bricks.y));
    first *= kBrickSide;
    std::array<int16_t, kBrickVoxels> phi;
    std::vector<uint8_t> labels(tissue ? kBrickVoxels : 0);
    for (int i = 0; i < kBrickVoxels; ++i) {
      dvec3 p(first + ivec3(i & 7, i >> 3 & 7, i >> 6));
      double v =
          std::clamp(std::round(distance(p) * kPhiPerVoxel), -double{kPhiLimit}, double{kPhiLimit});
      phi[static_cast<size_t>(i)] = static_cast<int16_t>(v);
      if (tissue) labels[static_cast<size_t>(i)] = static_cast<uint8_t>(tissue(p));
    }
    bool air = std::all_of(phi.begin(), phi.end(), [](int v) { return v == kPhiLimit; });
    bool deep = std::all_of(phi.begin(), phi.end(), [](int v) { return v == -kPhiLimit; });
    if (air)
      volume.SetUniform(b, Tissue::kAir);
    else if (deep && !tissue)
      volume.SetUniform(b, Tissue::kEnamel);
    else
      volume.SetBrick(b, phi, labels, Tissue::kEnamel);
  }
  return volume;
}

double BoxDistance(const dvec3& p, const dvec3& lo, const dvec3& hi) {
  dvec3 q = glm::max(lo - p, p - hi);
  dvec3 out = glm::max(q, dvec3(0));
  return glm::length(out) + std::min(0.0, std::max({q.x, q.y, q.z}));
}

// Sphere of 20 voxels whose centre is no lattice point and whose surface crosses many bricks.
constexpr double kRadius = 20;
const dvec3 kCentre(31.37, 30.81, 32.13);
Volume Ball() {
  return Sampled(Grid({8, 8, 8}),
                 [](const dvec3& p) { return glm::length(p - kCentre) - kRadius; });
}

std::map<std::pair<uint32_t, uint32_t>, int> DirectedEdges(const Mesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  return edges;
}

void ExpectClosed(const Mesh& mesh) {
  auto edges = DirectedEdges(mesh);
  size_t unmatched = 0;
  for (const auto& [edge, count] : edges) {
    auto opposite = edges.find({edge.second, edge.first});
    unmatched += opposite == edges.end() || opposite->second != count;
  }
  EXPECT_EQ(unmatched, 0u);
  EXPECT_FALSE(edges.empty());
}

void ExpectEveryEdgeTwice(const Mesh& mesh) {
  ExpectClosed(mesh);
  for (const auto& [edge, count] : DirectedEdges(mesh)) ASSERT_EQ(count, 1);
}

using Corners = std::array<std::array<float, 3>, 3>;

// Triangles by position, each begun at its lowest corner, so that vertex numbering does not matter.
void AppendTriangles(const Mesh& mesh, std::vector<Corners>& out) {
  for (const auto& t : mesh.triangles) {
    Corners c;
    for (size_t i = 0; i < 3; ++i) {
      glm::vec3 p = mesh.position_m[t[i]];
      c[i] = {p.x, p.y, p.z};
    }
    std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
    out.push_back(c);
  }
}

void ExpectBricksMakeTheWhole(const Volume& volume) {
  std::vector<Corners> whole, parts;
  AppendTriangles(ExtractSurface(volume), whole);
  for (int b = 0; b < volume.spec().brick_count(); ++b)
    AppendTriangles(ExtractBrick(volume, b), parts);
  std::sort(whole.begin(), whole.end());
  std::sort(parts.begin(), parts.end());
  EXPECT_EQ(whole.size(), parts.size());
  EXPECT_TRUE(whole == parts);
}

TEST(SurfaceTest, SphereIsClosedWithEveryEdgeTwice) {
  Mesh mesh = ExtractSurface(Ball());
  ASSERT_GT(mesh.triangles.size(), 5000u);
  ExpectEveryEdgeTwice(mesh);
}

TEST(SurfaceTest, SphereVerticesAreWithinATwentiethOfAVoxel) {
  Mesh mesh = ExtractSurface(Ball());
  double worst = 0;
  for (const auto& p : mesh.position_m) {
    worst = std::max(worst, std::fabs(glm::length(dvec3(p) / kVoxel_m - kCentre) - kRadius));
  }
  EXPECT_LE(worst, 0.05);
}

// The mesh is inside by about 0.02 voxel on average: 0.1 % of the radius, 0.3 % of the volume.
TEST(SurfaceTest, SphereVolumeAndAreaMeetTheClosedForm) {
  Mesh mesh = ExtractSurface(Ball());
  double r = kRadius * kVoxel_m;
  EXPECT_NEAR(EnclosedVolume_m3(mesh) / (4.0 / 3.0 * std::numbers::pi * r * r * r), 1, 0.005);
  EXPECT_NEAR(Area_m2(mesh) / (4 * std::numbers::pi * r * r), 1, 0.005);
}

TEST(SurfaceTest, SphereNormalsPointOutward) {
  Mesh mesh = ExtractSurface(Ball());
  double worst = 1;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    dvec3 n(mesh.normal[i]);
    ASSERT_NEAR(glm::length(n), 1, 1e-5);
    worst = std::min(worst, Dot(n, glm::normalize(dvec3(mesh.position_m[i]) / kVoxel_m - kCentre)));
  }
  EXPECT_GT(worst, std::cos(3 * std::numbers::pi / 180));
}

const dvec3 kMiddle(15.7, 16.2, 15.4);

// Samples count as at most a voxel away, which turns a normal a little.
TEST(SmoothNormalTest, BallAndPlaneAreTheClosedForm) {
  for (const double radius : {3.0, 5.0, 12.0, 1e4}) {
    const dvec3 centre = kMiddle - glm::normalize(dvec3(1, 2, 3)) * (radius > 100 ? radius : 0.0);
    const Volume volume =
        Sampled(Grid({4, 4, 4}), [&](const dvec3& p) { return glm::length(p - centre) - radius; });
    const Mesh mesh = ExtractSurface(volume);
    const std::vector<glm::vec3> normals = SmoothNormals(volume, mesh);
    ASSERT_EQ(normals.size(), mesh.normal.size());
    double worst = 1;
    size_t checked = 0;
    for (size_t i = 0; i < normals.size(); ++i) {
      const dvec3 p = dvec3(mesh.position_m[i]) / kVoxel_m;
      if (std::min({p.x, p.y, p.z}) < 3 || std::max({p.x, p.y, p.z}) > 28) continue;
      ++checked;
      worst = std::min(worst, Dot(dvec3(normals[i]), glm::normalize(p - centre)));
    }
    EXPECT_GT(checked, 150u) << radius;
    EXPECT_GT(worst, std::cos(2 * std::numbers::pi / 180)) << radius;
  }
}

// Two walls at right angles, whichever way they lie on the grid: their edge is known.
TEST(SmoothNormalTest, AlongTheEdgeOfTwoWallsItLeansToNeitherEnd) {
  std::mt19937 random(7);
  std::normal_distribution<double> any;
  const auto direction = [&] {
    return glm::normalize(dvec3(any(random), any(random), any(random)));
  };
  double worst = 0, worst_of_cells = 0;
  for (int turn = 0; turn < 20; ++turn) {
    const dvec3 a = direction(), edge = glm::normalize(glm::cross(a, direction())),
                b = glm::cross(edge, a);
    const Volume volume = Sampled(Grid({4, 4, 4}), [&](const dvec3& p) {
      return std::max(Dot(p - kMiddle, a), Dot(p - kMiddle, b));
    });
    const Mesh mesh = ExtractSurface(volume);
    const std::vector<glm::vec3> normals = SmoothNormals(volume, mesh);
    for (size_t i = 0; i < normals.size(); ++i) {
      const dvec3 p = dvec3(mesh.position_m[i]) / kVoxel_m;
      if (std::min({p.x, p.y, p.z}) < 4 || std::max({p.x, p.y, p.z}) > 27) continue;
      worst = std::max(worst, std::fabs(Dot(dvec3(normals[i]), edge)));
      worst_of_cells = std::max(worst_of_cells, std::fabs(Dot(dvec3(mesh.normal[i]), edge)));
    }
  }
  EXPECT_LT(worst, std::sin(8 * std::numbers::pi / 180));
  EXPECT_GT(worst_of_cells, std::sin(25 * std::numbers::pi / 180));
}

// Thinner than a voxel: there is no gradient in its middle.
TEST(SmoothNormalTest, WhereTheGradientVanishesTheOtherNormalStays) {
  const Volume volume(Grid({1, 1, 1}));
  const glm::vec3 otherwise(0, 1, 0);
  EXPECT_EQ(SmoothNormal(volume, dvec3(3.2, 4.1, 3.7), otherwise), otherwise);
}

TEST(SurfaceTest, TrianglesFaceTheWayTheirNormalsDo) {
  Mesh mesh = ExtractSurface(Ball());
  for (const auto& t : mesh.triangles) {
    glm::vec3 a = mesh.position_m[t[0]], b = mesh.position_m[t[1]], c = mesh.position_m[t[2]];
    ASSERT_GE(glm::dot(glm::cross(b - a, c - a), mesh.normal[t[0]]), 0);
  }
}

TEST(SurfaceTest, FlatWallsOfABoxAreExact) {
  dvec3 lo(5.3, 6.25, 7.8), hi(25.6, 26.5, 20.1);
  Mesh mesh = ExtractSurface(
      Sampled(Grid({4, 4, 4}), [&](const dvec3& p) { return BoxDistance(p, lo, hi); }));
  ExpectEveryEdgeTwice(mesh);
  size_t on_walls = 0;
  for (const auto& position : mesh.position_m) {
    dvec3 p = dvec3(position) / kVoxel_m;
    for (int axis = 0; axis < 3; ++axis) {
      int u = (axis + 1) % 3, w = (axis + 2) % 3;
      bool away_from_edges =
          p[u] > lo[u] + 2 && p[u] < hi[u] - 2 && p[w] > lo[w] + 2 && p[w] < hi[w] - 2;
      if (!away_from_edges) continue;
      ++on_walls;
      // Resolution of the stored distance is 1/8192 voxel, of the position in single precision
      // 1/50000.
      EXPECT_LT(std::min(std::fabs(p[axis] - lo[axis]), std::fabs(p[axis] - hi[axis])), 2e-4);
    }
  }
  EXPECT_GT(on_walls, 1000u);
  // The mean of crossings bevels the box's edges. With walls at fractions a, b of the edge's cell
  // the section lost is the quadrilateral (a, b), (a, -1/2), (a/2, b/2), (-1/2, b): at most 0.75
  // voxel^2.
  dvec3 size = hi - lo;
  double exact = size.x * size.y * size.z, bevel = 4 * (size.x + size.y + size.z) * 0.75;
  double volume = EnclosedVolume_m3(mesh) / std::pow(kVoxel_m, 3);
  EXPECT_LE(volume, exact + 0.5);
  EXPECT_GE(volume, exact - bevel);
}

TEST(SurfaceTest, ObliqueFlatWallIsExact) {
  dvec3 n = glm::normalize(dvec3(1, 2, 3)), through(15.5, 16.2, 15.9);
  Mesh mesh =
      ExtractSurface(Sampled(Grid({4, 4, 4}), [&](const dvec3& p) { return Dot(p - through, n); }));
  size_t checked = 0;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    dvec3 p = dvec3(mesh.position_m[i]) / kVoxel_m;
    if (std::min({p.x, p.y, p.z}) < 1 || std::max({p.x, p.y, p.z}) > 30) continue;  // grid's border
    ++checked;
    EXPECT_LT(std::fabs(Dot(p - through, n)), 3e-4);
    EXPECT_GT(Dot(dvec3(mesh.normal[i]), n), 0.99999);
  }
  EXPECT_GT(checked, 500u);
}

TEST(SurfaceTest, SolidThatTouchesTheBorderIsClosed) {
  Mesh full = ExtractSurface(Sampled(Grid({2, 3, 2}), [](const dvec3&) { return -10.0; }));
  ExpectEveryEdgeTwice(full);
  // Samples 0..15 are solid and those at -1 and 16 count as air: walls half-way between.
  EXPECT_NEAR(EnclosedVolume_m3(full) / std::pow(kVoxel_m, 3), 16 * 24 * 16, 4 * 56 * 0.75);
  Mesh half = ExtractSurface(Sampled(Grid({2, 2, 2}), [](const dvec3& p) { return p.z - 7.5; }));
  ExpectEveryEdgeTwice(half);
}

TEST(SurfaceTest, OriginShiftsEveryVertex) {
  auto field = [](const dvec3& p) { return glm::length(p - dvec3(8.2, 7.7, 8.1)) - 5; };
  Mesh a = ExtractSurface(Sampled(Grid({2, 2, 2}), field));
  Mesh b = ExtractSurface(Sampled(Grid({2, 2, 2}, {-1'000'000, 2'000'000, 500'000}), field));
  ASSERT_EQ(a.position_m.size(), b.position_m.size());
  for (size_t i = 0; i < a.position_m.size(); ++i) {
    glm::vec3 d = b.position_m[i] - a.position_m[i] - glm::vec3(-1e-3f, 2e-3f, 0.5e-3f);
    EXPECT_LT(glm::length(d), 1e-9f);
  }
}

TEST(SurfaceTest, BricksTogetherMakeTheWhole) { ExpectBricksMakeTheWhole(Ball()); }

TEST(SurfaceTest, StaysClosedAndConsistentAfterCuts) {
  for (BurShape shape : {BurShape::kSphere, BurShape::kCylinder}) {
    Volume volume = Ball();
    volume.Reserve();
    Bur bur{shape, 0.4e-3, 1.5e-3};
    cutting::Cutter cutter(volume, bur);
    cutting::RemovedUnits removed{};
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-1, 1);
    double before = EnclosedVolume_m3(ExtractSurface(volume));
    for (int i = 0; i < 60; ++i) {
      cutting::Pose pose;
      pose.tip_m = (kCentre + 22.0 * dvec3(unit(random), unit(random), unit(random))) * kVoxel_m;
      pose.orientation = Quat{unit(random), unit(random), unit(random), unit(random)}.Normalised();
      ASSERT_TRUE(cutter.Cut(pose, removed));
    }
    Mesh mesh = ExtractSurface(volume);
    ExpectClosed(mesh);
    ExpectBricksMakeTheWhole(volume);
    double removed_m3 =
        cutting::RemovedUnitsToM3(removed[static_cast<size_t>(Tissue::kEnamel)], kVoxel_m);
    // Two independent measures of what was removed; the mesh bevels sharp ridges.
    EXPECT_NEAR((before - EnclosedVolume_m3(mesh)) / removed_m3, 1, 0.02);
  }
}

TEST(SurfaceTest, CutWallLiesOnTheBur) {
  Volume volume = Sampled(Grid({6, 6, 6}), [](const dvec3& p) { return p.z - 30.25; });
  volume.Reserve();
  Bur bur{BurShape::kCylinder, 0.5e-3, 2e-3};
  cutting::Cutter cutter(volume, bur);
  cutting::RemovedUnits removed{};
  cutting::Pose pose;
  pose.tip_m = dvec3(24.3, 23.9, 18.4) * kVoxel_m;
  ASSERT_TRUE(cutter.Cut(pose, removed));
  Mesh mesh = ExtractSurface(volume);
  size_t floor_vertices = 0, wall_vertices = 0;
  for (const auto& position : mesh.position_m) {
    dvec3 p = dvec3(position) / kVoxel_m - dvec3(24.3, 23.9, 18.4);
    double rho = std::hypot(p.x, p.y);
    if (rho < 8.5 && std::fabs(p.z) < 5) {
      ++floor_vertices;
      EXPECT_LT(std::fabs(p.z), 3e-4);
    } else if (rho < 10.5 && p.z > 1.5 && p.z < 10.5) {
      ++wall_vertices;
      EXPECT_LT(std::fabs(rho - 10), 0.06);  // 0.5 / R, as for the sphere
    }
  }
  EXPECT_GT(floor_vertices, 200u);
  EXPECT_GT(wall_vertices, 300u);
}

TEST(SurfaceTest, ChangedBricksAndNeighboursAreAllThatChanges) {
  Volume volume = Ball();
  volume.Reserve();
  std::vector<Mesh> before;
  for (int b = 0; b < volume.spec().brick_count(); ++b) before.push_back(ExtractBrick(volume, b));
  cutting::Cutter cutter(volume, Bur{BurShape::kSphere, 0.3e-3, 0});
  cutting::RemovedUnits removed{};
  cutting::Pose pose;
  pose.tip_m = (kCentre + dvec3(0, 0, 16)) * kVoxel_m;
  ASSERT_TRUE(cutter.Cut(pose, removed));
  ivec3 n = volume.spec().bricks;
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    Mesh now = ExtractBrick(volume, b);
    if (now.position_m == before[static_cast<size_t>(b)].position_m) continue;
    ivec3 at(b % n.x, b / n.x % n.y, b / (n.x * n.y));
    bool near = false;
    for (int t : cutter.touched()) {
      ivec3 d = glm::abs(ivec3(t % n.x, t / n.x % n.y, t / (n.x * n.y)) - at);
      near |= std::max({d.x, d.y, d.z}) <= 1;
    }
    EXPECT_TRUE(near);
  }
}

int EulerNumber(const Mesh& mesh) {
  return static_cast<int>(mesh.position_m.size()) -
         static_cast<int>(DirectedEdges(mesh).size() / 2) + static_cast<int>(mesh.triangles.size());
}

TEST(SurfaceTest, EulerNumberTellsASphereFromOneWithATunnelFromTwo) {
  EXPECT_EQ(EulerNumber(ExtractSurface(Ball())), 2);
  Volume tunnel = Ball();
  tunnel.Reserve();
  cutting::Cutter cutter(tunnel, Bur{BurShape::kCylinder, 0.3e-3, 3e-3});
  cutting::RemovedUnits removed{};
  cutting::Pose pose;
  pose.tip_m = (kCentre + dvec3(0, 0, -25)) * kVoxel_m;
  ASSERT_TRUE(cutter.Cut(pose, removed));
  EXPECT_EQ(EulerNumber(ExtractSurface(tunnel)), 0);
  auto two = [](const dvec3& p) {
    return std::min(glm::length(p - dvec3(12.3, 16, 16)) - 6,
                    glm::length(p - dvec3(40.2, 16, 16)) - 7);
  };
  EXPECT_EQ(EulerNumber(ExtractSurface(Sampled(Grid({7, 4, 4}), two))), 4);
}

void ExpectSameMesh(const Mesh& a, const Mesh& b, int brick) {
  ASSERT_TRUE(a.position_m == b.position_m) << brick;
  ASSERT_TRUE(a.normal == b.normal) << brick;
  ASSERT_TRUE(a.tissue == b.tissue) << brick;
  ASSERT_TRUE(a.triangles == b.triangles) << brick;
}

// Slow travel, turns and jumps: after each cut the kept meshes are those of the whole, extracted
// anew.
TEST(BrickMeshesTest, KeptUpToDateTheyEqualThoseMadeAnew) {
  for (BurShape shape : {BurShape::kSphere, BurShape::kCylinder}) {
    Volume volume = Ball();
    volume.Reserve();
    BrickMeshes meshes(volume.spec());
    meshes.ExtractAll(volume);
    cutting::Cutter cutter(volume, Bur{shape, 0.4e-3, 1.5e-3});
    cutting::RemovedUnits removed{};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    cutting::Pose pose;
    size_t renewed = 0, looked_at = 0;
    for (int i = 0; i < 80; ++i) {
      if (i % 20 == 0) {
        pose.tip_m = (kCentre + 20.0 * dvec3(unit(random), unit(random), unit(random))) * kVoxel_m;
      }
      if (i % 5 == 0) {
        pose.orientation =
            Quat{unit(random), unit(random), unit(random), unit(random)}.Normalised();
      }
      pose.tip_m += dvec3(3e-6, -2e-6, 1e-6);
      ASSERT_TRUE(cutter.Cut(pose, removed));
      renewed += meshes.Update(volume, cutter.touched()).size();
      looked_at += meshes.looked_at();
      if (i % 4 != 0) continue;
      for (int b = 0; b < volume.spec().brick_count(); ++b) {
        ExpectSameMesh(meshes.at(b), ExtractBrick(volume, b), b);
      }
    }
    // The claim means nothing if every mesh was rebuilt.
    EXPECT_GT(renewed, 100u);
    EXPECT_LT(2 * renewed, looked_at);
  }
}

TEST(BrickMeshesTest, NothingChangedNothingIsMadeAnew) {
  Volume volume = Ball();
  BrickMeshes meshes(volume.spec());
  meshes.ExtractAll(volume);
  std::vector<int32_t> all(static_cast<size_t>(volume.spec().brick_count()));
  for (size_t b = 0; b < all.size(); ++b) all[b] = static_cast<int32_t>(b);
  EXPECT_TRUE(meshes.Update(volume, all).empty());
}

TEST(PlyTest, HoldsEveryVertexInMillimetresAndEveryTriangle) {
  Mesh mesh = ExtractSurface(Ball());
  Bytes ply = EncodePly(mesh);
  std::string text(AsText(ply));
  size_t body = text.find("end_header\n") + 11;
  ASSERT_NE(text.find("element vertex " + std::to_string(mesh.position_m.size()) + "\n"),
            std::string::npos);
  ASSERT_NE(text.find("comment unit: mm\n"), std::string::npos);
  ASSERT_EQ(ply.size(), body + 25 * mesh.position_m.size() + 13 * mesh.triangles.size());
  ByteReader in(ByteView(ply).subspan(body));
  for (const auto& p : mesh.position_m) {
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_FLOAT_EQ(std::bit_cast<float>(in.U32()), p[axis] * 1e3f);
    }
    in.Raw(13);
  }
  for (const auto& t : mesh.triangles) {
    ASSERT_EQ(in.U8(), 3);
    for (uint32_t corner : t) ASSERT_EQ(in.U32(), corner);
  }
  EXPECT_TRUE(in.ok() && in.AtEnd());
}

TEST(SurfaceTest, TissueIsThatJustUnderTheSurface) {
  auto tissue = [](const dvec3& p) {
    return p.x < 24 ? Tissue::kEnamel : p.x < 40 ? Tissue::kDentin : Tissue::kPulp;
  };
  Volume volume = Sampled(
      Grid({8, 8, 8}), [](const dvec3& p) { return glm::length(p - kCentre) - kRadius; }, tissue);
  Mesh mesh = ExtractSurface(volume);
  std::array<int, cutting::kTissueCount> seen{};
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    dvec3 p = dvec3(mesh.position_m[i]) / kVoxel_m;
    ++seen[mesh.tissue[i]];
    if (std::fabs(p.x - 23.5) < 1.5 || std::fabs(p.x - 39.5) < 1.5) continue;
    EXPECT_EQ(mesh.tissue[i], static_cast<uint8_t>(tissue(p)));
  }
  EXPECT_EQ(seen[0], 0);
  EXPECT_GT(seen[1], 100);
  EXPECT_GT(seen[2], 100);
  EXPECT_GT(seen[3], 100);
}

TEST(SurfaceTest, EmptyVolumeHasNoSurface) {
  Mesh mesh = ExtractSurface(Volume(Grid({3, 3, 3})));
  EXPECT_TRUE(mesh.position_m.empty());
  EXPECT_TRUE(mesh.triangles.empty());
  EXPECT_EQ(EnclosedVolume_m3(mesh), 0);
}

double BruteForce(const Mesh& mesh, const dvec3& p) {
  // Closest point by dense sampling would be inexact; a single-triangle query is not under test
  // here, so one query per triangle, which visits exactly that triangle.
  double best = 1e9;
  for (const auto& t : mesh.triangles) {
    Mesh one;
    for (uint32_t i : t) one.position_m.push_back(mesh.position_m[i]);
    one.triangles.push_back({0, 1, 2});
    best = std::min(best, DistanceQuery(one).Distance_m(p, 1e9));
  }
  return best;
}

TEST(DistanceQueryTest, SingleTriangleMeetsTheClosedForm) {
  Mesh mesh;
  mesh.position_m = {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}};
  mesh.triangles = {{0, 1, 2}};
  DistanceQuery query(mesh);
  EXPECT_DOUBLE_EQ(query.Distance_m({1, 1, 2}, 100), 2);    // over the face
  EXPECT_DOUBLE_EQ(query.Distance_m({1, 1, -2}, 100), 2);   // and under it
  EXPECT_DOUBLE_EQ(query.Distance_m({2, -3, 4}, 100), 5);   // beside an edge
  EXPECT_DOUBLE_EQ(query.Distance_m({7, -4, 0}, 100), 5);   // off a corner
  EXPECT_DOUBLE_EQ(query.Distance_m({4, 3, 0}, 100), 2.4);  // beside the long edge
  EXPECT_DOUBLE_EQ(query.Distance_m({1, 1, 0}, 100), 0);
  EXPECT_DOUBLE_EQ(query.Distance_m({1, 1, 2}, 1.5), 1.5);  // limited
}

TEST(DistanceQueryTest, AgreesWithVisitingEveryTriangle) {
  Volume volume = Sampled(Grid({3, 3, 3}),
                          [](const dvec3& p) { return glm::length(p - dvec3(11, 12, 11.5)) - 7; });
  Mesh mesh = ExtractSurface(volume);
  DistanceQuery query(mesh);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-10, 34);
  for (int i = 0; i < 40; ++i) {
    dvec3 p = dvec3(unit(random), unit(random), unit(random)) * kVoxel_m;
    EXPECT_NEAR(query.Distance_m(p, 1), BruteForce(mesh, p), 1e-12);
  }
}

TEST(DistanceQueryTest, WithinIsWhatTheDistanceSays) {
  Mesh mesh = ExtractSurface(Ball());
  DistanceQuery query(mesh);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-5, 69);
  for (int i = 0; i < 500; ++i) {
    dvec3 p = dvec3(unit(random), unit(random), unit(random)) * kVoxel_m;
    const double exact = query.Distance_m(p, 1);
    for (double share : {0.0, 0.5, 1 - 1e-9, 1.0, 1 + 1e-9, 2.0}) {
      EXPECT_EQ(query.IsWithin(p, share * exact), exact <= share * exact) << share;
    }
  }
  EXPECT_FALSE(DistanceQuery(Mesh{}).IsWithin({0, 0, 0}, 1));
  EXPECT_FALSE(query.IsWithin(dvec3(std::nan("")), 1));
}

TEST(DistanceQueryTest, NearestTriangleIsAsFarAsTheDistanceSays) {
  Mesh mesh = ExtractSurface(Ball());
  DistanceQuery query(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-5, 69);
  for (int i = 0; i < 500; ++i) {
    const dvec3 p = dvec3(unit(random), unit(random), unit(random)) * kVoxel_m;
    const auto nearest = query.NearestTriangle(p, 1);
    ASSERT_TRUE(nearest);
    EXPECT_EQ(nearest->distance_m, query.Distance_m(p, 1));
    EXPECT_EQ(query.DistanceTo_m(nearest->triangle, p), nearest->distance_m);
    EXPECT_FALSE(query.NearestTriangle(p, 0.999 * nearest->distance_m));
    // Vertices and the middle of the ball, too, are as near to several triangles.
    for (const dvec3& at :
         {p, dvec3(mesh.position_m[static_cast<size_t>(i)]), kCentre * kVoxel_m}) {
      const auto without = query.NearestTriangle(at, 1);
      for (const uint32_t guess : {without->triangle, uint32_t{0}, static_cast<uint32_t>(i) * 3}) {
        const auto with = query.NearestTriangle(at, 1, guess);
        ASSERT_TRUE(with);
        EXPECT_EQ(with->triangle, without->triangle);
        EXPECT_EQ(with->distance_m, without->distance_m);
      }
    }
  }
  EXPECT_FALSE(DistanceQuery(Mesh{}).NearestTriangle({0, 0, 0}, 1));
}

TEST(DistanceQueryTest, WithinABoxTheTrianglesAroundItGiveTheSameBits) {
  Mesh mesh = ExtractSurface(Ball());
  DistanceQuery all(mesh);
  const double reach = 8 * kVoxel_m;
  const dvec3 lo = (kCentre + dvec3(4, -6, 2)) * kVoxel_m, hi = lo + dvec3(20, 12, 9) * kVoxel_m;
  DistanceQuery around(mesh, lo - reach, hi + reach);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(0, 1);
  int near = 0;
  for (int i = 0; i < 1000; ++i) {
    dvec3 p = lo + (hi - lo) * dvec3(unit(random), unit(random), unit(random));
    const double exact = all.Distance_m(p, 1);
    if (exact >= reach) continue;
    ++near;
    EXPECT_EQ(around.Distance_m(p, 1), exact);
  }
  EXPECT_GT(near, 100);
}

TEST(DistanceQueryTest, DistanceToASphereMeetsTheClosedForm) {
  DistanceQuery query(ExtractSurface(Ball()));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 64);
  for (int i = 0; i < 2000; ++i) {
    dvec3 p(unit(random), unit(random), unit(random));
    double exact = std::fabs(glm::length(p - kCentre) - kRadius);
    EXPECT_NEAR(query.Distance_m(p * kVoxel_m, 1) / kVoxel_m, exact, 0.07);
  }
}

TEST(DistanceQueryTest, AnswersTheLimitWhenThereIsNothing) {
  DistanceQuery empty{Mesh{}};
  EXPECT_EQ(empty.Distance_m({0, 0, 0}, 2e-3), 2e-3);
  DistanceQuery ball(ExtractSurface(Ball()));
  EXPECT_EQ(ball.Distance_m(dvec3(std::nan("")), 2e-3), 2e-3);
  EXPECT_EQ(ball.Distance_m(dvec3(1e9), 2e-3), 2e-3);
}

}  // namespace
}  // namespace enamel::surface
