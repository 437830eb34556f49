#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/language/words.h"
#include "common/scoring/score.h"
#include "station/desk/background_task.h"
#include "station/desk/desk_attempt.h"
#include "station/desk/hand_alignment.h"
#include "station/desk/result_loss_view.h"
#include "station/desk/result_losses.h"
#include "station/desk/result_pictures.h"
#include "station/desk/watch/stillness.h"
#include "station/session/device_delay.h"
#include "station/session/last_device.h"

namespace enamel::station::desk {

enum class Place {
  kSignIn,
  kFirstPassword,  // in place of a one-time password
  kReserved,
  kExercises,
  kPracticeList,  // of exercises that need no server, for anybody
  kExercise,
  kWarmUp,  // trying the device: nothing is recorded
  kReady,
  kRunning,
  kHandIn,
  kResult,
  kLoss,
  kPractice
};
enum class Dialog {
  kNone,
  kPaused,
  kPracticePaused,
  kFinish,
  kGiveUp,
  kReference,
  kClose,
  kReserve,
  kPin,
  kCutOff,
  kSignOff,
  kFallback  // to another device than this station's
};

// How an attempt gets its ticket: requested when the device rests; taken in advance and locked with
// a PIN; or already there, because the attempt was interrupted and continues. Practice without the
// server is no attempt and needs none.
enum class Way { kTicket, kReserved, kResumed, kPractice };

// Whether progress on what the score measures is shown while cutting: in practice, and to
// instructors; in an exam to nobody.
inline bool MayShowProgress(bool graded, bool exam, bool instructor) {
  return !exam && (!graded || instructor);
}

// Students see the target's outline on the tooth where their ticket allows it (ChairTerms::outline),
// instructors everywhere but in an exam.
inline bool MayShowOutline(bool shown_to_student, bool exam, bool instructor) {
  return shown_to_student || (instructor && !exam);
}

struct WorkflowOptions {
  bool simulated = false;    // offer simulated hands too
  hid::DeviceChoice device;  // pedal, axes, watchdog of attached devices; its `device` is ignored
  double idle_s = 600;
  std::string profile = {};  // of this station's device: chosen at first if it exists
  int cpu = -1;              // bind the haptic loop to this processor; -1: to none
  bool mouth = true;         // draw it around a tooth
  int hand_turn_deg = 0;     // of devices whose turn was not measured here
  bool left_handed = false;  // until the person who signs in says otherwise
  language::Language language = language::Language::kEnglish;  // until somebody chooses another
};

// The person's place on the way from sign-in to result, and the steps from there. The pages draw
// this state and call the steps. Steps that wait for the server run as a background task, so no
// step waits itself; an error is in `problem`, in words. If the person leaves a place, what its
// background task needs is kept until the task ends. Needs the OpenGL context current where an
// attempt is shown or left (Tick and the steps). Thread safety: the window's thread.
class Workflow {
 public:
  using Clock = std::chrono::steady_clock;

  // `workplace` outlives this.
  Workflow(Workplace& workplace, WorkflowOptions options);
  ~Workflow();  // signs out, so that no background task waits for the server
  Workflow(const Workflow&) = delete;
  Workflow& operator=(const Workflow&) = delete;

  // Call once a frame: handles outcomes of background tasks and ends of attempts. `active`: the
  // person used mouse or keyboard.
  void Tick(Clock::time_point now, bool active);

  // The window's words in its language. Texts already shown stay in theirs.
  const language::Words& words() const { return words_; }
  void Speak(language::Language language) { words_ = language::Words(language); }

  // The person holds the handpiece in the left hand: panel and buttons change sides at once, the tooth
  // with the next attempt. Lasts until the person signs out.
  bool left_handed() const { return left_handed_; }
  void HoldInLeft(bool left) { left_handed_ = left; }

