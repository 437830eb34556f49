#include "station/desk/workflow.h"

#include <algorithm>

namespace enamel::station::desk {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLookEvery{400};  // at what the server makes of an attempt

double Seconds(Workflow::Clock::duration d) { return std::chrono::duration<double>(d).count(); }

}  // namespace

Workflow::Workflow(Workplace& workplace, std::vector<DeviceOffer> offers, double idle_s)
    : workplace_(workplace), offers_(std::move(offers)), idle_s_(idle_s) {}

void Workflow::Go(Place place) {
  place_ = place;
  dialog_ = Dialog::kNone;
  problem_.clear();
}

void Workflow::Fail(const Status& status) { problem_ = status.message(); }

void Workflow::Tick(Clock::time_point now, bool active) {
  if (active) active_at_ = now;
  errand_.Poll();
  switch (place_) {
    case Place::kReady:
      CheckDevice(now);
      break;
    case Place::kRunning:
      WatchRun();
      break;
    case Place::kHandIn:
      WatchUpload();
      break;
    case Place::kResult:
      WatchScore(now);
      break;
    default:
      break;
  }
  bool may_idle =
      place_ == Place::kExercises || place_ == Place::kExercise || place_ == Place::kResult;
  if (may_idle && !busy() && Seconds(now - active_at_) > idle_s_) {
    SignOut("You were signed out because nothing happened for a while.");
  }
}

void Workflow::SignIn(const std::string& login, const std::string& password) {
  if (busy()) return;
  problem_.clear();
  if (login.empty() || password.empty()) {
    problem_ = login.empty() ? "Write your login first." : "Write your password too.";
    return;
  }
  errand_.Start("Signing in", [this, login, password]() -> Errand::After {
    auto person = workplace_.SignIn(login, password);
    if (!person.ok()) return [this, s = person.status()] { Fail(s); };
    auto catalogue = workplace_.Exercises();
    return [this, p = *person, c = std::move(catalogue)] {
      person_ = p;
      if (!c.ok()) return Fail(c.status());
      catalogue_ = *c;
      Go(Place::kExercises);
    };
  });
}

void Workflow::SignOut(const std::string& why) {
  if (busy()) errand_.Forget();
  LeaveStage();
  preview_.reset();
  workplace_.SignOut();
  person_ = {};
  catalogue_ = {};
  Go(Place::kSignIn);
  problem_ = why;
}

void Workflow::Refresh() {
  if (busy()) return;
  problem_.clear();
  errand_.Start("Asking for the exercises", [this]() -> Errand::After {
    auto catalogue = workplace_.Exercises();
    return [this, c = std::move(catalogue)] {
      if (!c.ok()) return Fail(c.status());
      catalogue_ = *c;
    };
  });
}

const Catalogue::Profile* Workflow::ProfileFor(const DeviceOffer& offer) const {
  auto found = std::ranges::find(catalogue_.profiles, offer.profile, &Catalogue::Profile::name);
  return found == catalogue_.profiles.end() ? nullptr : &*found;
}

void Workflow::ChooseExercise(size_t index) {
  if (busy() || index >= catalogue_.exercises.size()) return;
  exercise_ = index;
  preview_.reset();
  Go(Place::kExercise);
  Fetch();
}

void Workflow::ChooseOffer(size_t index) {
  if (busy() || index >= offers_.size() || index == offer_) return;
  offer_ = index;
  preview_.reset();
  Fetch();
}

void Workflow::Fetch() {
  const Catalogue::Profile* profile = ProfileFor(offers_[offer_]);
  if (profile == nullptr) {
    problem_ = "The server has no profile '" + offers_[offer_].profile +
               "' for this device. An admin adds it; another device may do.";
    return;
  }
  problem_.clear();
  errand_.Start("Fetching the tooth",
                [this, e = catalogue_.exercises[exercise_], p = *profile]() -> Errand::After {
                  auto prepared = workplace_.Prepare(e, p);
                  if (!prepared.ok()) return [this, s = prepared.status()] { Fail(s); };
                  auto shared = std::make_shared<PreparedAttempt>(std::move(*prepared));
                  return [this, shared] {
                    preview_ = std::make_unique<PreparedAttempt>(std::move(*shared));
                  };
                });
}

void Workflow::Start(bool as_reference) {
  if (busy() || !preview_) return;
  auto stage = Stage::Create(std::move(*preview_), offers_[offer_]);
  preview_.reset();
  if (!stage.ok()) return Fail(stage.status());
  stage_ = std::move(*stage);
  ticketed_ = joined_ = marked_ = held_back_ = false;
  progress_.reset();
  score_.reset();
  stillness_.emplace(static_cast<double>(stage_->prepared().profile.resolution_nm.value) * 1e-9);
  started_ = Clock::now();
  Go(Place::kReady);
  TakeTicket(as_reference);
}

