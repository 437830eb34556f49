#include "common/mesh/mesh_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <unordered_map>

#include "common/base/counted.h"
#include "common/mesh/mesh_edges.h"
#include "common/mesh/solid_boundary.h"
#include "common/mesh/triangle_tree.h"

namespace enamel::mesh {
namespace {

constexpr double kWeld_mm = 1e-3;
constexpr double kSmallestFill = 0.02;  // of the bounding box

using Triangle = std::array<uint32_t, 3>;

Status NoSolid(const std::string& what) {
  return Status(Code::kInvalidInput, "this mesh is no solid: " + what);
}

struct CellHash {
  size_t operator()(const std::array<int64_t, 3>& cell) const {
    uint64_t h = 0;
    for (int64_t c : cell) h = (h ^ static_cast<uint64_t>(c)) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
    return h;
  }
};

void DropUseless(Triangles& mesh, MeshReport& report) {
  std::vector<std::pair<Triangle, uint32_t>> known;  // corners in order, index
  for (uint32_t i = 0; i < mesh.indices.size(); ++i) {
    Triangle t = mesh.indices[i];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++report.degenerate;
      continue;
    }
    std::sort(t.begin(), t.end());
    known.emplace_back(t, i);
  }
  std::sort(known.begin(), known.end());
  auto last = std::unique(known.begin(), known.end(),
                          [](const auto& l, const auto& r) { return l.first == r.first; });
  report.duplicate = static_cast<size_t>(known.end() - last);
  known.erase(last, known.end());
  std::vector<uint32_t> kept;
  for (const auto& [corners, i] : known) kept.push_back(i);
  // Back in the file's order, by which parts and their seeds are found.
  std::sort(kept.begin(), kept.end());
  std::vector<Triangle> triangles;
  for (uint32_t i : kept) triangles.push_back(mesh.indices[i]);
  mesh.indices = std::move(triangles);
}

struct Parts {
  std::vector<uint32_t> of;  // part of each triangle
  std::vector<bool> turn;    // triangles to turn for neighbours to agree
  uint32_t count = 0;
  bool two_sided = true;
};

// Parts hang together over edges of exactly two triangles.
Parts FindParts(const Triangles& mesh, MeshReport& report) {
  constexpr uint32_t kNone = ~0u;
  // Up to three neighbours; over edge k of a triangle.
  std::vector<std::array<uint32_t, 3>> neighbour(mesh.indices.size(), {kNone, kNone, kNone});
  std::vector<std::array<bool, 3>> agrees(mesh.indices.size());
  std::vector<uint8_t> known(mesh.indices.size(), 0);
  ForEachEdge(SortedEdges(mesh.indices), [&](std::span<const EdgeUse> uses) {
    report.non_manifold_edges += uses.size() > 2;
    if (uses.size() != 2) return;
    const uint32_t l = uses[0].triangle, r = uses[1].triangle;
    const bool agree = uses[0].forward != uses[1].forward;
    neighbour[l][known[l]] = r, agrees[l][known[l]++] = agree;
    neighbour[r][known[r]] = l, agrees[r][known[r]++] = agree;
  });
  Parts parts;
  parts.of.assign(mesh.indices.size(), kNone);
  parts.turn.assign(mesh.indices.size(), false);
  std::vector<uint32_t> open;
  for (uint32_t seed = 0; seed < mesh.indices.size(); ++seed) {
    if (parts.of[seed] != kNone) continue;
    parts.of[seed] = parts.count;
    open.assign(1, seed);
    while (!open.empty()) {
      const uint32_t t = open.back();
      open.pop_back();
      for (size_t k = 0; k < known[t]; ++k) {
        const uint32_t n = neighbour[t][k];
        const bool wanted = agrees[t][k] ? parts.turn[t] : !parts.turn[t];
        if (parts.of[n] == kNone) {
          parts.of[n] = parts.count;
          parts.turn[n] = wanted;
          open.push_back(n);
        } else if (parts.turn[n] != wanted) {
          parts.two_sided = false;
        }
      }
    }
    ++parts.count;
  }
  return parts;
}

// Directed edges that no other triangle of the part runs against: its boundary.
std::multimap<uint32_t, uint32_t> OpenEdges(const std::vector<Triangle>& triangles) {
  std::multimap<uint32_t, uint32_t> out;
  ForEachEdge(SortedEdges(triangles), [&](std::span<const EdgeUse> uses) {
    int balance = 0;
    for (const EdgeUse& use : uses) balance += use.forward ? 1 : -1;
    for (; balance > 0; --balance) out.emplace(uses[0].low, uses[0].high);
    for (; balance < 0; ++balance) out.emplace(uses[0].high, uses[0].low);
  });
  return out;
}

// Closes every loop of the boundary by a fan around its middle; returns the caps' area.
double CloseHoles(Triangles& mesh, std::vector<Triangle>& part, MeshReport& report) {
  auto boundary = OpenEdges(part);
  report.open_edges += boundary.size();
  double area = 0;
  while (!boundary.empty()) {
    std::vector<uint32_t> loop;
    uint32_t start = boundary.begin()->first, at = start;
    do {
      loop.push_back(at);
      // Always there: each triangle leaves a vertex as often as it enters it, and so does what is
      // left when edges run against each other.
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

void TurnAround(std::vector<Triangle>& triangles) {
  for (Triangle& t : triangles) std::swap(t[1], t[2]);
}

struct Part {
  std::vector<Triangle> triangles;  // closed, outward
  size_t own = 0, turned = 0;       // triangles of the file, and those turned around
  dvec3 lo{0}, hi{0};
  double volume = 0;
  bool faced_inward() const { return 2 * turned > own; }
};

// A part within another that faced the other way; caps of both may be in one plane.
bool IsHollowOf(const Part& inner, const Part& outer, const std::vector<dvec3>& vertices) {
  if (inner.faced_inward() == outer.faced_inward() || inner.volume >= outer.volume) return false;
  for (int k = 0; k < 3; ++k) {
    if (inner.lo[k] < outer.lo[k] - kWeld_mm || inner.hi[k] > outer.hi[k] + kWeld_mm) return false;
  }
  const TriangleTree tree({vertices, outer.triangles});
  // Some forty of its triangles, 95 in 100 of them inside.
  const size_t step = inner.own / 40 + 1;
  size_t tried = 0, within = 0;
  for (size_t i = 0; i < inner.own; i += step, ++tried) {
    const Triangle& t = inner.triangles[i];
    within += tree.Inside((vertices[t[0]] + vertices[t[1]] + vertices[t[2]]) / 3.0);
  }
  return 20 * within >= 19 * tried;
}

// Only the few largest parts can be what a hollow is in.
void FindHollows(std::vector<Part>& parts, const RepairOptions& options, Solid& solid) {
  const Triangles& mesh = solid.mesh;
  MeshReport& report = solid.report;
  solid.hollows.vertices = mesh.vertices;
  // Each pair costs a tree: a file of a thousand crumbs must not cost a million.
  constexpr size_t kLargest = 8;
  std::vector<size_t> by_size(parts.size());
  std::iota(by_size.begin(), by_size.end(), 0);
  std::stable_sort(by_size.begin(), by_size.end(),
                   [&](size_t l, size_t r) { return parts[l].volume > parts[r].volume; });
  by_size.resize(std::min(by_size.size(), kLargest));
  std::vector<size_t> hollows;
  for (size_t i : by_size) {
    if (std::any_of(by_size.begin(), by_size.end(), [&](size_t outer) {
          return outer != i && IsHollowOf(parts[i], parts[outer], mesh.vertices);
        }))
      hollows.push_back(i);
  }
  for (size_t i : hollows) {
    ++report.hollows;
    report.hollow_mm3 += parts[i].volume;
    solid.hollows.indices.insert(solid.hollows.indices.end(), parts[i].triangles.begin(),
                                 parts[i].triangles.end());
    if (!options.keep_hollows) continue;
    TurnAround(parts[i].triangles);
    parts[i].turned = parts[i].own - parts[i].turned;
  }
}

// Orients and closes each part on its own; `mesh.indices` becomes all of them. Returns the caps'
// area.
double CloseParts(Solid& solid, const Parts& found, const RepairOptions& options) {
  Triangles& mesh = solid.mesh;
  MeshReport& report = solid.report;
  std::vector<Part> parts(found.count);
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    Triangle t = mesh.indices[i];
    Part& part = parts[found.of[i]];
    if (found.turn[i]) std::swap(t[1], t[2]);
    part.turned += found.turn[i];
    part.triangles.push_back(t);
  }
  double cap_area = 0;
  for (Part& part : parts) {
    part.own = part.triangles.size();
    cap_area += CloseHoles(mesh, part.triangles, report);
    part.volume = SignedVolume(mesh.vertices, part.triangles);
    // Only a closed part has a volume with a sign: caps first.
    if (part.volume < 0) {
      TurnAround(part.triangles);
      part.volume = -part.volume;
      part.turned = part.own - part.turned;
    }
    BoxOf(mesh.vertices, part.triangles, part.lo, part.hi);
  }
  if (parts.size() > 1) FindHollows(parts, options, solid);
  mesh.indices.clear();
  for (const Part& part : parts) {
    report.flipped += part.turned;
    mesh.indices.insert(mesh.indices.end(), part.triangles.begin(), part.triangles.end());
  }
  return cap_area;
}

double BoxVolume(const Triangles& mesh) {
  dvec3 lo, hi;
  BoxOf(mesh.vertices, mesh.indices, lo, hi);
  return (hi - lo).x * (hi - lo).y * (hi - lo).z;
}

}  // namespace

Triangles Welded(const Triangles& in) {
  Triangles out;
  std::unordered_map<std::array<int64_t, 3>, uint32_t, CellHash> known;
  known.reserve(in.vertices.size());
  std::vector<uint32_t> to(in.vertices.size());
  for (size_t i = 0; i < in.vertices.size(); ++i) {
    std::array<int64_t, 3> key;
    for (int k = 0; k < 3; ++k)
      // By cells of a micrometre: quick, and two vertices on either side of a cell's border stay
      // two.
      key[static_cast<size_t>(k)] = std::llround(in.vertices[i][k] / kWeld_mm);
    auto [it, fresh] = known.emplace(key, static_cast<uint32_t>(out.vertices.size()));
    if (fresh) out.vertices.push_back(in.vertices[i]);
    to[i] = it->second;
  }
  out.indices.reserve(in.indices.size());
  for (const Triangle& t : in.indices) out.indices.push_back({to[t[0]], to[t[1]], to[t[2]]});
  return out;
}

Result<Solid> MakeSolid(const Triangles& mesh_mm, const RepairOptions& options) {
  Solid solid;
  solid.mesh = Welded(mesh_mm);
  MeshReport& report = solid.report;
  DropUseless(solid.mesh, report);
  if (solid.mesh.indices.size() < 4) {
    return NoSolid("expected at least 4 triangles with an area, found " +
                   std::to_string(solid.mesh.indices.size()));
  }
  const Parts parts = FindParts(solid.mesh, report);
  if (!parts.two_sided) {
    return NoSolid(
        "a part of it has only one side (like a Moebius strip), so nothing is inside: mend it in a "
        "mesh program");
  }
  report.parts = parts.count;
  solid.first_cap_vertex = solid.mesh.vertices.size();
  const double cap_area = CloseParts(solid, parts, options);
  report.vertices = solid.mesh.vertices.size();
  report.triangles = solid.mesh.indices.size();
  report.cap_share = cap_area / std::max(SurfaceArea(solid.mesh), 1e-12);
  if (report.cap_share > options.largest_cap_share) {
    return NoSolid("it is an open sheet, its " + std::to_string(report.open_edges) +
                   " open edges would need caps of " +
                   std::to_string(static_cast<int>(100 * report.cap_share)) +
                   " % of the surface: close it in a mesh program");
  }
  if (!(SignedVolume(solid.mesh) > kSmallestFill * BoxVolume(solid.mesh))) {
    return NoSolid(
        "it encloses next to nothing of its bounding box (a flat sheet or a soup of triangles)");
  }
  // Last: by now every part is closed, as its winding numbers need.
  ENAMEL_ASSIGN_OR_RETURN(SolidBoundary boundary,
                          BoundaryOf(solid.mesh, TriangleTree(solid.mesh), options.finest_mm));
  report.crossing = boundary.crossing;
  report.buried = boundary.buried;
  solid.boundary = std::move(boundary.pieces);
  return solid;
}

bool IsCap(const Solid& solid, const std::array<uint32_t, 3>& triangle) {
  return std::max({triangle[0], triangle[1], triangle[2]}) >= solid.first_cap_vertex;
}

Triangles Select(const Solid& solid, bool caps) {
  Triangles out{solid.mesh.vertices, {}};
  for (const auto& t : solid.mesh.indices) {
    if (IsCap(solid, t) == caps) out.indices.push_back(t);
  }
  return out;
}

std::vector<std::string> Describe(const MeshReport& r) {
  std::vector<std::string> lines;
  lines.push_back(Counted(r.triangles, "triangle") + ", " +
                  Counted(r.vertices, "vertex", "vertices") + ", " + Counted(r.parts, "part"));
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
  note(r.crossing, "triangles crossed by others; the solid is all that they surround");
  note(r.buried, "triangles inside the solid (of parts that overlap), ignored");
  if (r.hollows > 0) {
    char text[80];
    std::snprintf(text, sizeof text, "%zu closed hollows of %.2f mm3 within it", r.hollows,
                  r.hollow_mm3);
    lines.push_back(text);
  }
  if (lines.size() == 1) lines.push_back("closed and consistently oriented, nothing to repair");
  return lines;
}

}  // namespace enamel::mesh
