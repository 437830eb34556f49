#include "common/import/mesh_repair.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "common/import/triangle_tree.h"

namespace enamel::import {
namespace {

constexpr double kWeld_mm = 1e-3;
constexpr double kLargestCapShare = 0.4;  // a flat sheet and its cap: 0.5
constexpr double kSmallestFill = 0.02;    // of the bounding box
constexpr double kSide_mm = 2e-3;         // how far from a triangle its two sides are probed

using Triangle = std::array<uint32_t, 3>;
using Edge = std::pair<uint32_t, uint32_t>;

Edge Undirected(uint32_t a, uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

Status NoSolid(const std::string& what) {
  return Status(Code::kInvalidInput, "this mesh is no solid: " + what);
}

Triangles Weld(const Triangles& in) {
  Triangles out;
  std::map<std::array<int64_t, 3>, uint32_t> known;
  std::vector<uint32_t> to(in.vertices.size());
  for (size_t i = 0; i < in.vertices.size(); ++i) {
    std::array<int64_t, 3> key;
    for (int k = 0; k < 3; ++k)
      key[static_cast<size_t>(k)] = std::llround(in.vertices[i][k] / kWeld_mm);
    auto [it, fresh] = known.emplace(key, static_cast<uint32_t>(out.vertices.size()));
    if (fresh) out.vertices.push_back(in.vertices[i]);
    to[i] = it->second;
  }
  for (const Triangle& t : in.indices) out.indices.push_back({to[t[0]], to[t[1]], to[t[2]]});
  return out;
}

void DropUseless(Triangles& mesh, MeshReport& report) {
  std::set<Triangle> seen;
  std::vector<Triangle> kept;
  for (const Triangle& t : mesh.indices) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++report.degenerate;
      continue;
    }
    Triangle key = t;
    std::sort(key.begin(), key.end());
    if (!seen.insert(key).second) {
      ++report.duplicate;
      continue;
    }
    kept.push_back(t);
  }
  mesh.indices = std::move(kept);
}

struct EdgeUse {
  uint32_t triangle;
  bool forward;  // from the smaller index to the larger
};

// Edges with their triangles, by index.
std::map<Edge, std::vector<EdgeUse>> EdgesOf(const Triangles& mesh) {
  std::map<Edge, std::vector<EdgeUse>> edges;
  for (uint32_t i = 0; i < mesh.indices.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) {
      uint32_t a = mesh.indices[i][k], b = mesh.indices[i][(k + 1) % 3];
      edges[Undirected(a, b)].push_back({i, a < b});
    }
  }
  return edges;
}

// Part of each triangle; parts hang together over edges of exactly two triangles. `turn` says which
// triangles must be turned for neighbours to agree. False when a part has one side only.
bool FindParts(const Triangles& mesh, std::vector<int>& part, std::vector<bool>& turn, int& parts) {
  struct Neighbour {
    uint32_t triangle;
    bool agrees;
  };
  std::vector<std::vector<Neighbour>> neighbours(mesh.indices.size());
  for (const auto& [edge, uses] : EdgesOf(mesh)) {
    if (uses.size() != 2) continue;
    bool agrees = uses[0].forward != uses[1].forward;
    neighbours[uses[0].triangle].push_back({uses[1].triangle, agrees});
    neighbours[uses[1].triangle].push_back({uses[0].triangle, agrees});
  }
  part.assign(mesh.indices.size(), -1);
  turn.assign(mesh.indices.size(), false);
  parts = 0;
  bool two_sided = true;
  std::vector<uint32_t> open;
  for (uint32_t seed = 0; seed < mesh.indices.size(); ++seed) {
    if (part[seed] >= 0) continue;
    part[seed] = parts;
    open.assign(1, seed);
    while (!open.empty()) {
      uint32_t t = open.back();
      open.pop_back();
      for (const Neighbour& n : neighbours[t]) {
        bool wanted = n.agrees ? turn[t] : !turn[t];
        if (part[n.triangle] < 0) {
          part[n.triangle] = parts;
          turn[n.triangle] = wanted;
          open.push_back(n.triangle);
        } else if (turn[n.triangle] != wanted) {
          two_sided = false;
        }
      }
    }
    ++parts;
  }
  return two_sided;
}

// Directed edges that no other triangle of the part runs against: its boundary.
std::multimap<uint32_t, uint32_t> Boundary(const std::vector<Triangle>& triangles) {
  std::map<Edge, int> balance;
  for (const Triangle& t : triangles) {
    for (size_t k = 0; k < 3; ++k) {
      uint32_t a = t[k], b = t[(k + 1) % 3];
      balance[Undirected(a, b)] += a < b ? 1 : -1;
    }
  }
  std::multimap<uint32_t, uint32_t> out;
  for (const auto& [edge, n] : balance) {
    for (int i = 0; i < std::abs(n); ++i) {
      if (n > 0) out.emplace(edge.first, edge.second);
      if (n < 0) out.emplace(edge.second, edge.first);
    }
  }
  return out;
}

// Closes every loop of the boundary by a fan around its middle; returns the caps' area.
double CloseHoles(Triangles& mesh, std::vector<Triangle>& part, MeshReport& report) {
  auto boundary = Boundary(part);
  report.open_edges += boundary.size();
  double area = 0;
  while (!boundary.empty()) {
    std::vector<uint32_t> loop;
    uint32_t start = boundary.begin()->first, at = start;
    do {
      loop.push_back(at);
      auto next = boundary.find(at);
      at = next->second;
      boundary.erase(next);
    } while (at != start);
    dvec3 middle(0);
    for (uint32_t v : loop) middle += mesh.vertices[v] / static_cast<double>(loop.size());
    auto centre = static_cast<uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middle);
    for (size_t i = 0; i < loop.size(); ++i) {
      uint32_t a = loop[i], b = loop[(i + 1) % loop.size()];
      part.push_back({b, a, centre});
      area += 0.5 * glm::length(glm::cross(mesh.vertices[a] - middle, mesh.vertices[b] - middle));
    }
    ++report.holes_closed;
  }
  return area;
}

