#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>

#include "station/devices/trouble.h"
#include "station/hid/hid_reader.h"
#include "station/hid/open_device.h"
#include "station/sdk/answering.h"
#include "station/sdk/buses.h"
#include "station/sdk/device_file.h"
#include "station/sdk/frames.h"

// WoodenHaptics and Polhem over HID: encoder counts in, motor currents out. The bytes and the arms'
// dimensions are those of WoodenHaptics/woody-experimental (mbed-code/WoodenHapticsHID) and
// forsslund/haptikfabrikenapi (haptikfabrikenapi.h, kinematics.cpp).
namespace enamel::station::sdk {
namespace {

constexpr uint16_t kMbedVendor = 0x1234, kMbedProduct = 0x0006;
constexpr const char* kMbedIds = "1234:0006";
// No hand moves the tip by a hundred counts, 5 mm, from one answer to the next.
constexpr int kFarCounts = 100;

struct Model {
  std::string_view driver, name, profile;
  size_t report_bytes;
  dvec3 length_m;               // La, Lb, Lc
  dvec3 gear;                   // a body's diameter over its capstan's
  dvec3 origin_m;               // the workspace's middle
  double torque_per_amp;        // k, N m/A
  double zero_c_rad;            // of body c where its counter is 0
  dvec3 current_sign;           // a motor's positive current to its body's torque
  dvec3 most_ma;                // more is not carried for longer than 4 s
  std::array<int16_t, 6> home;  // counters of an arm that is held at home
  const char* how_to_home;
};

constexpr double kRight = std::numbers::pi / 2;
constexpr double kCountsPerTurn = 2000, kGimbalCountsPerTurn = 1024;

constexpr Model kWoodenHaptics{"woodenhaptics",
                               "WoodenHaptics",
                               "woodenhaptics_v2015",
                               8,
                               {0.080, 0.205, 0.245},
                               {16, 12, 12},
                               {0.220, 0, 0.080},
                               0.0259,
                               kRight,
                               {1, -1, -1},
                               {2000, 2000, 2000},
                               {},
                               "hold its arm at the home pose while you switch it on"};
constexpr Model kPolhem{"polhem",
                        "Polhem",
                        "polhem_v1",
                        14,
                        {0.058, 0.174, 0.133},
                        {18, 10, 10},
                        {0.140, 0, 0.100},
                        0.0538,
                        0,
                        {-1, -1, -1},
                        {1000, 2000, 2000},
                        {0, 0, -5000, 0, 0, 0},
                        "hold its arm at the home pose and press its calibration button"};

Quat AboutX(double rad) { return {std::sin(rad / 2), 0, 0, std::cos(rad / 2)}; }
Quat AboutY(double rad) { return {0, std::sin(rad / 2), 0, std::cos(rad / 2)}; }
Quat AboutZ(double rad) { return {0, 0, std::sin(rad / 2), std::cos(rad / 2)}; }

int16_t Word(ByteView bytes, size_t i) {
  return static_cast<int16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
}

// What an arm's counters say, and what its motors take, in the arm's own frame.
class Arm {
 public:
  explicit Arm(const Model& model) : model_(model) {}

  // The counters are int16 and wrap: what counts is how far they moved. False: they restarted.
  bool Take(ByteView report) {
    std::array<int16_t, 3> now;
    bool far = false, zero = true;
    for (size_t i = 0; i < 3; ++i) {
      now[i] = Word(report, i);
      far = far || std::abs(last_[i]) > kFarCounts;
      zero = zero && now[i] == 0;
    }
    if (known_ && far && zero) return false;
    for (size_t i = 0; i < 3; ++i) {
      counts_[i] = known_ ? counts_[i] + static_cast<int16_t>(now[i] - last_[i]) : now[i];
    }
    known_ = true;
    last_ = now;
    if (model_.report_bytes == kPolhem.report_bytes) {
      for (size_t i = 0; i < 3; ++i) gimbal_[i] = Word(report, 3 + i);
      asks_for_home_ = Word(report, 6) == 1;
    }
    for (int i = 0; i < 3; ++i) {
      angle_[i] = -Turn(static_cast<double>(counts_[static_cast<size_t>(i)]), kCountsPerTurn) /
                  model_.gear[i];
    }
    angle_.z += model_.zero_c_rad;
    return true;
  }
  void Forget() { known_ = false; }
  bool asks_for_home() const { return asks_for_home_; }

