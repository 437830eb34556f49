#include "station/desk/workflow.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "station/desk/exercise_words.h"
#include "station/desk/problem_words.h"
#include "station/loop/realtime.h"

namespace enamel::station::desk {
namespace {

using language::Words;

// Few enough for one look; the page has all of them.
constexpr size_t kResultsListed = 5;

// On a thread of its own, which takes the priority with it.
bool LacksRealtime() {
  bool lacks = false;
  std::thread([&] { lacks = !RequestRealtime().steady(); }).join();
  return lacks;
}

double Seconds(Workflow::Clock::duration d) { return std::chrono::duration<double>(d).count(); }

}  // namespace

Workflow::Workflow(Workplace& workplace, WorkflowOptions options)
    : workplace_(workplace),
      options_(std::move(options)),
      words_(options_.language),
      left_handed_(options_.left_handed),
      last_(LastDeviceOf(workplace.data())) {
  LookForKept();
}

Workflow::~Workflow() {
  LeaveAtOnce();
  workplace_.SignOut();
  ForgetResult();
}

void Workflow::Go(Place place) {
  place_ = place;
  dialog_ = Dialog::kNone;
  // A pending step belongs to the place being left.
  once_free_ = {};
  if (place != Place::kFirstPassword) signing_in_ = {};
  problem_.clear();
  notice_.clear();
}

// A sign-in lasts as long as its connection: afterwards the person has to sign in again.
void Workflow::Fail(const Status& status) {
  bool signed_in = !offline_ && way_ != Way::kPractice &&
                   (place_ == Place::kExercises || place_ == Place::kExercise ||
                    place_ == Place::kReady || place_ == Place::kResult);
  if (signed_in && status.code() == Code::kUnauthenticated && !workplace_.person()) {
    // A person who was looking at a result returns to it after signing in again.
    const Shown shown = place_ == Place::kResult ? result_ : Shown{};
    SignOutSpeaking(
        words_.Say(shown.attempt.IsZero() ? "signed_out.lost" : "signed_out.lost_result"));
    come_back_to_ = shown;
    return;
  }
  problem_ = ProblemText(words_, status);
  // The person who looks after the station needs the figures.
  if (problem_ != status.message()) spdlog::warn("{}", status.message());
}

// The same for a wrong password, an unknown login and a one-time password that was used: who guesses
// learns nothing, and who has one learns what it was good for.
void Workflow::FailToSignIn(const Status& status) {
  if (status.code() == Code::kUnauthenticated && status.field().empty()) {
    problem_ = words_.Say("sign_in.wrong");
  } else {
    Fail(status);
  }
}

void Workflow::Tick(Clock::time_point now, bool active) {
  if (active) active_at_ = now;
  // First: a task's outcome may change the place used below.
  task_.Poll();
  pictures_task_.Poll();
  FreeAgain();
  switch (place_) {
    case Place::kWarmUp:
      WatchWarmUp(now);
      break;
    case Place::kReady:
      CheckDevice(now);
      break;
    case Place::kRunning:
      WatchRun();
      break;
    case Place::kPractice:
      WatchPractice(now);
      break;
    case Place::kHandIn:
      WatchUpload();
      break;
    case Place::kResult:
      WatchScore(now);
      WatchPictures();
      break;
    default:
      break;
  }
  // Not during an attempt or while handing in: the person may be thinking, or waiting for us.
  bool may_idle = place_ == Place::kFirstPassword || place_ == Place::kExercises ||
                  place_ == Place::kExercise || place_ == Place::kResult ||
                  place_ == Place::kLoss || place_ == Place::kPractice ||
                  place_ == Place::kReserved || place_ == Place::kPracticeList ||
                  (place_ == Place::kReady && way_ == Way::kPractice);
  if (may_idle && !busy() && Seconds(now - active_at_) > options_.idle_s) {
    const bool nobody = way_ == Way::kPractice || place_ == Place::kPracticeList;
    SignOut(words_.Say(nobody ? "practice.idle" : "signed_out.idle"));
  }
}

void Workflow::SignIn(const std::string& login, const std::string& password) {
  if (busy()) return;
  problem_.clear();
  notice_.clear();  // of the sign-out before
  if (login.empty() || password.empty()) {
    problem_ = words_.Say(login.empty() ? "sign_in.no_login" : "sign_in.no_password");
    return;
  }
  task_.Start("task.sign_in", [this, login, password]() -> BackgroundTask::After {
    return SignedIn(workplace_.SignIn(login, password), {login, password});
  });
}

// In the background task of a sign-in.
BackgroundTask::After Workflow::SignedIn(const Result<Person>& person, const SigningIn& who) {
  if (!person.ok()) {
    return [this, s = person.status(), who] {
      if (s.code() != Code::kForbidden || s.field() != kOneTimePassword) return FailToSignIn(s);
      Go(Place::kFirstPassword);
      signing_in_ = who;
    };
  }
  auto catalogue = workplace_.Exercises();
  if (catalogue.ok()) workplace_.Describe(*catalogue);
  return [this, p = *person, c = std::move(catalogue), k = KeptOf(person->id)] {
    person_ = p;
    Go(Place::kExercises);
    TakeExercises(c, k);
    const Shown shown = std::exchange(come_back_to_, {});
    // Another person must not see whose result was open here.
    if (!shown.attempt.IsZero() && shown.person == p.id) ShowResult(shown);
  };
}

Workflow::Kept Workflow::KeptOf(const Uuid& person) {
  return {workplace_.UnfinishedOf(person), workplace_.HandedInOf(person, kResultsListed)};
}

void Workflow::SignOut(const std::string& why) {
  // First of all: it ends waits for the server, so that the attempt can be left.
  workplace_.SignOut();
  LeaveAttempt();
  ForgetResult();
  preview_.reset();
  person_ = {};
  catalogue_ = {};
  cut_off_.clear();
  handed_in_.clear();
  result_ = come_back_to_ = {};
  offline_ = as_reference_ = false;
  left_handed_ = options_.left_handed;
  way_ = Way::kTicket;
  // What one person chose is not there for the next.
  offers_.clear();
  offer_ = 0;
  picked_.clear();
  agreed_.clear();
  chosen_ = {};
  Speak(options_.language);
  Go(Place::kSignIn);
  LookForKept();
  notice_ = why;
}

// For a person who stays at the window, and signs in next.
void Workflow::SignOutSpeaking(const std::string& why) {
  const language::Language language = words_.language();
  SignOut(why);
  Speak(language);
}

void Workflow::Refresh() {
  if (busy()) return;
  problem_.clear();
  task_.Start("task.exercises", [this, id = person_.id]() -> BackgroundTask::After {
    auto catalogue = workplace_.Exercises();
    if (catalogue.ok()) workplace_.Describe(*catalogue);
    return [this, c = std::move(catalogue), k = KeptOf(id)] { TakeExercises(c, k); };
  });
}

void Workflow::TakeExercises(Result<Catalogue> catalogue, Kept kept) {
  // Each separately: a server that is away hides neither the recordings on this disk nor a fault of
  // it.
  if (kept.cut_off.ok()) cut_off_ = std::move(*kept.cut_off);
  if (!kept.cut_off.ok()) Fail(kept.cut_off.status());
  if (kept.handed_in.ok()) handed_in_ = std::move(*kept.handed_in);
  if (!kept.handed_in.ok()) Fail(kept.handed_in.status());
  if (!catalogue.ok()) return Fail(catalogue.status());
  catalogue_ = std::move(*catalogue);
}

const Catalogue::Exercise* Workflow::ExerciseOf(const SpooledAttempt& attempt) const {
  auto found =
      std::ranges::find(catalogue_.exercises, attempt.exercise, &Catalogue::Exercise::name);
  return found == catalogue_.exercises.end() ? nullptr : &*found;
}

std::string Workflow::TitleOf(const SpooledAttempt& attempt) const {
  const Catalogue::Exercise* exercise = ExerciseOf(attempt);
  return exercise == nullptr ? attempt.exercise : exercise->title;
}

std::string Workflow::DeviceNamed(const std::string& profile) const {
  return DeviceText(words_, profile, catalogue_.profiles);
}

const Catalogue::Profile* Workflow::ProfileFor(const DeviceOffer& offer) const {
  auto found = std::ranges::find(catalogue_.profiles, offer.profile, &Catalogue::Profile::name);
  return found == catalogue_.profiles.end() ? nullptr : &*found;
}

void Workflow::ChooseExercise(size_t index) {
  if (busy() || index >= catalogue_.exercises.size()) return;
  chosen_ = catalogue_.exercises[index];
  way_ = place_ == Place::kPracticeList ? Way::kPractice : Way::kTicket;
  preview_.reset();
  Go(Place::kExercise);
  LookForDevices();
}

void Workflow::LookForDevices() {
  if (busy()) return;
  task_.Start("task.devices", [this, language = words_.language()]() -> BackgroundTask::After {
    auto offers = DeviceOffers(Words(language), options_.simulated, options_.device);
    // Before anybody cuts: the loop asks only then.
    const bool lacks = std::ranges::any_of(offers, &DeviceOffer::felt) && LacksRealtime();
    return [this, offers = std::move(offers), lacks] {
      lacks_realtime_ = lacks;
      TakeOffers(offers);
    };
  });
}

bool Workflow::Fits(const DeviceOffer& offer) const {
  return any_device() || !preview_ || offer.profile == preview_->profile.name;
}

// A person's choice stays while it is available. The mouse that came up in place of the station's
// device does not.
void Workflow::TakeOffers(std::vector<DeviceOffer> offers) {
  offers_ = std::move(offers);
  auto same = [&](const DeviceOffer& o) {
    return o.title == picked_ && o.problem.empty() && Fits(o);
  };
  auto kept = std::ranges::find_if(offers_, same);
  std::string profile = any_device() || !preview_ ? "" : preview_->profile.name;
  offer_ = kept != offers_.end()
               ? static_cast<size_t>(kept - offers_.begin())
               : FirstUsable(offers_, profile.empty() ? options_.profile : profile);
  // The configured profile is a preference; if its device is not attached, any usable one is better
  // than none.
  if (offer_ == offers_.size() && profile.empty()) offer_ = FirstUsable(offers_, "");
  if (any_device()) return Fetch();
  if (offer_ == offers_.size()) {
    problem_ = words_.Say("device.profile_not_here", {{"device", DeviceNamed(profile)}});
  }
}

void Workflow::ChooseOffer(size_t index) {
  if (busy() || index >= offers_.size() || index == offer_) return;
  problem_ = offers_[index].problem;
  if (!problem_.empty()) return;
  offer_ = index;
  picked_ = offers_[index].title;
  // Another device has another profile and so another plan, which must be fetched.
  if (!any_device()) return;
  preview_.reset();
  Fetch();
}

void Workflow::Fetch() {
  const Catalogue::Profile* profile = ProfileFor(offers_[offer_]);
  if (profile == nullptr) {
    const bool practice = way_ == Way::kPractice;
    problem_ = words_.Say(practice ? "practice.no_profile" : "device.profile_unknown",
                          {{"profile", offers_[offer_].profile}});
    return;
  }
  problem_.clear();
  task_.Start(
      "task.tooth",
      [this, e = chosen_, p = *profile,
       practice = way_ == Way::kPractice]() -> BackgroundTask::After {
        auto prepared = practice ? workplace_.PreparePractice(e, p) : workplace_.Prepare(e, p);
        if (!prepared.ok()) return [this, s = prepared.status()] { Fail(s); };
        // std::function copies its captures, and a volume must not be copied: shared, then moved out.
        auto shared = std::make_shared<PreparedAttempt>(std::move(*prepared));
        return [this, shared] { preview_ = std::make_unique<PreparedAttempt>(std::move(*shared)); };
      });
}

void Workflow::Open(Dialog dialog) {
  dialog_ = dialog;
  if (dialog != Dialog::kNone) problem_.clear();
}

void Workflow::Interrupt() {
  if (cutting() && dialog_ == Dialog::kNone) Back();
}

void Workflow::LeaveAttempt() {
  stillness_.reset();
  if (busy()) {
    task_.Forget();
    // The task may be using the device or the loop: they live until it has ended, then FreeAgain
    // releases them.
    if (attempt_) left_ = std::move(attempt_);
    return;
  }
  attempt_.reset();
  workplace_.HandBackUnused();
}

// Discards the outcome of the current background task, if any; then runs the step.
void Workflow::WhenFree(std::function<void()> step) {
  if (!busy()) return step();
  task_.Forget();
  once_free_ = std::move(step);
}

void Workflow::FreeAgain() {
  if (busy()) return;
  if (left_) {
    left_.reset();
    workplace_.HandBackUnused();
  }
  // Taken out before it runs, because the step may set another.
  if (once_free_) std::exchange(once_free_, {})();
}

// Returns to the page where it was chosen.
void Workflow::LeaveAttemptFor(const Status& problem) {
  LeaveAttempt();
  preview_.reset();
  if (any_device()) {
    Go(Place::kExercise);
    Fetch();
  } else if (offline_) {
    ToReserved();
  } else {
    Go(Place::kExercises);
  }
  Fail(problem);
}

void Workflow::AnotherTry() {
  const Catalogue::Exercise before = chosen_;
  LeaveAttempt();
  auto same = [&](const Catalogue::Exercise& e) {
    return e.exercise == before.exercise &&
           // The same exercise may be assigned twice, with different terms: the try is for the
           // chosen one.
           (way_ != Way::kTicket || e.assignment == before.assignment);
  };
  auto found = std::ranges::find_if(catalogue_.exercises, same);
  if (found == catalogue_.exercises.end()) return ToExercises();
  const auto index = static_cast<size_t>(found - catalogue_.exercises.begin());
  WhenFree([this, index] { ChooseExercise(index); });
}

void Workflow::OpenCutOff(size_t index) {
  if (busy() || index >= cut_off_.size()) return;
  cut_off_index_ = index;
  Open(Dialog::kCutOff);
}

// A reserved or interrupted attempt counts as chosen.
void Workflow::TakeOn(std::shared_ptr<Result<PreparedAttempt>> prepared, Way way) {
  if (!prepared->ok()) return Fail(prepared->status());
  way_ = way;
  preview_ = std::make_unique<PreparedAttempt>(std::move(**prepared));
  chosen_ = {};
  chosen_.name = preview_->exercise.name;
  chosen_.title = preview_->exercise.title;
  chosen_.exercise = preview_->exercise_hash;
  // The ticket does not contain it; without the server the catalogue is empty, and exams need the
  // server.
  chosen_.exam = std::ranges::any_of(catalogue_.exercises, [&](const Catalogue::Exercise& e) {
    return e.exam && e.exercise == chosen_.exercise;
  });
  Go(Place::kExercise);
  LookForDevices();
}

void Workflow::GoOnWithCutOff() {
  if (busy()) return;
  problem_.clear();
  task_.Start("task.cut_again", [this, id = cut_off_chosen().id]() -> BackgroundTask::After {
    auto prepared = std::make_shared<Result<PreparedAttempt>>(workplace_.PrepareResume(id));
    return [this, prepared] { TakeOn(prepared, Way::kResumed); };
  });
}

void Workflow::EndCutOff() {
  if (busy()) return;
  problem_.clear();
  task_.Start("task.hand_in", [this, id = cut_off_chosen().id]() -> BackgroundTask::After {
    Status closed = workplace_.Close(id).status();
    return [this, closed] {
      if (!closed.ok()) return Fail(closed);
      ToExercises();
    };
  });
}

void Workflow::Reserve(const std::string& pin) {
  if (busy() || !preview_) return;
  problem_.clear();
  task_.Start("task.keep", [this, pin]() -> BackgroundTask::After {
    Status kept = workplace_.Reserve(*preview_, pin);
    return [this, kept] {
      if (!kept.ok()) return Fail(kept);
      CloseDialog();
      notice_ = words_.Say("reserve.kept");
    };
  });
}

// For the first page.
void Workflow::LookForKept() {
  LookForReserved();
  may_practise_ = workplace_.RemembersPractice();
}

void Workflow::LookForReserved() {
  auto reserved = workplace_.Reserved();
  if (!reserved.ok()) Fail(reserved.status());
  reserved_ = reserved.ok() ? std::move(*reserved) : std::vector<ReservedAttempt>();
}

void Workflow::ToReserved() {
  Go(Place::kReserved);
  LookForReserved();
}

void Workflow::ToPractice() {
  if (busy()) return;
  Go(Place::kPracticeList);
  task_.Start("task.exercises", [this]() -> BackgroundTask::After {
    return [this, practices = workplace_.Practices()] { catalogue_ = practices; };
  });
}

void Workflow::AskPin(size_t index) {
  if (busy() || index >= reserved_.size()) return;
  reserved_index_ = index;
  Open(Dialog::kPin);
}

void Workflow::OpenReserved(const std::string& pin) {
  if (busy()) return;
  problem_.clear();
  task_.Start("task.open", [this, pin, r = reserved_chosen()]() -> BackgroundTask::After {
    const Uuid& id = r.ticket.attempt;
    auto prepared = std::make_shared<Result<PreparedAttempt>>(
        r.cut_off ? workplace_.PrepareResume(id, pin) : workplace_.PrepareReserved(id, pin));
    return [this, prepared, r] {
      if (prepared->ok()) {
        offline_ = true;
        // The PIN identifies the person to this station only: on the server nobody is signed in.
        person_ = {(*prepared)->header.ticket.person, r.ticket.person, "student", {}, false};
      }
      TakeOn(prepared, r.cut_off ? Way::kResumed : Way::kReserved);
    };
  });
}

void Workflow::GiveBack(const std::string& pin) {
  if (busy()) return;
  problem_.clear();
  task_.Start("task.give_back",
              [this, pin, id = reserved_chosen().ticket.attempt]() -> BackgroundTask::After {
                auto given = workplace_.GiveBack(id, pin);
                return [this, given] {
                  // Before using the outcome: too many wrong PINs have destroyed the ticket, and it
                  // must not stay in the list.
                  LookForReserved();
                  if (!given.ok()) return Fail(given.status());
                  CloseDialog();
                  notice_ =
                      words_.Say(*given == HandedBack::kAtServer ? "reserve.given_back"
                                                                 : "reserve.given_back_later");
                };
              });
}

void Workflow::ToExercises() {
  LeaveAttempt();
  ForgetResult();
  preview_.reset();
  Go(Place::kExercises);
  WhenFree([this] { Refresh(); });
}

void Workflow::MarkReference(const std::string& dentist, bool consent, const std::string& anyway) {
  if (busy() || place_ != Place::kResult) return;
  problem_.clear();
  task_.Start(
      "task.reference",
      [this, dentist, consent, anyway, attempt = result_.attempt]() -> BackgroundTask::After {
        Status marked = workplace_.MarkReference(attempt, dentist, consent, anyway);
        return [this, marked] {
          needs_reason_ = marked.code() == Code::kConflict && marked.field() == kNeedsReason;
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
      // Its result is for a place that was left; it ends by itself.
      if (busy()) task_.Forget();
      preview_.reset();
      if (offline_) return SignOut();
      return Go(way_ == Way::kPractice ? Place::kPracticeList : Place::kExercises);
    case Place::kFirstPassword:
    case Place::kPracticeList:
    case Place::kReserved:
      return SignOutSpeaking({});
    case Place::kWarmUp:
      return EndWarmUp();
    case Place::kReady:
      LeaveAttempt();
      if (!any_device()) return offline_ ? ToReserved() : ToExercises();
      Go(Place::kExercise);
      return WhenFree([this] { LookForDevices(); });
    case Place::kRunning:
      return Open(Dialog::kPaused);
    case Place::kResult:
      return ToExercises();
    case Place::kLoss:
      return LeaveLoss();
    case Place::kPractice:
      return Open(Dialog::kPracticePaused);
    case Place::kExercises:
      return SignOut();
    default:
      return;
  }
}

}  // namespace enamel::station::desk
