#include "station/lab/laws/withdrawal.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/scene/builder.h"

namespace enamel::station::lab {
namespace {

using core::Core;
using core::CoreParams;
using cutting::Bur;
using cutting::BurShape;

constexpr double kTick_s = 1e-3;
constexpr double kFeed_m_per_s = 1e-3;

// The frame of bur and path, turned off the grid together.
struct Frame {
  Frame(double turn, double tilt)
      : orientation(ToQuantised(Quat{0, 0, std::sin(turn / 2), std::cos(turn / 2)} *
                                Quat{std::sin(tilt / 2), 0, 0, std::cos(tilt / 2)})),
        m(FromQuantised(orientation).Matrix()),
        tilt_sine(std::fabs(std::sin(tilt))) {}
  QuantisedOrientation orientation;
  dmat3 m;
  double tilt_sine;
};

// The hand's path for the tip; it returns along the last leg.
std::vector<dvec3> WayIn(Cut cut, const Bur& bur, const Frame& f) {
  const double h = bur.height_m(), r = bur.radius_m;
  const dvec3 x = f.m[0], y = f.m[1], z = f.m[2];
  const dvec3 above = z * (0.15e-3 + 1.2 * r * f.tilt_sine);
  const dvec3 off(13e-6, -9e-6, 3e-6);
  switch (cut) {
    case Cut::kSideMill: {
      // From outside the block's side, which is 1.5 mm away.
      double length = 1.5e-3 / std::fabs(x.x) + 1.3 * r + h * f.tilt_sine + 0.2e-3;
      return {off - z * (0.5 * h) - x * length, off - z * (0.5 * h)};
    }
    case Cut::kPlunge:
      return {off + above, off - z * (0.5 * h)};
    case Cut::kSunkToTop:
      return {off + above, off - z * h};
    case Cut::kPocket: {
      dvec3 low = off - z * (0.4 * h);
      return {off + above, low, low + y * (0.5 * r), low + y * (0.5 * r) + x * 0.9e-3};
    }
  }
  return {};
}

CoreParams ParamsOf(const Withdrawal& s) {
  auto nm = [](double m) { return static_cast<int32_t>(std::lround(m * 1e9)); };
  CoreParams p;
  p.law = s.law;
  p.kc_mn_per_mm = static_cast<int32_t>(std::lround(s.kc_n_per_m));
  p.resolution_nm = {nm(s.cell_m), nm(s.cell_m), nm(s.cell_m)};
  p.peak_force_mn = static_cast<int32_t>(std::lround(s.peak_force_n * 1e3));
  p.soft_start_ticks = 0;
  p.bur_shape = s.bur.shape;
  p.bur_radius_nm = nm(s.bur.radius_m);
  p.bur_length_nm = nm(s.bur.length_m);
  p.bur_narrow_radius_nm = nm(s.bur.narrow_radius_m);
  p.damping_mn_s_per_mm[1] = 6500;
  return p;
}

// The anchor's path in, from its end, by length.
class WayBack {
 public:
  explicit WayBack(const dvec3& tip) : points_{tip}, at_{0} {}
  void Add(const dvec3& p, bool last) {
    double step = glm::length(p - points_.back());
    // Points 20 um apart: the anchor's noise would lengthen the path.
    if (step < 20e-6 && !last) return;
    points_.push_back(p);
    at_.push_back(at_.back() + step);
  }
  double length() const { return at_.back(); }
  // `along` does not fall from call to call.
  dvec3 At(double along) {
    while (seg_ + 2 < points_.size() && at_[seg_ + 1] < along) ++seg_;
    double t = (along - at_[seg_]) / std::max(at_[seg_ + 1] - at_[seg_], 1e-12);
    return points_[seg_] + (points_[seg_ + 1] - points_[seg_]) * std::min(t, 1.0);
  }

 private:
  std::vector<dvec3> points_;
  std::vector<double> at_;
  size_t seg_ = 0;
};

class WithdrawalRun {
 public:
  WithdrawalRun(const Withdrawal& s, const cutting::Volume& block)
      : trial_(s), frame_(s.turned ? 0.4 : 0, s.turned ? 0.3 : 0), core_(ParamsOf(s), block) {
    input_.flags = core::kBurOn;
    input_.orientation = frame_.orientation;
  }

  WithdrawalFigures Run() {
    std::vector<dvec3> way = WayIn(trial_.cut, trial_.bur, frame_);
    StepTo(way[0]);
    for (size_t leg = 0; leg + 1 < way.size(); ++leg) {
      dvec3 d = way[leg + 1] - way[leg];
      // Free air is crossed quickly.
      int ticks = static_cast<int>(glm::length(d) / (kFeed_m_per_s * kTick_s)) + 1;
      anchors_.clear();
      for (int i = 1; i <= ticks; ++i) {
        StepTo(way[leg] + d * (static_cast<double>(i) / ticks));
        anchors_.push_back(out_.anchor.tip_m);
        figures_.deepest_n = std::max(figures_.deepest_n, glm::length(out_.force_sent_n));
      }
      // Until the anchor has passed the corner; before, the path back is not the path in.
      bool last = leg + 2 == way.size();
      for (int i = 0; !last && i < 300; ++i) StepTo(way[leg + 1]);
    }
    GoBack();
    return figures_;
  }