// Orients and closes each part on its own; `mesh.indices` becomes all of them.
double CloseParts(Triangles& mesh, const std::vector<int>& part_of, const std::vector<bool>& turn,
                  int parts, MeshReport& report) {
  std::vector<std::vector<Triangle>> part(static_cast<size_t>(parts));
  std::vector<size_t> turned(static_cast<size_t>(parts), 0);
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    Triangle t = mesh.indices[i];
    auto p = static_cast<size_t>(part_of[i]);
    if (turn[i]) std::swap(t[1], t[2]);
    turned[p] += turn[i];
    part[p].push_back(t);
  }
  mesh.indices.clear();
  double cap_area = 0;
  for (size_t p = 0; p < part.size(); ++p) {
    const size_t own = part[p].size();
    cap_area += CloseHoles(mesh, part[p], report);
    Triangles alone{mesh.vertices, part[p]};
    if (SignedVolume(alone) < 0) {
      for (Triangle& t : part[p]) std::swap(t[1], t[2]);
      turned[p] = own - turned[p];
    }
    report.flipped += turned[p];
    mesh.indices.insert(mesh.indices.end(), part[p].begin(), part[p].end());
  }
  return cap_area;
}

// Triangles with solid on one side and none on the other.
Triangles OuterBoundary(const Triangles& mesh, const TriangleTree& tree, MeshReport& report) {
  Triangles out{mesh.vertices, {}};
  for (const Triangle& t : mesh.indices) {
    const dvec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    dvec3 n = glm::cross(b - a, c - a);
    double size = std::sqrt(Dot(n, n));
    if (size < 1e-12) continue;
    dvec3 middle = (a + b + c) / 3.0, step = n * (kSide_mm / size);
    bool solid_below = tree.Winding(middle - step) > 0.5,
         solid_above = tree.Winding(middle + step) > 0.5;
    if (solid_below && solid_above) {
      ++report.buried;
    } else {
      out.indices.push_back(t);
    }
  }
  return out;
}

double BoxVolume(const Triangles& mesh) {
  dvec3 lo = mesh.vertices[mesh.indices[0][0]], hi = lo;
  for (const Triangle& t : mesh.indices) {
    for (uint32_t i : t) lo = glm::min(lo, mesh.vertices[i]), hi = glm::max(hi, mesh.vertices[i]);
  }
  dvec3 size = hi - lo;
  return size.x * size.y * size.z;
}

}  // namespace

Result<Solid> MakeSolid(const Triangles& mesh_mm) {
  Solid solid;
  solid.mesh = Weld(mesh_mm);
  MeshReport& report = solid.report;
  DropUseless(solid.mesh, report);
  if (solid.mesh.indices.size() < 4) {
    return NoSolid("expected at least 4 triangles with an area, found " +
                   std::to_string(solid.mesh.indices.size()));
  }
  for (const auto& [edge, uses] : EdgesOf(solid.mesh)) report.non_manifold_edges += uses.size() > 2;
  std::vector<int> part_of;
  std::vector<bool> turn;
  int parts = 0;
  if (!FindParts(solid.mesh, part_of, turn, parts)) {
    return NoSolid(
        "a part of it has only one side (like a Moebius strip), so nothing is inside: mend it in a "
        "mesh program");
  }
  report.parts = static_cast<size_t>(parts);
  double cap_area = CloseParts(solid.mesh, part_of, turn, parts, report);
  report.vertices = solid.mesh.vertices.size();
  report.triangles = solid.mesh.indices.size();
  report.cap_share = cap_area / std::max(SurfaceArea(solid.mesh), 1e-12);
  if (report.cap_share > kLargestCapShare) {
    return NoSolid("it is an open sheet, its " + std::to_string(report.open_edges) +
                   " open edges would need caps of " +
                   std::to_string(static_cast<int>(100 * report.cap_share)) +
                   " % of the surface: close it in a mesh program");
  }
  if (!(SignedVolume(solid.mesh) > kSmallestFill * BoxVolume(solid.mesh))) {
    return NoSolid(
        "it encloses next to nothing of its bounding box (a flat sheet or a soup of triangles)");
  }
  solid.boundary = OuterBoundary(solid.mesh, TriangleTree(solid.mesh), report);
  return solid;
}

std::vector<std::string> Describe(const MeshReport& r) {
  std::vector<std::string> lines;
  lines.push_back(std::to_string(r.triangles) + " triangles, " + std::to_string(r.vertices) +
                  " vertices, " + std::to_string(r.parts) + (r.parts == 1 ? " part" : " parts"));
  auto note = [&](size_t n, const std::string& what) {
    if (n > 0) lines.push_back(std::to_string(n) + " " + what);
  };
  note(r.degenerate, "triangles without an area left out");
  note(r.duplicate, "triangles present twice, left out once");
  note(r.non_manifold_edges, "edges shared by more than two triangles");
  note(r.flipped, "triangles faced the other way and were turned");
  note(r.open_edges, "open edges");
  if (r.holes_closed > 0) {
    lines.push_back(std::to_string(r.holes_closed) + " holes closed by flat caps, " +
                    std::to_string(static_cast<int>(std::lround(100 * r.cap_share))) +
                    " % of the surface");
  }
  note(r.buried,
       "triangles inside the solid (parts overlap or the surface crosses itself), ignored");
  if (lines.size() == 1) lines.push_back("closed and consistently oriented, nothing to repair");
  return lines;
}

}  // namespace enamel::import
