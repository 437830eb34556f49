#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <numbers>
#include <string>
#include <thread>

#include "common/base/bytes.h"
#include "common/base/fd.h"
#include "common/math/vec.h"
#include "station/lab/devices/emulated_arm.h"
#include "tests/support/temp_folder.h"

// Devices of published protocols, as bytes on the transport that the driver opens. Thread safety: all of
// it.
namespace enamel::station::testing_support {

using lab::EmulatedArm;

// Dimensions of WoodenHaptics or Polhem, from their published list; worked out here apart from the
// driver.
struct ArmDrawing {
  bool polhem;
  double a, b, c;              // bodies, m
  std::array<double, 3> gear;  // body over capstan
  dvec3 origin;                // m
  double k;                    // N m/A
  std::array<double, 3> sign;  // of the currents
  double zero_c;               // rad
};
inline const ArmDrawing kArmDrawings[] = {
    {false,
     0.080,
     0.205,
     0.245,
     {16, 12, 12},
     {0.220, 0, 0.080},
     0.0259,
     {1, -1, -1},
     std::numbers::pi / 2},
    {true, 0.058, 0.174, 0.133, {18, 10, 10}, {0.140, 0, 0.100}, 0.0538, {-1, -1, -1}, 0}};
// From the device's centre, scene axes, m. `counters`: encoders a to f.
dvec3 TipOf(const ArmDrawing& drawing, const std::array<int, 6>& counters);

// WoodenHaptics (8-byte reports) or Polhem (14) on the HID port's double.
class EmulatedHidArm final : public EmulatedArm {
 public:
  explicit EmulatedHidArm(bool polhem);
  ~EmulatedHidArm() override;
  std::string choice() const override { return polhem_ ? "polhem" : "woodenhaptics"; }
  const char* profile() const override { return polhem_ ? "polhem_v1" : "woodenhaptics_v2015"; }
  void Lower(int steps) override;
  size_t answer_bytes() const override { return polhem_ ? 14 : 8; }
  void Unplug() override;
  void Plug() override;

  // Encoders a to f.
  void Set(const std::array<int, 6>& counters);
  std::array<int, 6> counters() const;
  // The calibration button is down at the home pose; once calibrated the arm is moved to its start.
  void PressCalibration();
  bool calibrated_to_home() const { return homed_; }
  const std::string& path() const { return path_; }

 private:
  void Run();
  Bytes Answer(ByteView report);

  const bool polhem_;
  const std::string path_;
  std::array<int, 6> counters_;
  int info_ = 0;
  std::atomic<bool> homed_{false};
  // What the firmware has not read yet.
  std::mutex inbox_mutex_;
  std::condition_variable written_;
  std::deque<Bytes> inbox_;
  bool stop_ = false;
  std::thread thread_;
};

// Polhem v3 on a pseudo terminal, which a link in a folder of its own names.
class EmulatedSerialArm final : public EmulatedArm {
 public:
  EmulatedSerialArm();
  ~EmulatedSerialArm() override;
  std::string choice() const override { return "polhem_serial:" + link(); }
  const char* profile() const override { return "polhem_v3"; }
  void Lower(int steps) override;
  size_t answer_bytes() const override { return 64; }
  void Unplug() override;
  void Plug() override;

  // Tip, mm, and the joints a, lambda, d, e, rad; the device's own axes.
  void Set(const std::array<double, 3>& tip_mm, const std::array<double, 4>& joints_rad = {});
  void PressCalibration();
  bool calibrated_to_home() const { return homed_; }
  // Each answer comes in two pieces, after an empty line.
  void InPieces(bool pieces) { pieces_ = pieces; }
  // From each answer one byte is missing.
  void LoseAByte(bool lose) { lose_ = lose; }

 private:
  void Run();
  void Take(const std::string& line);
  void Send(const Bytes& bytes);

  std::string link() const { return (folder_.path() / "tty").string(); }

  const test::TempFolder folder_;
  std::unique_ptr<Fd> master_, slave_;
  std::array<double, 3> tip_mm_{};
  std::array<double, 4> joints_rad_{};
  int info_ = 0;
  std::atomic<bool> stop_{false}, pieces_{false}, lose_{false}, homed_{false};
  std::thread thread_;
};

}  // namespace enamel::station::testing_support
