#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/scoring/score.h"
#include "station/desk/errand.h"
#include "station/desk/stage.h"
#include "station/desk/stillness.h"

namespace enamel::station::desk {

enum class Place { kSignIn, kExercises, kExercise, kReady, kRunning, kHandIn, kResult };
enum class Dialog { kNone, kPaused, kFinish, kGiveUp, kReference, kClose };

// Where a person is on the way from sign-in to result, and the steps from there. The pages draw
// what is here and call the steps; steps that wait for the server run as an errand, and what went
// wrong is in `problem`, in words. Needs the OpenGL context current where a stage is made or left
// (Tick and the steps). Thread safety: the window's thread.
class Workflow {
 public:
  using Clock = std::chrono::steady_clock;

  // `workplace` outlives this.
  Workflow(Workplace& workplace, std::vector<DeviceOffer> offers, double idle_s);

  // Once a frame: outcomes of errands, ends of attempts. `active`: the person did something.
  void Tick(Clock::time_point now, bool active);

  // --- where ---
  Place place() const { return place_; }
  Dialog dialog() const { return dialog_; }
  const std::string& problem() const { return problem_; }
  bool busy() const { return errand_.busy(); }
  const std::string& errand() const { return errand_.what(); }
  const Person& person() const { return person_; }
  bool instructor() const { return person_.role != "student"; }
  const std::vector<Catalogue::Exercise>& exercises() const { return catalogue_.exercises; }
  size_t exercise_index() const { return exercise_; }
  const std::vector<DeviceOffer>& offers() const { return offers_; }
  size_t offer_index() const { return offer_; }
  // The exercise chosen, once fetched; from kReady on the stage has it.
  const PreparedAttempt* preview() const { return stage_ ? &stage_->prepared() : preview_.get(); }
  Stage* stage() { return stage_.get(); }
  const StillnessCheck* stillness() const { return stillness_ ? &*stillness_ : nullptr; }
  Uploader::State upload() const;
  uint32_t chunks() const;
  const std::optional<AttemptProgress>& progress() const { return progress_; }
  const std::optional<scoring::ScoreResult>& score() const { return score_; }
  // The score is there but not for this person yet.
  bool held_back() const { return held_back_; }
  bool marked_as_reference() const { return marked_; }
  Workplace& workplace() { return workplace_; }

  // --- steps ---
  void SignIn(const std::string& login, const std::string& password);
  void SignOut(const std::string& why = {});
  void Refresh();  // the exercises
  void ChooseExercise(size_t index);
  void ChooseOffer(size_t index);
  void Start(bool as_reference);
  void Open(Dialog dialog);
  void CloseDialog() { Open(Dialog::kNone); }
  void EndAttempt();   // finished, or given up: sealed as it is
  void LeaveHandIn();  // the upload goes on by itself
  void AnotherTry();
  void ToExercises();
  void MarkReference(const std::string& dentist, bool consent);
  void Back();  // one place back, where there is one
  void SetProblem(std::string problem) { problem_ = std::move(problem); }

 private:
  void Go(Place place);
  const Catalogue::Profile* ProfileFor(const DeviceOffer& offer) const;
  void Fetch();
  void ToStage(PreparedAttempt prepared, bool as_reference);
  void TakeTicket(bool as_reference);
  void CheckDevice(Clock::time_point now);
  void WatchRun();
  void WatchUpload();
  void WatchScore(Clock::time_point now);
  void Take(const AttemptProgress& progress);
  void Fail(const Status& status);
  void LeaveStage();

  Workplace& workplace_;
  const std::vector<DeviceOffer> offers_;
  const double idle_s_;
  Place place_ = Place::kSignIn;
  Dialog dialog_ = Dialog::kNone;
  std::string problem_;
  Person person_;
  Catalogue catalogue_;
  size_t exercise_ = 0, offer_ = 0;
  std::unique_ptr<PreparedAttempt> preview_;
  std::unique_ptr<Stage> stage_;
  std::optional<StillnessCheck> stillness_;
  bool ticketed_ = false, joined_ = false, marked_ = false, held_back_ = false;
  std::optional<AttemptProgress> progress_;
  std::optional<scoring::ScoreResult> score_;
  Clock::time_point started_ = Clock::now(), active_at_ = started_, next_look_{};
  Errand errand_;  // its thread ends before what it uses goes
};

}  // namespace enamel::station::desk