  // --- where ---
  Place place() const { return place_; }
  Dialog dialog() const { return dialog_; }
  const std::string& problem() const { return problem_; }
  const std::string& notice() const { return notice_; }  // something went well
  bool busy() const { return task_.busy(); }
  const std::string& task() const { return task_.what(); }  // a key of the words
  const Person& person() const { return person_; }
  bool instructor() const { return !person_.role.empty() && person_.role != "student"; }
  const std::vector<Catalogue::Exercise>& exercises() const { return catalogue_.exercises; }
  // The chosen exercise. For a reserved or interrupted attempt, what is known of it.
  const Catalogue::Exercise& chosen() const { return chosen_; }
  Way way() const { return way_; }
  // Running on a ticket taken in advance, with nobody signed in.
  bool offline() const { return offline_; }
  // This person's attempts handed in here, newest first, to see their scores.
  const std::vector<SpooledAttempt>& handed_in() const { return handed_in_; }
  // This person's interrupted attempts, and the one that the dialog is about.
  const std::vector<SpooledAttempt>& cut_off() const { return cut_off_; }
  const SpooledAttempt& cut_off_chosen() const { return cut_off_[cut_off_index_]; }
  std::string TitleOf(const SpooledAttempt& attempt) const;
  // A device as people call it, for the name of its profile.
  std::string DeviceNamed(const std::string& profile) const;
  const Catalogue::Exercise* ExerciseOf(const SpooledAttempt& attempt) const;  // null: not listed
  // The station remembers exercises that can be practised without the server.
  bool may_practise() const { return may_practise_; }
  // Tickets taken in advance, of all people here.
  const std::vector<ReservedAttempt>& reserved() const { return reserved_; }
  const ReservedAttempt& reserved_chosen() const { return reserved_[reserved_index_]; }
  const std::vector<DeviceOffer>& offers() const { return offers_; }
  size_t offer_index() const { return offer_; }
  // A device with motors is chosen, and this program has no real-time rights.
  bool lacks_realtime() const {
    return lacks_realtime_ && offer_ < offers_.size() && offers_[offer_].felt;
  }
  // Whether the ticket's device profile, if there is a ticket, allows this device.
  bool Fits(const DeviceOffer& offer) const;
  // The exercise chosen, once fetched; from kReady on the attempt has it.
  const PreparedAttempt* preview() const {
    return attempt_ ? &attempt_->prepared() : preview_.get();
  }
  DeskAttempt* attempt() { return attempt_.get(); }
  // The bur is in the person's hand: the picture is the tooth.
  bool cutting() const {
    return place_ == Place::kRunning || place_ == Place::kWarmUp || place_ == Place::kPractice;
  }
  const StillnessCheck* stillness() const { return stillness_ ? &*stillness_ : nullptr; }
  // Whether the whole tooth is in the picture.
  bool tooth_drawn() { return attempt_ && attempt_->drawn(); }
  Uploader::State upload() const;
  uint32_t chunks() const;
  // Why the recording cannot be stored at the moment, or ok; and whether all of it is stored.
  Status recording_problem() const;
  bool recorded() const { return recorded_; }
  // The attempt whose result kResult shows.
  const std::string& result_title() const { return result_.title; }
  const std::optional<AttemptProgress>& progress() const { return progress_; }
  const std::optional<scoring::ScoreResult>& score() const { return score_; }
  // The score exists, but is not released to this person yet.
  bool held_back() const { return held_back_; }
  // Its pictures, as far as there are any yet. What the score judged by comes with the score.
  const ResultPictures* pictures() const { return pictures_.get(); }
  // The attempt whose result is shown.
  const Uuid& result_attempt() const { return result_.attempt; }
  // Of kLoss: what it shows. The loss is one of the score's.
  LossView* loss() { return loss_.get(); }
  const Loss& loss_shown() const { return loss_shown_; }
  // Its exercise has attempts left, as far as this station knows.
  bool may_try_again() const;
  bool marked_as_reference() const { return marked_; }
  // Refused as reference, but allowed with a reason.
  bool reference_needs_reason() const { return needs_reason_; }
  Workplace& workplace() { return workplace_; }