  dvec3 Tip() const {
    const double out = Out();
    return dvec3(std::cos(angle_.x) * out, std::sin(angle_.x) * out,
                 model_.length_m.x + model_.length_m.y * std::cos(angle_.y) -
                     model_.length_m.z * std::cos(angle_.z)) -
           model_.origin_m;
  }
  // Of the tool; the identity where the arm has no encoders for it.
  Quat Turned() const {
    if (model_.report_bytes != kPolhem.report_bytes) return {};
    const auto gimbal = [&](size_t i, double sign) {
      return sign * Turn(gimbal_[i], kGimbalCountsPerTurn);
    };
    // Counter f turns the joint next to the arm.
    return AboutZ(angle_.x) * AboutY(kRight - angle_.z) * AboutX(gimbal(2, -1)) *
           AboutY(gimbal(1, 1)) * AboutX(gimbal(0, -1));
  }
  // The force by the transposed Jacobian of Tip, as currents. Beyond what a motor carries all three fall
  // by the same share, so that the push keeps its direction.
  std::array<int16_t, 3> Currents_ma(const dvec3& f) const {
    const double along = std::cos(angle_.x) * f.x + std::sin(angle_.x) * f.y;
    const dvec3 torque{Out() * (std::cos(angle_.x) * f.y - std::sin(angle_.x) * f.x),
                       model_.length_m.y * (std::cos(angle_.y) * along - std::sin(angle_.y) * f.z),
                       model_.length_m.z * (std::cos(angle_.z) * along + std::sin(angle_.z) * f.z)};
    dvec3 ma;
    double share = 1;
    for (int i = 0; i < 3; ++i) {
      ma[i] = model_.current_sign[i] * torque[i] / model_.gear[i] / model_.torque_per_amp * 1e3;
      if (std::abs(ma[i]) > model_.most_ma[i]) {
        share = std::min(share, model_.most_ma[i] / std::abs(ma[i]));
      }
    }
    std::array<int16_t, 3> out;
    for (size_t i = 0; i < 3; ++i) {
      out[i] = static_cast<int16_t>(std::lround(ma[static_cast<int>(i)] * share));
    }
    return out;
  }

 private:
  static double Turn(double counts, double per_turn) {
    return 2 * std::numbers::pi * counts / per_turn;
  }
  double Out() const {  // from the axis of body a
    return model_.length_m.y * std::sin(angle_.y) + model_.length_m.z * std::sin(angle_.z);
  }

  const Model& model_;
  bool known_ = false, asks_for_home_ = false;
  std::array<int16_t, 3> last_{}, gimbal_{};
  std::array<int64_t, 3> counts_{};
  dvec3 angle_{0};
};

class WoodenHaptics final : public AnsweringBus {
 public:
  WoodenHaptics(const Model& model, const BusChoice& choice, std::unique_ptr<Fd> claim,
                std::unique_ptr<hid::HidPort> port, std::string unit)
      : AnsweringBus(choice.peak_n, "plug it into this computer without a hub"),
        model_(model),
        reach_m_(choice.reach_m),
        unit_(std::move(unit)),
        claim_(std::move(claim)),
        port_(std::move(port)),
        arm_(model) {}

  std::string Name() const override { return std::string(model_.name); }
  std::string Driver() const override { return std::string(model_.driver); }
  std::string Unit() const override { return unit_; }
  bool counts_from_power_up() const override { return true; }
  bool is_calibrated_anew() const override { return is_calibrated_anew_; }

