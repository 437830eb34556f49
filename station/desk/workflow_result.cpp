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

void Workflow::ForgetResult() {
  loss_.reset();
  look_back_.reset();
  loss_shown_ = {};
  marked_ = held_back_ = needs_reason_ = false;
  progress_.reset();
  score_.reset();
  next_look_ = {};
}

}  // namespace enamel::station::desk
