#include "common/import/likeness.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/import/tooth_size.h"
#include "common/mesh/registration.h"
#include "common/mesh/triangle_tree.h"
#include "common/mesh/units.h"
#include "common/scene/builtin/teeth.h"

namespace enamel::import {
namespace {

constexpr double kStep_mm = 0.5, kMargin_mm = 1.5;
constexpr size_t kFewPoints = 120, kManyPoints = 400;
constexpr size_t kRefined = 30;
constexpr double kSaturated_mm = 1.0;  // farther apart is not alike
constexpr double kOtherUp = 0.77;      // 40 degrees
// A crown's width is within 20 % of the mean for two standard deviations; its height depends on the
// gum's place too.
constexpr double kSideWeight = 0.5, kHeightWeight = 0.1;

// Distances on a regular grid; beyond it the edge's and the way there.
class Grid {
 public:
  Grid(const dvec3& lo, const dvec3& hi) : lo_(lo - kMargin_mm) {
    size_ = ivec3(glm::ceil((hi + kMargin_mm - lo_) / kStep_mm)) + 1;
    values_.resize(static_cast<size_t>(size_.x * size_.y * size_.z));
  }
  template <typename Distance>
  void Fill(Distance distance) {
    size_t i = 0;
    for (int z = 0; z < size_.z; ++z)
      for (int y = 0; y < size_.y; ++y)
        for (int x = 0; x < size_.x; ++x)
          values_[i++] = static_cast<float>(distance(lo_ + kStep_mm * dvec3(x, y, z)));
  }
  double At(const dvec3& p) const {
    const dvec3 sample = (p - lo_) / kStep_mm;
    const dvec3 near = glm::clamp(sample, dvec3(0), dvec3(size_ - 2) + 0.999);
    const double beyond = glm::length(sample - near) * kStep_mm;
    const ivec3 cell(near);
    const dvec3 f = near - dvec3(cell);
    auto v = [&](int x, int y, int z) -> double {
      return values_[static_cast<size_t>(((cell.z + z) * size_.y + cell.y + y) * size_.x + cell.x +
                                         x)];
    };
    auto row = [&](int y, int z) { return v(0, y, z) + (v(1, y, z) - v(0, y, z)) * f.x; };
    const double a = row(0, 0) + (row(1, 0) - row(0, 0)) * f.y;
    const double b = row(0, 1) + (row(1, 1) - row(0, 1)) * f.y;
    return a + (b - a) * f.z + beyond;
  }
  // Points where the distance is 0, at most some of them.
  std::vector<dvec3> Surface(size_t count) const {
    std::vector<dvec3> all;
    size_t i = 0;
    const std::array<size_t, 3> next = {1, static_cast<size_t>(size_.x),
                                        static_cast<size_t>(size_.x * size_.y)};
    for (int z = 0; z < size_.z; ++z)
      for (int y = 0; y < size_.y; ++y)
        for (int x = 0; x < size_.x; ++x, ++i) {
          const ivec3 at(x, y, z);
          for (int k = 0; k < 3; ++k) {
            if (at[k] + 1 >= size_[k]) continue;
            const double a = values_[i], b = values_[i + next[static_cast<size_t>(k)]];
            if ((a < 0) == (b < 0)) continue;
            dvec3 p = dvec3(at);
            p[k] += a / (a - b);
            all.push_back(lo_ + kStep_mm * p);
          }
        }
    std::vector<dvec3> out;
    for (size_t k = 0; k < std::min(count, all.size()); ++k)
      out.push_back(all[k * all.size() / std::min(count, all.size())]);
    return out;
  }

