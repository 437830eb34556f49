// Trying a device on a block, before an attempt: its page, and its steps.
#include "station/desk/warm_up.h"

#include <utility>

#include "common/scene/builtin/builtin.h"
#include "common/scene/plan.h"
#include "station/desk/pages.h"
#include "station/desk/workflow.h"
#include "station/session/device_delay.h"
#include "station/session/hand_turn.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
namespace {

// Coarse: it is there at once, and what a hand feels is the law's, not the voxels'.
constexpr int32_t kBlockVoxel_nm = 150'000;

}  // namespace

Result<PreparedAttempt> WarmUpFor(const PreparedAttempt& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(auto block, scene::BuildBuiltinScene("block", kBlockVoxel_nm));
  PreparedAttempt out;
  out.exercise = exercise.exercise;
  // Of this block, with any bur.
  out.exercise.scene = {};
  block.scene.burs.clear();
  out.exercise.target = scene::ClassOneExercise(block.scene, {}).target;
  out.exercise.time_limit_s = 0;
  out.exercise.graded = false;
  out.terms.outline = true;
  out.profile = exercise.profile;
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(block.scene, out.exercise, out.profile));
  out.header = {{}, {}, block.scene.volume, params, SoftwareName(), {}};
  out.scene = std::move(block.scene);
  out.volume = std::move(block.volume);
  return out;
}

std::string WarmUpText(const language::Words& words, const UnrecordedRun::Found& found) {
  if (found.turning_s == 0 && found.faults == 0) return words.Say("warm_up.still");
  const std::string text =
      words.Say("warm_up.found", {{"seconds", NumberText(words, found.turning_s, 1)},
                                  {"late", static_cast<int64_t>(found.late_ticks)},
                                  {"force", words.Decimal(found.peak_force_n, 1)}});
  if (found.faults == 0) return text;
  return words.Say("warm_up.faults",
                   {{"found", text}, {"faults", static_cast<int64_t>(found.faults)}});
}

std::string AlignmentText(const language::Words& words, const HandAlignment& alignment) {
  if (alignment.awaits_hand()) return words.Say("warm_up.align_move");
  const auto& found = alignment.found();
  if (!found) return "";
  if (!found->IsAskew()) return words.Say("warm_up.aligned");
  return found->askew_deg > 0
             ? words.Say("warm_up.askew_clockwise", {{"degrees", found->askew_deg}})
             : words.Say("warm_up.askew_counter_clockwise", {{"degrees", -found->askew_deg}});
}

void Workflow::TryDevice() {
  if (busy() || place_ != Place::kExercise || !preview_ || offer_ >= offers_.size()) return;
  problem_.clear();
  OpenDevice([this](std::unique_ptr<Device> attached, const DevicePace& pace) {
    ShowWarmUp(std::move(attached), pace);
  });
}

void Workflow::ShowWarmUp(std::unique_ptr<Device> attached, const DevicePace& pace) {
  auto block = WarmUpFor(*preview_);
  if (!block.ok()) return Fail(block.status());
  if (attached != nullptr) {
    if (Status used = UseDelayOf(*block, *attached, pace, workplace_.data()); !used.ok())
      return Fail(used);
  }
  auto attempt =
      DeskAttempt::Create(std::move(*block), offers_[offer_], std::move(attached), false);
  if (!attempt.ok()) return Fail(attempt.status());
  TakeAttempt(std::move(*attempt));
  alignment_ = {};
  Go(Place::kWarmUp);
}

void Workflow::AlignHand() {
  if (place_ == Place::kWarmUp) alignment_.Begin(attempt_->hand_m());
}

void Workflow::WatchWarmUp(Clock::time_point now) {
  UnrecordedRun* run = attempt_->rehearsal();
  if (run == nullptr) {
    started_ = now;
    if (tooth_drawn()) attempt_->Rehearse(options_.cpu);
    return;
  }
  attempt_->held().SetPaused(dialog_ != Dialog::kNone);
  if (alignment_.Look(attempt_->hand_m())) {
    const int turn_deg = alignment_.found()->turn_deg;
    attempt_->StandsTurned(turn_deg);
    const Status kept = KeepHandTurn(workplace_.data(), attempt_->device(), turn_deg);
    if (!kept.ok()) Fail(kept);
  }
  const double waited_s = std::chrono::duration<double>(now - started_).count();
  const UnrecordedRun::Found found = run->found();
  // A simulated hand ends by itself.
  if (found.turning_s >= kWarmUp_s || waited_s > kWarmUp_s + kWarmUpWait_s || !run->ticking()) {
    EndWarmUp();
  }
}

void Workflow::EndWarmUp() {
  if (place_ != Place::kWarmUp) return;
  UnrecordedRun* run = attempt_->rehearsal();
  const std::string text = run == nullptr ? std::string() : WarmUpText(words_, run->found());
  LeaveAttempt();
  Go(Place::kExercise);
  notice_ = text;
}

void Pages::WarmUp() {
  DeskAttempt& attempt = *flow_.attempt();
  const bool can_align = attempt.turns_with_view();
  ui_.Begin("warm-up", Ui::OnFloor(0.38f));
  const std::string alignment = AlignmentText(flow_.words(), flow_.alignment());
  if (alignment.empty()) {
    ui_.OneLine(Say("warm_up.keys"));
  } else {
    ui_.Text(alignment);
  }
  UnrecordedRun* run = attempt.rehearsal();
  ui_.Bar(Say("warm_up.text"), run == nullptr ? 0 : run->found().turning_s / kWarmUp_s);
  const bool awaits_hand = flow_.alignment().awaits_hand();
  if (can_align && ui_.Button(Say("warm_up.align"), Ui::Look::kSmall, !awaits_hand)) {
    flow_.AlignHand();
  }
  ui_.SameLine();
  // The mouse is free where it is not the handpiece.
  const bool back =
      !attempt.by_pointer() &&
      ui_.Button(Say("exercise.back"), can_align ? Ui::Look::kSmall : Ui::Look::kPlain);
  if (back || ui_.escape()) flow_.EndWarmUp();
  ui_.End();
}

}  // namespace enamel::station::desk
