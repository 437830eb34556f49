#include "common/mesh/registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "common/mesh/triangle_tree.h"
#include "common/mesh/units.h"

namespace enamel::mesh {
namespace {

constexpr size_t kFirstPoints = 200, kGridPoints = 500, kFewPoints = 1000, kManyPoints = 4000;
constexpr size_t kAfterFirst = 100, kAfterGrid = 10;
constexpr double kGridStep_mm = 0.4, kGridMargin_mm = 3, kFar_mm = 40;
constexpr double kReach_mm = 2;        // of distances to the surface itself
constexpr double kSameFacing = 0.5;    // cosine
constexpr double kOtherPose_mm = 0.5;  // poses nearer than this are one
constexpr double kOutsideCost = 4;
// A crown is reduced by at most 2 mm, most often by 1 to 1.5.
constexpr double kSlide_mm = 1.6, kSlideStep_mm = 0.3, kOtherSlide_mm = 0.5;
constexpr size_t kSlidPoints = 300, kAfterSlide = 32;
// Where the surface was not cut, it agrees to a scanner's error; where a cut happens to lie near the
// tooth's surface, distances up to kAgree_mm are alike. So a pose this much more exact is right, even
// where less of the surface agrees.
constexpr double kExacter = 0.65, kExactShare = 0.1;
constexpr double kStill_mm = 1e-4;     // a step that moves less is the last; a scan is off by 0.01
constexpr double kMinScale_mm = 0.03;  // of Tukey's weight: no scan is better

// Where the surface is from a point: signed distance, and the direction away from it.
struct Away {
  double distance;
  dvec3 normal;
};

// Signed distances in a grid around the mesh; beyond it the grid's edge and the way there.
class DistanceGrid {
 public:
  DistanceGrid(const TriangleTree& tree, const Box& box) : lo_(box.lo - kGridMargin_mm) {
    size_ = ivec3(glm::ceil((box.hi + kGridMargin_mm - lo_) / kGridStep_mm)) + 2;
    values_.resize(static_cast<size_t>(size_.x * size_.y * size_.z));
    SignedProbe probe(tree, tree);
    for (int z = 0; z < size_.z; ++z)
      for (int y = 0; y < size_.y; ++y) FillRow(probe, y, z);
  }

  Away At(const dvec3& p) const {
    const dvec3 last = dvec3(size_ - 2) + 0.999;
    const dvec3 sample = (p - lo_) / kGridStep_mm, near = glm::clamp(sample, dvec3(0), last);
    const dvec3 beyond = (sample - near) * kGridStep_mm;
    const ivec3 cell(near);
    const dvec3 f = near - dvec3(cell);
    auto v = [&](int x, int y, int z) -> double {
      const ivec3 c = cell + ivec3(x, y, z);
      return values_[IndexOf(c)];
    };
    auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
    const double x00 = mix(v(0, 0, 0), v(1, 0, 0), f.x), x10 = mix(v(0, 1, 0), v(1, 1, 0), f.x);
    const double x01 = mix(v(0, 0, 1), v(1, 0, 1), f.x), x11 = mix(v(0, 1, 1), v(1, 1, 1), f.x);
    const double y0 = mix(x00, x10, f.y), y1 = mix(x01, x11, f.y);
    dvec3 slope;
    slope.x = mix(mix(v(1, 0, 0) - v(0, 0, 0), v(1, 1, 0) - v(0, 1, 0), f.y),
                  mix(v(1, 0, 1) - v(0, 0, 1), v(1, 1, 1) - v(0, 1, 1), f.y), f.z);
    slope.y = mix(x10 - x00, x11 - x01, f.z);
    slope.z = y1 - y0;
    const double far = glm::length(beyond);
    if (far > 0) return {mix(y0, y1, f.z) + far, beyond / far};
    const double length = glm::length(slope);
    return {mix(y0, y1, f.z), length > 0 ? slope / length : dvec3(0, 0, 1)};
  }

