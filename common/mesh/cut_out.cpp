#include "common/mesh/cut_out.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/mesh/mesh_edges.h"
#include "common/mesh/mesh_repair.h"
#include "common/mesh/units.h"

namespace enamel::mesh {
namespace {

// A person clicks on the surface itself, which the page draws to a hundredth of a millimetre. This is the longest edge of
// a coarse scan.
constexpr double kOffSurface_mm = 1.5;
// Between two points a gum is little longer than the straight line. A much longer way goes around a hole or over another
// tooth, which nobody meant.
constexpr double kDetour = 3, kDetourMore_mm = 2;
// A regular mesh has many shortest ways between two points. A person means the one along the straight
// line, so a step this far off it counts double.
constexpr double kStray_mm = 1;

Status Invalid(const std::string& message) {
  return Status(Code::kInvalidInput, message, "around");
}

double Distance(const dvec3& a, const dvec3& b) { return glm::length(a - b); }

double FromLine(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 along = b - a;
  const double squared = Dot(along, along);
  const double t = squared > 0 ? std::clamp(Dot(p - a, along) / squared, 0.0, 1.0) : 0;
  return Distance(p, a + t * along);
}

double AreaOf(const Triangles& mesh, uint32_t triangle) {
  const auto& t = mesh.indices[triangle];
  const dvec3& a = mesh.vertices[t[0]];
  return 0.5 * glm::length(glm::cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
}

}  // namespace

Jaw::Jaw(const Triangles& mesh_mm) : mesh_(Welded(mesh_mm)) {
  std::erase_if(mesh_.indices,
                [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  std::vector<Edge> edges;
  ForEachEdge(SortedEdges(mesh_.indices), [&](std::span<const EdgeUse> uses) {
    edges.push_back({uses[0].low, uses[0].high});
  });
  first_.assign(mesh_.vertices.size() + 1, 0);
  for (const Edge& e : edges)
    for (uint32_t v : e) ++first_[v + 1];
  for (size_t v = 0; v < mesh_.vertices.size(); ++v) first_[v + 1] += first_[v];
  steps_.resize(2 * edges.size());
  std::vector<uint32_t> next = first_;
  for (const auto& [a, b] : edges) {
    const double length = Distance(mesh_.vertices[a], mesh_.vertices[b]);
    steps_[next[a]++] = {b, length};
    steps_[next[b]++] = {a, length};
  }
}

std::span<const Jaw::Step> Jaw::StepsFrom(uint32_t vertex) const {
  return std::span(steps_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
}

uint32_t Jaw::Nearest(const dvec3& point) const {
  uint32_t best = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
    if (StepsFrom(v).empty()) continue;  // of no triangle
    const double d = Distance(mesh_.vertices[v], point);
    if (d < nearest) nearest = d, best = v;
  }
  return best;
}

// The bound keeps the search near the two points: it visits what a way of that cost can reach. From
// the lower vertex, so that the way back is the same.
bool Jaw::AddWay(uint32_t one, uint32_t other, std::vector<Edge>& way) const {
  const uint32_t from = std::min(one, other), to = std::max(one, other);
  const dvec3 &begin = mesh_.vertices[from], &goal = mesh_.vertices[to];
  const double bound = kDetour * Distance(begin, goal) + kDetourMore_mm;
  struct Reached {
    double cost_mm;  // length, weighted by how far it strays
    uint32_t before;
  };
  std::unordered_map<uint32_t, Reached> reached{{from, {0, from}}};
  using Waiting = std::pair<double, uint32_t>;  // cost at least, vertex: ties fall to the lower one
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting;
  waiting.emplace(Distance(begin, goal), from);
  while (!waiting.empty() && waiting.top().second != to) {
    const auto [whole, v] = waiting.top();
    waiting.pop();
    const double here = reached.at(v).cost_mm;
    if (whole > here + Distance(mesh_.vertices[v], goal))
      continue;  // reached by a better way since
    for (const Step& step : StepsFrom(v)) {
      const dvec3& next = mesh_.vertices[step.to];
      const double cost = here + step.length_mm * (1 + FromLine(next, begin, goal) / kStray_mm);
      const double at_least = cost + Distance(next, goal);
      if (at_least > bound) continue;
      const auto [known, fresh] = reached.try_emplace(step.to, Reached{cost, v});
      if (!fresh && known->second.cost_mm <= cost) continue;
      known->second = {cost, v};
      waiting.emplace(at_least, step.to);
    }
  }
  if (waiting.empty()) return false;
  for (uint32_t v = to; v != from; v = reached.at(v).before) {
    const uint32_t before = reached.at(v).before;
    way.push_back({std::min(v, before), std::max(v, before)});
  }
  return true;
}

Result<Triangles> Jaw::SmallerSide(std::vector<Edge> way) const {
  // A way to and fro parts nothing from anything.
  std::sort(way.begin(), way.end());
  way.erase(std::unique(way.begin(), way.end()), way.end());
  constexpr uint32_t kNone = ~0u;
  std::vector<std::vector<uint32_t>> beside(mesh_.indices.size());
  std::vector<uint32_t> along;  // triangles at the way
  ForEachEdge(SortedEdges(mesh_.indices), [&](std::span<const EdgeUse> uses) {
    const bool on_way = std::binary_search(way.begin(), way.end(), Edge{uses[0].low, uses[0].high});
    for (const EdgeUse& use : uses) {
      if (on_way) along.push_back(use.triangle);
      if (!on_way && use.triangle != uses[0].triangle) {
        beside[use.triangle].push_back(uses[0].triangle);
        beside[uses[0].triangle].push_back(use.triangle);
      }
    }
  });
  struct Side {
    double area_mm2 = 0;
    size_t along = 0;  // uses of the way's edges
  };
  std::vector<uint32_t> side_of(mesh_.indices.size(), kNone), open;
  std::vector<Side> sides;
  for (uint32_t seed : along) {
    if (side_of[seed] != kNone) {
      ++sides[side_of[seed]].along;
      continue;
    }
    const auto number = static_cast<uint32_t>(sides.size());
    Side side;
    side.along = 1;
    side_of[seed] = number;
    open.assign(1, seed);
    while (!open.empty()) {
      const uint32_t t = open.back();
      open.pop_back();
      side.area_mm2 += AreaOf(mesh_, t);
      for (uint32_t n : beside[t]) {
        if (side_of[n] != kNone) continue;
        side_of[n] = number;
        open.push_back(n);
      }
    }
    sides.push_back(side);
  }
  if (sides.size() < 2) {
    return Invalid(
        "expected a curve that goes once around a tooth, found one that parts nothing from the "
        "rest of the scan: "
        "set points along the whole gum of the tooth");
  }
  // A way that crosses itself encloses slivers beside the two sides that it was meant to part.
  std::vector<uint32_t> order(sides.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, std::greater{}, [&](uint32_t i) { return sides[i].along; });
  const uint32_t crown = sides[order[0]].area_mm2 < sides[order[1]].area_mm2 ? order[0] : order[1];
  Triangles out;
  std::vector<uint32_t> renamed(mesh_.vertices.size(), kNone);
  for (uint32_t t = 0; t < mesh_.indices.size(); ++t) {
    if (side_of[t] != crown) continue;
    std::array<uint32_t, 3> corners = mesh_.indices[t];
    for (uint32_t& v : corners) {
      if (renamed[v] == kNone) {
        renamed[v] = static_cast<uint32_t>(out.vertices.size());
        out.vertices.push_back(mesh_.vertices[v]);
      }
      v = renamed[v];
    }
    out.indices.push_back(corners);
  }
  return out;
}

Status Jaw::CheckCurve(std::span<const dvec3> curve_mm) {
  if (curve_mm.size() >= kMinPoints && curve_mm.size() <= kMaxPoints) return Status::Ok();
  return Invalid("expected " + std::to_string(kMinPoints) + " to " + std::to_string(kMaxPoints) +
                 " points around a tooth, found " + std::to_string(curve_mm.size()));
}

Result<Triangles> Jaw::Crown(std::span<const dvec3> curve_mm) const {
  ENAMEL_RETURN_IF_ERROR(CheckCurve(curve_mm));
  if (mesh_.indices.empty()) return Invalid("the scan holds no triangles");
  std::vector<uint32_t> stations;
  for (const dvec3& p : curve_mm) {
    const uint32_t v = Nearest(p);
    if (const double off = Distance(mesh_.vertices[v], p); !(off <= kOffSurface_mm)) {
      return Invalid("expected points on the scan, found point " +
                     std::to_string(stations.size() + 1) + " " + Fixed(off, 1) +
                     " mm away from it");
    }
    stations.push_back(v);
  }
  std::vector<Edge> way;
  for (size_t i = 0; i < stations.size(); ++i) {
    const size_t next = (i + 1) % stations.size();
    if (AddWay(stations[i], stations[next], way)) continue;
    return Invalid("the scan's surface does not join points " + std::to_string(i + 1) + " and " +
                   std::to_string(next + 1) +
                   " by a short way: a hole or a gap lies between them; set more points around it");
  }
  return SmallerSide(std::move(way));
}

}  // namespace enamel::mesh
