#include "station/desk/pages.h"

#include <algorithm>
#include <utility>

#include "common/base/unix_time.h"
#include "station/desk/exercise_words.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
void Pages::Busy() {
  if (flow_.busy()) {
    ui_.Note(Say("task.running", {{"task", Say(flow_.task())}}));
  } else {
    // As high as the line it replaces: buttons below must not move while somebody clicks.
    ui_.Note(" ");
  }
}

bool Pages::Draw() {
  // Typed text belongs to the person who typed it: the next person at this window must not find it.
  if (flow_.place() != before_) {
    password_.clear();
    password_again_.clear();
    search_.clear();
    dentist_.clear();
    consent_ = false;
    said_.reset();
    offered_ = false;
    // A login stays after a wrong password, and is cleared when its person leaves.
    if (flow_.place() == Place::kSignIn) static_cast<TypedByPerson&>(*this) = {};
    before_ = flow_.place();
  }
  if (flow_.dialog() != dialog_before_) {
    // A PIN never outlives its dialog.
    signer_.clear();
    pin_.clear();
    pin_again_.clear();
    dialog_before_ = flow_.dialog();
  }
  switch (flow_.place()) {
    case Place::kSignIn:
      SignIn();
      break;
    case Place::kFirstPassword:
      FirstPassword();
      break;
    case Place::kReserved:
      Reserved();
      break;
    case Place::kExercises:
      Exercises();
      break;
    case Place::kPracticeList:
      PracticeList();
      break;
    case Place::kExercise:
      Exercise();
      break;
    case Place::kWarmUp:
      WarmUp();
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
    case Place::kLoss:
      ShownLoss();
      break;
    case Place::kPractice:
      Practice();
      break;
  }
  bool close = false;
  switch (flow_.dialog()) {
    case Dialog::kNone:
      break;
    case Dialog::kPaused:
      Paused();
      break;
    case Dialog::kPracticePaused:
      PracticePaused();
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
    case Dialog::kSignOff:
      AskSignOff();
      break;
    case Dialog::kFallback:
      AskFallback();
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
  ui_.Begin("sign-in", kSignInPage);
  ui_.Title("Enamel");
  ui_.Note(Say("sign_in.station", {{"station", station_}}));
  ui_.Gap(10);
  bool go = ui_.Field(Say("sign_in.login"), login_);
  // Enter in the first field moves to the second.
  if (go && password_.empty()) {
    ui_.Focus(Say("sign_in.password"));
    go = false;
  }
  go |= ui_.Field(Say("sign_in.password"), password_, true);
  ui_.Gap(12);
  go |= ui_.Button(Say(flow_.busy() ? "sign_in.going" : "sign_in.go"), Ui::Look::kMain,
                   !flow_.busy());
  ui_.SameLine();
  bool offline = !flow_.reserved().empty() &&
                 ui_.Button(Say("sign_in.offline"), Ui::Look::kPlain, !flow_.busy());
  ui_.SameLine();
  const bool practise =
      flow_.may_practise() && ui_.Button(Say("sign_in.practise"), Ui::Look::kSmall, !flow_.busy());
  ui_.Gap(8);
  ui_.Problem(flow_.problem());
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  ui_.Note(Say("sign_in.keys"));
  Languages();
  if (go) {
    // After a wrong password the next letters are another try.
    if (!login_.empty()) ui_.Focus(Say("sign_in.password"));
    flow_.SignIn(login_, password_);
    // Not kept after sending, whatever the server answers.
    password_.clear();
  }
  if (offline) flow_.ToReserved();
  if (practise) flow_.ToPractice();
  if (ui_.escape()) flow_.Open(Dialog::kClose);
  ui_.End();
}

// In their own words, so that people who cannot read this page find theirs. Chinese is not offered
// without a font for it.
void Pages::Languages() {
  ui_.Gap(8);
  bool first = true;
  for (language::Language each : language::kLanguages) {
    if (each == language::Language::kChinese && !render::FindChineseFont()) continue;
    if (!std::exchange(first, false)) ui_.SameLine();
    const bool spoken = each == flow_.words().language();
    if (ui_.Button(std::string(NameOf(each)), Ui::Look::kSmall, !spoken)) flow_.Speak(each);
  }
}

Card Pages::AttemptCard(const SpooledAttempt& attempt, std::string_view title,
                        const std::string& text, std::string_view right) const {
  Card card;
  // Of its exercise: the tooth and the place.
  if (const Catalogue::Exercise* exercise = flow_.ExerciseOf(attempt)) {
    card = CardOf(flow_.words(), *exercise, UnixMs());
    card.lines = {PlaceText(flow_.words(), *exercise)};
    std::erase(card.lines, "");
  }
  card.title = Say(title, {{"title", WordedTitle(flow_.words(), flow_.TitleOf(attempt))}});
  card.lines.push_back(text);
  card.right = Say(right);
  return card;
}

void Pages::Exercises() {
  ui_.Begin("exercises", kWidePage);
  ui_.Title(Say("exercises.hello", {{"name", flow_.person().display_name}}));
  ui_.Note(Say("exercises.choose"));
  ui_.Problem(flow_.problem());
  ExerciseList();
  Busy();
  if (ui_.Button(Say("exercises.again"), Ui::Look::kPlain, !flow_.busy())) flow_.Refresh();
  ui_.SameLine();
  const bool clear = ui_.escape() && !search_.empty();
  if (clear) search_.clear();
  if (ui_.Button(Say("exercises.sign_out")) || (ui_.escape() && !clear)) flow_.SignOut();
  ui_.End();
}

// Of whoever comes: no names, no results, no interrupted attempts.
void Pages::PracticeList() {
  ui_.Begin("practice-list", kWidePage);
  ui_.Title(Say("sign_in.practise"));
  ui_.Note(Say("practice_list.text"));
  ui_.Problem(flow_.problem());
  const auto& all = flow_.exercises();
  std::vector<Card> cards;
  for (const auto& exercise : all) cards.push_back(CardOf(flow_.words(), exercise, UnixMs()));
  ui_.BeginList("practices");
  const auto chosen = ui_.Cards(cards);
  if (all.empty() && !flow_.busy()) ui_.Text(Say("practice_list.none"));
  ui_.EndList();
  Busy();
  const bool back = ui_.Button(Say("exercise.back")) || ui_.escape();
  ui_.End();
  if (back) return flow_.Back();
  if (chosen) flow_.ChooseExercise(*chosen);
}

void Pages::ExerciseFacts(const PreparedAttempt& prepared) {
  const scene::Exercise& e = prepared.exercise;
  ui_.Text(e.instructions.empty() ? Say("exercise.no_instructions")
                                  : WordedText(flow_.words(), e.instructions));
  ui_.Gap(8);
  if (flow_.way() == Way::kPractice) return ui_.Text(Say("practice.note"));
  ui_.Note(FactsText(flow_.words(), e, prepared.scene.title, flow_.chosen().exam));
}

void Pages::Exercise() {
  ui_.Begin("exercise", kWidePage);
  const Catalogue::Exercise& ref = flow_.chosen();
  ui_.Title(WordedTitle(flow_.words(), ref.title));
  if (ref.exam) ui_.Note(Say(ref.sign_off ? "exercise.exam_signed" : "exercise.exam"));
  ui_.Problem(flow_.problem().empty() ? RefusalText(flow_.words(), ref) : flow_.problem());
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  if (flow_.lacks_realtime()) ui_.Problem(Say("exercise.no_realtime"));
  const PreparedAttempt* prepared = flow_.preview();
  ui_.BeginList("facts");
  if (prepared != nullptr) {
    ExerciseFacts(*prepared);
    ui_.Gap(10);
    for (const scene::BurSpec& bur : prepared->exercise.burs()) {
      ui_.Text(Say("exercise.bur", {{"bur", BurText(flow_.words(), bur)}}));
      DrawBur(bur.metric(), 900 * ui_.px(), 170 * ui_.px(), 40 * ui_.px());
    }
  } else {
    Busy();
  }
  Devices();
  ui_.Gap(10);
  if (bool left = flow_.left_handed(); ui_.Check(Say("exercise.left_handed"), left)) {
    flow_.HoldInLeft(left);
  }
  ui_.EndList();
  ChosenDevice();
  if (flow_.instructor() && flow_.way() == Way::kTicket) {
    ui_.Check(Say("exercise.as_reference"), as_reference_);
  }
  ExerciseChoices(prepared != nullptr);
  ui_.End();
}

// The devices that somebody may choose instead.
void Pages::Devices() {
  bool first = true;
  for (size_t i = 0; i < flow_.offers().size(); ++i) {
    const DeviceOffer& offer = flow_.offers()[i];
    // A device that cannot be chosen for this attempt would only confuse.
    if (!flow_.Fits(offer) || i == flow_.offer_index()) continue;
    if (std::exchange(first, false)) {
      ui_.Gap(10);
      ui_.Text(Say("exercise.other_devices"));
    }
    const bool usable = offer.problem.empty();
    if (ui_.Row(offer.title, usable ? offer.detail : offer.problem,
                usable ? "" : Say("exercise.not_usable"))) {
      flow_.ChooseOffer(i);
    }
  }
}

// Enter, pressed twice by habit, must not start with another device: it looks for the right one.
void Pages::AskFallback() {
  const auto missing = flow_.missing_device();
  if (!missing || flow_.offer_index() >= flow_.offers().size()) return flow_.CloseDialog();
  const DeviceOffer& used = flow_.offers()[flow_.offer_index()];
  ui_.BeginDialog("fallback", Say("fallback.title", {{"device", missing->title}}));
  ui_.Text(missing->reason);
  ui_.Text(Say("fallback.ask", {{"device", used.title}}));
  ui_.Note(used.detail);
  ui_.Gap(12);
  if (ui_.Button(Say("exercise.find_devices"), Ui::Look::kMain)) {
    flow_.CloseDialog();
    flow_.LookForDevices();
  }
  ui_.SameLine();
  if (ui_.Button(Say("fallback.use"))) flow_.StartWithFallback();
  ui_.SameLine();
  if (ui_.Button(Say("exercise.back")) || ui_.escape()) flow_.CloseDialog();
  ui_.EndDialog();
}

// Below the list: what an attempt would begin with is seen without scrolling.
void Pages::ChosenDevice() {
  // A row without a device, too: buttons must not move while somebody clicks.
  if (flow_.offer_index() >= flow_.offers().size()) {
    (void)ui_.Row(Say("exercise.no_device"), " ", "", true);
    return;
  }
  const DeviceOffer& offer = flow_.offers()[flow_.offer_index()];
  (void)ui_.Row(offer.title, offer.detail, Say("exercise.in_use"), true);
}

void Pages::ExerciseChoices(bool prepared) {
  bool has_device = flow_.offer_index() < flow_.offers().size();
  bool ready = prepared && has_device && !flow_.busy() && flow_.chosen().refusal.ok();
  bool resumed = flow_.way() == Way::kResumed;
  // Once, as soon as it can begin: Enter chooses an exercise and Enter begins it.
  if (ready && !std::exchange(offered_, true)) {
    ui_.Focus(Say(resumed ? "exercise.go_on" : "exercise.start"));
  }
  if (ui_.Button(Say(resumed ? "exercise.go_on" : "exercise.start"), Ui::Look::kMain, ready)) {
    flow_.Start(as_reference_ && flow_.instructor());
  }
  ui_.SameLine();
  // An exam needs the server at its start; an attempt kept for later is kept already.
  if (flow_.way() == Way::kTicket && !flow_.chosen().exam) {
    if (ui_.Button(Say("exercise.keep"), Ui::Look::kSmall, ready)) flow_.Open(Dialog::kReserve);
    ui_.SameLine();
  }
  if (ui_.Button(Say("warm_up.try"), Ui::Look::kSmall, prepared && has_device && !flow_.busy())) {
    flow_.TryDevice();
  }
  ui_.SameLine();
  if (ui_.Button(Say("exercise.find_devices"), Ui::Look::kSmall, !flow_.busy()))
    flow_.LookForDevices();
  ui_.SameLine();
  if (ui_.Button(Say("exercise.back"), Ui::Look::kSmall) || ui_.escape()) flow_.Back();
}

void Pages::Reserved() {
  ui_.Begin("reserved", kWidePage);
  ui_.Title(Say("reserved.title"));
  ui_.Note(Say("reserved.text"));
  ui_.Problem(flow_.problem());
  if (!flow_.notice().empty()) ui_.Text(flow_.notice());
  ui_.BeginList("reserved");
  const auto& all = flow_.reserved();
  for (size_t i = 0; i < all.size(); ++i) {
    if (ui_.Row(
            WordedTitle(flow_.words(), all[i].ticket.title),
            ReservedText(flow_.words(), all[i], flow_.DeviceNamed(all[i].ticket.profile), UnixMs()),
            all[i].cut_off ? Say("exercises.go_on") : "")) {
      flow_.AskPin(i);
    }
  }
  if (all.empty()) ui_.Text(Say("reserved.none"));
  ui_.EndList();
  if (ui_.Button(Say("exercise.back")) || ui_.escape()) flow_.Back();
  ui_.End();
}

void Pages::AskPin() {
  const ReservedAttempt& reserved = flow_.reserved_chosen();
  ui_.BeginDialog("pin", WordedTitle(flow_.words(), reserved.ticket.title));
  ui_.Text(
      Say(reserved.cut_off ? "pin.ask_cut_off" : "pin.ask", {{"person", reserved.ticket.person}}));
  bool go = ui_.Field(Say("pin.label"), pin_, true);
  ui_.Problem(flow_.problem());
  Busy();
  go |= ui_.Button(Say(reserved.cut_off ? "cut_off.go_on" : "pin.open"), Ui::Look::kMain,
                   !flow_.busy());
  if (go && !pin_.empty()) {
    flow_.OpenReserved(pin_);
    pin_.clear();
    ui_.Focus(Say("pin.label"));
  }
  ui_.SameLine();
  if (!reserved.cut_off) {
    if (ui_.Button(Say("pin.give_back"), Ui::Look::kDanger, !pin_.empty() && !flow_.busy())) {
      flow_.GiveBack(pin_);
      pin_.clear();
      ui_.Focus(Say("pin.label"));
    }
    ui_.SameLine();
  }
  if (ui_.Button(Say("pin.leave"), Ui::Look::kPlain, !flow_.busy()) ||
      (ui_.escape() && !flow_.busy())) {
    flow_.CloseDialog();
  }
  ui_.EndDialog();
}

void Pages::AskReserve() {
  ui_.BeginDialog("reserve", Say("reserve.title"));
  ui_.Text(Say("reserve.text"));
  bool go = ui_.Field(Say("pin.label"), pin_, true);
  if (go) ui_.Focus(Say("pin.again"));
  go = ui_.Field(Say("pin.again"), pin_again_, true);
  bool same = pin_ == pin_again_;
  // The two fields differ while the second is being typed: reported only once it is as long.
  bool typed = pin_again_.size() >= pin_.size() && !pin_.empty();
  ui_.Problem(typed && !same ? Say("pin.different") : flow_.problem());
  Busy();
  go |= ui_.Button(Say("reserve.keep"), Ui::Look::kMain, typed && same && !flow_.busy());
  if (go && typed && same) {
    flow_.Reserve(pin_);
    pin_.clear();
    pin_again_.clear();
    ui_.Focus(Say("pin.label"));
  }
  ui_.SameLine();
  if (ui_.Button(Say("pin.leave"), Ui::Look::kPlain, !flow_.busy()) ||
      (ui_.escape() && !flow_.busy())) {
    flow_.CloseDialog();
  }
  ui_.EndDialog();
}

void Pages::AskCutOff() {
  const SpooledAttempt& attempt = flow_.cut_off_chosen();
  ui_.BeginDialog("cut-off", Say("exercises.cut_off",
                                 {{"title", WordedTitle(flow_.words(), flow_.TitleOf(attempt))}}));
  // Without a chunk there is no seal, and so nothing to hand in.
  bool recorded = attempt.chunks > 0;
  ui_.Text(Say(recorded ? "cut_off.some" : "cut_off.nothing",
               {{"text", CutOffText(flow_.words(), attempt, flow_.DeviceNamed(attempt.profile),
                                    UnixMs())}}));
  ui_.Problem(flow_.problem());
  Busy();
  bool free = !flow_.busy();
  if (ui_.Button(Say("cut_off.go_on"), Ui::Look::kMain, free)) flow_.GoOnWithCutOff();
  ui_.SameLine();
  if (ui_.Button(Say("cut_off.hand_in"), Ui::Look::kDanger, free && recorded)) flow_.EndCutOff();
  ui_.SameLine();
  if (ui_.Button(Say("cut_off.later"), Ui::Look::kPlain, free) || (free && ui_.escape()))
    flow_.CloseDialog();
  ui_.EndDialog();
}

bool DrawOpeningProblem(Ui& ui, const Words& words, Opening& opening) {
  const OpeningProblem shown = opening.explained(words);
  ui.Begin("trouble", kWidePage);
  ui.Title(words.Say("trouble.title"));
  ui.Gap(8);
  ui.Problem(shown.what);
  ui.Text(shown.safe);
  ui.Text(shown.todo);
  ui.BeginList("operators");
  ui.Note(words.Say("trouble.operators"));
  ui.Note(shown.operators);
  ui.EndList();
  // Students see no path and no command except in the operator's part.
  ui.Note(words.Say(opening.busy() ? "trouble.looking" : "trouble.f1"));
  if (ui.Button(words.Say("trouble.again"), Ui::Look::kMain, !opening.busy())) opening.TryAgain();
  ui.SameLine();
  const bool close = ui.Button(words.Say("trouble.close"));
  ui.End();
  ui.EndFrame();
  return close;
}

bool Pages::AskClose() {
  ui_.BeginDialog("close", Say("close.title"));
  ui_.Text(Say("close.text"));
  ui_.Gap(12);
  // First, so that Esc and Enter do not end the program.
  if (ui_.Button(Say("close.stay"), Ui::Look::kMain) || ui_.escape()) flow_.CloseDialog();
  ui_.SameLine();
  const bool close = ui_.Button(Say("close.close"), Ui::Look::kDanger);
  ui_.EndDialog();
  return close;
}

}  // namespace enamel::station::desk