 private:
  dvec3 lo_;
  ivec3 size_{0};
  std::vector<float> values_;  // (z, y, x), x fastest
};

// A change of our tooth: the share of the crown's height that is worn off, and the share of half its width that is taken
// away all around, above the shoulder.
struct Change {
  double worn, reduced;
};
constexpr std::array<Change, 3> kChanges = {{{0, 0}, {0.15, 0}, {0, 0.2}}};
constexpr double kShoulder = 0.35;

struct Model {
  Grid grid;
  std::vector<dvec3> points;
  dvec3 middle, size;  // of its box
};

scene::ToothShape ShapeOf(int tooth) {
  const int place = tooth % 10;
  const bool primary = tooth > 50, upper = (tooth / 10) % 4 == 1 || (tooth / 10) % 4 == 2;
  scene::ToothShape shape = place <= 3               ? scene::UpperCentralIncisor()
                            : place <= 5 && !primary ? scene::UpperFirstPremolar()
                                                     : scene::LowerFirstMolar();
  shape.fdi = tooth;
  if (place == 3) {
    // One cusp, and thicker than an incisor.
    shape.ridges.clear();
    shape.cusps = {{0.3, 0.2, 5.3, 0.75}};
    shape.sections.buccal = {2.4, 3.0, 3.5, 3.9, 3.6, 3.1, 2.5, 1.9, 1.2};
    shape.sections.lingual = {2.4, 3.0, 3.5, 3.7, 3.2, 2.5, 1.9, 1.5, 1.0};
  }
  if (upper && place >= 6) {
    shape.cusps = {{2.4, 2.9, 3.6, 0.86},
                   {-2.0, 2.8, 3.3, 0.86},
                   {2.0, -2.5, 4.0, 0.84},
                   {-2.6, -2.9, 2.9, 0.88}};
  }
  return shape;
}

// Our tooth of the number, stretched to the mean size: whole, and with the lowest part of its crown
// missing (as below a gum), each with sharp cusps or edge and worn ones, and reduced for a crown.
std::vector<Model> ModelsOf(int tooth) {
  const scene::ToothShape shape = ShapeOf(tooth);
  const ToothSize& mean = MeanSize(tooth);
  double top = -1e300;
  dvec3 half(0);
  for (double z = shape.cervical_z; z < shape.hi.z; z += 0.25) {
    const auto section = scene::SectionAt_mm(shape, z);
    half.x = std::max(half.x, 0.5 * (section[0] + section[1]));
    half.y = std::max(half.y, 0.5 * (section[2] + section[3]));
  }
  for (double x = -half.x; x <= half.x; x += 0.25)
    for (double y = -half.y; y <= half.y; y += 0.25) {
      if (const auto p = scene::SurfaceBelow_m(shape, x, y)) top = std::max(top, p->z * 1e3);
    }
  const double height = top - shape.cervical_z;
  const dvec3 stretch(mean.mesiodistal_mm / (2 * half.x), mean.buccolingual_mm / (2 * half.y),
                      mean.height_mm / height);
  const double scale = std::cbrt(stretch.x * stretch.y * stretch.z);
  const dvec3 lo = dvec3(-half.x, -half.y, shape.cervical_z) * stretch - 0.8,
              hi = dvec3(half.x, half.y, top) * stretch + 0.8;
  Grid whole(lo, hi);
  whole.Fill([&](const dvec3& p) {
    return 1e3 * scale * scene::ToothField(shape, p / stretch * 1e-3).distance_m;
  });
  std::vector<Model> out;
  for (double missing : {0.0, 0.3}) {
    for (const Change& change : kChanges) {
      const double bottom = (shape.cervical_z + missing * height) * stretch.z,
                   flat = (top - change.worn * height) * stretch.z,
                   shoulder = (shape.cervical_z + kShoulder * height) * stretch.z;
      Grid grid(lo, hi);
      grid.Fill([&](const dvec3& p) {
        const double reduced =
            change.reduced * half.x * stretch.x * std::clamp((p.z - shoulder) / 0.5, 0.0, 1.0);
        return std::max({whole.At(p) + reduced, bottom - p.z, p.z - flat});
      });
      Model model{grid, grid.Surface(kManyPoints), dvec3(0), dvec3(0)};
      dvec3 low(1e300), high(-1e300);
      for (const dvec3& p : model.points) low = glm::min(low, p), high = glm::max(high, p);
      model.middle = 0.5 * (low + high), model.size = high - low;
      out.push_back(std::move(model));
    }
  }
  return out;
}

class Comparison {
 public:
  Comparison(const mesh::Triangles& whole, const mesh::Triangles& own)
      : box_(mesh::BoxOf(whole)), grid_(box_.lo, box_.hi) {
    const mesh::TriangleTree tree(whole);
    mesh::SignedProbe probe(tree, tree);
    grid_.Fill([&](const dvec3& p) { return probe.Distance(p, 4); });
    for (const auto& p : mesh::SpreadOver(own, kManyPoints)) points_.push_back(p.at);
    for (const auto& p : mesh::SpreadOver(whole, kManyPoints)) outline_.push_back(p.at);
  }