 private:
  size_t IndexOf(const ivec3& c) const {
    return static_cast<size_t>((c.z * size_.y + c.y) * size_.x + c.x);
  }
  // Forth and back, so that each search starts next to the one before.
  void FillRow(SignedProbe& probe, int y, int z) {
    for (int x = 0; x < size_.x; ++x) {
      const ivec3 c((y + z) % 2 == 0 ? x : size_.x - 1 - x, y, z);
      values_[IndexOf(c)] =
          static_cast<float>(probe.Distance(lo_ + kGridStep_mm * dvec3(c), kFar_mm));
    }
  }

  dvec3 lo_;
  ivec3 size_{0};
  std::vector<float> values_;  // (z, y, x), x fastest
};

// The same from the triangles. The side is that of the nearest triangle, which a winding number
// would tell at its sharp edges too, at forty times the cost; what an edge misjudges is a few
// points of a thousand.
class SurfaceDistance {
 public:
  explicit SurfaceDistance(const TriangleTree& tree) : tree_(&tree) {}

  Away At(const dvec3& p) {
    const double d = tree_->Distance(p, kReach_mm, &nearest_);
    if (d >= kReach_mm) return {tree_->Inside(p) ? -kReach_mm : kReach_mm, dvec3(0)};
    return From(p, d);
  }
  // The surface within `limit` on either side; where it is farther, {limit, no direction}. Many
  // triangles are about as near to a point deep inside, and finding the nearest of them takes long.
  Away Within(const dvec3& p, double limit) {
    const double d = tree_->Distance(p, limit, &nearest_);
    return d < limit ? From(p, d) : Away{limit, dvec3(0)};
  }

 private:
  Away From(const dvec3& p, double d) const {
    const TriangleTree::Triangle& t = tree_->At(nearest_);
    const dvec3 facing = glm::normalize(glm::cross(t.b - t.a, t.c - t.a));
    const dvec3 way = p - tree_->NearestOn(nearest_, p);
    const double along = Dot(way, facing);
    if (d < 1e-7) return {d, facing};
    return {along < 0 ? -d : d, way / (along < 0 ? -d : d)};
  }

  const TriangleTree* tree_;
  uint32_t nearest_ = 0;  // to the point before
};

double Biweight(double r, double scale) {
  const double q = r / scale, rest = 1 - q * q;
  return rest > 0 ? rest * rest : 0;
}

// Solves m x = b for a symmetric positive m (Cholesky). False where it is not.
bool Solve(std::array<std::array<double, 6>, 6> m, std::array<double, 6> b,
           std::array<double, 6>& x) {
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j <= i; ++j) {
      double sum = m[i][j];
      for (size_t k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
      if (i != j) {
        m[i][j] = sum / m[j][j];
        continue;
      }
      if (!(sum > 0)) return false;
      m[i][i] = std::sqrt(sum);
    }
  }
  for (size_t i = 0; i < 6; ++i) {
    for (size_t k = 0; k < i; ++k) b[i] -= m[i][k] * b[k];
    b[i] /= m[i][i];
  }
  for (size_t i = 6; i-- > 0;) {
    for (size_t k = i + 1; k < 6; ++k) b[i] -= m[k][i] * b[k];
    b[i] /= m[i][i];
  }
  x = b;
  return true;
}

dmat3 TurnBy(const dvec3& axis_rad) {
  const double angle = glm::length(axis_rad);
  if (angle == 0) return dmat3(1.0);
  const dvec3 a = axis_rad / angle;
  const double s = std::sin(angle), c = std::cos(angle);
  auto turned = [&](const dvec3& v) {
    return v * c + glm::cross(a, v) * s + a * (Dot(a, v) * (1 - c));
  };
  return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})};
}

// Of each point in this pose: most of what a step costs.
template <typename AwayAt>
std::vector<Away> AwayFrom(const AwayAt& away_at, const std::vector<SurfacePoint>& points,
                           const Rigid& pose) {
  std::vector<Away> out;
  out.reserve(points.size());
  for (const SurfacePoint& point : points) out.push_back(away_at(pose.At(point.at)));
  return out;
}