 private:
  Got Await(std::chrono::microseconds patience) override {
    const auto patience_ms = std::chrono::ceil<std::chrono::milliseconds>(patience);
    const int got = port_->Read(report_, static_cast<int>(patience_ms.count()));
    report_bytes_ = static_cast<size_t>(std::max(got, 0));
    return got < 0 ? Got::kClosed : got == 0 ? Got::kNothing : Got::kAnswer;
  }
  Heard Understand(Pose& out) override {
    if (report_bytes_ != model_.report_bytes) return Heard::kRefused;
    if (!arm_.Take(ByteView(report_.data(), report_bytes_))) return Heard::kGone;
    out.tip_m = FromUserward(arm_.Tip());
    const Quat q = arm_.Turned();
    const dvec3 axis = FromUserward({q.x, q.y, q.z});
    out.orientation = {axis.x, axis.y, axis.z, q.w};
    return Heard::kPose;
  }
  // An arm whose button was pressed before the session gets its counters.
  bool Ask(const dvec3& force_n) override {
    if (!is_ready_ && arm_.asks_for_home()) {
      is_calibrated_anew_ = true;
      return SendHome();
    }
    const auto ma = arm_.Currents_ma(ToUserward(force_n));
    return Write({ma[0], ma[1], ma[2], 0, 0, 0, 0});
  }
  Result<bool> IsReady(Heard heard, const Pose& pose) override {
    if (heard == Heard::kRefused) return OtherReports();
    if (arm_.asks_for_home()) return false;
    ENAMEL_RETURN_IF_ERROR(CheckHome(Name(), pose.tip_m, reach_m_, model_.how_to_home));
    is_ready_ = true;
    return true;
  }
  // Seven words; the arm with the shorter report takes the first four.
  bool Write(const std::array<int16_t, 7>& words) {
    Bytes report(1 + model_.report_bytes);  // a leading 0: its reports have no ids
    for (size_t i = 0; i < model_.report_bytes / 2; ++i) {
      const auto word = static_cast<uint16_t>(words[i]);
      report[1 + 2 * i] = static_cast<uint8_t>(word & 0xFF);
      report[2 + 2 * i] = static_cast<uint8_t>(word >> 8);
    }
    return port_->Write(report);
  }
  bool SendHome() {
    const auto& h = model_.home;
    arm_.Forget();
    return Write({h[3], h[4], h[5], 1, h[0], h[1], h[2]});
  }
  Status OtherReports() const {
    return Status(Code::kConflict,
                  kMbedIds + std::string(" sends reports of ") + std::to_string(report_bytes_) +
                      " bytes, expected " + std::to_string(model_.report_bytes) + " from " +
                      Name() + ": choose woodenhaptics for 8 bytes, polhem for 14",
                  trouble::kModel);
  }

  const Model& model_;
  const double reach_m_;
  const std::string unit_;
  const std::unique_ptr<Fd> claim_;
  const std::unique_ptr<hid::HidPort> port_;
  Arm arm_;
  std::array<uint8_t, 64> report_{};
  size_t report_bytes_ = 0;
  bool is_ready_ = false, is_calibrated_anew_ = false;
};

std::string UnitOf(const Model& model, const hid::HidInfo& info) {
  const std::string place = UsbPlace(info.path);
  return place.empty() ? place : std::string(model.driver) + ":usb:" + place;
}

Result<std::unique_ptr<PolledBus>> Open(const Model& model, const BusChoice& choice) {
  hid::HidMatch match;
  if (!choice.address.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(match, hid::ParseHidMatch(choice.address));
  } else {
    match.vendor = kMbedVendor;
    match.product = kMbedProduct;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto info, hid::FindHid(match));
  ENAMEL_ASSIGN_OR_RETURN(auto claim, OpenAlone(info.path));
  ENAMEL_ASSIGN_OR_RETURN(auto port, hid::HidPort::Open(info.path));
  auto bus = std::make_unique<WoodenHaptics>(model, choice, std::move(claim), std::move(port),
                                             UnitOf(model, info));
  ENAMEL_RETURN_IF_ERROR(bus->Open());
  return std::unique_ptr<PolledBus>(std::move(bus));
}

std::vector<SdkDevice> Find(const Model& model) {
  std::vector<SdkDevice> out;
  for (const hid::HidInfo& info : hid::ListHid()) {
    if (info.vendor != kMbedVendor || info.product != kMbedProduct) continue;
    out.push_back({"", std::string(model.name), std::string(model.profile), kMbedIds,
                   UnitOf(model, info), OpenAlone(info.path).status()});
  }
  return out;
}

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenWoodenHaptics(const BusChoice& choice) {
  return Open(kWoodenHaptics, choice);
}
std::vector<SdkDevice> FindWoodenHaptics() { return Find(kWoodenHaptics); }
Result<std::unique_ptr<PolledBus>> OpenPolhem(const BusChoice& choice) {
  return Open(kPolhem, choice);
}
std::vector<SdkDevice> FindPolhem() { return Find(kPolhem); }

}  // namespace enamel::station::sdk