  double Cost(const Model& model, const dmat3& turn, bool many) const {
    dvec3 low(1e300), high(-1e300);
    for (const dvec3& p : outline_) {
      const dvec3 q = turn * p;
      low = glm::min(low, q), high = glm::max(high, q);
    }
    const dvec3 stretch = model.size / (high - low), middle = 0.5 * (low + high);
    const dvec3 size(std::log(stretch.x), std::log(stretch.y), std::log(stretch.z));
    // The scale as a whole is cheap: people differ in size by it.
    const double all = (size.x + size.y + size.z) / 3;
    const dvec3 own = size - 0.5 * all;
    const double misfit =
        kSideWeight * (own.x * own.x + own.y * own.y) + kHeightWeight * own.z * own.z;
    const size_t step = many ? 1 : kManyPoints / kFewPoints;
    double there = 0, back = 0, n = 0, m = 0;
    for (size_t i = 0; i < points_.size(); i += step, ++n)
      there += Part(model.grid.At(stretch * (turn * points_[i] - middle) + model.middle));
    const dmat3 inverse = glm::transpose(turn);
    const double scale = std::exp(all);
    for (size_t i = 0; i < model.points.size(); i += step, ++m)
      back +=
          Part(scale * grid_.At(inverse * ((model.points[i] - model.middle) / stretch + middle)));
    return there / n + back / m + misfit;
  }

 private:
  static double Part(double d) {
    const double q = d / kSaturated_mm;
    return std::min(q * q, 1.0);
  }
  mesh::Box box_;
  Grid grid_;
  std::vector<dvec3> points_, outline_;
};

dmat3 TurnAbout(int axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  dmat3 out(1.0);
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  out[a][a] = c, out[b][b] = c, out[a][b] = s, out[b][a] = -s;
  return out;
}

// Turned a little as long as that helps.
void Improve(const Comparison& comparison, const Model& model, Likeness& best) {
  for (double angle = 0.2; angle > 0.02; angle /= 2) {
    for (int tries = 0; tries < 4; ++tries) {
      bool better = false;
      for (int axis = 0; axis < 3; ++axis)
        for (double sign : {-1.0, 1.0}) {
          const dmat3 turn = TurnAbout(axis, sign * angle) * best.scene_from_file;
          const double cost = comparison.Cost(model, turn, true);
          if (cost >= best.cost) continue;
          best = {turn, cost};
          better = true;
        }
      if (!better) break;
    }
  }
}

}  // namespace

std::vector<Likeness> LikeOwnTooth(const mesh::Triangles& whole, const mesh::Triangles& own,
                                   int tooth) {
  const std::vector<Model> models = ModelsOf(tooth);
  const Comparison comparison(whole, own);
  struct Candidate {
    Likeness likeness;
    const Model* model;
  };
  std::vector<Candidate> all;
  for (size_t i = 0; i < mesh::kSpiralTurns; ++i) {
    const dmat3 turn = mesh::SpiralTurn(i);
    for (const Model& model : models)
      all.push_back({{turn, comparison.Cost(model, turn, false)}, &model});
  }
  auto better = [](const Candidate& l, const Candidate& r) {
    return l.likeness.cost < r.likeness.cost;
  };
  std::stable_sort(all.begin(), all.end(), better);
  // The best in each of some directions, so that each is heard.
  std::vector<Candidate> kept;
  for (const Candidate& c : all) {
    size_t near = 0;
    for (const Candidate& k : kept) near += Dot(k.likeness.up(), c.likeness.up()) > kOtherUp;
    if (near < 4) kept.push_back(c);
    if (kept.size() == kRefined) break;
  }
  for (Candidate& c : kept) {
    c.likeness.cost = comparison.Cost(*c.model, c.likeness.scene_from_file, true);
    Improve(comparison, *c.model, c.likeness);
  }
  std::stable_sort(kept.begin(), kept.end(), better);
  std::vector<Likeness> out;
  for (const Candidate& c : kept) {
    const bool known = std::any_of(out.begin(), out.end(), [&](const Likeness& l) {
      return Dot(l.up(), c.likeness.up()) > kOtherUp;
    });
    if (!known) out.push_back(c.likeness);
  }
  return out;
}

}  // namespace enamel::import
