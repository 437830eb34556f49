#include "station/devices/pointer_device.h"

#include <algorithm>
#include <cmath>

namespace enamel::station {
namespace {

constexpr double kMaxAdvance_s = 0.1;

bool Usable(const dvec3& v) {
  double square = Dot(v, v);
  return std::isfinite(square) && square > 0;
}

Quat Turn(const dvec3& axis, double angle_rad) {
  double s = std::sin(0.5 * angle_rad);
  return {axis.x * s, axis.y * s, axis.z * s, std::cos(0.5 * angle_rad)};
}

// The scene axis nearest to `v`, with its sign.
dvec3 NearestAxis(const dvec3& v) {
  int largest = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::fabs(v[i]) > std::fabs(v[largest])) largest = i;
  }
  dvec3 axis(0);
  axis[largest] = v[largest] < 0 ? -1 : 1;
  return axis;
}

dvec3 Toward(const dvec3& from, const dvec3& to, double share) noexcept {
  return from + (to - from) * share;
}

// The short way round; both are near each other.
Quat Toward(const Quat& from, const Quat& to, double share) noexcept {
  double dot = from.x * to.x + from.y * to.y + from.z * to.z + from.w * to.w;
  double sign = dot < 0 ? -share : share, rest = 1 - share;
  return Quat{from.x * rest + to.x * sign, from.y * rest + to.y * sign, from.z * rest + to.z * sign,
              from.w * rest + to.w * sign}
      .Normalised();
}

}  // namespace

PointerMapping::PointerMapping(const PointerSettings& settings)
    : settings_(settings), offset_m_(settings.start_m) {}

void PointerMapping::SetView(const dvec3& right, const dvec3& toward_viewer, double m_per_px) {
  if (!Usable(right) || !Usable(toward_viewer) || !(m_per_px > 0)) return;
  dvec3 toward = NearestAxis(toward_viewer);
  dvec3 in_plane = right - toward * Dot(right, toward);
  double length = std::sqrt(Dot(in_plane, in_plane));
  if (!(length > 0)) return;
  toward_ = toward;
  right_ = in_plane * (1 / length);
  up_ = glm::cross(toward_, right_);
  m_per_px_ = m_per_px;
}

void PointerMapping::MoveBy(double dx_px, double dy_px) {
  Shift((right_ * dx_px - up_ * dy_px) * m_per_px_);
}

void PointerMapping::Wheel(double notches) { Shift(toward_ * (-notches * settings_.wheel_step_m)); }

void PointerMapping::SetTilt(int right, int away) {
  tilt_right_ = std::clamp(right, -1, 1);
  tilt_away_ = std::clamp(away, -1, 1);
}

void PointerMapping::Advance(double dt_s) {
  if (!(dt_s > 0)) return;
  double turn =
      settings_.tilt_rad_per_s * std::min(dt_s, kMaxAdvance_s) * (fine_ ? settings_.fine_ratio : 1);
  double most = settings_.max_tilt_rad;
  lean_right_rad_ = std::clamp(lean_right_rad_ + turn * tilt_right_, -most, most);
  lean_away_rad_ = std::clamp(lean_away_rad_ + turn * tilt_away_, -most, most);
}

void PointerMapping::ReleaseKeys() {
  buttons_ = 0;
  tilt_right_ = tilt_away_ = 0;
  fine_ = false;
}

void PointerMapping::Recall() {
  if (buttons_ & kPedal) return;
  Straighten();
  offset_m_ = settings_.start_m;
}

PointerPose PointerMapping::pose() const {
  // The shank points along the bur's +z: leaning right is a turn about the direction away from the
  // viewer's upright, leaning away one about the screen's right. Seen from above, up_ is away.
  const dvec3 up_scene(0, 0, 1);
  dvec3 level_right = right_ - up_scene * Dot(right_, up_scene);
  double length = std::sqrt(Dot(level_right, level_right));
  level_right = length > 0 ? level_right * (1 / length) : dvec3(1, 0, 0);
  dvec3 level_away = glm::cross(up_scene, level_right);
  Quat lean = Turn(level_right, -lean_away_rad_) * Turn(level_away, lean_right_rad_);
  return {offset_m_, lean, buttons_};
}

void PointerMapping::SetButton(uint8_t button, bool down) {
  buttons_ = static_cast<uint8_t>(down ? buttons_ | button : buttons_ & ~button);
}

void PointerMapping::Shift(const dvec3& by_m) {
  dvec3 to = offset_m_ + by_m * (fine_ ? settings_.fine_ratio : 1);
  double length = std::sqrt(Dot(to, to));
  if (!std::isfinite(length)) return;
  offset_m_ = length > settings_.reach_m ? to * (settings_.reach_m / length) : to;
}

PointerDevice::PointerDevice(double resolution_m, double tick_s, const dvec3& start_m)
    : resolution_m_(resolution_m),
      tick_s_(tick_s),
      share_(tick_s / (kLag_s + tick_s)),
      first_m_(start_m),
      at_m_(start_m) {
  ENAMEL_CHECK(resolution_m > 0 && tick_s > 0);
  mailbox_.Write({{start_m, {}, 0}, 0});
}

void PointerDevice::Publish(const PointerPose& pose) noexcept {
  mailbox_.Write({pose, ++published_});
}

DeviceSample PointerDevice::ReadSample() noexcept {
  const Message& newest = mailbox_.Read();
  silent_s_ = newest.number == seen_ ? silent_s_ + tick_s_ : 0;
  seen_ = newest.number;
  first_m_ = Toward(first_m_, newest.pose.offset_m, share_);
  dvec3 step = (first_m_ - at_m_) * share_;
  double length = std::sqrt(Dot(step, step)), limit = kMaxSpeed_m_per_s * tick_s_;
  at_m_ += length > limit ? step * (limit / length) : step;
  first_ = Toward(first_, newest.pose.orientation, share_);
  orientation_ = Toward(orientation_, first_, share_);

  DeviceSample sample;
  for (int i = 0; i < 3; ++i) {
    sample.counts[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(at_m_[i] / resolution_m_));
  }
  sample.orientation = ToQuantised(orientation_);
  sample.buttons = newest.pose.buttons;
  if (silent_s_ > kSilence_s) sample.buttons &= static_cast<uint8_t>(~kPedal);
  if (sample.buttons & kPedal) sample.bur_speed_krpm = kTurbineSpeed_krpm;
  sample.sequence = static_cast<uint32_t>(newest.number);
  return sample;
}

}  // namespace enamel::station