// One Gauss-Newton step towards the surface, which is `aways` from the points in this pose. Returns
// how far it moved what it weighed, about.
double Step(const std::vector<Away>& aways, const std::vector<SurfacePoint>& points,
            double scale_mm, bool facing, Rigid& pose) {
  std::array<std::array<double, 6>, 6> m{};
  std::array<double, 6> b{};
  dvec3 middle(0);
  for (const SurfacePoint& point : points) middle += pose.At(point.at);
  middle /= static_cast<double>(points.size());
  double weights = 0, arm2 = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& point = points[i];
    const Away& away = aways[i];
    double weight = away.distance > scale_mm ? 0.5 * scale_mm / away.distance
                    : away.distance > 0      ? 0.5 + 0.5 * Biweight(away.distance, scale_mm)
                                             : Biweight(away.distance, scale_mm);
    if (facing) {
      weight = Biweight(away.distance, scale_mm);
      if (Dot(pose.rotation * point.normal, away.normal) < kSameFacing) weight = 0;
    }
    if (weight == 0) continue;
    const dvec3 arm = pose.At(point.at) - middle, turn = glm::cross(arm, away.normal);
    const std::array<double, 6> row = {away.normal.x, away.normal.y, away.normal.z,
                                       turn.x,        turn.y,        turn.z};
    for (size_t k = 0; k < 6; ++k) {
      b[k] -= weight * away.distance * row[k];
      for (size_t j = 0; j <= k; ++j) m[k][j] += weight * row[k] * row[j];
    }
    weights += weight;
    arm2 += weight * Dot(arm, arm);
  }
  if (!(weights > 0)) return 0;
  // So little that it only holds what nothing else does.
  for (size_t i = 0; i < 6; ++i) m[i][i] += 1e-6 * (i < 3 ? weights : arm2) + 1e-12;
  for (size_t i = 0; i < 6; ++i)
    for (size_t j = 0; j < i; ++j) m[j][i] = m[i][j];
  std::array<double, 6> x;
  if (!Solve(m, b, x)) return 0;
  const dvec3 move(x[0], x[1], x[2]), turn(x[3], x[4], x[5]);
  const dmat3 rotation = TurnBy(turn);
  pose = Rigid{rotation, middle + move - rotation * middle}.After(pose);
  return glm::length(move) + glm::length(turn) * std::sqrt(arm2 / weights);
}

double CostOf(double distance, bool faces, double scale_mm) {
  const double q = distance / scale_mm, square = q * q;
  if (distance > 0) return std::min(square, kOutsideCost);
  return faces ? std::min(square, 1.0) : 1;
}

template <typename Distances>
double Cost(Distances& distances, const std::vector<SurfacePoint>& points, const Rigid& pose,
            double scale_mm, bool facing) {
  double sum = 0;
  for (const SurfacePoint& point : points) {
    const Away away = distances.At(pose.At(point.at));
    const bool faces = !facing || Dot(pose.rotation * point.normal, away.normal) >= kSameFacing;
    sum += CostOf(away.distance, faces, scale_mm);
  }
  return sum / static_cast<double>(points.size());
}

// A tooth that was reduced evenly agrees on its collar alone, but exactly. Slid by the reduction, its
// cut surface nearly agrees with the tooth's, over more of it. So exactness counts: the mean cost over
// scales from half of a good scanner's error to what just agrees.
constexpr std::array<double, 5> kScales_mm = {0.01, 0.02, 0.04, 0.08, kAgree_mm};
double ExactCost(double distance, bool faces) {
  double sum = 0;
  for (double scale : kScales_mm)
    sum += distance > kAgree_mm ? CostOf(distance, faces, kAgree_mm)
                                : std::min(CostOf(distance, faces, scale), 1.0);
  return sum / static_cast<double>(kScales_mm.size());
}

struct Candidate {
  Rigid pose;
  double cost = 0;
};

