#include "common/mesh/solid_boundary.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "common/mesh/facet.h"
#include "common/mesh/mesh_edges.h"

namespace enamel::mesh {
namespace {

constexpr double kSide_mm = 2e-3;   // how far from a triangle its two sides are probed
constexpr double kTouch_mm = 1e-6;  // nearer to a plane than this lies in it
constexpr size_t kMaxPieces = 1'000'000;
// On average, of each triangle with others.
constexpr size_t kMaxNear = 400, kMaxCrossings = 40, kAllowed = 1'000'000;

Facet FacetOf(const Triangles& mesh, uint32_t i) { return Facet::Of(mesh, mesh.indices[i]); }

// Does the segment, in the facet's plane, have a point in the facet?
bool MeetsInPlane(const Facet& f, const dvec3& n, const dvec3& p, const dvec3& q) {
  // The segment is clipped by the three edges in turn (Cyrus and Beck, Computers & Graphics 3,
  // 1978). Only touching one is no meeting: neighbours in one plane do.
  double from = 0, to = 1;
  const dvec3 corners[3] = {f.a, f.b, f.c};
  for (int k = 0; k < 3; ++k) {
    const dvec3 inward = glm::cross(n, corners[(k + 1) % 3] - corners[k]);
    const double at_p = Dot(p - corners[k], inward), at_q = Dot(q - corners[k], inward);
    if (at_p <= 0 && at_q <= 0) return false;
    if (at_p < 0) from = std::max(from, at_p / (at_p - at_q));
    if (at_q < 0) to = std::min(to, at_p / (at_p - at_q));
  }
  return from < to;
}

// Does the segment pass through the facet's inner part?
bool Pierces(const Facet& f, const dvec3& n, double at_p, double at_q, const dvec3& p,
             const dvec3& q) {
  // A corner in the plane counts as below it: of two edges that meet there one passes, never both.
  if ((at_p > 0) == (at_q > 0)) return false;
  const dvec3 x = p + (at_p / (at_p - at_q)) * (q - p);
  return Dot(glm::cross(f.b - f.a, x - f.a), n) >= 0 &&
         Dot(glm::cross(f.c - f.b, x - f.b), n) >= 0 && Dot(glm::cross(f.a - f.c, x - f.c), n) >= 0;
}

// Do some of the other facet's edges (bit k: the one from corner k) pass through this one, or run
// over it in its plane?
bool EdgesMeet(const Facet& f, const Facet& other, unsigned edges) {
  const dvec3 n = f.AreaNormal();
  const double size = std::sqrt(Dot(n, n));
  if (size <= 0) return false;
  const dvec3 corners[3] = {other.a, other.b, other.c};
  double at[3];
  for (int k = 0; k < 3; ++k) {
    at[k] = Dot(corners[k] - f.a, n) / size;
    if (std::abs(at[k]) < kTouch_mm) at[k] = 0;
  }
  const bool in_plane = at[0] == 0 && at[1] == 0 && at[2] == 0;
  for (int k = 0; k < 3; ++k) {
    if ((edges >> k & 1) == 0) continue;
    const dvec3 &p = corners[k], &q = corners[(k + 1) % 3];
    if (in_plane ? MeetsInPlane(f, n, p, q) : Pierces(f, n, at[k], at[(k + 1) % 3], p, q))
      return true;
  }
  return false;
}

bool Cross(const Facet& l, const Facet& r) { return EdgesMeet(l, r, 7) || EdgesMeet(r, l, 7); }

// Of triangles with one common corner, only the edges across from it can pass through the other;
// neighbours over an edge do not cross.
bool Cross(const Triangles& mesh, uint32_t l, uint32_t r) {
  const auto &s = mesh.indices[l], &t = mesh.indices[r];
  int common = 0, of_l = 0, of_r = 0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      if (s[static_cast<size_t>(i)] != t[static_cast<size_t>(k)]) continue;
      ++common, of_l = i, of_r = k;
    }
  if (common > 1) return false;
  const Facet a = FacetOf(mesh, l), b = FacetOf(mesh, r);
  if (common == 0) return Cross(a, b);
  return EdgesMeet(a, b, 1u << (of_r + 1) % 3) || EdgesMeet(b, a, 1u << (of_l + 1) % 3);
}

using Crossing = std::vector<std::vector<uint32_t>>;  // which triangles cross which

Result<Crossing> FindCrossings(const Triangles& mesh, const TriangleTree& tree) {
  Crossing with(mesh.indices.size());
  std::vector<uint32_t> near;
  size_t looked = 0, found = 0;
  for (uint32_t i = 0; i < mesh.indices.size(); ++i) {
    const Facet f = FacetOf(mesh, i);
    tree.Collect(glm::min(f.a, glm::min(f.b, f.c)), glm::max(f.a, glm::max(f.b, f.c)), near);
    looked += near.size();
    for (uint32_t at : near) {
      const uint32_t other = tree.SourceOf(at);
      if (other <= i || !Cross(mesh, i, other)) continue;
      with[i].push_back(other);
      with[other].push_back(i);
      ++found;
    }
    if (looked > kMaxNear * with.size() + kAllowed ||
        found > kMaxCrossings * with.size() + kAllowed) {
      return Status(Code::kInvalidInput,
                    "this mesh is no solid: its triangles overlap everywhere (a soup of triangles)"
                    ": make one closed surface of it in a mesh program");
    }
  }
  return with;
}

// kTurned: on the boundary, but facing the solid (a loop the wrong way around).
enum class Place { kBoundary, kTurned, kBuried, kOutside };

class Judge {
 public:
  explicit Judge(const TriangleTree& tree) : tree_(tree) {}
  Place Of(const Facet& f) const {
    const dvec3 n = f.AreaNormal();
    const double size = std::sqrt(Dot(n, n));
    if (size <= 0) return Place::kOutside;
    const dvec3 middle = f.Middle(), step = n * (kSide_mm / size);
    // Both sides, not the normal: a loop of a surface that crosses itself runs the wrong way
    // around.
    const bool below = tree_.Inside(middle - step), above = tree_.Inside(middle + step);
    if (below != above) return below ? Place::kBoundary : Place::kTurned;
    return below ? Place::kBuried : Place::kOutside;
  }

