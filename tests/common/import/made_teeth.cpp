#include "tests/common/import/made_teeth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/import/tooth_size.h"
#include "common/mesh/units.h"

namespace enamel::import {
namespace {

constexpr int kAround = 64, kUp = 40, kAcross = 24;

double Between(std::mt19937& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}

// Through (t, value) pairs, smooth.
double Along(double t, std::initializer_list<std::pair<double, double>> points) {
  auto at = points.begin();
  for (auto next = at + 1; next != points.end(); at = next++) {
    if (t > next->first) continue;
    double s = (t - at->first) / (next->first - at->first);
    s = s * s * (3 - 2 * s);
    return at->second + (next->second - at->second) * s;
  }
  return at->second;
}

// Rings of kAround points, from the gum to the middle of the occlusal side, closed at both ends.
mesh::Triangles Closed(const std::vector<std::vector<dvec3>>& rings, double dome_mm) {
  mesh::Triangles out;
  for (const auto& ring : rings) out.vertices.insert(out.vertices.end(), ring.begin(), ring.end());
  auto at = [](size_t ring, size_t k) {
    return static_cast<uint32_t>(ring * kAround + k % kAround);
  };
  for (size_t r = 0; r + 1 < rings.size(); ++r)
    for (size_t k = 0; k < kAround; ++k) {
      out.indices.push_back({at(r, k), at(r, k + 1), at(r + 1, k + 1)});
      out.indices.push_back({at(r, k), at(r + 1, k + 1), at(r + 1, k)});
    }
  auto middle = [&](const std::vector<dvec3>& ring) {
    dvec3 sum(0);
    for (const dvec3& p : ring) sum += p / static_cast<double>(kAround);
    return sum;
  };
  // The dome below, in rings of its own.
  const dvec3 low = middle(rings.front());
  std::vector<uint32_t> last;
  for (size_t k = 0; k < kAround; ++k) last.push_back(at(0, k));
  for (int step = 1; step < 8; ++step) {
    const double u = 1 - step / 8.0;
    std::vector<uint32_t> next;
    for (size_t k = 0; k < kAround; ++k) {
      dvec3 p = low + u * (rings.front()[k] - low);
      p.z -= dome_mm * (1 - u * u);
      next.push_back(static_cast<uint32_t>(out.vertices.size()));
      out.vertices.push_back(p);
    }
    for (size_t k = 0; k < kAround; ++k) {
      const size_t j = (k + 1) % kAround;
      out.indices.push_back({next[k], next[j], last[j]});
      out.indices.push_back({next[k], last[j], last[k]});
    }
    last = next;
  }
  const auto below = static_cast<uint32_t>(out.vertices.size());
  out.vertices.push_back(low - dvec3(0, 0, dome_mm));
  for (size_t k = 0; k < kAround; ++k)
    out.indices.push_back({below, last[(k + 1) % kAround], last[k]});
  const auto above = static_cast<uint32_t>(out.vertices.size());
  out.vertices.push_back(middle(rings.back()));
  for (size_t k = 0; k < kAround; ++k)
    out.indices.push_back({above, at(rings.size() - 1, k), at(rings.size() - 1, k + 1)});
  return out;
}

mesh::Triangles Anterior(double h, double w, double d, bool canine, std::mt19937& random) {
  const double neck = Between(random, 0.65, 0.85),
               edge_w = canine ? Between(random, 0.2, 0.45) : Between(random, 0.85, 1.0),
               edge_d = Between(random, 0.22, 0.42), bulge_at = Between(random, 0.12, 0.25),
               lean = Between(random, -0.5, 1.2), hollow = Between(random, 0.2, 1.2),
               hollow_at = Between(random, 0.5, 0.65), worn = Between(random, 0, 0.12);
  std::vector<std::vector<dvec3>> rings;
  for (int i = 0; i <= kUp; ++i) {
    const double t = (1 - worn) * i / kUp;
    const double wide = w * (canine ? Along(t, {{0, neck}, {0.4, 1}, {0.65, 0.9}, {1, edge_w}})
                                    : Along(t, {{0, neck}, {0.6, 1}, {1, edge_w}}));
    const double deep = d * Along(t, {{0, 0.9}, {bulge_at, 1}, {0.45, 0.85}, {1, edge_d}});
    const double middle = lean * Along(t, {{0, 0}, {0.5, 0.3}, {1, 1}});
    std::vector<dvec3> ring;
    for (int k = 0; k < kAround; ++k) {
      const double a = 2 * std::numbers::pi * k / kAround;
      dvec3 p(wide / 2 * std::cos(a), deep / 2 * std::sin(a) + middle, h * t);
      if (p.y < middle)
        p.y += hollow * std::exp(-std::pow((t - hollow_at) / 0.2, 2)) *
               std::exp(-std::pow(p.x / (0.3 * w), 2));
      ring.push_back(p);
    }
    rings.push_back(ring);
  }
  std::vector<dvec3> edge = rings.back();
  double y = 0;
  for (const dvec3& p : edge) y += p.y / kAround;
  for (dvec3& p : edge) p = {0.8 * p.x, y + 0.8 * (p.y - y), p.z + 0.2};
  rings.push_back(edge);
  return Closed(rings, Between(random, 0, 1.2));
}

mesh::Triangles Posterior(double h, double w, double d, int cusps, std::mt19937& random) {
  const double neck = Between(random, 0.7, 0.88), rim = Between(random, 0.72, 0.92),
               widest = Between(random, 0.45, 0.65), square = Between(random, 2.0, 2.8),
               tall = Between(random, 0.5, 1.4), fossa = Between(random, 0.5, 1.5),
               lean = Between(random, -0.6, 0.6), worn = Between(random, 0, 0.7) * tall;
  const double first = cusps == 2 ? std::numbers::pi / 2 : std::numbers::pi / cusps;
  auto round = [&](double a) {
    return std::pow(
        std::pow(std::abs(std::cos(a)), square) + std::pow(std::abs(std::sin(a)), square),
        -1 / square);
  };
  std::vector<double> heights;
  for (int i = 0; i < cusps; ++i) heights.push_back(tall * Between(random, 0.75, 1.1));
  auto cusp = [&](double a) {
    double out = 0;
    for (int i = 0; i < cusps; ++i) {
      const double at = first + 2 * std::numbers::pi * i / cusps;
      const double off = std::remainder(a - at, 2 * std::numbers::pi) * cusps / 5;
      out = std::max(out, heights[static_cast<size_t>(i)] * std::exp(-off * off * 1.6));
    }
    return out;
  };
  std::vector<std::vector<dvec3>> rings;
  const double shoulder = h - tall;
  auto top = [&](double u, double a) {
    // A bowl with cusps on its rim; worn flat above.
    const double z = shoulder + cusp(a) * u * u * (3 - 2 * u) - fossa * std::pow(1 - u, 1.5);
    return std::min(z, h - worn);
  };
  for (int i = 0; i <= kUp; ++i) {
    const double t = static_cast<double>(i) / kUp;
    const double wide = Along(t, {{0, neck}, {widest, 1}, {1, rim}});
    std::vector<dvec3> ring;
    for (int k = 0; k < kAround; ++k) {
      const double a = 2 * std::numbers::pi * k / kAround, r = wide * round(a);
      ring.push_back({w / 2 * r * std::cos(a), d / 2 * r * std::sin(a) + lean * t, t * top(1, a)});
    }
    rings.push_back(ring);
  }
  for (int i = 1; i < kAcross; ++i) {
    const double u = 1 - static_cast<double>(i) / kAcross;
    std::vector<dvec3> ring;
    for (int k = 0; k < kAround; ++k) {
      const double a = 2 * std::numbers::pi * k / kAround, r = rim * u * round(a);
      ring.push_back({w / 2 * r * std::cos(a), d / 2 * r * std::sin(a) + lean, top(u, a)});
    }
    rings.push_back(ring);
  }
  return Closed(rings, Between(random, 0, 1.2));
}

double HeightAt(const mesh::Triangles& mesh, const dvec3& up, double share) {
  double lo = 1e300, hi = -1e300;
  for (const dvec3& v : mesh.vertices) lo = std::min(lo, Dot(v, up)), hi = std::max(hi, Dot(v, up));
  return lo + share * (hi - lo);
}

}  // namespace

MadeTooth MakeTooth(int tooth, std::mt19937& random) {
  const ToothSize& mean = MeanSize(tooth);
  const int place = tooth % 10;
  const bool primary = tooth > 50, upper = (tooth / 10) % 4 == 1 || (tooth / 10) % 4 == 2;
  // Part of the height is below the gum of many a scan.
  const double h = mean.height_mm * Between(random, 0.7, 1.1),
               w = mean.mesiodistal_mm * Between(random, 0.88, 1.12),
               d = mean.buccolingual_mm * Between(random, 0.88, 1.12);
  if (place <= 3) return {Anterior(h, w, d, place == 3, random), tooth};
  const int cusps = place <= 5 && !primary ? 2 : upper ? 4 : 5;
  return {Posterior(h, w, d, cusps, random), tooth};
}

mesh::Triangles CutOpen(const mesh::Triangles& mesh, const dvec3& up, double share,
                        std::mt19937& random) {
  const dvec3 along =
      glm::normalize(up + dvec3(Between(random, -0.2, 0.2), Between(random, -0.2, 0.2),
                                Between(random, -0.2, 0.2)));
  const double from = HeightAt(mesh, along, share);
  mesh::Triangles out = mesh;
  std::erase_if(out.indices, [&](const auto& t) {
    return Dot(mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]], along) < 3 * from;
  });
  return out;
}

