// The pages of one attempt: ready, running, handing in, its result, and their dialogs.
#include <algorithm>
#include <cmath>

#include "common/language/score_text.h"
#include "station/desk/pages.h"
#include "station/desk/problem_words.h"
#include "station/desk/stop_sign.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {

void Pages::Ready() {
  ui_.Begin("ready", Column(0.2f, 0.7f, 0.6f));
  ui_.Title(Say("ready.title"));
  const StillnessCheck* check = flow_.stillness();
  // A simulated hand holds still by itself, and sampling it would advance its time.
  bool still = flow_.attempt() != nullptr && flow_.attempt()->simulated();
  ui_.Bar(Say(check != nullptr && !check->wanted().empty() ? check->wanted() : "ready.looking"),
          still || check == nullptr ? 1 : check->share());
  ui_.Note(Say("ready.text"));
  if (flow_.busy() || flow_.tooth_drawn()) {
    Busy();
  } else {
    ui_.Note(Say("ready.drawing"));
  }
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  ui_.Problem(flow_.problem());
  if (ui_.Button(Say("exercise.back")) || ui_.escape()) flow_.Back();
  ui_.End();
}

// Stays until the person dismisses it, because their hands are at the tooth; only a waiting message
// replaces it.
void Pages::Remark(RunningAttempt& run) {
  constexpr std::chrono::seconds kShown{10};
  const auto now = Workflow::Clock::now();
  if (said_ && ui_.pressed('R')) said_.reset();
  // Below a dialog nobody would see it.
  const bool free = !said_ || now - said_->since >= kShown;
  if (free && flow_.dialog() == Dialog::kNone) {
    if (auto next = run.remark()) {
      said_ = Said{std::move(*next), now};
      // Drawn in this frame, so the report to the server is true.
      run.RemarkShown(said_->remark.id);
    }
  }
  if (!said_) return;
  ui_.Remark(Say("remark.from", {{"name", said_->remark.from}}), said_->remark.text,
             Say("remark.put_away"));
}

// Keys and mouse belong to the handpiece here; only Esc and F are left for the window.
void Pages::Running() {
  ui_.Begin("running", Ui::OnFloor(0.38f));
  // The mouse is the handpiece, so it could not reach buttons.
  if (flow_.attempt()->by_pointer()) {
    ui_.OneLine(Say("running.keys"));
  } else {
    if (ui_.Button(Say("running.pause"))) flow_.Open(Dialog::kPaused);
    ui_.SameLine();
    if (ui_.Button(Say("running.finish"))) flow_.Open(Dialog::kFinish);
  }
  if (ui_.escape()) flow_.Open(Dialog::kPaused);
  if (ui_.pressed('F')) flow_.Open(Dialog::kFinish);
  if (RunningAttempt* run = flow_.attempt()->run()) Remark(*run);
  ui_.End();
}

void Pages::Paused() {
  RunningAttempt* run = flow_.attempt() != nullptr ? flow_.attempt()->run() : nullptr;
  // A person who put the handpiece down gets that message, not an error.
  const bool put_down = run != nullptr && run->snapshot().put_down;
  ui_.BeginDialog("paused", Say(put_down ? "paused.put_down" : "paused.title"),
                  Ui::Space::kIsThePedal);
  DrawStopSign(put_down ? Stop::kHolder : Stop::kPaused, ui_.Square(kSign_px));
  if (put_down) ui_.Text(Say("paused.in_holder"));
  ui_.Text(Say("paused.text"));
  if (run != nullptr) {
    ui_.Problem(FaultSentence(flow_.words(), run->snapshot().fault,
                              flow_.attempt()->device().problem(),
                              flow_.attempt()->lacks_realtime()));
  }
  ui_.Note(Say("paused.leave_text"));
  ui_.Gap(12);
  // While it is being left, nothing else can be chosen.
  const bool free = !flow_.busy();
  if (ui_.Button(Say("paused.go_on"), Ui::Look::kMain, free) || (free && ui_.escape())) {
    flow_.CloseDialog();
  }
  ui_.SameLine();
  if (ui_.Button(Say("running.finish"), Ui::Look::kPlain, free)) flow_.Open(Dialog::kFinish);
  ui_.SameLine();
  if (ui_.Button(Say("paused.leave"), Ui::Look::kPlain, free)) flow_.LeaveForNow();
  ui_.SameLine();
  if (ui_.Button(Say("paused.give_up"), Ui::Look::kDanger, free)) flow_.Open(Dialog::kGiveUp);
  ui_.EndDialog();
}

void Pages::AskFinish() {
  ui_.BeginDialog("finish", Say("finish.title"), Ui::Space::kIsThePedal);
  ui_.Text(Say("finish.text"));
  ui_.Gap(12);
  if (ui_.Button(Say("finish.go_on")) || ui_.escape()) flow_.CloseDialog();
  ui_.SameLine();
  if (ui_.Button(Say("finish.hand_in"), Ui::Look::kMain)) flow_.EndAttempt();
  ui_.EndDialog();
}

