#include "common/surface/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/base/check.h"
#include "common/surface/brick_block.h"

namespace enamel::surface {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::Volume;

constexpr uint32_t kNone = 0xffffffffu;
using VertexTable = std::array<uint32_t, kCells * kCells * kCells>;

constexpr size_t CellIndex(const ivec3& c) {
  return static_cast<size_t>((c.z * kCells + c.y) * kCells + c.x);
}

// All of a cell in single precision: samples are integers below 2^15, so crossings are good to
// 1e-7 voxel.
struct Vertex {
  glm::vec3 offset;  // from the cell's first corner, voxels
  glm::vec3 normal;
  ivec3 under;  // inside corner nearest to the vertex, 0 or 1 along each axis
};

constexpr ivec3 Corner(size_t i) {
  auto c = static_cast<int>(i);
  return ivec3(c & 1, c >> 1 & 1, c >> 2 & 1);
}

// A cell's edges by their corners: four along x, four along y, four along z.
constexpr size_t kEdgeFrom[12] = {0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3};
constexpr size_t kEdgeTo[12] = {1, 3, 5, 7, 2, 3, 6, 7, 4, 5, 6, 7};

// Mean of the crossings of a cell's edges. Requires: at least one.
glm::vec3 MeanCrossing(const std::array<float, 8>& v) {
  float at[12], crossed[12];
  for (int e = 0; e < 12; ++e) {
    float a = v[kEdgeFrom[e]], b = v[kEdgeTo[e]];
    crossed[e] = (a < 0) != (b < 0) ? 1.0f : 0.0f;
    // Without a crossing a - b may be 0.
    at[e] = crossed[e] * a / (crossed[e] != 0 ? a - b : 1.0f);
  }
  float count = 0;
  for (float c : crossed) count += c;
  // Along its own axis an edge says where it is crossed, along the others where it lies.
  float x = at[0] + at[1] + at[2] + at[3] + crossed[5] + crossed[7] + crossed[9] + crossed[11];
  float y = at[4] + at[5] + at[6] + at[7] + crossed[1] + crossed[3] + crossed[10] + crossed[11];
  float z = at[8] + at[9] + at[10] + at[11] + crossed[2] + crossed[3] + crossed[6] + crossed[7];
  return glm::vec3(x, y, z) / count;
}

// Gradient of the trilinear interpolation at `p` in the unit cell.
glm::vec3 Gradient(const std::array<float, 8>& v, const glm::vec3& p) {
  glm::vec3 q = 1.0f - p;
  float x00 = v[1] - v[0], x10 = v[3] - v[2], x01 = v[5] - v[4], x11 = v[7] - v[6];
  float y00 = v[2] - v[0], y10 = v[3] - v[1], y01 = v[6] - v[4], y11 = v[7] - v[5];
  float z00 = v[4] - v[0], z10 = v[5] - v[1], z01 = v[6] - v[2], z11 = v[7] - v[3];
  return {(x00 * q.y + x10 * p.y) * q.z + (x01 * q.y + x11 * p.y) * p.z,
          (y00 * q.x + y10 * p.x) * q.z + (y01 * q.x + y11 * p.x) * p.z,
          (z00 * q.x + z10 * p.x) * q.y + (z01 * q.x + z11 * p.x) * p.y};
}

// From the inside corners to the outside ones: the normal where the gradient vanishes, as in the
// middle of a sheet thinner than a voxel.
glm::vec3 CoarseNormal(const std::array<float, 8>& v) {
  glm::vec3 n(0);
  for (size_t i = 0; i < 8; ++i) n += (glm::vec3(Corner(i)) - 0.5f) * (v[i] < 0 ? -1.0f : 1.0f);
  float length = glm::length(n);
  return length > 0 ? n / length : glm::vec3(0, 0, 1);
}

ivec3 NearestInside(const std::array<float, 8>& v, const glm::vec3& p) {
  glm::vec3 q = 1.0f - p, near = p * p, far = q * q;
  float nearest = 1e9f;
  size_t corner = 0;
  for (size_t i = 0; i < 8; ++i) {
    float d2 = (i & 1 ? far.x : near.x) + (i & 2 ? far.y : near.y) + (i & 4 ? far.z : near.z);
    bool better = v[i] < 0 && d2 < nearest;
    corner = better ? i : corner;
    nearest = better ? d2 : nearest;
  }
  return Corner(corner);
}

Vertex MakeVertex(const Block& block, const ivec3& cell) {
  std::array<float, 8> v;
  const int16_t* first = &block.phi[SampleIndex(cell.x, cell.y, cell.z)];
  for (size_t i = 0; i < 8; ++i) {
    v[i] = first[(i & 1) + (i >> 1 & 1) * kSide + (i >> 2) * kSide * kSide];
  }
  Vertex out;
  out.offset = MeanCrossing(v);
  glm::vec3 g = Gradient(v, out.offset);
  float length = glm::length(g);
  // Far below one voxel of distance per voxel the direction is rounding, not shape.
  out.normal = length > 0.05f * cutting::kPhiPerVoxel ? g / length : CoarseNormal(v);
  out.under = NearestInside(v, out.offset);
  return out;
}

uint32_t AppendVertex(const Volume& volume, const Block& block, const ivec3& cell, Mesh& mesh) {
  Vertex v = MakeVertex(block, cell);
  const GridSpec& spec = volume.spec();
  ivec3 voxel = block.first + cell;
  auto index = static_cast<uint32_t>(mesh.position_m.size());
  mesh.position_m.emplace_back(spec.origin_m() + (dvec3(voxel) + dvec3(v.offset)) * spec.voxel_m());
  mesh.normal.push_back(v.normal);
  mesh.tissue.push_back(static_cast<uint8_t>(volume.TissueAt(voxel + v.under)));
  return index;
}

void AppendQuad(const std::array<uint32_t, 4>& q, Mesh& mesh) {
  auto length2 = [&](uint32_t a, uint32_t b) {
    glm::vec3 d = mesh.position_m[a] - mesh.position_m[b];
    return glm::dot(d, d);
  };
  if (length2(q[0], q[2]) <= length2(q[1], q[3])) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  } else {
    mesh.triangles.push_back({q[0], q[1], q[3]});
    mesh.triangles.push_back({q[1], q[2], q[3]});
  }
}

