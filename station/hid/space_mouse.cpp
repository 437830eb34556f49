#include "station/hid/space_mouse.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::hid {
namespace {

constexpr uint8_t kTranslationId = 1, kRotationId = 2, kButtonsId = 3;
// Of the deflection's 350. A hand resting on the cap must not move the bur, and the square keeps
// small motions slow; both values are our choice, space_mouse_test.cpp has the curve.
constexpr double kDeadZone = 10, kFullDeflection = 350;

void TakeAxes(ByteView bytes, size_t first, size_t count, SpaceMouseState& state) noexcept {
  ByteReader in(bytes);
  for (size_t i = 0; i < count; ++i) state.axes[first + i] = in.I16();
}

double Curve(int16_t deflection) noexcept {
  double size = std::fabs(static_cast<double>(deflection)) - kDeadZone;
  double share = std::clamp(size / (kFullDeflection - kDeadZone), 0.0, 1.0);
  return deflection < 0 ? -share * share : share * share;
}

}  // namespace

SpaceMouseReport TakeReport(ByteView report, SpaceMouseState& state) noexcept {
  if (report.empty()) return SpaceMouseReport::kTooShort;
  ByteView body = report.subspan(1);
  switch (report[0]) {
    case kTranslationId:
      if (body.size() < 6) return SpaceMouseReport::kTooShort;
      // Only this length distinguishes the two families.
      TakeAxes(body, 0, body.size() >= 12 ? 6 : 3, state);
      return SpaceMouseReport::kTaken;
    case kRotationId:
      if (body.size() < 6) return SpaceMouseReport::kTooShort;
      TakeAxes(body, 3, 3, state);
      return SpaceMouseReport::kTaken;
    case kButtonsId:
      if (body.empty()) return SpaceMouseReport::kTooShort;
      state.buttons = 0;
      for (size_t i = 0; i < std::min<size_t>(body.size(), 4); ++i) {
        state.buttons |= static_cast<uint32_t>(body[i]) << (8 * i);
      }
      return SpaceMouseReport::kTaken;
    default:
      return SpaceMouseReport::kIgnored;
  }
}

SpaceMouseMotion MotionOf(const SpaceMouseState& state,
                          const SpaceMouseSettings& settings) noexcept {
  const auto& a = state.axes;
  // Right, toward the user, down -> right, away, up: half a turn about x, for both.
  return {dvec3(Curve(a[0]), -Curve(a[1]), -Curve(a[2])) * settings.max_speed_m_per_s,
          dvec3(Curve(a[3]), -Curve(a[4]), -Curve(a[5])) * settings.max_turn_rad_per_s};
}

Result<std::unique_ptr<SpaceMouse>> SpaceMouse::Open(const SpaceMouseSettings& settings,
                                                     double resolution_m, double tick_s) {
  ENAMEL_ASSIGN_OR_RETURN(auto info, FindHid(settings.match));
  ENAMEL_ASSIGN_OR_RETURN(auto port, HidPort::Open(info.path));
  return std::unique_ptr<SpaceMouse>(new SpaceMouse(
      settings, info.name.empty() ? "6-DoF mouse" : info.name, resolution_m, tick_s));
}

SpaceMouse::SpaceMouse(const SpaceMouseSettings& settings, std::string name, double resolution_m,
                       double tick_s)
    : settings_(settings),
      name_(std::move(name)),
      resolution_m_(resolution_m),
      tick_s_(tick_s),
      reader_(settings.match, *this) {
  ENAMEL_CHECK(resolution_m > 0 && tick_s > 0);
}

void SpaceMouse::Publish(bool attached) { mailbox_.Write({state_, attached, ++published_}); }

void SpaceMouse::OnReport(ByteView report) {
  switch (TakeReport(report, state_)) {
    case SpaceMouseReport::kTaken:
      ++samples_;
      Publish(true);
      break;
    case SpaceMouseReport::kTooShort:
      ++refused_;
      break;
    case SpaceMouseReport::kIgnored:
      break;
  }
}

bool SpaceMouse::OnAttached(const HidInfo&) {
  state_ = {};
  Publish(true);
  return true;
}

void SpaceMouse::OnDetached() {
  ++detached_;
  state_ = {};
  Publish(false);
}

DeviceSample SpaceMouse::ReadSample() noexcept {
  const Message& newest = mailbox_.Read();
  silent_s_ = newest.number == seen_ ? silent_s_ + tick_s_ : 0;
  seen_ = newest.number;
  // After a longer silence it stops: a last deflection must not drive on for ever.
  if (silent_s_ <= kSilence_s) {
    SpaceMouseMotion motion = MotionOf(newest.state, settings_);
    at_m_ += motion.velocity_m_per_s * tick_s_;
    double length = std::sqrt(Dot(at_m_, at_m_));
    if (length > settings_.reach_m) at_m_ *= settings_.reach_m / length;
    dvec3 half = motion.turn_rad_per_s * (0.5 * tick_s_);
    // First order and made unit: at 1 rad/s and a tick of 1 ms the angle is good to 1e-10 rad.
    orientation_ = (Quat{half.x, half.y, half.z, 1} * orientation_).Normalised();
  }
  DeviceSample sample;
  for (int i = 0; i < 3; ++i) {
    sample.counts[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(at_m_[i] / resolution_m_));
  }
  sample.orientation = ToQuantised(orientation_);
  sample.attached = newest.attached;
  if (newest.attached && (newest.state.buttons & 1) != 0) {
    sample.buttons = kPedal;
    sample.bur_speed_krpm = kTurbineSpeed_krpm;
  }
  if (newest.attached && (newest.state.buttons & 2) != 0) sample.buttons |= kSecond;
  sample.sequence = static_cast<uint32_t>(newest.number);
  return sample;
}

DeviceCounters SpaceMouse::counters() const noexcept {
  DeviceCounters out;
  out.samples = samples_;
  out.refused = refused_;
  out.detached = detached_;
  return out;
}

}  // namespace enamel::station::hid
