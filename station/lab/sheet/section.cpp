#include "station/lab/sheet/section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace enamel::station::lab {
namespace {

using cutting::Tissue;

constexpr double kStep_m = 0.1e-3,
                 kSearch_m = 0.25e-3;  // of points in a picture, and to find its plane
constexpr double kAround_m = 1.2e-3;   // tooth shown around the cut
constexpr double kUnit_m = 10e-6;      // of the picture's coordinates

struct Axes {
  int across, up, through;
};
Axes AxesOf(Plane plane) {
  switch (plane) {
    case Plane::kMesiodistal:
      return {0, 2, 1};
    case Plane::kBuccolingual:
      return {1, 2, 0};
    case Plane::kLevel:
      return {0, 1, 2};
  }
  return {0, 2, 1};
}

// Distances to the tooth that is left (m, negative inside it) after `wanted` and after `taken`.
struct Left {
  double should = 1, is = 1;
};
// `tooth`: the distance to the whole tooth there.
Left LeftAt(const CutPair& cut, const dvec3& p, double tooth) {
  if (tooth > 2 * kSearch_m) return {tooth, tooth};
  const bool neighbour = cut.tooth->TissueAtPoint(p) == Tissue::kNeighbour;
  const bool spared = neighbour && cut.neighbours == Neighbours::kSpared;
  return {neighbour ? tooth : std::max(tooth, -cut.wanted(p)),
          spared ? tooth : std::max(tooth, -cut.taken(p))};
}

// A window of points in a plane.
struct Window {
  Axes axes;
  double through_m = 0, across_m = 0, up_m = 0;  // the plane, and the first point
  int columns = 0, rows = 0;

  dvec3 At(int column, int row) const {
    dvec3 p(0);
    p[axes.through] = through_m;
    p[axes.across] = across_m + column * kStep_m;
    p[axes.up] = up_m + row * kStep_m;
    return p;
  }
};

// A plane near the middle of what had to be cut, if it shows a fair part of the difference that the
// best plane shows: the middle is what people know. NaN where nothing differs.
double BestPlane_m(const CutPair& cut, const Axes& axes) {
  constexpr double kFairPart = 0.15;
  const cutting::GridSpec& spec = cut.tooth->spec();
  const dvec3 lo = spec.origin_m(), hi = lo + dvec3(spec.voxels()) * spec.voxel_m();
  std::vector<double> differing;
  double wanted = 0, wanted_at = 0;  // points of the cut, and the sum of their places
  for (double w = lo[axes.through]; w < hi[axes.through]; w += kSearch_m) {
    double count = 0;
    for (double u = lo[axes.across]; u < hi[axes.across]; u += kSearch_m) {
      for (double v = lo[axes.up]; v < hi[axes.up]; v += kSearch_m) {
        dvec3 p(0);
        p[axes.through] = w, p[axes.across] = u, p[axes.up] = v;
        const double tooth = cut.tooth->DistanceAt_m(p);
        if (tooth >= 0) continue;
        const Left left = LeftAt(cut, p, tooth);
        count += (left.should < 0) != (left.is < 0) ? 1 : 0;
        if (left.should < 0) continue;
        wanted += 1, wanted_at += static_cast<double>(differing.size());
      }
    }
    differing.push_back(count);
  }
  const double most = *std::ranges::max_element(differing);
  if (most == 0) return std::nan("");
  const double middle = wanted > 0 ? wanted_at / wanted : 0;
  double best = -1;
  for (size_t i = 0; i < differing.size(); ++i) {
    const auto at = static_cast<double>(i);
    if (differing[i] < kFairPart * most) continue;
    if (best < 0 || std::fabs(at - middle) < std::fabs(best - middle)) best = at;
  }
  return lo[axes.through] + best * kSearch_m;
}

Window WindowOf(const CutPair& cut, const Axes& axes, double through_m) {
  const cutting::GridSpec& spec = cut.tooth->spec();
  const dvec3 first = spec.origin_m(), size = dvec3(spec.voxels()) * spec.voxel_m();
  Window all{axes,
             through_m,
             first[axes.across],
             first[axes.up],
             static_cast<int>(size[axes.across] / kStep_m),
             static_cast<int>(size[axes.up] / kStep_m)};
  int left = all.columns, right = 0, bottom = all.rows, top = 0;
  for (int row = 0; row < all.rows; ++row) {
    for (int column = 0; column < all.columns; ++column) {
      const dvec3 p = all.At(column, row);
      if (cut.tooth->DistanceAt_m(p) >= 0 || !(cut.wanted(p) < 0 || cut.taken(p) < 0)) continue;
      left = std::min(left, column), right = std::max(right, column);
      bottom = std::min(bottom, row), top = std::max(top, row);
    }
  }
  const int around = static_cast<int>(std::lround(kAround_m / kStep_m));
  left = std::max(0, left - around), bottom = std::max(0, bottom - around);
  all.across_m += left * kStep_m, all.up_m += bottom * kStep_m;
  all.columns = std::min(all.columns - left, right + around - left);
  all.rows = std::min(all.rows - bottom, top + around - bottom);
  return all;
}

// A field over a window's points, row by row; the picture's rim counts as outside.
using Field = std::vector<double>;

// The lines around where a field is negative, as an SVG path with y down: marching squares, each
// line followed from edge to edge of the squares.
class Outliner {
 public:
  Outliner(const Window& window, const Field& field) : w_(window), field_(field) {}

