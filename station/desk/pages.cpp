#include "station/desk/pages.h"

#include <algorithm>

#include "common/base/unix_time.h"

namespace enamel::station::desk {
namespace {

// "3 days", "5 hours", "1 minute".
std::string SpanText(int64_t span_ms) {
  int64_t minutes = std::max<int64_t>(span_ms, 0) / 60'000;
  // From two on, so that no span is told as one day when it is nearly two.
  if (minutes >= 2 * 24 * 60) return std::to_string(minutes / (24 * 60)) + " days";
  if (minutes == 0) return "less than a minute";
  if (minutes >= 2 * 60) return std::to_string(minutes / 60) + " hours";
  return std::to_string(minutes) + (minutes == 1 ? " minute" : " minutes");
}

}  // namespace

std::string AssignmentText(const Catalogue::Exercise& exercise, int64_t now_unix_ms) {
  if (!exercise.refusal.empty()) return exercise.refusal;
  std::string out;
  auto add = [&](const std::string& words) { out += (out.empty() ? "" : ", ") + words; };
  if (int64_t left_min = (exercise.due_unix_ms - now_unix_ms) / 60'000; exercise.due_unix_ms > 0) {
    if (left_min < 0)
      add("past due: counts as late");
    else
      add("due in " + SpanText(exercise.due_unix_ms - now_unix_ms));
  }
  if (exercise.attempt_limit > 0) {
    uint32_t left = exercise.attempts_left;
    add(std::to_string(left) + (left == 1 ? " attempt left" : " attempts left"));
  }
  return out.empty() ? "as often as you like" : out;
}

std::string CutOffText(const SpooledAttempt& attempt, int64_t now_unix_ms) {
  return std::to_string(attempt.chunks) + " parts recorded on " + attempt.profile + ", begun " +
         SpanText(now_unix_ms - attempt.created_unix_ms) + " ago";
}

std::string HandedInText(const SpooledAttempt& attempt, int64_t now_unix_ms) {
  return std::string(attempt.complete() ? "Handed in" : "Not all of it is on the server yet") +
         ", made " + SpanText(now_unix_ms - attempt.created_unix_ms) + " ago on " + attempt.profile;
}

std::string ReservedText(const ReservedAttempt& reserved, int64_t now_unix_ms) {
  return reserved.ticket.person + ", on " + reserved.ticket.profile + ", " +
         SpanText(reserved.ticket.expires_unix_ms - now_unix_ms) + " left";
}

void Pages::Busy() {
  if (flow_.busy()) {
    ui_.Note(flow_.task() + " …");
  } else {
    // As high as the line it takes the place of: buttons below must not jump under a finger.
    ui_.Note(" ");
  }
}

bool Pages::Draw() {
  // What was typed belongs to who typed it: the next person at this window must not find it.
  if (flow_.place() != before_) {
    password_.clear();
    dentist_.clear();
    consent_ = false;
    // A login stays through a wrong password, and goes with its person.
    if (flow_.place() == Place::kSignIn) login_.clear();
    before_ = flow_.place();
  }
  if (flow_.dialog() != dialog_before_) {
    // A PIN never outlives its dialog.
    pin_.clear();
    pin_again_.clear();
    dialog_before_ = flow_.dialog();
  }
  switch (flow_.place()) {
    case Place::kSignIn:
      SignIn();
      break;
    case Place::kReserved:
      Reserved();
      break;
    case Place::kExercises:
      Exercises();
      break;
    case Place::kExercise:
      Exercise();
      break;
    case Place::kReady:
      Ready();
      break;
    case Place::kRunning:
      Running();
      break;
    case Place::kHandIn:
      HandIn();
      break;
    case Place::kResult:
      Result();
      break;
  }
  bool close = false;
  switch (flow_.dialog()) {
    case Dialog::kNone:
      break;
    case Dialog::kPaused:
      Paused();
      break;
    case Dialog::kFinish:
      AskFinish();
      break;
    case Dialog::kGiveUp:
      AskGiveUp();
      break;
    case Dialog::kReference:
      AskReference();
      break;
    case Dialog::kReserve:
      AskReserve();
      break;
    case Dialog::kPin:
      AskPin();
      break;
    case Dialog::kCutOff:
      AskCutOff();
      break;
    case Dialog::kClose:
      close = AskClose();
      break;
  }
  ui_.EndFrame();
  return close;
}

void Pages::SignIn() {
  ui_.Begin("sign-in", {0.27f, 0.10f, 0.46f, 0.86f, false});
  ui_.Title("Enamel");
  ui_.Note("Station " + station_ + ". Sign in with the login your school gave you.");
  ui_.Gap();
  bool go = ui_.Field("Login", login_);
  // Enter in the first field goes on to the second.
  if (go && password_.empty()) {
    ui_.Focus("Password");
    go = false;
  }
  go |= ui_.Field("Password", password_, true);
  ui_.Gap(12);
  go |= ui_.Button(flow_.busy() ? "Signing in …" : "Sign in", Ui::Look::kMain, !flow_.busy());
  ui_.Gap(8);
  ui_.Problem(flow_.problem());
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  bool offline = !flow_.reserved().empty() &&
                 ui_.Button("Without the server", Ui::Look::kPlain, !flow_.busy());
  ui_.Note("Esc closes the station, F1 shows how it is.");
  if (go) {
    flow_.SignIn(login_, password_);
    // Kept nowhere once it was sent, whatever the server says to it.
    password_.clear();
  }
  if (offline) flow_.ToReserved();
  if (ui_.escape()) flow_.Open(Dialog::kClose);
  ui_.End();
}

void Pages::Exercises() {
  ui_.Begin("exercises", kWidePage);
  ui_.Title("Hello, " + flow_.person().display_name);
  ui_.Note("Choose what to practise. Tab or the arrow keys move, Enter chooses.");
  ui_.Problem(flow_.problem());
  ui_.BeginList("exercises", 180);
  for (size_t i = 0; i < flow_.cut_off().size(); ++i) {
    const SpooledAttempt& attempt = flow_.cut_off()[i];
    if (ui_.Row("Cut off: " + flow_.TitleOf(attempt), CutOffText(attempt, UnixMs()), "GO ON")) {
      flow_.OpenCutOff(i);
    }
  }
  const auto& all = flow_.exercises();
  for (size_t i = 0; i < all.size(); ++i) {
    std::string detail = AssignmentText(all[i], UnixMs());
    if (ui_.Row(all[i].title, detail, all[i].exam ? "EXAM" : "")) flow_.ChooseExercise(i);
  }
  for (size_t i = 0; i < flow_.handed_in().size(); ++i) {
    const SpooledAttempt& attempt = flow_.handed_in()[i];
    if (ui_.Row("Result: " + flow_.TitleOf(attempt), HandedInText(attempt, UnixMs()), "LOOK")) {
      flow_.OpenHandedIn(i);
    }
  }
  if (all.empty() && !flow_.busy()) {
    ui_.Text("There is nothing for you here yet. An instructor assigns exercises to your cohort.");
  }
  ui_.EndList();
  Busy();
  if (ui_.Button("Look again", Ui::Look::kPlain, !flow_.busy())) flow_.Refresh();
  ui_.SameLine();
  if (ui_.Button("Sign out") || ui_.escape()) flow_.SignOut();
  ui_.End();
}

void Pages::ExerciseFacts(const PreparedAttempt& prepared) {
  const scene::Exercise& e = prepared.exercise;
  ui_.Text(e.instructions.empty() ? "No instructions." : e.instructions);
  ui_.Gap(8);
  std::string facts = prepared.scene.title;
  facts += e.graded ? ". Graded: the score is released by your instructor"
                    : ". Practice: the score is shown at once";
  if (e.time_limit_s > 0) facts += ". " + render::TimerText(e.time_limit_s) + " minutes";
  ui_.Note(facts + ".");
}

void Pages::Exercise() {
  ui_.Begin("exercise", kWidePage);
  const Catalogue::Exercise& ref = flow_.chosen();
  ui_.Title(ref.title);
  if (ref.exam) ui_.Note("An exam: no score is shown before your instructor releases it.");
  ui_.Problem(flow_.problem().empty() ? ref.refusal : flow_.problem());
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  const PreparedAttempt* prepared = flow_.preview();
  ui_.BeginList("facts", flow_.instructor() ? 190 : 130);
  if (prepared != nullptr) {
    ExerciseFacts(*prepared);
    ui_.Gap(10);
    cutting::Bur bur = prepared->exercise.bur().metric();
    ui_.Text("Bur: " + BurText(bur));
    DrawBur(bur, 900 * ui_.px(), 170 * ui_.px(), 40 * ui_.px());
  } else {
    Busy();
  }
  ui_.Gap(10);
  Devices();
  ui_.EndList();
  if (flow_.instructor() && flow_.way() == Way::kTicket) {
    ui_.Check("A reference cut: what students are compared with later", as_reference_);
  }
  ExerciseChoices(prepared != nullptr);
  ui_.End();
}

void Pages::Devices() {
  ui_.Text("Device");
  for (size_t i = 0; i < flow_.offers().size(); ++i) {
    const DeviceOffer& offer = flow_.offers()[i];
    // A device that cannot be chosen for this attempt would only raise a question.
    if (!flow_.Fits(offer)) continue;
    bool mine = i == flow_.offer_index();
    bool usable = offer.problem.empty();
    if (ui_.Row(offer.title, usable ? offer.detail : offer.problem,
                mine ? "in use" : (usable ? "" : "not usable"), mine)) {
      flow_.ChooseOffer(i);
    }
  }
}

void Pages::ExerciseChoices(bool prepared) {
  bool has_device = flow_.offer_index() < flow_.offers().size();
  bool ready = prepared && has_device && !flow_.busy() && flow_.chosen().refusal.empty();
  bool resumed = flow_.way() == Way::kResumed;
  if (ui_.Button(resumed ? "Go on cutting" : "Start", Ui::Look::kMain, ready)) {
    // The box is only there for instructors, and its state outlives a sign-out.
    flow_.Start(as_reference_ && flow_.instructor());
  }
  ui_.SameLine();
  // An exam begins while the server is there; one that was kept for later is kept already.
  if (flow_.way() == Way::kTicket && !flow_.chosen().exam) {
    if (ui_.Button("Keep for later", Ui::Look::kPlain, ready)) flow_.Open(Dialog::kReserve);
    ui_.SameLine();
  }
  if (ui_.Button("Find devices", Ui::Look::kPlain, !flow_.busy())) flow_.LookForDevices();
  ui_.SameLine();
  if (ui_.Button("Back") || ui_.escape()) flow_.Back();
}

void Pages::Reserved() {
  ui_.Begin("reserved", kWidePage);
  ui_.Title("Without the server");
  ui_.Note("Attempts that were kept for later here. Yours opens with your PIN.");
  ui_.Problem(flow_.problem());
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  ui_.BeginList("reserved", 110);
  const auto& all = flow_.reserved();
  for (size_t i = 0; i < all.size(); ++i) {
    if (ui_.Row(all[i].ticket.title, ReservedText(all[i], UnixMs()),
                all[i].cut_off ? "GO ON" : "")) {
      flow_.AskPin(i);
    }
  }
  if (all.empty()) ui_.Text("Nothing is kept here any more.");
  ui_.EndList();
  if (ui_.Button("Back") || ui_.escape()) flow_.Back();
  ui_.End();
}

void Pages::AskPin() {
  const ReservedAttempt& reserved = flow_.reserved_chosen();
  ui_.BeginDialog("pin", reserved.ticket.title);
  ui_.Text(reserved.ticket.person + ", write the PIN you chose when you kept it." +
           (reserved.cut_off ? "" : " Given back it does not count, and is gone from here."));
  bool go = ui_.Field("PIN", pin_, true);
  ui_.Problem(flow_.problem());
  Busy();
  go |= ui_.Button(reserved.cut_off ? "Go on" : "Open", Ui::Look::kMain, !flow_.busy());
  if (go && !pin_.empty()) {
    flow_.OpenReserved(pin_);
    pin_.clear();
    ui_.Focus("PIN");
  }
  ui_.SameLine();
  if (!reserved.cut_off) {
    if (ui_.Button("Give back", Ui::Look::kDanger, !pin_.empty() && !flow_.busy())) {
      flow_.GiveBack(pin_);
      pin_.clear();
      ui_.Focus("PIN");
    }
    ui_.SameLine();
  }
  if (ui_.Button("Leave it", Ui::Look::kPlain, !flow_.busy()) || (ui_.escape() && !flow_.busy())) {
    flow_.CloseDialog();
  }
  ui_.EndDialog();
}

void Pages::AskReserve() {
  ui_.BeginDialog("reserve", "Keep it for later?");
  ui_.Text(
      "It can be made here within 12 hours, with or without the server, and counts as an attempt "
      "unless you give it back. Choose a PIN of 6 to 12 digits.");
  bool go = ui_.Field("PIN", pin_, true);
  if (go) ui_.Focus("The same PIN again");
  go = ui_.Field("The same PIN again", pin_again_, true);
  bool same = pin_ == pin_again_;
  // Two fields are different while the second is being written: said only once it is as long.
  bool typed = pin_again_.size() >= pin_.size() && !pin_.empty();
  ui_.Problem(typed && !same ? "These are two different PINs." : flow_.problem());
  Busy();
  go |= ui_.Button("Keep", Ui::Look::kMain, typed && same && !flow_.busy());
  if (go && typed && same) {
    flow_.Reserve(pin_);
    pin_.clear();
    pin_again_.clear();
    ui_.Focus("PIN");
  }
  ui_.SameLine();
  if (ui_.Button("Leave it", Ui::Look::kPlain, !flow_.busy()) || (ui_.escape() && !flow_.busy())) {
    flow_.CloseDialog();
  }
  ui_.EndDialog();
}

void Pages::AskCutOff() {
  const SpooledAttempt& attempt = flow_.cut_off_chosen();
  ui_.BeginDialog("cut-off", "Cut off: " + flow_.TitleOf(attempt));
  // Without a chunk there is no seal to make, and so nothing to hand in.
  bool recorded = attempt.chunks > 0;
  ui_.Text(CutOffText(attempt, UnixMs()) +
           (recorded ? ". All but its last moment is kept: go on where that ends, or hand it in as "
                       "it is."
                     : ". Nothing was recorded yet: it can only go on."));
  ui_.Problem(flow_.problem());
  Busy();
  bool free = !flow_.busy();
  if (ui_.Button("Go on", Ui::Look::kMain, free)) flow_.GoOnWithCutOff();
  ui_.SameLine();
  if (ui_.Button("Hand in", Ui::Look::kDanger, free && recorded)) flow_.EndCutOff();
  ui_.SameLine();
  if (ui_.Button("Later", Ui::Look::kPlain, free) || (free && ui_.escape())) flow_.CloseDialog();
  ui_.EndDialog();
}

bool DrawOpeningProblem(Ui& ui, Opening& opening) {
  const OpeningProblem shown = opening.explained();
  ui.Begin("trouble", kWidePage);
  ui.Title("This station cannot be used just now");
  ui.Gap(8);
  ui.Problem(shown.what);
  ui.Text(shown.safe);
  ui.Text(shown.todo);
  ui.BeginList("operators", 150);
  ui.Note("For whoever looks after it:");
  ui.Note(shown.operators);
  ui.EndList();
  // Who sits here sees no path and no command but in the part for the operator.
  ui.Note(opening.busy() ? "Looking again …" : "F1 shows how the station is.");
  if (ui.Button("Try again", Ui::Look::kMain, !opening.busy())) opening.TryAgain();
  ui.SameLine();
  const bool close = ui.Button("Close");
  ui.End();
  ui.EndFrame();
  return close;
}

bool Pages::AskClose() {
  ui_.BeginDialog("close", "Close the station?");
  ui_.Text("Nothing is lost: what is recorded here is sent when the program runs again.");
  ui_.Gap(12);
  bool close = ui_.Button("Close", Ui::Look::kDanger);
  ui_.SameLine();
  if (ui_.Button("Stay", Ui::Look::kMain) || ui_.escape()) flow_.CloseDialog();
  ui_.EndDialog();
  return close;
}

}  // namespace enamel::station::desk
