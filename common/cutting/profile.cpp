#include "common/cutting/profile.h"

#include <cmath>

namespace enamel::cutting {
namespace {

// Lower than any distance in metres, and finite: it is multiplied and cast to float.
constexpr double kNoBorder = -1e30;

}  // namespace

// Walks along the outline, counter-clockwise: the body is on the left.
class ProfileBuilder {
 public:
  void Line(double r, double z) noexcept {
    double dr = r - at_[0], dz = z - at_[1], length = std::sqrt(dr * dr + dz * dz);
    if (length == 0) return;
    double n_r = dz / length, n_z = -dr / length;
    // A bend gets an arc of radius 0, so that the region beside two lines has its nearest point as
    // well.
    if (std::fabs(n_r - normal_[0]) + std::fabs(n_z - normal_[1]) > kSmooth) Corner(n_r, n_z);
    ProfilePiece& p = profile_.pieces_[profile_.count_++];
    p.first[0] = p.last[0] = normal_[0], p.first[1] = p.last[1] = normal_[1];
    p.at[0] = at_[0], p.at[1] = at_[1];
    p.to[0] = at_[0] = r, p.to[1] = at_[1] = z;
    Border(p, 0, p.at), Border(p, 1, p.to);
  }
  // About a centre, from where the walk is, until the normal is n.
  void Arc(double centre_r, double centre_z, double radius, double n_r, double n_z) noexcept {
    ProfilePiece& p = profile_.pieces_[profile_.count_++];
    p.arc = true;
    p.radius = radius;
    p.at[0] = centre_r, p.at[1] = centre_z;
    p.first[0] = normal_[0], p.first[1] = normal_[1];
    p.last[0] = normal_[0] = n_r, p.last[1] = normal_[1] = n_z;
    at_[0] = centre_r + radius * n_r, at_[1] = centre_z + radius * n_z;
    Border(p, 0, p.at), Border(p, 1, p.at);
  }
  void Corner(double n_r, double n_z) noexcept { Arc(at_[0], at_[1], 0, n_r, n_z); }
  const Profile& Done() const noexcept { return profile_; }

 private:
  static constexpr double kSmooth = 1e-9;  // a smaller change of normal is rounding

  static void Border(ProfilePiece& p, int end, const double (&through)[2]) noexcept {
    double* b = p.region[end];
    // The tangent in walking direction is the normal turned by a quarter; the last border looks
    // back.
    b[0] = end == 0 ? -p.first[1] : p.last[1];
    b[1] = end == 0 ? p.first[0] : -p.last[0];
    bool on_axis = through[0] == 0 && std::fabs(b[1]) < kSmooth;
    b[2] = on_axis ? kNoBorder : b[0] * through[0] + b[1] * through[1];
  }

  Profile profile_;
  double at_[2] = {0, 0};
  double normal_[2] = {0, -1};
};

namespace {

void Frustum(double tip_radius, double top_radius, double length, ProfileBuilder& b) noexcept {
  // A pointed cone's has no length and is left out; the corner before the next line is its point.
  b.Line(tip_radius, 0);
  b.Line(top_radius, length);
  b.Line(0, length);
}

// A ball at the tip and its tangent cone to the narrow end q = (s, l - R) from the ball's middle:
// the tangent's normal n solves n . q = R.
void Pear(double radius, double narrow, double length, ProfileBuilder& b) noexcept {
  double q_r = narrow, q_z = length - radius, d2 = q_r * q_r + q_z * q_z;
  // q . n = R splits n into R/|q| along q and w/|q| across it.
  double w = std::sqrt(d2 - radius * radius);
  b.Arc(0, radius, radius, (radius * q_r + w * q_z) / d2, (radius * q_z - w * q_r) / d2);
  b.Line(narrow, length);
  b.Line(0, length);
}

// One arc from the pointed tip (0, 0) over the belly (radius, z_m) to (narrow, length). Its centre
// (r_c, z_m) is as far from all three: r_c = (R^2 - z_m^2) / 2R and
// (s/R) z_m^2 - 2 l z_m + s^2 + l^2 - s R = 0, of which the smaller root is meant.
void Flame(double radius, double narrow, double length, ProfileBuilder& b) noexcept {
  double share = narrow / radius, c = narrow * narrow + length * length - narrow * radius;
  // The smaller root by its larger partner, so that nothing cancels.
  double belly = c / (length + std::sqrt(length * length - share * c));
  double centre = (radius * radius - belly * belly) / (2 * radius), big = radius - centre;
  b.Corner(-centre / big, -belly / big);
  b.Arc(centre, belly, big, (narrow - centre) / big, (length - belly) / big);
  b.Line(0, length);
}

void Wheel(double radius, double length, ProfileBuilder& b) noexcept {
  double rim = 0.5 * length, centre = radius - rim;
  b.Line(centre, 0);
  // Two quarters. The cull takes an arc's normals for positive sums of its outer two
  // (brick_kernel.inc), and half a turn's are not.
  b.Arc(centre, rim, rim, 1, 0);
  b.Arc(centre, rim, rim, 0, 1);
  b.Line(0, length);
}

}  // namespace

double Profile::Distance(double r, double z) const noexcept {
  double out = kNoBorder;
  for (const ProfilePiece& p : pieces()) {
    double dr = r - p.at[0], dz = z - p.at[1], d;
    if (!p.arc) {
      d = p.first[0] * dr + p.first[1] * dz;
    } else {
      if (p.region[0][0] * r + p.region[0][1] * z < p.region[0][2]) continue;
      if (p.region[1][0] * r + p.region[1][1] * z < p.region[1][2]) continue;
      d = std::sqrt(dr * dr + dz * dz) - p.radius;
    }
    out = d > out ? d : out;
  }
  return out;
}

Profile ProfileOf(const Bur& bur) noexcept {
  ProfileBuilder b;
  const double r = bur.radius_m, s = bur.narrow_radius_m, l = bur.length_m;
  switch (bur.shape) {
    case BurShape::kSphere:
      b.Arc(0, r, r, 0, 1);
      break;
    case BurShape::kCylinder:
      Frustum(r, r, l, b);
      break;
    case BurShape::kCone:
      Frustum(s, r, l, b);
      break;
    case BurShape::kInvertedCone:
      Frustum(r, s, l, b);
      break;
    case BurShape::kPear:
      Pear(r, s, l, b);
      break;
    case BurShape::kFlame:
      Flame(r, s, l, b);
      break;
    case BurShape::kWheel:
      Wheel(r, l, b);
      break;
  }
  return b.Done();
}

}  // namespace enamel::cutting
