#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::mesh {

// A scan of several teeth in one surface, from which crowns are cut out along their gums.
//
// A person gives some points along the gum, once around a tooth. The way from each to the next is a short one over the
// mesh's edges (A*, Hart, Nilsson and Raphael, IEEE Trans. SSC 4(2), 1968), so the cut follows the surface between the
// points and needs no plane. The closed way parts the surface; the crown is the side of less area. It is as jagged as
// the mesh's triangles are long, 0.1 to 0.3 mm in a scan.
// Thread safety: const after construction. Not real-time: some tenths of a second for 500 000 triangles.
class Jaw {
 public:
  static constexpr size_t kMinPoints = 3, kMaxPoints = 200;

  // Millimetres; vertices nearer than a micrometre are joined (mesh_repair.h).
  explicit Jaw(const Triangles& mesh_mm);

  // Errors: kInvalidInput, field "around": too few or too many points.
  static Status CheckCurve(std::span<const dvec3> curve_mm);
  // The crown inside the closed curve, an open shell. Errors: CheckCurve's, and kInvalidInput, field "around":
  // a point off the surface, two that the surface does not join nearby, a curve that parts no crown from the rest.
  Result<Triangles> Crown(std::span<const dvec3> curve_mm) const;

 private:
  struct Step {
    uint32_t to;
    double length_mm;
  };
  using Edge = std::array<uint32_t, 2>;  // ascending

  std::span<const Step> StepsFrom(uint32_t vertex) const;
  uint32_t Nearest(const dvec3& point) const;
  bool AddWay(uint32_t one, uint32_t other, std::vector<Edge>& way) const;
  Result<Triangles> SmallerSide(std::vector<Edge> way) const;

  Triangles mesh_;
  std::vector<uint32_t> first_;  // of a vertex's steps; one more than there are vertices
  std::vector<Step> steps_;
};

}  // namespace enamel::mesh
