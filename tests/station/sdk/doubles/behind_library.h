#pragma once

#include <array>
#include <string>

namespace enamel::station::testing_support {

// The device behind a double of a maker's library, which a test gives it. In the library's units and axes.
class BehindLibrary {
 public:
  struct Pose {
    std::array<double, 3> position{};
    std::array<std::array<double, 3>, 3> frame{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // by rows
    bool button = false, second = false;
  };
  struct Facts {
    std::string name;
    int serial = 0;
    bool wrist = false;  // sensed and driven
    bool gripper = false;
    bool calibrated = true;
    bool motors = false;
    int off_cause = 0;  // why the motors are off, as dhdGetStatus has it
  };
  enum class Line { kHere, kSilent, kGone };

  virtual ~BehindLibrary() = default;
  // Why it cannot be opened, as the library words it; null: it is open now.
  virtual const char* Open() = 0;
  virtual void Close() = 0;
  virtual Facts facts() = 0;
  // One exchange each. kSilent: nothing came or went.
  virtual Line Read(Pose& out) = 0;
  virtual Line Write(const std::array<double, 3>& force, const std::array<double, 3>& torque) = 0;
  virtual void SwitchMotors(bool on) = 0;
  // Without a force for so long the motors go off; 0: they stay on.
  virtual void SetWatchdog(int us) = 0;
  virtual void EmulateButton(bool on) = 0;
};

// What each double exports beside the library's functions: the device behind it from now on, or null.
using SetBehindLibrary = void (*)(BehindLibrary*);
inline constexpr const char* kSetBehindLibrary = "EnamelSetBehindLibrary";

}  // namespace enamel::station::testing_support
