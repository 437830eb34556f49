#include "common/surface/surface.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace enamel::surface {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kPhiLimit;
using cutting::Tissue;
using cutting::Volume;

// A brick's samples with one layer of its neighbours' around them.
constexpr int kSide = kBrickSide + 2;
// Cells that such a block holds whole; cell (0, 0, 0) starts one voxel below the brick.
constexpr int kCells = kBrickSide + 1;
constexpr uint32_t kNone = 0xffffffffu;
using VertexTable = std::array<uint32_t, kCells * kCells * kCells>;

constexpr size_t SampleIndex(int x, int y, int z) {
  return static_cast<size_t>((z * kSide + y) * kSide + x);
}
constexpr size_t CellIndex(const ivec3& c) {
  return static_cast<size_t>((c.z * kCells + c.y) * kCells + c.x);
}

// -1 solid throughout, +1 air throughout, 0 stored.
int SignOf(const Volume& volume, const ivec3& b) {
  if (!volume.spec().Contains(b)) return 1;
  int brick = volume.spec().BrickIndex(b);
  if (volume.IsStored(brick)) return 0;
  return volume.UniformTissue(brick) == Tissue::kAir ? 1 : -1;
}

struct Block {
  ivec3 brick;  // grid coordinates
  ivec3 first;  // voxel of sample (0, 0, 0)
  std::array<int16_t, kSide * kSide * kSide> phi;

  int At(const ivec3& s) const { return phi[SampleIndex(s.x, s.y, s.z)]; }
};

// Part of a block along one axis that comes from the neighbour at `d` (-1, 0, 1).
struct Overlap {
  int to, from, count;
};
constexpr Overlap OverlapOf(int d) {
  if (d < 0) return {0, kBrickSide - 1, 1};
  if (d > 0) return {kSide - 1, 0, 1};
  return {1, 0, kBrickSide};
}

void CopyNeighbour(const Volume& volume, const ivec3& d, Block& block) {
  ivec3 b = block.brick + d;
  Overlap ox = OverlapOf(d.x), oy = OverlapOf(d.y), oz = OverlapOf(d.z);
  int sign = SignOf(volume, b);
  const int16_t* source = sign == 0 ? volume.Phi(volume.spec().BrickIndex(b)).phi.data() : nullptr;
  auto uniform = static_cast<int16_t>(sign * kPhiLimit);
  for (int z = 0; z < oz.count; ++z) {
    for (int y = 0; y < oy.count; ++y) {
      int16_t* row = &block.phi[SampleIndex(ox.to, oy.to + y, oz.to + z)];
      if (!source) {
        std::fill_n(row, ox.count, uniform);
      } else {
        std::copy_n(source + ((oz.from + z) * kBrickSide + oy.from + y) * kBrickSide + ox.from,
                    ox.count, row);
      }
    }
  }
}

// False when no surface passes near the brick; the block is then not filled.
bool Gather(const Volume& volume, int brick, Block& block) {
  const GridSpec& spec = volume.spec();
  block.brick = ivec3(brick % spec.bricks.x, brick / spec.bricks.x % spec.bricks.y,
                      brick / (spec.bricks.x * spec.bricks.y));
  block.first = block.brick * kBrickSide - 1;
  int own = SignOf(volume, block.brick);
  bool mixed = own == 0;
  for (int i = 0; i < 27 && !mixed; ++i) {
    mixed = SignOf(volume, block.brick + ivec3(i % 3, i / 3 % 3, i / 9) - 1) != own;
  }
  if (!mixed) return false;
  for (int i = 0; i < 27; ++i) {
    CopyNeighbour(volume, ivec3(i % 3, i / 3 % 3, i / 9) - 1, block);
  }
  auto inside = [](int16_t v) { return v < 0; };
  return std::any_of(block.phi.begin(), block.phi.end(), inside) &&
         !std::all_of(block.phi.begin(), block.phi.end(), inside);
}

struct Vertex {
  dvec3 offset;  // from the cell's first corner, voxels
  dvec3 normal;
  ivec3 under;  // inside corner nearest to the vertex, 0 or 1 along each axis
};

constexpr ivec3 Corner(int i) { return ivec3(i & 1, i >> 1 & 1, i >> 2 & 1); }

