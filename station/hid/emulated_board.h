#pragma once

#include <functional>
#include <memory>

#include "common/board/board.h"
#include "common/scene/types.h"
#include "station/devices/device.h"
#include "station/hid/haptic_report.h"

namespace enamel::station::hid {

struct EmulatedBoardSettings {
  scene::DeviceProfile profile;  // b, c, cells, peak force
  int64_t kc_mn_per_mm = 0;      // of its spring
  uint32_t rate_hz = 1000;       // of its reports
  int inner_ticks = 8;           // of the spring in one of them
  int delay_ticks = 1;           // inner ones, from reading to force
  // Where the tip is at a time, m, scene axes.
  std::function<dvec3(double t_s)> hand;
};

// A board without hardware: the reference firmware (common/board) behind its reports as bytes, on axes
// that are the scene's. Its time is that of the samples read: each ReadSample is one report later.
// Thread safety: none. Real-time: not safe.
class EmulatedBoard final : public MotorDevice {
 public:
  // Errors: kInvalidInput, field "kc_mn_per_mm", when damping or friction do not pay for Kc at the inner
  // loop's T and d: with the largest Kc that would do.
  static Result<std::unique_ptr<EmulatedBoard>> Make(const EmulatedBoardSettings& settings);

  // What it answers to the feature request.
  FeatureReport feature() const;

  std::string Name() const override { return "emulated board"; }
  Hand hand() const override { return MakeHand(HandKind::kProgram, Name(), "hid", {}); }
  DeviceSample ReadSample() noexcept override;
  void SendForceAndTorque(const dvec3& force_n, const dvec3& torque_n_m) noexcept override;
  bool runs_spring() const noexcept override { return true; }
  void SendSpring(const SpringCommand& command) noexcept override;

  // False: reports to it are lost on the way.
  void Hear(bool heard) noexcept { heard_ = heard; }
  const dvec3& force_n() const noexcept { return force_n_; }

 private:
  explicit EmulatedBoard(const EmulatedBoardSettings& settings) : settings_(settings) {}
  std::array<int32_t, 3> CountsAt(double t_s) const;

  const EmulatedBoardSettings settings_;
  EnBoard board_{};
  uint64_t ticks_ = 0;
  uint32_t sequence_ = 0;
  bool heard_ = true;
  dvec3 force_n_{0};
};

}  // namespace enamel::station::hid