// Farthest that a corner of the box lies apart in the two poses.
double Apart_mm(const Rigid& a, const Rigid& b, const Box& box) {
  double out = 0;
  for (int i = 0; i < 8; ++i) {
    const dvec3 p((i & 1 ? box.hi : box.lo).x, (i & 2 ? box.hi : box.lo).y,
                  (i & 4 ? box.hi : box.lo).z);
    out = std::max(out, glm::length(a.At(p) - b.At(p)));
  }
  return out;
}

// The best of those that are not the same as a better one.
void KeepBest(std::vector<Candidate>& all, size_t count, double apart_mm, const Box& box) {
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& l, const Candidate& r) { return l.cost < r.cost; });
  std::vector<Candidate> kept;
  for (const Candidate& c : all) {
    if (kept.size() == count) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Candidate& k) {
      return Apart_mm(k.pose, c.pose, box) < apart_mm;
    });
    if (!known) kept.push_back(c);
  }
  all = std::move(kept);
}

// Middle on middle, and each end on its end: a scan without the root is shorter.
std::vector<Candidate> Starts(const std::vector<SurfacePoint>& points, const Box& fixed) {
  std::vector<Candidate> out;
  for (size_t i = 0; i < kSpiralTurns; ++i) {
    const dmat3 turn = SpiralTurn(i);
    Box box{dvec3(1e300), dvec3(-1e300)};
    for (const SurfacePoint& point : points) {
      const dvec3 p = turn * point.at;
      box.lo = glm::min(box.lo, p), box.hi = glm::max(box.hi, p);
    }
    const dvec3 middle = 0.5 * (fixed.lo + fixed.hi) - 0.5 * (box.lo + box.hi);
    out.push_back({{turn, middle}, 0});
    for (int axis = 0; axis < 3; ++axis) {
      dvec3 low = middle, high = middle;
      low[axis] = fixed.lo[axis] - box.lo[axis];
      high[axis] = fixed.hi[axis] - box.hi[axis];
      out.push_back({{turn, low}, 0});
      out.push_back({{turn, high}, 0});
    }
  }
  return out;
}

std::vector<Candidate> FindCoarse(const DistanceGrid& grid, const Triangles& moving,
                                  const Box& fixed, const Box& box) {
  const auto first = SpreadOver(moving, kFirstPoints), more = SpreadOver(moving, kGridPoints);
  std::vector<Candidate> all = Starts(first, fixed);
  const auto away_at = [&](const dvec3& p) { return grid.At(p); };
  for (Candidate& c : all) {
    for (double scale : {3.0, 3.0, 2.0, 2.0, 1.5, 1.0})
      Step(AwayFrom(away_at, first, c.pose), first, scale, false, c.pose);
    c.cost = Cost(grid, first, c.pose, 0.8, false);
  }
  KeepBest(all, kAfterFirst, 2 * kOtherPose_mm, box);
  for (Candidate& c : all) {
    for (double scale : {1.5, 1.2, 1.0, 0.8, 0.6, 0.5}) {
      for (int i = 0; i < 4; ++i) Step(AwayFrom(away_at, more, c.pose), more, scale, false, c.pose);
    }
    c.cost = Cost(grid, more, c.pose, 0.4, false);
  }
  KeepBest(all, kAfterGrid, kOtherPose_mm, box);
  return all;
}

template <typename Distances>
double ExactCost(Distances& distances, const std::vector<SurfacePoint>& points, const Rigid& pose,
                 bool facing) {
  double sum = 0;
  for (const SurfacePoint& point : points) {
    const Away away = distances.At(pose.At(point.at));
    const bool faces = !facing || Dot(pose.rotation * point.normal, away.normal) >= kSameFacing;
    sum += ExactCost(away.distance, faces);
  }
  return sum / static_cast<double>(points.size());
}