// Along x, y, z: bit x is set where the edge that starts at sample (x, y, z) is crossed.
struct Crossings {
  uint32_t along[3];
  uint32_t any() const { return along[0] | along[1] | along[2]; }
};
Crossings CrossingsOf(const Block& block, int y, int z, uint32_t own) {
  uint32_t row = block.Row(y, z);
  return {{(row ^ row >> 1) & own, (row ^ block.Row(y + 1, z)) & own,
           (row ^ block.Row(y, z + 1)) & own}};
}

// The samples whose edges are the brick's: its own, and those one voxel below the grid.
struct OwnSamples {
  int first_y, first_z;
  uint32_t row;  // bits along x
};
OwnSamples OwnSamplesOf(const Block& block) {
  uint32_t row = (1u << (kBrickSide + 1)) - 1;
  return {block.brick.y == 0 ? 0 : 1, block.brick.z == 0 ? 0 : 1,
          block.brick.x == 0 ? row : row & ~1u};
}

size_t CountCrossings(const Block& block) {
  OwnSamples own = OwnSamplesOf(block);
  size_t count = 0;
  for (int z = own.first_z; z <= kBrickSide; ++z) {
    for (int y = own.first_y; y <= kBrickSide; ++y) {
      for (uint32_t bits : CrossingsOf(block, y, z, own.row).along) {
        count += static_cast<size_t>(std::popcount(bits));
      }
    }
  }
  return count;
}

