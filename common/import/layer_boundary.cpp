#include <cmath>
#include <vector>

#include "common/import/layers.h"
#include "common/mesh/facet.h"

namespace enamel::import {
namespace {

constexpr double kStep_mm = 2e-3;
constexpr double kUniform_mm = 0.1;  // smaller triangles are judged by four of their points

// Halves triangles until each piece is of one kind, and keeps those with air before them.
class BoundaryPieces {
 public:
  BoundaryPieces(const LayeredTooth& tooth, size_t own, double finest_mm)
      : own_(tooth.surface(own)->boundary, tooth.surface(own)->whole),
        bridge_(tooth.bridge()),
        finest_(finest_mm) {
    for (size_t i = 0; i < kLayers; ++i) {
      const auto* s = tooth.surface(i);
      if (s == nullptr || i == own) continue;
      others_.push_back({&s->boundary, mesh::SignedProbe(s->boundary, s->whole)});
    }
  }

  void Add(const mesh::Facet& f, mesh::Triangles& out) {
    const double radius = f.Radius();
    const dvec3 middle = f.Middle();
    dvec3 normal = f.AreaNormal();
    const double size = std::sqrt(Dot(normal, normal));
    if (!(size > 0)) return;
    normal = normal / size;
    // Slivers along a line where a surface crosses itself may face either way.
    if (own_.Distance(middle + 2 * kStep_mm * normal, 1) < 0) normal = -normal;
    bool near = false;
    const bool bare = HasAirBefore(middle, normal, radius + bridge_, near);
    if (near && radius > finest_ && (radius > kUniform_mm || !IsOfOneKind(f, normal, bare))) {
      for (const mesh::Facet& half : f.Halves()) Add(half, out);
      return;
    }
    if (!bare) return;
    const auto first = static_cast<uint32_t>(out.vertices.size());
    out.vertices.insert(out.vertices.end(), {f.a, f.b, f.c});
    out.indices.push_back({first, first + 1, first + 2});
  }

 private:
  struct Other {
    const mesh::TriangleTree* surface;
    mesh::SignedProbe probe;
  };

  // Half and all of the bridge before p.
  bool IsOutside(mesh::SignedProbe& probe, const dvec3& p, const dvec3& normal) const {
    return probe.Distance(p + 0.5 * bridge_ * normal, 1) >= 0 &&
           probe.Distance(p + bridge_ * normal, 1) >= 0;
  }

  bool IsOfOneKind(const mesh::Facet& f, const dvec3& normal, bool bare) {
    bool near = false;
    const dvec3 middle = f.Middle();
    for (const dvec3& corner : {f.a, f.b, f.c}) {
      if (HasAirBefore(corner + 0.05 * (middle - corner), normal, 2 * bridge_, near) != bare)
        return false;
    }
    return true;
  }

  // Neither inside another solid nor at a cleft to one. `near` is set when another surface is
  // within `look`.
  bool HasAirBefore(const dvec3& p, const dvec3& normal, double look, bool& near) {
    bool bare = true;
    const dvec3 before = p + kStep_mm * normal;
    for (Other& other : others_) {
      const double s = other.probe.Distance(before, look + kStep_mm);
      near |= std::abs(s) < look;
      if (s < 0) {
        bare = false;
      } else if (s < bridge_) {
        const dvec3 way = other.surface->NearestOn(other.probe.nearest(), before) - before;
        // The cleft test once more, from the surface: the other side lies ahead, not beside.
        if (Dot(way, normal) > -LayeredTooth::kOpposite * s) bare = false;
        bare = bare && IsOutside(other.probe, p, normal);
      }
      // A fold of the own surface, if it is at an interface.
      if (bare && std::abs(s) < bridge_) bare = IsOutside(own_, p, normal);
    }
    return bare;
  }

  mesh::SignedProbe own_;
  double bridge_, finest_;
  std::vector<Other> others_;
};

}  // namespace

void LayeredTooth::FindBoundary(double finest_mm) {
  mesh::Triangles pieces;
  for (size_t i = 0; i < kLayers; ++i) {
    if (!surfaces_[i]) continue;
    const mesh::Triangles& own = surfaces_[i]->solid.boundary;
    BoundaryPieces cutter(*this, i, finest_mm);
    for (const auto& t : own.indices) cutter.Add(mesh::Facet::Of(own, t), pieces);
  }
  boundary_ = std::make_unique<mesh::TriangleTree>(pieces);
}

}  // namespace enamel::import
