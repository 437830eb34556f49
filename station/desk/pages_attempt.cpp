// The pages of one attempt: ready, running, handing in, its result, and their dialogs.
#include <cstdio>

#include "station/desk/pages.h"

namespace enamel::station::desk {
namespace {

std::string Points(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  std::string out = text;
  if (out.size() > 2 && out.ends_with(".0")) out.resize(out.size() - 2);
  return out;
}

}  // namespace

std::string WorstWall(const scoring::ScoreResult& score) {
  const scoring::CriterionResult* worst = nullptr;
  for (const scoring::CriterionResult& c : score.criteria) {
    bool wall = c.name.starts_with("wall_") || c.name == "floor_mm";
    double lost = c.max_points - c.points;
    if (!wall || lost <= 0) continue;
    if (worst == nullptr || lost > worst->max_points - worst->points) worst = &c;
  }
  return worst != nullptr ? worst->reason : "";
}

void Pages::Ready() {
  ui_.Begin("ready", {0.2f, 0.3f, 0.6f, 0.5f, false});
  ui_.Title("Hold still");
  const StillnessCheck* check = flow_.stillness();
  // A simulated hand holds still by itself, and looking at it would make its time pass.
  bool still = flow_.attempt() != nullptr && flow_.attempt()->simulated();
  ui_.Bar(
      check != nullptr && !check->wanted().empty() ? check->wanted() : "The device is looked at",
      still || check == nullptr ? 1 : check->share());
  ui_.Note("The bur and its force come on once the handpiece has rested in the air.");
  if (flow_.busy() || flow_.tooth_drawn()) {
    Busy();
  } else {
    ui_.Note("Drawing the tooth …");
  }
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  ui_.Problem(flow_.problem());
  if (ui_.Button("Back") || ui_.escape()) flow_.Back();
  ui_.End();
}

// Keys and mouse belong to the handpiece here; Esc and F are all that is left for the window.
void Pages::Running() {
  Ui::Page page{0.605f, 0.79f, 0.38f, 0.12f, true};
  page.keys = false;
  ui_.Begin("running", page);
  // The mouse is the handpiece: buttons could not be reached with it.
  if (flow_.attempt()->by_pointer()) {
    ui_.Large("Esc pause    F finish");
  } else {
    if (ui_.Button("Pause")) flow_.Open(Dialog::kPaused);
    ui_.SameLine();
    if (ui_.Button("Finish")) flow_.Open(Dialog::kFinish);
  }
  if (ui_.escape()) flow_.Open(Dialog::kPaused);
  if (ui_.pressed('F')) flow_.Open(Dialog::kFinish);
  ui_.End();
}

void Pages::Paused() {
  RunningAttempt* run = flow_.attempt() != nullptr ? flow_.attempt()->run() : nullptr;
  // Whoever put the handpiece down is told so, and not that something is wrong.
  const bool put_down = run != nullptr && run->snapshot().put_down;
  ui_.BeginDialog("paused", put_down ? "Paused: handpiece put down" : "Paused",
                  Ui::Space::kIsThePedal);
  if (put_down) ui_.Text("It lies in its holder: take it up to go on cutting, or finish.");
  ui_.Text("The bur is off. The clock and the recording go on.");
  ui_.Gap(12);
  if (ui_.Button("Go on", Ui::Look::kMain) || ui_.escape()) flow_.CloseDialog();
  ui_.SameLine();
  if (ui_.Button("Finish")) flow_.Open(Dialog::kFinish);
  ui_.SameLine();
  if (ui_.Button("Give up", Ui::Look::kDanger)) flow_.Open(Dialog::kGiveUp);
  ui_.EndDialog();
}

void Pages::AskFinish() {
  ui_.BeginDialog("finish", "Finish and hand in?", Ui::Space::kIsThePedal);
  ui_.Text("It is scored as it is now; afterwards nothing can be changed.");
  ui_.Gap(12);
  if (ui_.Button("Go on cutting") || ui_.escape()) flow_.CloseDialog();
  ui_.SameLine();
  if (ui_.Button("Hand in", Ui::Look::kMain)) flow_.EndAttempt();
  ui_.EndDialog();
}

void Pages::AskGiveUp() {
  ui_.BeginDialog("give-up", "Give up this attempt?", Ui::Space::kIsThePedal);
  ui_.Text("What was cut so far is kept and counts as an attempt. It cannot be taken back.");
  ui_.Gap(12);
  if (ui_.Button("Go on cutting", Ui::Look::kMain) || ui_.escape()) flow_.CloseDialog();
  ui_.SameLine();
  if (ui_.Button("Give up", Ui::Look::kDanger)) flow_.EndAttempt();
  ui_.EndDialog();
}

void Pages::HandIn() {
  ui_.Begin("hand-in", {0.15f, 0.2f, 0.7f, 0.7f, false});
  ui_.Title("Handing in");
  Uploader::State up = flow_.upload();
  uint32_t chunks = flow_.chunks();
  const Status problem = flow_.recording_problem();
  // "All parts are on the server" would be true and wrong where its end is not stored.
  const bool partly = !problem.ok() || (!flow_.busy() && !flow_.recorded());
  ui_.Bar(
      std::to_string(up.committed) + " of " + std::to_string(chunks) + " parts " +
          (partly ? "stored here are on the server; its end is not stored" : "are on the server"),
      chunks > 0 ? static_cast<double>(up.committed) / chunks : 0);
  ui_.Problem(flow_.problem());
  if (!problem.ok() && flow_.busy()) {
    // Still being tried: who can free space has until then.
    ui_.Problem("The end of this recording cannot be stored: " + problem.message() +
                ". It is kept in memory and tried again until then.");
    if (ui_.Button("Give up its end", Ui::Look::kDanger)) flow_.GiveUpRecording();
  } else if (up.gave_up) {
    ui_.Problem((IsDamaged(up.problem) ? "Not all of this recording can be read from this station: "
                                       : "The server does not take this recording: ") +
                up.problem.message());
  } else if (!up.reachable) {
    ui_.Problem(
        "The server is away. The recording is safe on this station and is sent when the "
        "server is back; you need not wait.");
  }
  ui_.Gap(12);
  // The recorder is still closing: leaving now would leave its loop and device running.
  bool may_leave = !flow_.busy();
  if (ui_.Button("Do not wait", Ui::Look::kPlain, may_leave) || (may_leave && ui_.escape())) {
    flow_.LeaveHandIn();
  }
  if (!up.reachable) {
    ui_.SameLine();
    if (ui_.Button("Try again now")) flow_.TryAgainNow();
  }
  ui_.End();
}

void Pages::Score(const scoring::ScoreResult& score) {
  char text[16];
  std::snprintf(text, sizeof text, "%.0f", score.score);
  ui_.Score(text, " of 100 points");
  if (score.critical_fail) ui_.Problem("Failed: a critical criterion was not met.");
  for (const scoring::GateResult& g : score.gates) {
    if (g.share < 1) ui_.Problem(g.reason);
  }
  if (std::string worst = WorstWall(score); !worst.empty()) ui_.Text("Worst: " + worst);
  ui_.BeginList("reasons", 140);
  for (const scoring::CriterionResult& c : score.criteria) {
    if (c.max_points == 0) continue;  // not in this exercise
    ui_.Line(c.title, Points(c.points) + " of " + Points(c.max_points),
             // Half of the tenth that is shown: "10 of 10" with a reason would be a riddle.
             c.max_points - c.points > 0.05 ? c.reason : "", c.points + 0.05 < c.max_points);
  }
  ui_.EndList();
}

void Pages::Result() {
  ui_.Begin("result", kWidePage);
  ui_.Title(flow_.result_title());
  ui_.Problem(flow_.problem());
  const auto& progress = flow_.progress();
  if (flow_.score()) {
    Score(*flow_.score());
  } else if (flow_.held_back()) {
    ui_.Gap();
    ui_.Large("Handed in.");
    ui_.Text(
        "This exercise is graded: your instructor releases the score. You then find it on the "
        "page.");
  } else if (progress && (progress->state == "failed" || progress->state == "quarantined")) {
    ui_.Gap();
    ui_.Large("Handed in, no score yet");
    ui_.Text("The server has the recording. It says: " + progress->problem + ".");
    ui_.Note("Nothing is lost. Tell your instructor when it should have been scored.");
  } else if (progress && (progress->state == "ticketed" || progress->state == "recording")) {
    ui_.Gap();
    ui_.Large("On its way to the server");
    ui_.Text("The recording is safe on this station and is sent; the score follows by itself.");
  } else {
    ui_.Gap();
    ui_.Bar("The server cuts the tooth again from the recording and scores it",
            progress ? progress->progress : 0);
  }
  ui_.Gap(8);
  ResultChoices();
  ui_.End();
}

void Pages::ResultChoices() {
  if (ui_.Button("Another try", Ui::Look::kMain)) return flow_.AnotherTry();
  ui_.SameLine();
  if (ui_.Button("Exercises") || ui_.escape()) return flow_.ToExercises();
  ui_.SameLine();
  if (ui_.Button("Sign out")) return flow_.SignOut();
  // Only a scored attempt can be one that others are compared with; the server checks it too.
  bool scored = flow_.progress() && flow_.progress()->state == "scored";
  if (!flow_.instructor() || !scored) return;
  ui_.SameLine();
  if (ui_.Button(flow_.marked_as_reference() ? "Is the reference" : "Reference", Ui::Look::kPlain,
                 !flow_.marked_as_reference())) {
    // A proposal: most instructors cut their own reference.
    dentist_ = flow_.person().display_name;
    flow_.Open(Dialog::kReference);
  }
}

void Pages::AskReference() {
  ui_.BeginDialog("reference", "Make it the reference?");
  ui_.Text("Attempts at this exercise are compared with this cut from now on.");
  ui_.Field("Dentist, as students will read it", dentist_);
  ui_.Check("The dentist agrees to being named and to the cut being used", consent_);
  ui_.Problem(flow_.problem());
  ui_.Gap(12);
  if (ui_.Button("Make it the reference", Ui::Look::kMain,
                 consent_ && !dentist_.empty() && !flow_.busy())) {
    flow_.MarkReference(dentist_, consent_);
  }
  ui_.SameLine();
  if (ui_.Button("Leave it") || ui_.escape()) flow_.CloseDialog();
  ui_.EndDialog();
}

}  // namespace enamel::station::desk