void Workflow::TakeTicket(bool as_reference) {
  errand_.Start("Asking for the ticket", [this, as_reference]() -> Errand::After {
    Status taken = workplace_.TakeTicket(stage_->prepared(), as_reference);
    return [this, taken] {
      if (taken.ok()) {
        ticketed_ = true;
        return;
      }
      LeaveStage();
      Go(Place::kExercise);
      Fetch();
      Fail(taken);
    };
  });
}

// A simulated hand's time passes when it is looked at: it is not.
void Workflow::CheckDevice(Clock::time_point now) {
  if (!stage_) return;
  if (!stage_->simulated() && !stillness_->passed()) {
    stillness_->Look(stage_->device().ReadSample(), Seconds(now - started_));
    if (!stillness_->passed()) return;
  }
  if (!ticketed_ || busy()) return;
  if (Status begun = stage_->Begin(workplace_); !begun.ok()) {
    LeaveStage();
    Go(Place::kExercise);
    Fetch();
    return Fail(begun);
  }
  Go(Place::kRunning);
}

void Workflow::WatchRun() {
  stage_->held().SetPaused(dialog_ != Dialog::kNone);
  if (stage_->run()->ticking()) return;
  if (!busy() && !joined_) EndAttempt();
}

void Workflow::EndAttempt() {
  if (busy() || joined_ || !stage_ || stage_->run() == nullptr) return;
  Go(Place::kHandIn);
  stage_->run()->End();
  errand_.Start("Closing the recording", [this]() -> Errand::After {
    auto seal = stage_->run()->Join();
    return [this, s = seal.status()] {
      joined_ = true;
      if (!s.ok()) Fail(s);
    };
  });
}

Uploader::State Workflow::upload() const {
  return stage_ && stage_->run() ? stage_->run()->upload() : Uploader::State{};
}

uint32_t Workflow::chunks() const {
  return stage_ && stage_->run() ? stage_->run()->recording().chunks : 0;
}

void Workflow::WatchUpload() {
  if (joined_ && upload().sealed) Go(Place::kResult);
}

void Workflow::LeaveHandIn() {
  if (!joined_) return;
  ToExercises();
}

void Workflow::Take(const AttemptProgress& progress) {
  progress_ = progress;
  if (progress.state != "scored") return;
  held_back_ = progress.result_json.empty();
  if (held_back_) return;
  auto score = scoring::ScoreFromJson(progress.result_json);
  if (!score.ok()) return Fail(score.status());
  score_ = std::move(*score);
}

void Workflow::WatchScore(Clock::time_point now) {
  bool over = progress_ && (progress_->state == "scored" || progress_->state == "failed" ||
                            progress_->state == "quarantined");
  if (over || busy() || now < next_look_ || !stage_) return;
  next_look_ = now + kLookEvery;
  errand_.Start("Scoring", [this, attempt = stage_->prepared().attempt()]() -> Errand::After {
    auto progress = workplace_.Progress(attempt);
    return [this, p = std::move(progress)] {
      if (p.ok()) {
        problem_.clear();
        return Take(*p);
      }
      Fail(p.status());
      next_look_ = Clock::now() + 5 * kLookEvery;
    };
  });
}

void Workflow::Open(Dialog dialog) {
  dialog_ = dialog;
  if (dialog != Dialog::kNone) problem_.clear();
}

void Workflow::LeaveStage() {
  if (busy()) {
    // It may use the stage: its outcome is not wanted, its end is waited for.
    errand_.Forget();
    while (errand_.busy()) {
      std::this_thread::sleep_for(milliseconds(2));
      errand_.Poll();
    }
  }
  stage_.reset();
  stillness_.reset();
}

void Workflow::AnotherTry() {
  LeaveStage();
  Go(Place::kExercise);
  preview_.reset();
  Fetch();
}

void Workflow::ToExercises() {
  LeaveStage();
  preview_.reset();
  Go(Place::kExercises);
  Refresh();
}

void Workflow::MarkReference(const std::string& dentist, bool consent) {
  if (busy() || !stage_) return;
  problem_.clear();
  errand_.Start(
      "Marking the reference",
      [this, dentist, consent, attempt = stage_->prepared().attempt()]() -> Errand::After {
        Status marked = workplace_.MarkReference(attempt, dentist, consent);
        return [this, marked] {
          if (!marked.ok()) return Fail(marked);
          marked_ = true;
          CloseDialog();
        };
      });
}

void Workflow::Back() {
  if (dialog_ != Dialog::kNone) return CloseDialog();
  switch (place_) {
    case Place::kExercise:
      if (busy()) errand_.Forget();
      preview_.reset();
      return Go(Place::kExercises);
    case Place::kReady:
      if (ticketed_ || busy()) return;  // it begins by itself
      LeaveStage();
      return Go(Place::kExercise);
    case Place::kRunning:
      return Open(Dialog::kPaused);
    case Place::kResult:
      return ToExercises();
    case Place::kExercises:
      return SignOut();
    default:
      return;
  }
}

}  // namespace enamel::station::desk
