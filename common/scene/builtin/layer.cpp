#include "common/scene/builtin/layer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"

namespace enamel::scene {
namespace {

constexpr double kLattice_m = kLatticeUm * 1e-6;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Heights over a lattice about the part's middle: from -half to +half along each axis.
class Heights {
 public:
  Heights(int half_x, int half_y)
      : half_x_(half_x),
        half_y_(half_y),
        z_m_(static_cast<size_t>((2 * half_x + 1) * (2 * half_y + 1))) {}

  template <typename F>
  static Heights Of(int half_x, int half_y, F&& at) {
    Heights out(half_x, half_y);
    for (int j = -half_y; j <= half_y; ++j)
      for (int i = -half_x; i <= half_x; ++i) out.z_m_[out.Index(i, j)] = at(i, j);
    return out;
  }
  bool Has(int i, int j) const { return std::abs(i) <= half_x_ && std::abs(j) <= half_y_; }
  double operator()(int i, int j) const { return z_m_[Index(i, j)]; }

 private:
  size_t Index(int i, int j) const {
    return static_cast<size_t>((j + half_y_) * (2 * half_x_ + 1) + i + half_x_);
  }
  int half_x_, half_y_;
  std::vector<double> z_m_;
};

// Lattice points of a disc, each with a height over it.
struct Offset {
  int i = 0, j = 0;
  double z_m = 0;
};
template <typename F>
std::vector<Offset> Disc(double radius_m, F&& height_m) {
  std::vector<Offset> out;
  const int reach = static_cast<int>(radius_m / kLattice_m);
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i) {
      const double d2 = (i * i + j * j) * kLattice_m * kLattice_m;
      if (d2 <= radius_m * radius_m) out.push_back({i, j, height_m(d2)});
    }
  return out;
}

int Steps(double half_m) { return static_cast<int>(std::ceil(half_m / kLattice_m - 1e-9)); }

}  // namespace

Relief ReliefOf(const Layer& layer, const PreparationPart& part, const PointUm& at,
                int32_t step_um) {
  ENAMEL_CHECK(step_um % kLatticeUm == 0 && part.depth_um > 0);
  const auto& half_um = part.outline == PreparationPart::Outline::kStump ? part.stump.foot.half_um
                                                                         : part.half_size_um;
  const double r = layer.end_radius_m, thick = layer.thick_m;
  const int axis_x = Steps(layer.axis_half_m[0]), axis_y = Steps(layer.axis_half_m[1]);
  const int end = Steps(r), around = end + Steps(thick);
  const double x_m = (at[0] + part.top_um[0]) * 1e-6, y_m = (at[1] + part.top_um[1]) * 1e-6;
  const auto surface = Heights::Of(axis_x + around, axis_y + around, [&](int i, int j) {
    return layer.surface_m(x_m + i * kLattice_m, y_m + j * kLattice_m);
  });
  // Rolled over the surface, a ball of the layer's thickness touches what stays.
  const auto ball =
      Disc(thick, [&](double d2) { return std::sqrt(std::max(0.0, thick * thick - d2)); });
  const auto stays = Heights::Of(axis_x + end, axis_y + end, [&](int i, int j) {
    double z = kInfinite;
    for (const Offset& o : ball) z = std::min(z, surface(i + o.i, j + o.j) - o.z_m);
    return z;
  });
  // How low the bur's end may go, and what it sweeps.
  const auto tool = Disc(r, [&](double d2) {
    return layer.round_end ? r - std::sqrt(std::max(0.0, r * r - d2)) : 0.0;
  });
  const auto tip = Heights::Of(axis_x, axis_y, [&](int i, int j) {
    if (layer.axis_may && !layer.axis_may(x_m + i * kLattice_m, y_m + j * kLattice_m)) {
      return kInfinite;
    }
    double z = -kInfinite;
    for (const Offset& o : tool) z = std::max(z, stays(i + o.i, j + o.j) - o.z_m);
    return z;
  });
  Relief out;
  out.step_um = step_um;
  const int every = step_um / kLatticeUm;
  std::array<int, 2> to{};
  for (size_t k = 0; k < 2; ++k) {
    to[k] = (half_um[k] + step_um - 1) / step_um;
    out.count[k] = 2 * to[k] + 1;
  }
  for (int j = -to[1]; j <= to[1]; ++j)
    for (int i = -to[0]; i <= to[0]; ++i) {
      double z = kInfinite;
      for (const Offset& o : tool) {
        const int ti = i * every - o.i, tj = j * every - o.j;
        if (tip.Has(ti, tj)) z = std::min(z, tip(ti, tj) + o.z_m);
      }
      const double below_um = at[2] + part.top_um[2] - std::min(z * 1e6, 1e9);
      const auto tens = static_cast<int32_t>(std::lround(std::max(0.0, below_um) / 10));
      out.below_um.push_back(std::min(10 * tens, part.depth_um));
    }
  return out;
}

}  // namespace enamel::scene