 private:
  const TriangleTree& tree_;
};

// Halves a triangle where others cross it and keeps the pieces on the boundary.
class Cutter {
 public:
  Cutter(const Triangles& mesh, const Judge& judge, SolidBoundary& out, double smallest_mm)
      : mesh_(mesh), judge_(judge), out_(out), smallest_mm_(smallest_mm) {}

  void Cut(const Facet& piece, const std::vector<uint32_t>& others) {
    std::vector<uint32_t> here;
    for (uint32_t i : others) {
      if (Cross(piece, FacetOf(mesh_, i))) here.push_back(i);
    }
    if (here.empty() || piece.Radius() < smallest_mm_) {
      const Place place = judge_.Of(piece);
      if (place == Place::kBoundary) Keep(piece);
      if (place == Place::kTurned) Keep({piece.a, piece.c, piece.b});
      return;
    }
    for (const Facet& half : piece.Halves()) Cut(half, here);
  }

 private:
  void Keep(const Facet& piece) {
    const auto first = static_cast<uint32_t>(out_.pieces.vertices.size());
    out_.pieces.vertices.insert(out_.pieces.vertices.end(), {piece.a, piece.b, piece.c});
    out_.pieces.indices.push_back({first, first + 1, first + 2});
  }

  const Triangles& mesh_;
  const Judge& judge_;
  SolidBoundary& out_;
  double smallest_mm_;
};

// A few nested parts may cross with most of their triangles; a scan has more than these.
constexpr size_t kRoughFrom = 2000;

// Patches of triangles that hang together over edges and that nothing crosses.
std::vector<uint32_t> Patches(const Triangles& mesh, const Crossing& with) {
  std::vector<uint32_t> patch(mesh.indices.size());
  std::iota(patch.begin(), patch.end(), 0);
  auto root = [&](uint32_t i) {
    // Union-find with path halving.
    while (patch[i] != i) i = patch[i] = patch[patch[i]];
    return i;
  };
  ForEachEdge(SortedEdges(mesh.indices), [&](std::span<const EdgeUse> uses) {
    if (uses.size() != 2) return;
    const uint32_t l = uses[0].triangle, r = uses[1].triangle;
    if (with[l].empty() && with[r].empty()) patch[root(l)] = root(r);
  });
  for (uint32_t i = 0; i < patch.size(); ++i) patch[i] = root(i);
  return patch;
}

// A line of length L through triangles of mean radius r makes about L / smallest pieces.
double SmallestPiece(const Triangles& mesh, const Crossing& with, double finest_mm) {
  double pieces = 0;
  for (uint32_t i = 0; i < with.size(); ++i) {
    if (!with[i].empty())
      pieces += static_cast<double>(with[i].size()) *
                std::max(1.0, 4 * FacetOf(mesh, i).Radius() / finest_mm);
  }
  return finest_mm * std::max(1.0, pieces / static_cast<double>(kMaxPieces));
}

}  // namespace

Result<SolidBoundary> BoundaryOf(const Triangles& mesh, const TriangleTree& tree,
                                 double finest_mm) {
  ENAMEL_ASSIGN_OR_RETURN(const Crossing crossings, FindCrossings(mesh, tree));
  const Crossing& with = crossings;
  const auto crossed =
      std::ranges::count_if(with, [](const auto& others) { return !others.empty(); });
  if (mesh.indices.size() > kRoughFrom && 2 * static_cast<size_t>(crossed) > mesh.indices.size()) {
    return Status(Code::kInvalidInput,
                  "expected a surface that crosses itself in places at most, found that " +
                      std::to_string(crossed) + " of " + std::to_string(mesh.indices.size()) +
                      " triangles cross others, as in a scan whose noise is larger than its "
                      "triangles; smooth it, or save it with larger triangles");
  }
  const auto patch = Patches(mesh, with);
  const Judge judge(tree);
  SolidBoundary out{{mesh.vertices, {}}, 0, 0};
  Cutter cutter(mesh, judge, out, SmallestPiece(mesh, with, finest_mm));
  // By each patch's largest triangle: the probes of a sliver may miss their side.
  std::vector<uint32_t> largest = patch;
  std::vector<double> size(patch.size(), -1);
  for (uint32_t i = 0; i < patch.size(); ++i) {
    const dvec3 n = FacetOf(mesh, i).AreaNormal();
    if (Dot(n, n) > size[patch[i]]) size[patch[i]] = Dot(n, n), largest[patch[i]] = i;
  }
  std::vector<std::optional<Place>> judged(patch.size());
  for (uint32_t i = 0; i < patch.size(); ++i) {
    if (!with[i].empty()) {
      ++out.crossing;
      cutter.Cut(FacetOf(mesh, i), with[i]);
      continue;
    }
    auto& place = judged[patch[i]];
    if (!place) place = judge.Of(FacetOf(mesh, largest[patch[i]]));
    const auto& t = mesh.indices[i];
    if (*place == Place::kBoundary) {
      out.pieces.indices.push_back(t);
    } else if (*place == Place::kTurned) {
      out.pieces.indices.push_back({t[0], t[2], t[1]});
    } else {
      ++out.buried;
    }
  }
  return out;
}

}  // namespace enamel::mesh
