#include "common/cutting/bur.h"

#include <cmath>
#include <numbers>

#include "common/cutting/profile.h"
#include "common/math/trig.h"

namespace enamel::cutting {
namespace {

// Cuts a surface of revolution into bands, tip to shank, and places points of equal area on them.
// Turning each by the golden ratio against the one before spreads them evenly (Vogel, Mathematical
// Biosciences 44, 1979), and no two enter a wall or a layer at the same height.
class PointSpreader {
 public:
  // Points stand for `area` each; 0: only add up the area.
  PointSpreader(double area, std::vector<SurfacePoint>& out) : each_(area), out_(out) {}
  double area() const { return area_; }

  void Line(const double (&a)[2], const double (&b)[2], const double (&n)[2]) {
    // Half the sum of two radii times the length, times 2 pi: a cone's side.
    double dr = b[0] - a[0], dz = b[1] - a[1], length = std::sqrt(dr * dr + dz * dz);
    Band(std::numbers::pi * (a[0] + b[0]) * length, [&](double area) {
      // A cone's area to the share t of its length is 2 pi l (r_a t + dr t^2 / 2).
      // The root that does not cancel: good for a cylinder (dr = 0) as well.
      double y = area / (2 * std::numbers::pi * length), square = a[0] * a[0] + 2 * dr * y;
      double t = 2 * y / (a[0] + std::sqrt(square > 0 ? square : 0));
      Place(a[0] + dr * t, a[1] + dz * t, n[0], n[1]);
    });
  }
  // The part of an arc from normal a to b, halved until it is nearly straight.
  void Arc(const ProfilePiece& p, double a_r, double a_z, double b_r, double b_z) {
    double c_r = b_r - a_r, c_z = b_z - a_z, chord = std::sqrt(c_r * c_r + c_z * c_z);
    if (chord > 0.03) {
      double m_r = a_r + b_r, m_z = a_z + b_z, sum = std::sqrt(m_r * m_r + m_z * m_z);
      // Half a turn has no middle by addition: it is a quarter from either end.
      m_r = sum > 1e-9 ? m_r / sum : -a_z;
      m_z = sum > 1e-9 ? m_z / sum : a_r;
      Arc(p, a_r, a_z, m_r, m_z);
      Arc(p, m_r, m_z, b_r, b_z);
      return;
    }
    // Pappus and Guldin, 2 pi integral (r_c + R n_r) R d angle; angle = 2 asin(chord / 2), whose
    // next term is below 1e-15.
    double x = 0.5 * chord, x2 = x * x;
    double angle = chord * (1 + x2 * (1.0 / 6 + x2 * (3.0 / 40 + x2 * (15.0 / 336))));
    double whole = 2 * std::numbers::pi * p.radius * (p.at[0] * angle + p.radius * c_z);
    Band(whole, [&](double area) {
      double t = area / whole, n_r = a_r + c_r * t, n_z = a_z + c_z * t;
      double length = std::sqrt(n_r * n_r + n_z * n_z);
      n_r /= length, n_z /= length;
      Place(p.at[0] + p.radius * n_r, p.at[1] + p.radius * n_z, n_r, n_z);
    });
  }

 private:
  template <typename At>
  void Band(double area, At at) {
    for (; each_ > 0; ++placed_) {
      // Every point is in the middle of its share of the whole area, counted from the tip on; this
      // is how far into the band that middle is.
      double within = (static_cast<double>(placed_) + 0.5) * each_ - area_;
      if (!(within < area)) break;
      at(within > 0 ? within : 0);
    }
    area_ += area;
  }
  void Place(double r, double z, double n_r, double n_z) {
    double turns = static_cast<double>(placed_) * 0.61803398874989484820;
    SinCos t = SinCosOfTurns(turns - static_cast<double>(static_cast<int64_t>(turns)));
    out_.push_back({dvec3(r * t.cos, r * t.sin, z), dvec3(n_r * t.cos, n_r * t.sin, n_z), each_});
  }

  double each_;
  std::vector<SurfacePoint>& out_;
  double area_ = 0;
  int64_t placed_ = 0;
};

template <typename Walk>
std::vector<SurfacePoint> Spread(double spacing_m, size_t max_points, Walk walk) {
  std::vector<SurfacePoint> out;
  // Two walks: the first only measures, so that the second knows each point's share.
  PointSpreader measure(0, out);
  walk(measure);
  double wanted = measure.area() / (spacing_m * spacing_m) + 1,
         most = static_cast<double>(max_points);
  auto count = static_cast<size_t>(wanted < most ? wanted : most);
  out.reserve(count);
  PointSpreader place(measure.area() / static_cast<double>(count), out);
  walk(place);
  return out;
}

}  // namespace

double Bur::Distance(const dvec3& p) const noexcept {
  return ProfileOf(*this).Distance(std::sqrt(p.x * p.x + p.y * p.y), p.z);
}

std::optional<std::string_view> WhyImpossible(const Bur& bur) noexcept {
  const double r = bur.radius_m, s = bur.narrow_radius_m, l = bur.length_m;
  if (!(r > 0)) return "a radius above 0";
  if (bur.shape != BurShape::kSphere && !(l > 0)) return "a length above 0";
  switch (bur.shape) {
    case BurShape::kSphere:
    case BurShape::kCylinder:
      return std::nullopt;
    case BurShape::kCone:
      if (!(s >= 0 && s < r)) return "a cone's narrow radius from 0 to below its radius";
      return std::nullopt;
    case BurShape::kInvertedCone:
      if (!(s > 0 && s < r)) return "an inverted cone's narrow radius between 0 and its radius";
      return std::nullopt;
    case BurShape::kPear:
    case BurShape::kFlame:
      if (!(s > 0 && s < r)) return "a pear's or flame's narrow radius between 0 and its radius";
      // A pear's ball has to end below the narrow end, or the tangent cone (profile.cpp, Pear) does
      // not exist.
      if (!(l >= 2 * r)) return "a pear's or flame's length at least twice its radius";
      return std::nullopt;
    case BurShape::kWheel:
      // The rim's radius is half the length: at 2 its centre would be on the axis and the wheel a
      // ball.
      if (!(l <= 1.8 * r)) return "a wheel's length at most 1.8 times its radius";
      return std::nullopt;
  }
  return "a known shape";
}

std::vector<SurfacePoint> SampleSurface(const Bur& bur, double spacing_m, size_t max_points) {
  Profile profile = ProfileOf(bur);
  return Spread(spacing_m, max_points, [&](PointSpreader& spreader) {
    for (const ProfilePiece& p : profile.pieces()) {
      if (!p.arc)
        spreader.Line(p.at, p.to, p.first);
      else if (p.radius > 0)
        spreader.Arc(p, p.first[0], p.first[1], p.last[0], p.last[1]);
    }
  });
}

std::vector<SurfacePoint> SampleShank(const Bur& bur, double spacing_m, size_t max_points) {
  if (!(bur.shank_radius_m > 0)) return {};
  double r = bur.shank_radius_m, low = bur.height_m() + bur.neck_m;
  return Spread(spacing_m, max_points, [&](PointSpreader& spreader) {
    spreader.Line({0, low}, {r, low}, {0, -1});
    spreader.Line({r, low}, {r, low + kShankLength_m}, {1, 0});
  });
}

}  // namespace enamel::cutting