  // --- steps ---
  void SignIn(const std::string& login, const std::string& password);
  // Replaces the one-time password, and shows the exercises. Until then it works.
  void ChoosePassword(const std::string& chosen, const std::string& again);
  void SignOut(const std::string& why = {});
  void Refresh();  // the exercises
  void ChooseExercise(size_t index);
  void LookForDevices();
  void ChooseOffer(size_t index);
  // Asks first (Dialog::kFallback) where this would be another device than the station's, which
  // cannot be used: the configured one, else the one with motors that was last cut with.
  void Start(bool as_reference);
  // The device that cannot be used. None: the chosen one is right, or was agreed to.
  std::optional<MissingDevice> missing_device() const;
  // Agrees to the chosen device until the person signs out, and starts.
  void StartWithFallback();
  // Ten seconds of cutting on a block with this exercise's bur; then, or by EndWarmUp, back to the
  // exercise, with what was found in `notice`.
  void TryDevice();
  void EndWarmUp();
  // Finds how the tried device stands, from a hand that goes to the right, and keeps it.
  void AlignHand();
  const HandAlignment& alignment() const { return alignment_; }
  void OpenHandedIn(size_t index);  // its result
  void OpenCutOff(size_t index);
  void GoOnWithCutOff();
  void EndCutOff();  // hands it in as recorded
  void Reserve(const std::string& pin);
  void ToReserved();
  // The exercises that can be practised without the server. Nobody signs in, and nothing is recorded.
  void ToPractice();
  void AskPin(size_t index);
  void OpenReserved(const std::string& pin);
  void GiveBack(const std::string& pin);  // returns the dialog's ticket for good
  // A second person's signature, for Dialog::kSignOff: of the start before the first tick, or of
  // the end before it is handed in.
  void SignOff(const std::string& login, const std::string& pin);
  // Nobody signs: goes back before the first tick, or hands in without the signature.
  void LeaveSignOff();
  bool signs_end() const { return place_ == Place::kHandIn; }
  void Open(Dialog dialog);
  // The person cannot see or steer the cut any more: as Esc, where the bur may be turning.
  void Interrupt();
  void CloseDialog() { Open(Dialog::kNone); }
  void EndAttempt();  // finished, or given up: sealed as recorded
  // Stores what was recorded and goes back to the exercises, where the attempt can be continued.
  void LeaveForNow();
  // What a signal or the display's end leaves time for: force 0, everything stored, the device closed.
  // No step may follow.
  void LeaveAtOnce();
  void LeaveHandIn();      // the upload continues in the background
  void GiveUpRecording();  // stops waiting for a disk that takes nothing
  // Asks the server at once instead of waiting for the next try.
  void TryAgainNow();
  void AnotherTry();
  void ToExercises();
  // `anyway`: the reason, where one is required.
  void MarkReference(const std::string& dentist, bool consent, const std::string& anyway);
  // Goes to the place of a loss and makes its stroke again; asked there again, once more. `loss`: of
  // score(), with a place.
  void ShowLoss(const Loss& loss);
  void LeaveLoss();  // to the result
  // Continues the cut where the attempt left it, for practice only: for whoever sees progress.
  bool may_go_on() const;
  void GoOnForPractice();
  void EndPractice();  // to the result, or to the exercise practised without the server
  void Back();         // one place back, if possible