// Quads of the crossed edges whose first sample is the brick's, or lies one voxel below the grid.
// `vertex_of(cell)` gives the index of a cell's vertex, made on first use.
template <typename VertexOf>
void AppendQuads(const Block& block, Mesh& mesh, VertexOf&& vertex_of) {
  OwnSamples own = OwnSamplesOf(block);
  for (int z = own.first_z; z <= kBrickSide; ++z) {
    for (int y = own.first_y; y <= kBrickSide; ++y) {
      Crossings crossed = CrossingsOf(block, y, z, own.row);
      for (uint32_t left = crossed.any(); left != 0; left &= left - 1) {
        int x = std::countr_zero(left);
        ivec3 s(x, y, z);
        bool inside = block.Row(y, z) >> x & 1;
        for (int axis = 0; axis < 3; ++axis) {
          if (!(crossed.along[axis] >> x & 1)) continue;
          ivec3 u(axis == 2, axis == 0, axis == 1), w(axis == 1, axis == 2, axis == 0);
          // Counter-clockwise seen from the far end of the edge, since u x w is along it.
          std::array<uint32_t, 4> quad = {vertex_of(s - u - w), vertex_of(s - w), vertex_of(s),
                                          vertex_of(s - u)};
          if (!inside) std::swap(quad[1], quad[3]);
          AppendQuad(quad, mesh);
        }
      }
    }
  }
}

// A quad has four corners and a vertex four quads, but for the rim.
void Reserve(size_t crossings, Mesh& mesh) {
  size_t vertices = crossings + crossings / 2;
  mesh.position_m.reserve(vertices);
  mesh.normal.reserve(vertices);
  mesh.tissue.reserve(vertices);
  mesh.triangles.reserve(2 * crossings);
}

}  // namespace

Mesh ExtractBlock(const Volume& volume, const Block& block) {
  Mesh mesh;
  VertexTable table;
  table.fill(kNone);
  Reserve(CountCrossings(block), mesh);
  AppendQuads(block, mesh, [&](const ivec3& cell) {
    uint32_t& index = table[CellIndex(cell)];
    if (index == kNone) index = AppendVertex(volume, block, cell, mesh);
    return index;
  });
  return mesh;
}

Mesh ExtractBrick(const Volume& volume, int brick) {
  ENAMEL_CHECK(brick >= 0 && brick < volume.spec().brick_count());
  Block block;
  return Gather(volume, brick, block) ? ExtractBlock(volume, block) : Mesh();
}

Mesh ExtractSurface(const Volume& volume, std::vector<ivec3>* cells) {
  const GridSpec& spec = volume.spec();
  Mesh mesh;
  // A cell's vertex is kept in the table of the brick that holds the cell's first corner.
  std::vector<int32_t> table_of(static_cast<size_t>(spec.brick_count()), -1);
  std::vector<VertexTable> tables;
  Block block;
  for (int brick = 0; brick < spec.brick_count(); ++brick) {
    if (!Gather(volume, brick, block)) continue;
    AppendQuads(block, mesh, [&](ivec3 cell) {
      ivec3 owner = block.brick, local = cell;
      for (int i = 0; i < 3; ++i) {
        if (local[i] == 0 && owner[i] > 0) {
          --owner[i];
          local[i] = kBrickSide;
        }
      }
      int32_t& table = table_of[static_cast<size_t>(spec.BrickIndex(owner))];
      if (table < 0) {
        table = static_cast<int32_t>(tables.size());
        tables.emplace_back().fill(kNone);
      }
      uint32_t& index = tables[static_cast<size_t>(table)][CellIndex(local)];
      if (index != kNone) return index;
      if (cells != nullptr) cells->push_back(block.first + cell);
      index = AppendVertex(volume, block, cell, mesh);
      return index;
    });
  }
  return mesh;
}

double Area_m2(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    dvec3 a(mesh.position_m[t[0]]), b(mesh.position_m[t[1]]), c(mesh.position_m[t[2]]);
    sum += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return sum;
}

double EnclosedVolume_m3(const Mesh& mesh) {
  if (mesh.position_m.empty()) return 0;
  // About a vertex, not the frame's origin, so that a far mesh loses no digits.
  dvec3 o(mesh.position_m[0]);
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    dvec3 a(mesh.position_m[t[0]]), b(mesh.position_m[t[1]]), c(mesh.position_m[t[2]]);
    sum += Dot(a - o, glm::cross(b - o, c - o)) / 6;
  }
  return sum;
}

}  // namespace enamel::surface
