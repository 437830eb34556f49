#pragma once

#include <chrono>
#include <deque>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "station/devices/polled_device.h"

namespace enamel::station::sdk {

// Two answers may be lost before the loop has missed five ticks, which is a fault.
inline constexpr std::chrono::milliseconds kAnswerPatience{2};
// Of a device whose answers usually take longer: then none may be lost, and one that takes longer than
// this is a fault.
inline constexpr std::chrono::milliseconds kLongestPatience{4};

// A device that says where it is only in answer to a force, one answer each, in the order of the questions.
// Pairs the answers with their questions: an answer that came too late is not taken for the next
// question's.
class AnsweringBus : public PolledBus {
 public:
  bool answers() const final { return true; }
  Heard Read(Pose& out) final;
  bool Send(const dvec3& force_n) final;

  // Awaits the first pose and times answers. Errors: kUnavailable, with what to do; the driver's own.
  Status Open();

 protected:
  using Clock = std::chrono::steady_clock;
  enum class Got { kAnswer, kNothing, kClosed };

  // `peak_n`: a longer force is shortened to this. `faster`: what somebody can do about late answers.
  AnsweringBus(double peak_n, const char* faster) : peak_n_(peak_n), faster_(faster) {}

  // Waits up to `patience` for the next whole answer and keeps it for Understand, in place of the
  // previous one. Part of an answer is kNothing, and is kept for a later call.
  virtual Got Await(std::chrono::microseconds patience) = 0;
  // What the kept answer says.
  virtual Heard Understand(Pose& out) = 0;
  // Writes a question. False: the device is detached.
  virtual bool Ask(const dvec3& force_n) = 0;
  // Called for each answer until it returns true, or an error: the device can be used.
  virtual Result<bool> IsReady(Heard heard, const Pose& pose) = 0;

  std::chrono::milliseconds patience() const { return patience_; }

 private:
  Got Next(std::chrono::microseconds patience);
  bool DropLate();
  void ForgetLost();
  Status AwaitReady();
  Status ChoosePatience();

  const double peak_n_;
  const char* const faster_;
  std::chrono::milliseconds patience_ = kAnswerPatience;
  std::deque<Clock::time_point> owed_;  // when each question without an answer was asked
  Clock::time_point answered_;          // when the question to the newest answer was
  bool is_unsure_ = false;              // the newest answer came while others were owed
  std::optional<Clock::time_point> unsure_since_;
};

// Of a device that gives no first pose.
Status SaysNothing(const std::string& name);
// Sends force 0 until the first pose, for a second. Errors: SaysNothing.
Status AwaitFirstPose(PolledBus& bus);

// Of a device that cannot be used because of `problem`. Ok: it can.
Status UsableUnless(const Status& problem, const std::string& name);

// Whether a first pose, m from the middle of the workspace, is within the arm's reach. One whose encoders
// lost their home is not, or by chance. Errors: kUnavailable, with `how_to_home`.
Status CheckHome(const std::string& name, const dvec3& tip_m, double reach_m,
                 const char* how_to_home);

}  // namespace enamel::station::sdk
