// The steps of one attempt: from the device's opening to the score. Other steps are in
// workflow.cpp.
#include <spdlog/spdlog.h>

#include <utility>

#include "station/desk/problem_words.h"
#include "station/desk/workflow.h"
#include "station/loop/realtime.h"
#include "station/sdk/open_sdk_device.h"
#include "station/session/device_delay.h"
#include "station/session/hand_turn.h"

namespace enamel::station::desk {
namespace {

constexpr std::chrono::milliseconds kLookEvery{400};  // at what the server makes of an attempt

}  // namespace

void Workflow::Start(bool as_reference) {
  if (busy() || !preview_ || offer_ >= offers_.size()) return;
  problem_.clear();
  as_reference_ = as_reference;
  if (missing_device()) return Open(Dialog::kFallback);
  OpenDevice([this](std::unique_ptr<Device> attached, const DevicePace& pace) {
    ShowAttempt(std::move(attached), pace);
  });
}

std::optional<MissingDevice> Workflow::missing_device() const {
  // A ticket taken in advance or an interrupted attempt names the device profile itself.
  if (!any_device() || offer_ >= offers_.size() || offers_[offer_].title == agreed_) return {};
  // Where nobody has set the station's device, it is the one that was cut with before: once it is
  // unplugged, nothing else tells that there was one.
  const bool set = !options_.profile.empty() || !last_;
  return MissingFor(words_, offers_, offer_, set ? options_.profile : last_->profile,
                    set ? DeviceNamed(options_.profile) : last_->title);
}

void Workflow::RememberDevice() {
  const DeviceOffer& used = offers_[offer_];
  const LastDevice device{used.title, used.profile};
  if (!used.felt || last_ == device) return;
  last_ = device;
  if (Status kept = KeepLastDevice(workplace_.data(), device); !kept.ok()) {
    spdlog::warn("the device that is cut with could not be remembered: {}", kept.message());
  }
}

void Workflow::StartWithFallback() {
  if (busy() || dialog_ != Dialog::kFallback || offer_ >= offers_.size()) return;
  CloseDialog();
  agreed_ = offers_[offer_].title;
  Start(as_reference_);
}

void Workflow::OpenDevice(ShowDevice show) {
  if (offers_[offer_].device.empty()) return show(nullptr, {});
  hid::DeviceChoice choice = options_.device;
  choice.device = offers_[offer_].device;
  choice.pedal = offers_[offer_].pedal;
  // On the reader's own thread, before its first sample: a driver's thread that is not real-time
  // makes the loop late. If refused, the loop's own request reports it.
  choice.thread_setup = [] { (void)RequestRealtime(); };
  task_.Start("task.device",
              [this, choice, show = std::move(show), profile = preview_->profile,
               tick_s = 1.0 / preview_->header.params.rate_hz]() -> BackgroundTask::After {
                auto opened = std::make_shared<Result<std::unique_ptr<Device>>>(
                    sdk::OpenChosenDevice(choice, profile, tick_s));
                const DevicePace pace = opened->ok() ? AwaitPace(***opened) : DevicePace{};
                return [this, opened, pace, show] {
                  if (!opened->ok()) return Fail(opened->status());
                  show(std::move(**opened), pace);
                };
              });
}

void Workflow::TakeAttempt(std::unique_ptr<DeskAttempt> attempt) {
  attempt_ = std::move(attempt);
  if (left_handed_) attempt_->view().camera().MirrorAside();
  attempt_->StandsTurned(HandTurnOf(workplace_.data(), attempt_->device(), options_.hand_turn_deg));
}

void Workflow::ShowAttempt(std::unique_ptr<Device> attached, const DevicePace& pace) {
  std::string softer;
  if (attached != nullptr) {
    // Only the opened device identifies its unit, and so its calibration.
    if (Status used = UseDelayOf(*preview_, *attached, pace, workplace_.data()); !used.ok())
      return Fail(used);
    if (preview_->delay) {
      softer = SofterText(words_, preview_->delay->from, offers_[offer_].title);
    }
  }
  // From here on there is no preview: after a failure it is fetched again (LeaveAttemptFor).
  auto attempt = DeskAttempt::Create(std::move(*preview_), offers_[offer_], std::move(attached),
                                     options_.mouth);
  preview_.reset();
  if (!attempt.ok()) return LeaveAttemptFor(attempt.status());
  TakeAttempt(std::move(*attempt));
  // Reserved and resumed attempts bring their ticket.
  ticketed_ = way_ != Way::kTicket;
  joined_ = recorded_ = false;
  needs_start_ = false;
  needs_end_ = attempt_->prepared().terms.sign_off;
  ForgetResult();
  LookForStillness();
  Go(Place::kReady);
  notice_ = softer;
}

void Workflow::LookForStillness() {
  stillness_.emplace(static_cast<double>(attempt_->prepared().profile.resolution_nm.value) * 1e-9);
  started_ = Clock::now();
}

void Workflow::TakeTicket() {
  task_.Start(
      "task.ticket",
      [this, attempt = attempt_.get(), reference = as_reference_]() -> BackgroundTask::After {
        Status taken = workplace_.TakeTicket(attempt->prepared(), reference);
        return [this, taken] {
          // No ticket, no attempt: returns to the exercise, with the server's reason.
          ticketed_ = taken.ok();
          if (!ticketed_) return LeaveAttemptFor(taken);
          needs_start_ = needs_end_ = attempt_->prepared().terms.sign_off;
          if (needs_start_) Open(Dialog::kSignOff);
        };
      });
}

void Workflow::SignOff(const std::string& login, const std::string& pin) {
  if (busy() || dialog_ != Dialog::kSignOff) return;
  problem_.clear();
  const SignedAt at = signs_end() ? SignedAt::kEnd : SignedAt::kStart;
  task_.Start(
      "task.sign_off",
      [this, login, pin, at, id = attempt_->prepared().attempt()]() -> BackgroundTask::After {
        auto signer = workplace_.SignOff(id, at, login, pin);
        return [this, at, s = signer.status()] {
          // Not Fail: whoever makes the attempt stays signed in, or is asked again later.
          if (!s.ok()) {
            const bool wrong = s.code() == Code::kUnauthenticated && s.field().empty();
            problem_ = wrong ? words_.Say("sign_off.wrong") : ProblemText(words_, s);
            return;
          }
          CloseDialog();
          if (at == SignedAt::kEnd) return HandInUnheld();
          needs_start_ = false;
          // Two people were at the chair: the device has to rest once more.
          LookForStillness();
        };
      });
}

void Workflow::LeaveSignOff() {
  if (busy()) return;
  CloseDialog();
  signs_end() ? HandInUnheld() : Back();
}

void Workflow::HandInUnheld() {
  needs_end_ = false;
  workplace_.HandIn(attempt_->prepared().attempt());
}

// The ticket is taken last: the server waits for the attempt from then on. A simulated hand is not
// sampled, because that would advance its time.
void Workflow::CheckDevice(Clock::time_point now) {
  if (!attempt_ || busy() || needs_start_) return;
  // A hand on the handpiece at the first tick would be pulled: force comes on only after stillness,
  // and saying so before the ticket is taken costs nobody a try.
  if (!attempt_->simulated() && !stillness_->passed()) {
    stillness_->Look(attempt_->device().ReadSample(),
                     std::chrono::duration<double>(now - started_).count());
    if (!stillness_->passed()) return;
  }
  if (!tooth_drawn()) return;  // nobody should cut what cannot be seen yet
  if (ticketed_) return Begin();
  TakeTicket();
}

void Workflow::Begin() {
  RememberDevice();
  if (way_ == Way::kPractice) return Practise();
  if (Status begun = attempt_->Begin(workplace_, options_.cpu); !begun.ok())
    return LeaveAttemptFor(begun);
  put_downs_ = 0;
  Go(Place::kRunning);
}

// Putting the handpiece down pauses; the person is asked whether that was the end.
void Workflow::PauseWhenPutDown(Dialog dialog) {
  const uint64_t put_downs = attempt_->newest().counters.put_downs;
  if (put_downs != put_downs_ && dialog_ == Dialog::kNone) Open(dialog);
  put_downs_ = put_downs;
  // A dialog covers the tooth: nobody can be cutting on purpose.
  attempt_->held().SetPaused(dialog_ != Dialog::kNone);
}

void Workflow::WatchRun() {
  PauseWhenPutDown(Dialog::kPaused);
  if (busy() || attempt_->run()->ticking() || attempt_->run()->left()) return;
  // The hand's finish or a permanent fault has ended the loop; the person is not asked.
  if (!joined_) EndAttempt();
}

void Workflow::EndAttempt() {
  if (busy() || joined_ || !attempt_ || attempt_->run() == nullptr) return;
  Go(Place::kHandIn);
  // Only requests the end; Join waits for the disk, and so needs a task.
  attempt_->run()->End();
  task_.Start("task.closing", [this, run = attempt_->run()]() -> BackgroundTask::After {
    auto seal = run->Join();
    return [this, s = seal.status()] {
      joined_ = true;
      recorded_ = s.ok();
      // The log has the reason, and how to repair it.
      if (!s.ok()) problem_ = words_.Say("hand_in.end_lost");
    };
  });
}

void Workflow::LeaveForNow() {
  if (busy() || joined_ || !attempt_ || attempt_->run() == nullptr) return;
  task_.Start("task.leaving", [this, run = attempt_->run()]() -> BackgroundTask::After {
    const Status left = run->Leave();
    return [this, left] {
      if (offline_) {
        SignOut(words_.Say("signed_out.left"));
      } else {
        ToExercises();
      }
      // The log has the reason, and how to repair it.
      if (!left.ok()) problem_ = words_.Say("hand_in.end_lost");
    };
  });
}

void Workflow::LeaveAtOnce() {
  for (DeskAttempt* attempt : {attempt_.get(), left_.get()}) {
    if (attempt != nullptr) attempt->LeaveAtOnce();
  }
  // A ticket that was taken for the ready page, which a second person may still have had to sign.
  workplace_.HandBackUnused();
}

Uploader::State Workflow::upload() const {
  return attempt_ && attempt_->run() ? attempt_->run()->upload() : Uploader::State{};
}

uint32_t Workflow::chunks() const {
  return attempt_ && attempt_->run() ? attempt_->run()->recording().chunks : 0;
}

Status Workflow::recording_problem() const {
  return attempt_ && attempt_->run() ? attempt_->run()->recording().problem : Status::Ok();
}

void Workflow::GiveUpRecording() {
  if (attempt_ && attempt_->run()) attempt_->run()->GiveUp();
}

void Workflow::WatchUpload() {
  // What is not whole on this disk has no end to sign.
  if (joined_ && needs_end_ && !recorded_) HandInUnheld();
  if (joined_ && needs_end_ && dialog_ == Dialog::kNone) Open(Dialog::kSignOff);
  // The upload may be ahead of the recorder's outcome, which must be shown first.
  if (!joined_ || !upload().sealed) return;
  if (offline_) return SignOut(words_.Say("signed_out.handed_in"));
  ShowResult({person_.id, attempt_->prepared().attempt(), attempt_->prepared().exercise.title});
}

void Workflow::ShowResult(Shown shown) {
  result_ = std::move(shown);
  ForgetResult();
  Go(Place::kResult);
}

// "Another try" selects the same settings again.
void Workflow::OpenHandedIn(size_t index) {
  if (busy() || index >= handed_in_.size()) return;
  const SpooledAttempt& attempt = handed_in_[index];
  const Catalogue::Exercise* exercise = ExerciseOf(attempt);
  chosen_ = exercise == nullptr ? Catalogue::Exercise{} : *exercise;
  way_ = Way::kTicket;
  ShowResult({person_.id, attempt.id, TitleOf(attempt)});
}

void Workflow::TryAgainNow() { workplace_.uploader().Retry(); }

void Workflow::LeaveHandIn() {
  if (!joined_) return;
  if (offline_) return SignOut(words_.Say("signed_out.safe"));
  ToExercises();
}

void Workflow::Take(const AttemptProgress& progress) {
  progress_ = progress;
  if (progress.state != "scored") return;
  // Scored but not shown: graded work before its release.
  held_back_ = progress.result_json.empty();
  if (held_back_) return;
  auto score = scoring::ScoreFromJson(progress.result_json);
  if (!score.ok()) return Fail(score.status());
  score_ = std::move(*score);
}

void Workflow::WatchScore(Clock::time_point now) {
  bool over = progress_ && (progress_->state == "scored" || progress_->state == "failed" ||
                            progress_->state == "quarantined");
  if (over || busy() || now < next_look_) return;
  next_look_ = now + kLookEvery;
  task_.Start("task.scoring", [this, attempt = result_.attempt]() -> BackgroundTask::After {
    auto progress = workplace_.Progress(attempt);
    return [this, p = std::move(progress)] {
      if (p.ok()) {
        problem_.clear();
        return Take(*p);
      }
      Fail(p.status());
      // A server that is away is asked less often than one that is scoring.
      next_look_ = Clock::now() + 5 * kLookEvery;
    };
  });
}

}  // namespace enamel::station::desk