void Pages::AskGiveUp() {
  ui_.BeginDialog("give-up", Say("give_up.title"), Ui::Space::kIsThePedal);
  ui_.Text(Say("give_up.text"));
  ui_.Gap(12);
  if (ui_.Button(Say("finish.go_on"), Ui::Look::kMain) || ui_.escape()) flow_.CloseDialog();
  ui_.SameLine();
  if (ui_.Button(Say("paused.give_up"), Ui::Look::kDanger)) flow_.EndAttempt();
  ui_.EndDialog();
}

void Pages::HandIn() {
  ui_.Begin("hand-in", kHandInPage);
  ui_.Title(Say("hand_in.title"));
  Uploader::State up = flow_.upload();
  uint32_t chunks = flow_.chunks();
  const Status problem = flow_.recording_problem();
  // "100 % is on the server" would be true and misleading if the end is not stored.
  const bool partly = !problem.ok() || (!flow_.busy() && !flow_.recorded());
  const double share = chunks > 0 ? static_cast<double>(up.committed) / chunks : 0;
  // Rounded down: 100 % is all of it.
  const std::string percent = flow_.words().Decimal(std::floor(100 * share), 0);
  ui_.Bar(Say(partly ? "hand_in.share_without_end" : "hand_in.share", {{"percent", percent}}),
          share);
  ui_.Problem(flow_.problem());
  if (!problem.ok() && flow_.busy()) {
    // Still retrying: until then somebody can free space.
    DrawStopSign(Stop::kDisk, ui_.Square(kSign_px));
    ui_.Problem(Say("hand_in.cannot_store"));
    ui_.Gap(12);
    if (ui_.Button(Say("hand_in.give_up_end"), Ui::Look::kDanger)) flow_.GiveUpRecording();
  } else if (up.gave_up) {
    ui_.Problem(IsDamaged(up.problem)
                    ? Say("hand_in.damaged")
                    : Say("hand_in.refused", {{"reason", ProblemText(flow_.words(), up.problem)}}));
  } else if (!up.reachable) {
    ui_.Problem(Say("hand_in.away"));
  }
  ui_.Gap(12);
  // The recorder is still closing: leaving now would leave its loop and device running.
  bool may_leave = !flow_.busy();
  if (ui_.Button(Say("hand_in.leave"), Ui::Look::kPlain, may_leave) ||
      (may_leave && ui_.escape())) {
    flow_.LeaveHandIn();
  }
  if (!up.reachable) {
    ui_.SameLine();
    if (ui_.Button(Say("hand_in.again"))) flow_.TryAgainNow();
  }
  ui_.End();
}

void Pages::AskSignOff() {
  const bool end = flow_.signs_end();
  ui_.BeginDialog("sign-off", Say(end ? "sign_off.end" : "sign_off.start"));
  ui_.Text(Say(end ? "sign_off.end_text" : "sign_off.start_text"));
  if (ui_.Field(Say("sign_in.login"), signer_)) ui_.Focus(Say("pin.label"));
  bool go = ui_.Field(Say("pin.label"), pin_, true);
  ui_.Problem(flow_.problem());
  Busy();
  const bool free = !flow_.busy();
  go |= ui_.Button(Say("sign_off.sign"), Ui::Look::kMain, free);
  if (go && free && !signer_.empty() && !pin_.empty()) {
    flow_.SignOff(signer_, pin_);
    // Not kept after sending, whatever the server answers.
    pin_.clear();
    ui_.Focus(Say("pin.label"));
  }
  ui_.SameLine();
  // Esc, pressed by habit, must not hand in.
  if (ui_.Button(Say(end ? "sign_off.unsigned" : "exercise.back"), Ui::Look::kPlain, free) ||
      (free && !end && ui_.escape())) {
    flow_.LeaveSignOff();
  }
  ui_.EndDialog();
}

void Pages::Score(const scoring::ScoreResult& score) {
  ui_.Score(flow_.words().Decimal(score.score, 0), Say("result.of"));
  if (score.critical_fail) ui_.Problem(Say("result.failed"));
  // All below scrolls: beside pictures the page is narrow, and errors take many lines.
  ui_.BeginList("reasons");
  for (const scoring::CriticalResult& c : score.critical) {
    ui_.Problem(ReasonText(flow_.words(), c));
  }
  for (const scoring::CriticalResult& c : score.borderline) {
    ui_.Note(BorderlineText(flow_.words(), c));
  }
  ui_.Text(CountText(flow_.words(), score));
  const std::vector<Loss> losses = LossesOf(score);
  Losses({losses.begin(),
          losses.begin() + static_cast<std::ptrdiff_t>(std::min(losses.size(), kLossesShown))});
  ui_.Gap(8);
  for (const scoring::CriterionResult& c : score.criteria) {
    if (c.most > 0 || c.group != scoring::Group::kHand) Criterion(c);
  }
  if (score.beyond > kLossShown) {
    ui_.Note(Say("result.beyond", {{"points", NumberText(flow_.words(), score.beyond, 1)}}));
  }
  ui_.EndList();
}

