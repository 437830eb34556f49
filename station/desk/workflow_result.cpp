// What the result page shows of an attempt beside its score.
#include <stdexcept>
#include <utility>

#include "station/desk/workflow.h"

namespace enamel::station::desk {

void Workflow::ShowLoss(const Loss& loss) {
  const bool there = place_ == Place::kResult || place_ == Place::kLoss;
  if (busy() || !there || loss.place == nullptr) return;
  problem_.clear();
  loss_shown_ = loss;
  task_.Start("task.loss",
              [this, attempt = result_.attempt, person = person_.id, back = look_back_,
               place = *loss.place]() mutable -> BackgroundTask::After {
                if (back == nullptr) {
                  auto opened = workplace_.LookBackAt(attempt);
                  if (!opened.ok()) return [this, s = opened.status()] { Fail(s); };
                  back = std::move(*opened);
                }
                const ShownTicks ticks = TicksToShow(place, back->prepared().header.params.rate_hz);
                auto stretch = std::make_shared<Result<Stretch>>(
                    // Nobody waits for it once its person has signed out.
                    back->Take(ticks.from, ticks.to, [this, person](double) {
                      const auto signed_in = workplace_.person();
                      return signed_in && signed_in->id == person;
                    }));
                return [this, back, stretch, place] {
                  look_back_ = back;
                  if (!stretch->ok()) return Fail(stretch->status());
                  try {
                    loss_ =
                        std::make_unique<LossView>(back->prepared(), std::move(**stretch), place);
                  } catch (const std::exception& e) {
                    return Fail(Status(Code::kUnavailable, e.what(), "window"));
                  }
                  Go(Place::kLoss);
                };
              });
}

void Workflow::LeaveLoss() {
  if (busy()) task_.Forget();
  loss_.reset();
  Go(Place::kResult);
}

bool Workflow::may_try_again() const {
  if (chosen_.attempt_limit == 0) return true;
  // The list is older than this attempt.
  const uint32_t used = attempt_ && way_ == Way::kTicket ? 1 : 0;
  return chosen_.attempts_left > used;
}

bool Workflow::may_go_on() const {
  const bool ended = attempt_ && attempt_->run() && joined_ && recorded_;
  // A simulated hand has finished.
  return place_ == Place::kResult && ended && !attempt_->simulated() &&
         MayShowProgress(attempt_->prepared().exercise.graded, chosen_.exam, instructor());
}

void Workflow::GoOnForPractice() {
  if (!busy() && may_go_on()) Practise();
}

void Workflow::Practise() {
  put_downs_ = 0;
  attempt_->Rehearse(options_.cpu);
  Go(Place::kPractice);
}

void Workflow::WatchPractice(Clock::time_point now) {
  PauseWhenPutDown(Dialog::kPracticePaused);
  // A hand that cuts uses neither mouse nor keyboard.
  if ((attempt_->newest().input_flags & core::kBurOn) != 0) active_at_ = now;
  if (!attempt_->rehearsal()->ticking()) EndPractice();
}

void Workflow::EndPractice() {
  if (place_ != Place::kPractice) return;
  attempt_->rehearsal()->End();
  if (way_ == Way::kPractice) {
    // The cut is not kept. Its device may be another one next time.
    LeaveAttempt();
    Go(Place::kExercise);
    return LookForDevices();
  }
  attempt_->held().SetPaused(false);
  Go(Place::kResult);
}

// Beside everything else: nobody waits for pictures. Where there are none, the page says nothing.
void Workflow::WatchPictures() {
  if (pictures_task_.busy()) return;
  if (!tooth_tried_) return PaintTooth();
  if (surfaces_ && score_ && !judgement_tried_) PaintJudgement();
}

void Workflow::PaintTooth() {
  tooth_tried_ = true;
  pictures_wanted_ = std::make_shared<std::atomic<bool>>(true);
  pictures_task_.Start(
      "task.loss",
      [this, attempt = result_.attempt, wanted = pictures_wanted_]() -> BackgroundTask::After {
        auto opened = workplace_.LookBackAt(attempt);
        if (!opened.ok()) return {};
        std::shared_ptr<LookBack> back = std::move(*opened);
        auto surfaces = SurfacesOf(*back, [wanted](double) { return wanted->load(); });
        if (!surfaces.ok()) return {};
        return [this, back, made = std::make_shared<ResultSurfaces>(std::move(*surfaces))] {
          if (look_back_ == nullptr) look_back_ = back;
          surfaces_ = made;
          try {
            pictures_ = std::make_unique<ResultPictures>(*made);
          } catch (const std::exception&) {
            surfaces_.reset();
          }
        };
      });
}

// The server gives the deviation to whoever may see the score.
void Workflow::PaintJudgement() {
  judgement_tried_ = true;
  pictures_task_.Start(
      "task.loss",
      [this, attempt = result_.attempt, back = look_back_,
       surfaces = surfaces_]() -> BackgroundTask::After {
        auto target = std::make_shared<render::GroupMesh>(TargetSurface(back->prepared()));
        auto off = std::make_shared<std::optional<render::GroupMesh>>();
        if (const auto bytes = workplace_.Deviation(attempt); bytes.ok()) {
          auto mesh = DeviationSurface(surfaces->after_surface, surfaces->after_cells, *bytes);
          if (mesh.ok()) *off = std::move(*mesh);
        }
        return [this, target, off] {
          try {
            pictures_->Add(*target, *off);
          } catch (const std::exception&) {
            // The driver refuses: the others stay.
          }
        };
      });
}

void Workflow::ForgetResult() {
  if (pictures_wanted_) *pictures_wanted_ = false;
  pictures_task_.Forget();
  pictures_.reset();
  surfaces_.reset();
  tooth_tried_ = judgement_tried_ = false;
  loss_.reset();
  look_back_.reset();
  loss_shown_ = {};
  marked_ = held_back_ = needs_reason_ = false;
  progress_.reset();
  score_.reset();
  next_look_ = {};
}

}  // namespace enamel::station::desk