  std::string Path() {
    next_.assign(static_cast<size_t>(2 * Stride() * (w_.rows + 2)), -1);
    for (int row = -1; row < w_.rows; ++row) {
      for (int column = -1; column < w_.columns; ++column) Square(column, row);
    }
    std::string out;
    for (size_t edge = 0; edge < next_.size(); ++edge) {
      if (next_[edge] >= 0) Follow(static_cast<int>(edge), out);
    }
    return out;
  }

 private:
  struct Point {
    long x, y;
  };
  int Stride() const { return w_.columns + 2; }
  double At(int column, int row) const {
    const bool in = column >= 0 && row >= 0 && column < w_.columns && row < w_.rows;
    return in ? field_[static_cast<size_t>(row * w_.columns + column)] : kStep_m;
  }
  // The edge from a point to the right (0) or up (1).
  int Edge(int column, int row, int up) const {
    return 2 * ((row + 1) * Stride() + column + 1) + up;
  }
  void Square(int column, int row) {
    const std::array<bool, 4> in = {At(column, row) < 0, At(column + 1, row) < 0,
                                    At(column + 1, row + 1) < 0, At(column, row + 1) < 0};
    const std::array<int, 4> edges = {Edge(column, row, 0), Edge(column + 1, row, 1),
                                      Edge(column, row + 1, 0), Edge(column, row, 1)};
    for (size_t i = 0; i < 4; ++i) {
      if (!in[i] || in[(i + 1) % 4]) continue;
      size_t back = (i + 1) % 4;
      while (in[back] || !in[(back + 1) % 4]) back = (back + 1) % 4;
      next_[static_cast<size_t>(edges[i])] = edges[back];
    }
  }
  Point PointOn(int edge) const {
    const int column = edge / 2 % Stride() - 1, row = edge / 2 / Stride() - 1;
    const bool up = edge % 2 != 0;
    const double a = At(column, row), b = up ? At(column, row + 1) : At(column + 1, row);
    const double along = a / (a - b), unit = kStep_m / kUnit_m;
    return {std::lround(unit * (column + (up ? 0 : along))),
            std::lround(unit * (w_.rows - row - (up ? along : 0)))};
  }
  void Follow(int edge, std::string& out) {
    Point at = PointOn(edge);
    const std::string first = "M" + std::to_string(at.x) + " " + std::to_string(at.y) + "l";
    std::string line;
    while (next_[static_cast<size_t>(edge)] >= 0) {
      const int to = next_[static_cast<size_t>(edge)];
      next_[static_cast<size_t>(edge)] = -1;
      const Point p = PointOn(to);
      if (p.x != at.x || p.y != at.y) {
        line += std::to_string(p.x - at.x) + " " + std::to_string(p.y - at.y) + " ";
      }
      at = p, edge = to;
    }
    if (!line.empty()) out += first + line + "z";
  }

