#include "station/sdk/answering.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "station/devices/limited.h"
#include "station/devices/trouble.h"

namespace enamel::station::sdk {
namespace {

using namespace std::chrono;

// An answer that did not come within this time is lost. While opening, the driver waits so long for each.
constexpr milliseconds kLost{50};
constexpr seconds kSilence{1};
// Answers in one exchange that nobody asked for. After more of them the next one may be old, however many are dropped.
constexpr int kMaxUnasked = 64;
// So many answers in a row that nobody understands are another device's, or noise.
constexpr int kMaxRefused = 100;
// Exchanges that are timed, and how many of them may be late before it is not now and then.
constexpr int kTimedAnswers = 100, kFewLate = 10, kManyLate = kTimedAnswers / 2;

}  // namespace

PolledBus::Heard AnsweringBus::Read(Pose& out) {
  switch (Next(patience_)) {
    case Got::kClosed:
      return Heard::kGone;
    case Got::kNothing:
      return Heard::kNothing;
    case Got::kAnswer:
      break;
  }
  out.asked_ns = nanoseconds(answered_.time_since_epoch()).count();
  const Heard heard = Understand(out);
  return heard == Heard::kPose && !CanBe(out) ? Heard::kRefused : heard;
}

bool AnsweringBus::Send(const dvec3& force_n) {
  if (!DropLate()) {
    // It may still listen, and not every device has a watchdog: the last it hears is no force.
    (void)Ask(dvec3(0));
    return false;
  }
  owed_.push_back(Clock::now());
  return Ask(Limited(force_n, peak_n_));
}

Status AnsweringBus::Open() {
  patience_ = kLost;
  ENAMEL_RETURN_IF_ERROR(AwaitReady());
  return ChoosePatience();
}

AnsweringBus::Got AnsweringBus::Next(microseconds patience) {
  const Got got = Await(patience);
  if (got != Got::kAnswer || owed_.empty()) return got;
  answered_ = owed_.front();
  owed_.pop_front();
  is_unsure_ = !owed_.empty();
  if (is_unsure_ && !unsure_since_) unsure_since_ = Clock::now();
  return got;
}

// An answer that came too late answers nothing any more: kept, each later answer would be one exchange
// old. Where an answer came while several were owed, this waits for the others. False: the device is
// detached, or sends so much unasked that its newest pose is not at hand.
bool AnsweringBus::DropLate() {
  const auto until = Clock::now() + (is_unsure_ ? patience_ : milliseconds(0));
  Got got = Got::kAnswer;
  for (int unasked = 0; got == Got::kAnswer; unasked += owed_.empty()) {
    if (unasked > kMaxUnasked) return false;
    const auto left = owed_.empty() ? Clock::duration(0) : until - Clock::now();
    got = Next(std::max(microseconds(0), duration_cast<microseconds>(left)));
  }
  ForgetLost();
  is_unsure_ = false;
  return got != Got::kClosed;
}

void AnsweringBus::ForgetLost() {
  const auto since = Clock::now() - kLost;
  while (!owed_.empty() && owed_.front() < since) owed_.pop_front();
  // Each later answer takes the place of a lost one, so that the first of them is never old.
  if (unsure_since_ && *unsure_since_ < since) owed_.clear();
  if (owed_.empty()) unsure_since_.reset();
}

Status AnsweringBus::AwaitReady() {
  const auto until = Clock::now() + kSilence;
  for (int refused = 0; Clock::now() < until && refused < kMaxRefused;) {
    Pose pose;
    if (!Send(dvec3(0))) break;
    const Heard heard = Read(pose);
    if (heard == Heard::kGone) break;
    if (heard == Heard::kNothing) continue;
    refused = heard == Heard::kRefused ? refused + 1 : 0;
    ENAMEL_ASSIGN_OR_RETURN(const bool is_ready, IsReady(heard, pose));
    if (is_ready) return Status::Ok();
  }
  return SaysNothing(Name());
}

Status AnsweringBus::ChoosePatience() {
  int late = 0, too_late = 0;
  for (int i = 0; i < kTimedAnswers && too_late <= kManyLate; ++i) {
    Pose pose;
    const auto begin = Clock::now();
    if (!Send(dvec3(0)) || Read(pose) == Heard::kGone) break;  // as the next exchange finds
    late += Clock::now() - begin > kAnswerPatience;
    too_late += Clock::now() - begin > kLongestPatience;
  }
  if (too_late > kManyLate) {
    return Status(Code::kUnavailable,
                  Name() + " takes more than " + std::to_string(kLongestPatience.count()) +
                      " ms for half of its answers: close other programs, and " + faster_,
                  trouble::kSlow);
  }
  patience_ = late > kFewLate ? kLongestPatience : kAnswerPatience;
  return Status::Ok();
}

Status SaysNothing(const std::string& name) {
  return Status(Code::kUnavailable,
                name + " sends no pose within a second: switch it on, and plug it in again",
                trouble::kSilent);
}

Status AwaitFirstPose(PolledBus& bus) {
  PolledBus::Pose pose;
  for (const auto until = steady_clock::now() + kSilence; steady_clock::now() < until;) {
    if (!bus.Send(dvec3(0))) break;
    const PolledBus::Heard heard = bus.Read(pose);
    if (heard == PolledBus::Heard::kPose) return Status::Ok();
    if (heard == PolledBus::Heard::kGone) break;
    std::this_thread::sleep_for(milliseconds(1));
  }
  return SaysNothing(bus.Name());
}

Status UsableUnless(const Status& problem, const std::string& name) {
  if (problem.ok()) return problem;
  return Status(problem.code(), name + ": " + problem.message(), problem.field());
}

Status CheckHome(const std::string& name, const dvec3& tip_m, double reach_m,
                 const char* how_to_home) {
  const double off_m = std::sqrt(Dot(tip_m, tip_m));
  if (off_m <= reach_m) return Status::Ok();
  return Status(
      Code::kUnavailable,
      name + " puts its tip " + std::to_string(std::lround(off_m * 1e3)) +
          " mm from the middle of its workspace, which reaches " +
          std::to_string(std::lround(reach_m * 1e3)) +
          " mm: move it there. If it is there, its encoders are not calibrated: " + how_to_home,
      trouble::kMiddle);
}

}  // namespace enamel::station::sdk
