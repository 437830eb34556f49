#include "station/lab/cutting/swept_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/cutting/engagement.h"

namespace enamel::station::lab {
namespace {

constexpr int kSteps = 4000;

// Radius of the body at a height above its tip, by bisection, since a profile provides only its
// distance. 0 where there is no body.
double RadiusAt(const cutting::Profile& profile, double height_m, double beyond_m) {
  double in = 0, out = beyond_m;
  if (profile.Distance(0, height_m) >= 0) return 0;
  // 2^-60 of the interval: as accurate as a double.
  for (int i = 0; i < 60; ++i) {
    double middle = 0.5 * (in + out);
    (profile.Distance(middle, height_m) < 0 ? in : out) = middle;
  }
  return in;
}

// A table over heights, between its entries by a straight line, after the last by that.
double At(const std::vector<double>& table, double step_m, double height_m) {
  double at = std::clamp(height_m / step_m, 0.0, static_cast<double>(table.size() - 1));
  auto i = std::min(static_cast<size_t>(at), table.size() - 2);
  return table[i] + (table[i + 1] - table[i]) * (at - static_cast<double>(i));
}

// Walks the outline below a height: f(r, n_r, n_z, ds).
template <class F>
void AlongOutline(const cutting::Profile& profile, double below_m, const F& f) {
  for (const cutting::ProfilePiece& q : profile.pieces()) {
    double from = std::atan2(q.first[1], q.first[0]), to = std::atan2(q.last[1], q.last[0]);
    double along[2]{q.to[0] - q.at[0], q.to[1] - q.at[1]};
    double length = q.arc ? q.radius * (to - from) : std::hypot(along[0], along[1]);
    for (int i = 0; i < kSteps; ++i) {
      double share = (i + 0.5) / kSteps, angle = from + (to - from) * share;
      double n[2]{q.arc ? std::cos(angle) : q.first[0], q.arc ? std::sin(angle) : q.first[1]};
      double r = q.at[0] + (q.arc ? q.radius * n[0] : along[0] * share);
      double z = q.at[1] + (q.arc ? q.radius * n[1] : along[1] * share);
      if (z < below_m) f(r, n[0], n[1], length / kSteps);
    }
  }
}

}  // namespace

SweptBody::SweptBody(const CutPath& path, std::vector<dvec3> tips_m)
    : plunge_(path.plunge),
      speed_m_s_(path.speed_m_s),
      // 1 mN s/mm = 1 N s/m.
      beta_(path.params.damping_mn_s_per_mm[static_cast<size_t>(cutting::Tissue::kGypsum)] /
            cutting::EngagementReader::kReferenceArea_m2),
      bur_(path.bur),
      profile_(cutting::ProfileOf(bur_)),
      tips_m_(std::move(tips_m)) {
  step_m_ = bur_.height_m() / kSteps;
  double half_area = 0, hole = 0, largest = 0;
  half_area_m2_ = hole_m3_ = {0};
  for (int i = 0; i < kSteps; ++i) {
    double r = RadiusAt(profile_, (i + 0.5) * step_m_, 4 * bur_.radius_m);
    largest = std::max(largest, r);
    half_area_m2_.push_back(half_area += r * step_m_);
    hole_m3_.push_back(hole += std::numbers::pi * largest * largest * step_m_);
  }
}

double SweptBody::Volume_m3() const {
  const dvec3& end = tips_m_.back();
  const double depth = -end.z, height = bur_.height_m();
  if (plunge_) {
    // Above the cutting part the hole is as wide as the bur was anywhere.
    double above = std::max(0.0, depth - height);
    return At(hole_m3_, step_m_, depth) + std::numbers::pi * bur_.radius_m * bur_.radius_m * above;
  }
  double volume = 0;
  for (size_t i = 1; i < tips_m_.size(); ++i) {
    const dvec3 &a = tips_m_[i - 1], &b = tips_m_[i];
    double way = std::max(b.x, 0.0) - std::max(a.x, 0.0);
    volume += 2 * At(half_area_m2_, step_m_, -0.5 * (a.z + b.z)) * way;
  }
  // And the front's half of the body.
  for (int i = 0; i < kSteps && (i + 0.5) * step_m_ < depth; ++i) {
    double r = (half_area_m2_[static_cast<size_t>(i) + 1] - half_area_m2_[static_cast<size_t>(i)]) /
               step_m_;
    volume += 0.5 * std::numbers::pi * r * r * step_m_;
  }
  return volume;
}

double SweptBody::Distance_m(const dvec3& p) const {
  if (plunge_) {
    const dvec3& end = tips_m_.back();
    const double r = std::hypot(p.x - end.x, p.y - end.y), z = p.z - end.z;
    // The nearest place on the way: the distance is convex in it.
    double low = 0, high = std::max(0.0, -end.z);
    for (int i = 0; i < 60; ++i) {
      double a = low + (high - low) / 3, b = high - (high - low) / 3;
      if (profile_.Distance(r, z - a) < profile_.Distance(r, z - b)) {
        high = b;
      } else {
        low = a;
      }
    }
    return profile_.Distance(r, z - low);
  }
  // The nearest place is the one beside the point. Ticks are a few micrometres apart.
  auto after = std::lower_bound(tips_m_.begin(), tips_m_.end(), p.x,
                                [](const dvec3& tip, double x) { return tip.x < x; });
  dvec3 tip = after == tips_m_.end() ? tips_m_.back() : *after;
  if (after != tips_m_.end() && after != tips_m_.begin()) {
    const dvec3& before = *(after - 1);
    tip = before + (tip - before) * ((p.x - before.x) / (tip.x - before.x));
  }
  dvec3 q = p - tip;
  return profile_.Distance(std::hypot(q.x, q.y), q.z);
}

dvec3 SweptBody::Force_n() const {
  double along = 0, up = 0;
  AlongOutline(profile_, -tips_m_.back().z, [&](double r, double n_r, double n_z, double ds) {
    if (plunge_) {
      if (n_z < 0) along += 2 * std::numbers::pi * r * n_z * n_z * ds;
      return;
    }
    // Over the half circle that faces the way: of cos^2 pi / 2, of cos 2.
    along += 0.5 * std::numbers::pi * r * n_r * n_r * ds;
    up += 2 * r * n_r * n_z * ds;
  });
  const double b = beta_ * speed_m_s_;
  return plunge_ ? dvec3(0, 0, b * along) : dvec3(-b * along, 0, -b * up);
}

}  // namespace enamel::station::lab
