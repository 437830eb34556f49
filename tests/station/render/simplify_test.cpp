#include "station/render/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "station/render/revolve.h"

namespace enamel::station::render {
namespace {

constexpr int kSide = 40;
constexpr float kStep_mm = 0.05f, kRadius_mm = 5;

// A patch of a sphere as from surface nets, in two halves that repeat the seam between them.
GroupMesh Patch(uint8_t tissue_beyond = 1) {
  GroupMesh mesh;
  auto add = [&](int i, int j) {
    float x = (static_cast<float>(i) - kSide / 2.0f) * kStep_mm,
          y = (static_cast<float>(j) - kSide / 2.0f) * kStep_mm,
          z = std::sqrt(kRadius_mm * kRadius_mm - x * x - y * y);
    auto byte = [](float v) { return static_cast<int8_t>(std::lround(v / kRadius_mm * 127)); };
    mesh.vertices.push_back(
        {{x, y, z}, {byte(x), byte(y), byte(z)}, i < kSide - 2 ? uint8_t{1} : tissue_beyond});
  };
  for (int half = 0; half < 2; ++half) {
    auto base = static_cast<uint32_t>(mesh.vertices.size());
    int first = half * kSide / 2, count = kSide / 2;
    for (int i = first; i <= first + count; ++i)
      for (int j = 0; j <= kSide; ++j) add(i, j);
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < kSide; ++j) {
        auto a = base + static_cast<uint32_t>(i * (kSide + 1) + j), b = a + kSide + 1;
        mesh.indices.insert(mesh.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
      }
  }
  return mesh;
}

glm::vec3 At(const GroupMesh& mesh, size_t index) {
  const float* p = mesh.vertices[mesh.indices[index]].position_mm;
  return {p[0], p[1], p[2]};
}

// Edges without an opposite one, by position.
std::map<std::array<float, 6>, int> Border(const GroupMesh& mesh) {
  std::map<std::array<float, 6>, int> edges;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    for (size_t k = 0; k < 3; ++k) {
      glm::vec3 a = At(mesh, i + k), b = At(mesh, i + (k + 1) % 3);
      if (edges.erase({b.x, b.y, b.z, a.x, a.y, a.z}) == 0) {
        edges[{a.x, a.y, a.z, b.x, b.y, b.z}] = 1;
      }
    }
  }
  return edges;
}

TEST(SimplifyTest, ManyFewerTrianglesStayWithinTheErrorOfASphere) {
  GroupMesh mesh = Patch();
  size_t before = mesh.indices.size();
  Simplify(mesh, 0.004f);
  EXPECT_LT(mesh.indices.size(), before / 4);
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    glm::vec3 middle = (At(mesh, i) + At(mesh, i + 1) + At(mesh, i + 2)) / 3.0f;
    EXPECT_NEAR(glm::length(middle), kRadius_mm, 0.012f);
  }
}

TEST(SimplifyTest, TheOuterBorderStaysAsItIsAndTheSeamInsideCloses) {
  GroupMesh mesh = Patch();
  auto before = Border(mesh);
  Simplify(mesh, 0.004f);
  EXPECT_EQ(Border(mesh), before);
}

// Triangles by the tissues of their corners, and by position.
std::map<std::array<float, 9>, bool> TrianglesBetweenTissues(const GroupMesh& mesh) {
  std::map<std::array<float, 9>, bool> out;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    auto tissue = [&](size_t k) { return mesh.vertices[mesh.indices[i + k]].tissue; };
    if (tissue(0) == tissue(1) && tissue(1) == tissue(2)) continue;
    std::array<glm::vec3, 3> p{At(mesh, i), At(mesh, i + 1), At(mesh, i + 2)};
    // Corners in a fixed order: which one is first has no meaning.
    auto first = std::min_element(p.begin(), p.end(), [](const glm::vec3& a, const glm::vec3& b) {
      return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    });
    std::rotate(p.begin(), first, p.end());
    out[{p[0].x, p[0].y, p[0].z, p[1].x, p[1].y, p[1].z, p[2].x, p[2].y, p[2].z}] = true;
  }
  return out;
}