 private:
  // This person's attempts at this station.
  struct Kept {
    Result<std::vector<SpooledAttempt>> cut_off, handed_in;
  };
  // The result shown, or to be shown once its person has signed in again.
  struct Shown {
    Uuid person, attempt;  // zero: none
    std::string title;
  };
  // A person signing in, whose one-time password is kept until another is chosen.
  struct SigningIn {
    std::string login, one_time;
  };
  void Go(Place place);
  void SignOutSpeaking(const std::string& why);
  BackgroundTask::After SignedIn(const Result<Person>& person, const SigningIn& who);
  void WhenFree(std::function<void()> step);
  void FreeAgain();
  Kept KeptOf(const Uuid& person);
  void ShowResult(Shown shown);
  void ForgetResult();
  const Catalogue::Profile* ProfileFor(const DeviceOffer& offer) const;
  void Fetch();
  void TakeOffers(std::vector<DeviceOffer> offers);
  void TakeExercises(Result<Catalogue> catalogue, Kept kept);
  void TakeOn(std::shared_ptr<Result<PreparedAttempt>> prepared, Way way);
  // In a background task, then `show` with what was opened: null for mouse and simulated hands.
  using ShowDevice = std::function<void(std::unique_ptr<Device>, const DevicePace&)>;
  // Opens the offered device and awaits its pace in the background. Null for one that is not attached.
  void OpenDevice(ShowDevice show);
  void ShowAttempt(std::unique_ptr<Device> attached, const DevicePace& pace);
  void ShowWarmUp(std::unique_ptr<Device> attached, const DevicePace& pace);
  void WatchWarmUp(Clock::time_point now);
  void TakeAttempt(std::unique_ptr<DeskAttempt> attempt);
  void TakeTicket();
  void RememberDevice();  // the one that is cut with, where it has motors
  void Begin();
  void Practise();
  // Reserved and interrupted attempts have their device profile in their signed ticket.
  bool any_device() const { return way_ == Way::kTicket || way_ == Way::kPractice; }
  void LookForKept();
  void LookForReserved();
  void LookForStillness();
  void HandInUnheld();
  void CheckDevice(Clock::time_point now);
  void WatchRun();
  void PauseWhenPutDown(Dialog dialog);
  void WatchPractice(Clock::time_point now);
  void WatchUpload();
  void WatchScore(Clock::time_point now);
  void WatchPictures();
  void PaintTooth();
  void PaintJudgement();
  void Take(const AttemptProgress& progress);
  void Fail(const Status& status);
  void FailToSignIn(const Status& status);
  void LeaveAttempt();
  void LeaveAttemptFor(const Status& problem);

  Workplace& workplace_;
  const WorkflowOptions options_;
  language::Words words_;
  bool left_handed_ = false;
  std::vector<DeviceOffer> offers_;
  Place place_ = Place::kSignIn;
  Dialog dialog_ = Dialog::kNone;
  std::string problem_, notice_;
  Person person_;
  SigningIn signing_in_;
  Catalogue catalogue_;
  Catalogue::Exercise chosen_;
  Way way_ = Way::kTicket;
  bool offline_ = false, as_reference_ = false, may_practise_ = false, lacks_realtime_ = false;
  std::vector<SpooledAttempt> cut_off_, handed_in_;
  std::vector<ReservedAttempt> reserved_;
  size_t offer_ = 0, cut_off_index_ = 0, reserved_index_ = 0;
  std::string picked_;              // title of the device that the person chose; empty: none
  std::string agreed_;              // and agreed to instead of the station's
  std::optional<LastDevice> last_;  // with motors, that somebody cut with here
  std::unique_ptr<PreparedAttempt> preview_;
  std::unique_ptr<DeskAttempt> attempt_;
  std::unique_ptr<DeskAttempt> left_;  // left while a background task may still use it
  std::function<void()> once_free_;
  Shown result_, come_back_to_;
  HandAlignment alignment_;
  std::optional<StillnessCheck> stillness_;
  uint64_t put_downs_ = 0;  // times the handpiece was put down that have been answered
  bool ticketed_ = false, joined_ = false, recorded_ = false, marked_ = false, held_back_ = false,
       needs_reason_ = false;
  bool needs_start_ = false, needs_end_ = false;  // a signature (Dialog::kSignOff)
  std::optional<AttemptProgress> progress_;
  std::optional<scoring::ScoreResult> score_;
  std::shared_ptr<LookBack> look_back_;  // at the result's attempt, once it was asked for
  Loss loss_shown_;
  std::unique_ptr<LossView> loss_;
  Clock::time_point started_ = Clock::now(), active_at_ = started_, next_look_{};
  // Of the result's pictures. Parts that were tried are not tried again.
  bool tooth_tried_ = false, judgement_tried_ = false;
  std::shared_ptr<const ResultSurfaces> surfaces_;
  std::unique_ptr<ResultPictures> pictures_;
  std::shared_ptr<std::atomic<bool>> pictures_wanted_;  // false: nobody looks at them any more
  BackgroundTask pictures_task_;                        // beside the other, which people wait for
  BackgroundTask task_;                                 // its thread ends before what it uses goes
};

}  // namespace enamel::station::desk