  const Window& w_;
  const Field& field_;
  std::vector<int> next_;
};

template <typename At>
Field FieldOf(const Window& w, const At& at) {
  Field out;
  for (int row = 0; row < w.rows; ++row) {
    for (int column = 0; column < w.columns; ++column) out.push_back(at(column, row));
  }
  return out;
}

Field Both(const Field& a, const Field& b, double sign_of_b) {
  Field out;
  for (size_t i = 0; i < a.size(); ++i) out.push_back(std::max(a[i], sign_of_b * b[i]));
  return out;
}

std::string Element(const Window& w, const Field& field, const char* name) {
  const std::string path = Outliner(w, field).Path();
  if (path.empty()) return "";
  return std::string("<path class=\"") + name + "\" d=\"" + path + "\"/>";
}

struct Layer {
  const char* name;
  std::vector<Tissue> tissues;
};
const std::vector<Layer>& Layers() {
  static const std::vector<Layer> layers = {{"dentin", {Tissue::kDentin, Tissue::kPulp}},
                                            {"pulp", {Tissue::kPulp}},
                                            {"caries", {Tissue::kCaries}},
                                            {"gypsum", {Tissue::kGypsum}},
                                            {"neighbour", {Tissue::kNeighbour}}};
  return layers;
}

// Where the tissue is one of these, its border smoothed over three points each way.
Field TissueField(const CutPair& cut, const Window& w, std::span<const Tissue> tissues) {
  return FieldOf(w, [&](int column, int row) {
    double sum = 0;
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        const Tissue t = cut.tooth->TissueAtPoint(w.At(column + i, row + j));
        sum += std::ranges::find(tissues, t) != tissues.end() ? -1 : 1;
      }
    }
    return sum * kStep_m / 9;
  });
}

}  // namespace

std::string DrawSections(const CutPair& cut, Plane plane) {
  const Axes axes = AxesOf(plane);
  const double through_m = BestPlane_m(cut, axes);
  if (std::isnan(through_m)) return "";
  const Window w = WindowOf(cut, axes, through_m);
  Field is;
  const Field should = FieldOf(w, [&](int column, int row) {
    const dvec3 p = w.At(column, row);
    const Left left = LeftAt(cut, p, cut.tooth->DistanceAt_m(p));
    is.push_back(left.is);
    return left.should;
  });
  std::string sections[2] = {Element(w, should, "enamel"), Element(w, is, "enamel")};
  for (const Layer& layer : Layers()) {
    const Field tissue = TissueField(cut, w, layer.tissues);
    sections[0] += Element(w, Both(should, tissue, 1), layer.name);
    sections[1] += Element(w, Both(is, tissue, 1), layer.name);
  }
  sections[1] +=
      Element(w, Both(should, is, -1), "over") + Element(w, Both(is, should, -1), "left");
  sections[1] += Element(w, should, "should");
  const double unit = kStep_m / kUnit_m;
  const std::string width = std::to_string(std::lround(unit * w.columns)),
                    height = std::to_string(std::lround(unit * w.rows));
  std::string out;
  for (const std::string& section : sections) {
    out += "<svg viewBox=\"0 0 " + width + " " + height + "\" aria-hidden=\"true\">" + section +
           "<path class=\"scale\" d=\"M12 " + std::to_string(std::lround(unit * w.rows) - 12) +
           "h100\"/></svg>";
  }
  return out;
}

}  // namespace enamel::station::lab