TEST(SimplifyTest, TrianglesBetweenTwoTissuesStayAndThoseOfOneGetFewer) {
  GroupMesh mesh = Patch(2);
  auto between = TrianglesBetweenTissues(mesh);
  size_t before = mesh.indices.size();
  ASSERT_FALSE(between.empty());
  Simplify(mesh, 0.004f);
  EXPECT_EQ(TrianglesBetweenTissues(mesh), between);
  EXPECT_LT(mesh.indices.size(), before / 3);
}

// The patch closes: no edge inside it is without its opposite.
TEST(SimplifyTest, NoHoleOpensBetweenTissues) {
  GroupMesh mesh = Patch(2);
  auto before = Border(mesh);
  Simplify(mesh, 0.004f);
  EXPECT_EQ(Border(mesh), before);
}

TEST(SimplifyTest, CoarseTrianglesAreFewerStillAndMeetTheSameBorder) {
  GroupMesh mesh = Patch(2);
  Coarsen(mesh, 0.02f);
  Simplify(mesh, 0.004f);
  auto border = Border(mesh);
  EXPECT_LT(mesh.coarse.size(), mesh.indices.size());
  GroupMesh coarse = mesh;
  coarse.indices = mesh.coarse;
  EXPECT_EQ(Border(coarse), border);
  for (size_t i = 0; i < coarse.indices.size(); i += 3) {
    glm::vec3 middle = (At(coarse, i) + At(coarse, i + 1) + At(coarse, i + 2)) / 3.0f;
    EXPECT_NEAR(glm::length(middle), kRadius_mm, 0.05f);
  }
}

TEST(SimplifyTest, CoarseTrianglesLeaveTheSurfaceAsItIs) {
  GroupMesh mesh = Patch();
  size_t before = mesh.indices.size();
  Coarsen(mesh, 0.02f);
  EXPECT_EQ(mesh.indices.size(), before);
  EXPECT_LT(mesh.coarse.size(), before / 8);
}

TEST(SimplifyTest, AnEdgeKeepsItsTriangles) {
  GroupMesh mesh = Patch();
  for (GpuVertex& v : mesh.vertices) {
    v.position_mm[2] = std::min(0.0f, v.position_mm[0]);  // a roof's edge along y
    bool slope = v.position_mm[0] < -0.01f;
    int8_t lean = slope ? -90 : 0, up = slope ? 90 : 127;
    v.normal[0] = lean, v.normal[1] = 0, v.normal[2] = up;
  }
  auto edges = [](const GroupMesh& m) {
    size_t count = 0;
    for (size_t i = 0; i < m.indices.size(); i += 3) {
      int8_t lean[] = {m.vertices[m.indices[i]].normal[0], m.vertices[m.indices[i + 1]].normal[0],
                       m.vertices[m.indices[i + 2]].normal[0]};
      count += lean[0] != lean[1] || lean[1] != lean[2];
    }
    return count;
  };
  size_t before = edges(mesh), all = mesh.indices.size();
  ASSERT_GT(before, size_t{kSide});
  Simplify(mesh, 0.004f);
  EXPECT_EQ(edges(mesh), before);
  EXPECT_LT(mesh.indices.size(), all / 3);  // the roof's two planes
}

TEST(SimplifyTest, NothingStaysNothing) {
  GroupMesh mesh;
  Simplify(mesh, 0.004f);
  EXPECT_TRUE(mesh.indices.empty());
}

// Large triangles would smear colours that change across them.
TEST(SimplifyTest, NoTriangleSpansMoreShadesThanBefore) {
  GroupMesh mesh = Patch();
  for (GpuVertex& v : mesh.vertices) {
    v.tissue = static_cast<uint8_t>(kGingiva + std::lround(60 * (v.position_mm[0] + 1)));
  }
  const size_t before = mesh.indices.size();
  Simplify(mesh, 0.004f);
  EXPECT_LT(mesh.indices.size(), before);
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    auto shade = [&](size_t k) { return mesh.vertices[mesh.indices[i + k]].tissue; };
    EXPECT_LT(std::max({shade(0), shade(1), shade(2)}) - std::min({shade(0), shade(1), shade(2)}),
              20);
  }
}

}  // namespace
}  // namespace enamel::station::render
