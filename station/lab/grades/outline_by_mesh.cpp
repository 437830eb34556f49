#include "station/lab/grades/outline_by_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/scoring/deviation.h"

namespace enamel::station::lab {

std::vector<OutlinePiece> OutlineOn(const surface::Mesh& tooth, const Hollow& taken) {
  std::vector<double> distance(tooth.position_m.size());
  for (size_t i = 0; i < distance.size(); ++i) distance[i] = taken(dvec3(tooth.position_m[i]));
  std::vector<OutlinePiece> out;
  for (const auto& corners : tooth.triangles) {
    if (tooth.tissue[corners[0]] == static_cast<uint8_t>(cutting::Tissue::kNeighbour)) continue;
    std::vector<dvec3> ends;
    for (size_t k = 0; k < 3; ++k) {
      const size_t a = corners[k], b = corners[(k + 1) % 3];
      if ((distance[a] < 0) == (distance[b] < 0)) continue;
      const double t = distance[a] / (distance[a] - distance[b]);
      ends.push_back(glm::mix(dvec3(tooth.position_m[a]), dvec3(tooth.position_m[b]), t));
    }
    if (ends.size() != 2) continue;
    const dvec3 way = ends[1] - ends[0];
    out.push_back({(ends[0] + ends[1]) * 0.5, std::sqrt(Dot(way, way))});
  }
  return out;
}

double OutlineOver_m(const surface::Mesh& tooth, const Hollow& wanted, const Hollow& made) {
  const std::vector<OutlinePiece> to = OutlineOn(tooth, made);
  std::vector<scoring::WeightedValue> over;
  for (const OutlinePiece& p : OutlineOn(tooth, wanted)) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const OutlinePiece& q : to) {
      const dvec3 d = p.middle_m - q.middle_m;
      nearest = std::min(nearest, Dot(d, d));
    }
    over.push_back({made(p.middle_m) < 0 ? std::sqrt(nearest) : 0, p.length_m});
  }
  return scoring::WeightedQuantile(std::move(over), 0.95);
}

}  // namespace enamel::station::lab