// The candidates slid as far as a crown is reduced, in all directions, and those kept that agree
// most exactly.
std::vector<Candidate> Slid(const DistanceGrid& grid, const Triangles& moving,
                            const std::vector<Candidate>& from, const Box& box) {
  const auto points = SpreadOver(moving, kSlidPoints);
  const auto away_at = [&](const dvec3& p) { return grid.At(p); };
  std::vector<Candidate> all;
  const int reach = static_cast<int>(kSlide_mm / kSlideStep_mm);
  for (const Candidate& candidate : from)
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const dvec3 slide = kSlideStep_mm * dvec3(x, y, z);
          if (glm::length(slide) > kSlide_mm) continue;
          Candidate c = candidate;
          c.pose.shift += slide;
          for (double scale : {0.25, 0.25, 0.2, 0.2, 0.15, 0.15})
            Step(AwayFrom(away_at, points, c.pose), points, scale, false, c.pose);
          c.cost = ExactCost(grid, points, c.pose, false);
          all.push_back(c);
        }
  KeepBest(all, kAfterSlide, kOtherSlide_mm, box);
  return all;
}

// Scale of Tukey's weight for the spread of what agrees: 95 % efficient for normal errors (Holland
// and Welsch, Communications in Statistics A6, 1977).
double ScaleFor_mm(const std::vector<Away>& aways) {
  std::vector<double> sizes;
  for (const Away& away : aways) {
    const double d = std::abs(away.distance);
    if (d < kAgree_mm) sizes.push_back(d);
  }
  if (sizes.empty()) return kAgree_mm;
  const auto middle = sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::clamp(4.685 * 1.4826 * *middle, kMinScale_mm, kAgree_mm);
}

void Refine(SurfaceDistance& distances, const std::vector<SurfacePoint>& points, Rigid& pose,
            bool wide) {
  // Points farther away than the scale have no weight.
  const auto away_from = [&](double scale_mm) {
    return AwayFrom([&](const dvec3& p) { return distances.Within(p, scale_mm); }, points, pose);
  };
  if (wide) {
    for (double scale : {0.8, 0.8, 0.6, 0.4, 0.4, 0.3, 0.2, 0.2})
      Step(away_from(scale), points, scale, true, pose);
  }
  for (int i = 0; i < 30; ++i) {
    const std::vector<Away> aways = away_from(kAgree_mm);
    if (Step(aways, points, ScaleFor_mm(aways), true, pose) < kStill_mm) return;
  }
}

Fit Measure(SurfaceDistance& distances, const std::vector<SurfacePoint>& points,
            const Rigid& pose) {
  Fit out;
  out.fixed_from_moving = pose;
  std::vector<double> sizes;
  double squares = 0;
  size_t agree = 0, inside = 0, outside = 0;
  for (const SurfacePoint& point : points) {
    const Away away = distances.At(pose.At(point.at));
    const bool faces = Dot(pose.rotation * point.normal, away.normal) >= kSameFacing;
    out.distance_mm.push_back(away.distance);
    out.cost += ExactCost(away.distance, faces);
    if (away.distance > kAgree_mm) {
      ++outside;
    } else if (away.distance < -kAgree_mm || !faces) {
      ++inside;
      continue;
    } else {
      ++agree;
    }
    squares += away.distance * away.distance;
    sizes.push_back(std::abs(away.distance));
  }
  const auto count = static_cast<double>(points.size());
  out.cost /= count;
  out.agree_share = static_cast<double>(agree) / count;
  out.inside_share = static_cast<double>(inside) / count;
  out.outside_share = static_cast<double>(outside) / count;
  if (sizes.empty()) return out;
  out.rms_mm = std::sqrt(squares / static_cast<double>(sizes.size()));
  const auto at = sizes.begin() + static_cast<ptrdiff_t>(0.95 * static_cast<double>(sizes.size()));
  std::nth_element(sizes.begin(), at, sizes.end());
  out.p95_mm = *at;
  return out;
}

}  // namespace