mesh::Triangles ReducedAbove(const mesh::Triangles& mesh, const dvec3& up, double share,
                             double depth_mm) {
  std::vector<dvec3> normal(mesh.vertices.size(), dvec3(0));
  for (const auto& t : mesh.indices) {
    const dvec3 n = glm::cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                               mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    for (uint32_t v : t) normal[v] += n;
  }
  const double from = HeightAt(mesh, up, share);
  mesh::Triangles out = mesh;
  for (size_t v = 0; v < out.vertices.size(); ++v) {
    const double length = glm::length(normal[v]);
    const double ramp = std::clamp((Dot(mesh.vertices[v], up) - from) / 0.3, 0.0, 1.0);
    if (length > 0) out.vertices[v] -= ramp * depth_mm * normal[v] / length;
  }
  return out;
}

mesh::Triangles WithCavity(const mesh::Triangles& mesh, const dvec3& up, double radius_mm,
                           double depth_mm) {
  const mesh::Box box = mesh::BoxOf(mesh);
  const dvec3 middle = 0.5 * (box.lo + box.hi);
  const double half = HeightAt(mesh, up, 0.5);
  mesh::Triangles out = mesh;
  for (dvec3& v : out.vertices) {
    if (Dot(v, up) < half) continue;
    const dvec3 way = v - middle;
    const double away = glm::length(way - Dot(way, up) * up);
    v -= up * depth_mm * std::clamp((radius_mm - away) / 0.3, 0.0, 1.0);
  }
  return out;
}

mesh::Triangles TurnedBy(const mesh::Triangles& mesh, const dmat3& turn) {
  mesh::Triangles out = mesh;
  for (dvec3& v : out.vertices) v = turn * v;
  return out;
}

std::vector<dmat3> QuarterTurns() {
  std::vector<dmat3> out;
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 6; ++y) {
      dvec3 a(0), b(0);
      a[x % 3] = x < 3 ? 1 : -1, b[y % 3] = y < 3 ? 1 : -1;
      if (x % 3 != y % 3) out.push_back({a, b, glm::cross(a, b)});
    }
  return out;
}

}  // namespace enamel::import