 private:
  void StepTo(const dvec3& tip) {
    for (int i = 0; i < 3; ++i) {
      input_.counts[static_cast<size_t>(i)] =
          static_cast<int32_t>(std::lround(tip[i] / trial_.cell_m));
    }
    out_ = core_.Step(input_);
    tip_ = tip;
  }

  void GoBack() {
    const dvec3 back = anchors_.front() - anchors_.back();
    const dvec3 along = back / glm::length(back);
    WayBack way(tip_);
    for (size_t i = anchors_.size(); i-- > 0;) way.Add(anchors_[i], i == 0);
    const double speed = trial_.speed_m_per_s;
    // A pocket's leg begins in a corner, where there is tissue ahead again.
    const double length = way.length() - (trial_.cut == Cut::kPocket ? 0.15e-3 : 0);
    const int ticks = static_cast<int>(length / (speed * kTick_s));
    dvec3 force = out_.force_sent_n, velocity(0), hand = tip_;
    double before = 0;
    for (int i = 1; i <= ticks; ++i) {
      dvec3 target = way.At(speed * kTick_s * i) + frame_.m[1] * trial_.beside_m;
      if (trial_.hand_n_per_m > 0) {
        // 0.25 kg, the device's 6 N s/m and a hand of 10 N s/m, in ten steps a tick.
        for (int k = 0; k < 10; ++k) {
          dvec3 f = force + (target - hand) * trial_.hand_n_per_m +
                    (along * speed - velocity) * 10.0 - velocity * 6.0;
          velocity += f * (kTick_s / 10 / 0.25);
          hand += velocity * (kTick_s / 10);
        }
        target = hand;
      }
      dvec3 was = tip_;
      StepTo(target);
      const double grown = glm::length(out_.force_sent_n) - glm::length(force);
      force = out_.force_sent_n;
      double opposing = std::max(0.0, -glm::dot(force, along));
      figures_.opposing_n = std::max(figures_.opposing_n, opposing);
      figures_.rise_n = std::max(figures_.rise_n, opposing - before);
      before = opposing;
      double allowed =
          trial_.kc_n_per_m * (glm::length(tip_ - was) + std::sqrt(3.0) * trial_.cell_m);
      figures_.other_n = std::max(figures_.other_n, grown - allowed);
    }
    figures_.out = glm::length(out_.anchor.tip_m - tip_) < 0.1e-3;
  }

  Withdrawal trial_;
  Frame frame_;
  Core core_;
  core::TickInput input_;
  core::TickOutput out_;
  dvec3 tip_{0};
  std::vector<dvec3> anchors_;  // of the last leg
  WithdrawalFigures figures_;
};

}  // namespace

const std::vector<NamedBur>& WithdrawalBurs() {
  static const std::vector<NamedBur> burs = {
      {"fissure", {BurShape::kCylinder, 0.6e-3, 2e-3}},
      {"flame", {BurShape::kFlame, 0.6e-3, 2e-3, 0.3e-3}},
      {"inverted", {BurShape::kInvertedCone, 0.6e-3, 1.2e-3, 0.4e-3}},
      {"pear", {BurShape::kPear, 0.6e-3, 2e-3, 0.35e-3}},
      {"round", {BurShape::kSphere, 0.8e-3, 0}},
      {"taper", {BurShape::kCone, 0.8e-3, 2e-3, 0.5e-3}},
      {"wheel", {BurShape::kWheel, 1.5e-3, 1.0e-3}}};
  return burs;
}

const char* CutName(Cut cut) {
  constexpr const char* kNames[] = {"side-mill", "plunge", "sunk", "pocket"};
  return kNames[static_cast<int>(cut)];
}

cutting::Volume WithdrawalBlock() {
  constexpr double kHalf_m = 1.5e-3, kDepth_m = 2.6e-3;
  auto field = [](const dvec3& p) {
    dvec3 q(glm::abs(p.x) - kHalf_m, glm::abs(p.y) - kHalf_m,
            glm::abs(p.z + kDepth_m / 2) - kDepth_m / 2);
    dvec3 out = glm::max(q, dvec3(0));
    double inside = std::min(std::max({q.x, q.y, q.z}), 0.0);
    return scene::FieldSample{glm::length(out) + inside, cutting::Tissue::kEnamel, 1.0};
  };
  return scene::BuildVolume(
      scene::GridAround({-kHalf_m, -kHalf_m, -kDepth_m}, {kHalf_m, kHalf_m, 0}, 50'000),
      scene::Field(field));
}

WithdrawalFigures RunWithdrawal(const Withdrawal& withdrawal, const cutting::Volume& block) {
  return WithdrawalRun(withdrawal, block).Run();
}

}  // namespace enamel::station::lab