dmat3 SpiralTurn(size_t i) {
  const double s = static_cast<double>(i) + 0.5, t = s / kSpiralTurns;
  const double r = std::sqrt(t), rest = std::sqrt(1 - t);
  const double a = 2 * std::numbers::pi * s / std::numbers::sqrt2;
  const double b = 2 * std::numbers::pi * s / 1.533751168755204288118041;
  const double x = r * std::sin(a), y = r * std::cos(a), z = rest * std::sin(b),
               w = rest * std::cos(b);
  return {dvec3(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
          dvec3(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
          dvec3(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y))};
}

double TurnOf_deg(const dmat3& r) {
  // By the sine: the cosine of a small angle has lost its digits.
  const dvec3 axis(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
  return std::atan2(glm::length(axis), r[0][0] + r[1][1] + r[2][2] - 1) * 180 / std::numbers::pi;
}

Triangles Moved(Triangles mesh, const Rigid& by) {
  for (dvec3& v : mesh.vertices) v = by.At(v);
  return mesh;
}

std::vector<SurfacePoint> SpreadOver(const Triangles& mesh, size_t count) {
  const double each = SurfaceArea(mesh) / static_cast<double>(count);
  std::vector<SurfacePoint> out;
  out.reserve(count);
  double passed = 0;
  for (const auto& t : mesh.indices) {
    const dvec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const dvec3 twice = glm::cross(b - a, c - a);
    const double length = glm::length(twice);
    passed += 0.5 * length;
    while (out.size() < count && (static_cast<double>(out.size()) + 0.5) * each < passed) {
      // Roberts' R2 sequence: even within triangles that get many.
      const auto n = static_cast<double>(out.size() + 1);
      double u = n * 0.7548776662466927, v = n * 0.5698402909980532;
      u -= std::floor(u), v -= std::floor(v);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      out.push_back({a + u * (b - a) + v * (c - a), twice / length});
    }
  }
  return out;
}

std::vector<Fit> FitOnto(const Triangles& fixed, const Triangles& moving) {
  const TriangleTree tree(fixed);
  const Box fixed_box = BoxOf(fixed), box = BoxOf(moving);
  const DistanceGrid grid(tree, fixed_box);
  std::vector<Candidate> found = FindCoarse(grid, moving, fixed_box, box);
  std::vector<Candidate> slid = Slid(grid, moving, found, box);
  SurfaceDistance distances(tree);
  const auto few = SpreadOver(moving, kFewPoints), many = SpreadOver(moving, kManyPoints);
  for (Candidate& c : found) Refine(distances, few, c.pose, true);
  for (Candidate& c : slid) Refine(distances, few, c.pose, false);
  found.insert(found.end(), slid.begin(), slid.end());
  for (Candidate& c : found) c.cost = ExactCost(distances, few, c.pose, true);
  KeepBest(found, kAfterGrid, kOtherPose_mm, box);
  std::vector<Fit> out;
  for (Candidate& c : found) {
    // The others only show whether there is another that is as good.
    if (out.empty()) Refine(distances, many, c.pose, false);
    Fit fit = Measure(distances, many, c.pose);
    if (fit.agree_share > 0) out.push_back(std::move(fit));
  }
  const auto exacter = std::find_if(out.begin(), out.end(), [&](const Fit& fit) {
    return fit.rms_mm < kExacter * out.front().rms_mm &&
           fit.outside_share <= out.front().outside_share && fit.agree_share >= kExactShare;
  });
  if (exacter != out.end()) {
    std::rotate(out.begin(), exacter, exacter + 1);
    Rigid pose = out.front().fixed_from_moving;
    Refine(distances, many, pose, false);
    out.front() = Measure(distances, many, pose);
  }
  return out;
}

Fit FitNear(const Triangles& fixed, const Triangles& moving, const Rigid& start) {
  const TriangleTree tree(fixed);
  SurfaceDistance distances(tree);
  Rigid pose = start;
  Refine(distances, SpreadOver(moving, kFewPoints), pose, true);
  const auto many = SpreadOver(moving, kManyPoints);
  Refine(distances, many, pose, false);
  return Measure(distances, many, pose);
}

}  // namespace enamel::mesh