// Gradient of the trilinear interpolation at `p` in the unit cell.
dvec3 Gradient(const std::array<double, 8>& v, const dvec3& p) {
  dvec3 g(0);
  for (int i = 0; i < 8; ++i) {
    ivec3 c = Corner(i);
    double wx = c.x ? p.x : 1 - p.x, wy = c.y ? p.y : 1 - p.y, wz = c.z ? p.z : 1 - p.z;
    double value = v[static_cast<size_t>(i)];
    g +=
        value * dvec3((c.x ? 1 : -1) * wy * wz, (c.y ? 1 : -1) * wx * wz, (c.z ? 1 : -1) * wx * wy);
  }
  return g;
}

// From the inside corners to the outside ones: the normal where the gradient vanishes, as in the
// middle of a sheet thinner than a voxel.
dvec3 CoarseNormal(const std::array<double, 8>& v) {
  dvec3 n(0);
  for (int i = 0; i < 8; ++i) {
    n += (dvec3(Corner(i)) - 0.5) * (v[static_cast<size_t>(i)] < 0 ? -1.0 : 1.0);
  }
  double length = glm::length(n);
  return length > 0 ? n / length : dvec3(0, 0, 1);
}

Vertex MakeVertex(const Block& block, const ivec3& cell) {
  std::array<double, 8> v;
  for (int i = 0; i < 8; ++i) v[static_cast<size_t>(i)] = block.At(cell + Corner(i));
  dvec3 sum(0);
  int crossings = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 8; ++i) {
      if (i >> axis & 1) continue;
      double a = v[static_cast<size_t>(i)], b = v[static_cast<size_t>(i | 1 << axis)];
      if ((a < 0) == (b < 0)) continue;
      dvec3 at(Corner(i));
      at[axis] = a / (a - b);
      sum += at;
      ++crossings;
    }
  }
  Vertex out;
  out.offset = sum / static_cast<double>(crossings);
  dvec3 g = Gradient(v, out.offset);
  double length = glm::length(g);
  // Far below one voxel of distance per voxel the direction is rounding, not shape.
  out.normal = length > 0.05 * cutting::kPhiPerVoxel ? g / length : CoarseNormal(v);
  double nearest = 1e9;
  for (int i = 0; i < 8; ++i) {
    if (v[static_cast<size_t>(i)] >= 0) continue;
    dvec3 d = dvec3(Corner(i)) - out.offset;
    if (double d2 = Dot(d, d); d2 < nearest) {
      nearest = d2;
      out.under = Corner(i);
    }
  }
  return out;
}

uint32_t AppendVertex(const Volume& volume, const Block& block, const ivec3& cell, Mesh& mesh) {
  Vertex v = MakeVertex(block, cell);
  const GridSpec& spec = volume.spec();
  ivec3 voxel = block.first + cell;
  auto index = static_cast<uint32_t>(mesh.position_m.size());
  mesh.position_m.emplace_back(spec.origin_m() + (dvec3(voxel) + v.offset) * spec.voxel_m());
  mesh.normal.emplace_back(v.normal);
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

// Quads of the crossed edges whose first sample is the brick's, or lies one voxel below the grid.
// `vertex_of(cell)` gives the index of a cell's vertex, made on first use.
template <typename VertexOf>
void AppendQuads(const Block& block, Mesh& mesh, VertexOf&& vertex_of) {
  ivec3 lo(block.brick.x == 0 ? 0 : 1, block.brick.y == 0 ? 0 : 1, block.brick.z == 0 ? 0 : 1);
  for (int z = lo.z; z <= kBrickSide; ++z) {
    for (int y = lo.y; y <= kBrickSide; ++y) {
      for (int x = lo.x; x <= kBrickSide; ++x) {
        ivec3 s(x, y, z);
        bool inside = block.At(s) < 0;
        for (int axis = 0; axis < 3; ++axis) {
          ivec3 along(axis == 0, axis == 1, axis == 2);
          if ((block.At(s + along) < 0) == inside) continue;
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

}  // namespace

Mesh ExtractBrick(const Volume& volume, int brick) {
  ENAMEL_CHECK(brick >= 0 && brick < volume.spec().brick_count());
  Mesh mesh;
  Block block;
  if (!Gather(volume, brick, block)) return mesh;
  VertexTable table;
  table.fill(kNone);
  AppendQuads(block, mesh, [&](const ivec3& cell) {
    uint32_t& index = table[CellIndex(cell)];
    if (index == kNone) index = AppendVertex(volume, block, cell, mesh);
    return index;
  });
  return mesh;
}

Mesh ExtractSurface(const Volume& volume) {
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
      if (index == kNone) index = AppendVertex(volume, block, cell, mesh);
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