// A group with its state, or a figure of the hand with its reason.
void Pages::Criterion(const scoring::CriterionResult& criterion) {
  const Words& words = flow_.words();
  const bool lost = criterion.lost > kLossShown;
  const bool hand = criterion.group == scoring::Group::kHand;
  std::string below;
  if (lost || !criterion.judged) below = hand ? DetailText(words, criterion) : "";
  if (!hand) below = language::StateText(words, criterion.state);
  ui_.Line(hand ? WordedTitle(words, criterion.title) : language::GroupText(words, criterion.group),
           LostText(words, criterion.lost), below, lost);
}

void Pages::Result() {
  const std::vector<Picture> pictures = PicturesOfResult();
  Ui::Page page = kWidePage;
  // Pictures come beside it, and buttons must not move then.
  page.width = 0.58f;
  ui_.Begin("result", page);
  ui_.Title(WordedTitle(flow_.words(), flow_.result_title()));
  ui_.Problem(flow_.problem());
  const auto& progress = flow_.progress();
  if (flow_.score()) {
    Score(*flow_.score());
  } else if (flow_.held_back()) {
    ui_.Gap();
    ui_.Large(Say("result.handed_in"));
    ui_.Text(Say("result.held_back"));
  } else if (progress && (progress->state == "failed" || progress->state == "quarantined")) {
    ui_.Gap();
    ui_.Large(Say("result.no_score"));
    ui_.Text(NoScoreText(flow_.words(), progress->problem));
    ui_.Note(Say("result.tell"));
  } else if (progress && (progress->state == "ticketed" || progress->state == "recording")) {
    ui_.Gap();
    ui_.Large(Say("result.on_its_way"));
    ui_.Text(Say("result.follows"));
  } else {
    ui_.Gap();
    ui_.Bar(Say("result.scoring"), progress ? progress->progress : 0);
  }
  ui_.Gap(8);
  ResultChoices();
  ui_.End();
  if (!pictures.empty())
    ui_.Pictures(pictures, {0.655f, 0.06f, 0.325f, 0.9f}, [this] { BelowPictures(); });
}

void Pages::ResultChoices() {
  const bool again = flow_.may_try_again();
  if (again && ui_.Button(Say("result.another"), Ui::Look::kMain)) return flow_.AnotherTry();
  ui_.SameLine();
  // Small: above them are the points, which people come for.
  if (flow_.may_go_on() && ui_.Button(Say("result.go_on"), Ui::Look::kSmall)) {
    return flow_.GoOnForPractice();
  }
  ui_.SameLine();
  if (ui_.Button(Say("result.exercises"), again ? Ui::Look::kSmall : Ui::Look::kMain) ||
      ui_.escape()) {
    return flow_.ToExercises();
  }
  ui_.SameLine();
  if (ui_.Button(Say("exercises.sign_out"), Ui::Look::kSmall)) return flow_.SignOut();
  // Only a scored attempt can be a reference; the server checks this too.
  bool scored = flow_.progress() && flow_.progress()->state == "scored";
  if (!flow_.instructor() || !scored) return;
  ui_.SameLine();
  if (ui_.Button(Say(flow_.marked_as_reference() ? "result.is_reference" : "result.reference"),
                 Ui::Look::kSmall, !flow_.marked_as_reference())) {
    // A proposal: most instructors cut their own reference.
    dentist_ = flow_.person().display_name;
    anyway_.clear();
    flow_.Open(Dialog::kReference);
  }
}

void Pages::AskReference() {
  ui_.BeginDialog("reference", Say("reference.title"));
  ui_.Text(Say("reference.text"));
  ui_.Field(Say("reference.dentist"), dentist_);
  ui_.Check(Say("reference.consent"), consent_);
  ui_.Problem(flow_.problem());
  // Only after a refusal: most cuts made for this need no reason.
  const bool why = flow_.reference_needs_reason();
  if (why) ui_.Field(Say("reference.anyway"), anyway_);
  ui_.Gap(12);
  if (ui_.Button(Say(why ? "reference.make_anyway" : "reference.make"), Ui::Look::kMain,
                 consent_ && !dentist_.empty() && !(why && anyway_.empty()) && !flow_.busy())) {
    flow_.MarkReference(dentist_, consent_, why ? anyway_ : "");
  }
  ui_.SameLine();
  if (ui_.Button(Say("pin.leave")) || ui_.escape()) flow_.CloseDialog();
  ui_.EndDialog();
}

}  // namespace enamel::station::desk
