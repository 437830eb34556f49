#include "station/desk/desk.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "station/desk/opening.h"
#include "station/desk/operator_panel.h"
#include "station/desk/pages.h"
#include "station/desk/problem_words.h"
#include "station/desk/script.h"
#include "station/desk/stop_sign.h"
#include "station/desk/view_hand.h"
#include "station/render/display_watch.h"
#include "station/render/panel.h"
#include "station/session/stop_signals.h"
#include "station/sound/handpiece_voice.h"
#include "station/sound/speaker.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
namespace {

using language::Words;
using render::Quality;
using Clock = Workflow::Clock;

uint32_t AttemptWarnings(RunningAttempt& run, double time_s, double limit_s) {
  uint32_t warnings = 0;
  if (!run.recording().problem.ok()) warnings |= render::kWarnDisk;
  if (!run.upload().reachable) warnings |= render::kWarnOffline;
  if (limit_s > 0 && time_s > limit_s) warnings |= render::kWarnTime;
  return warnings;
}

const Quality& QualityOf(const DeskOptions& options, const render::QualityGovernor& governor) {
  const Quality* wanted = render::FindQuality(options.quality);
  return wanted != nullptr ? *wanted : render::kQualities[governor.level()];
}

// F1 opens and closes the operator's panel.
void TakePanelKey(const render::Screen& screen, const Ui& ui, bool& panel) {
  // Before the first page a panel has nothing to cover.
  if (ui.page().empty()) return;
  for (const render::InputEvent& event : screen.events()) {
    bool f1 = event.kind == render::InputEvent::Kind::kKey && event.code == render::kKeyF1;
    if (f1 && event.pressed) panel = !panel;
  }
}

// The window while there is no workplace.
class OpeningDesk {
 public:
  OpeningDesk(const DeskOptions& options, render::Screen& screen, Opening& opening, Script& script)
      : options_(options),
        screen_(screen),
        opening_(opening),
        script_(script),
        governor_(render::GovernorFor(screen)),
        ui_(screen),
        words_(options.language) {}

  // Runs until the workplace opens or the person closes the window. Errors: the script's.
  Status Run() {
    screen_.Speak(options_.language);
    while (opening_.workplace() == nullptr && Frame()) {
    }
    return script_.status();
  }

 private:
  bool Frame() {
    bool end = !screen_.Begin();
    opening_.Tick();
    TakePanelKey(screen_, ui_, panel_);
    end |= DrawOpeningProblem(ui_, words_, opening_);
    if (panel_) {
      DrawOperatorPanel(opening_.Lines(), screen_, times_, QualityOf(options_, governor_),
                        governor_.budget_s());
    }
    if (opening_.busy() || script_.playing()) screen_.StayAwake();
    screen_.End();
    times_.Add(screen_.drawing_s());
    end |= script_.playing() && script_.Step(screen_, ui_, nullptr);
    return !end && StopsAsked() == 0;
  }

  const DeskOptions& options_;
  render::Screen& screen_;
  Opening& opening_;
  Script& script_;
  render::QualityGovernor governor_;
  PictureTimes times_;
  Ui ui_;
  const Words words_;
  bool panel_ = false;
};

class Desk {
 public:
  Desk(const DeskOptions& options, render::Screen& screen, Workplace& workplace, Script& script)
      : options_(options),
        screen_(screen),
        governor_(render::GovernorFor(screen)),
        script_(script),
        ui_(screen),
        flow_(workplace, {options.simulated, options.device, 60 * options.idle_minutes,
                          options.profile, options.cpu, options.mouth, options.hand_turn_deg,
                          options.left_handed, options.language}),
        pages_(ui_, flow_, workplace.credentials().name),
        station_(workplace) {
    if (options.sound) speaker_.emplace();
  }

  Status Run() {
    while (Frame()) {
    }
    // First of all that follows: the sound's thread may hang with its server.
    flow_.LeaveAtOnce();
    return script_.status();
  }

 private:
  // Whoever started the window has ended, in the middle of an attempt: a session, or the compositor of
  // its unit. What only starts it, such as a menu, has ended long before.
  bool Orphaned() {
    const pid_t parent = ::getppid();
    const bool changed = parent != parent_;
    parent_ = parent;
    return changed && (flow_.place() == Place::kRunning || flow_.place() == Place::kHandIn);
  }

  bool Frame() {
    screen_.Speak(flow_.words().language());
    if (!screen_.Begin()) AskToClose();
    // The picture may be covered, and keys go elsewhere. Before the flow, which stops the bur.
    if (screen_.away()) flow_.Interrupt();
    auto now = Clock::now();
    // For the window only: the device and the tick have their own time.
    double dt_s = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    // Before drawing: a frame shows one state, not parts of two.
    flow_.Tick(now, !screen_.events().empty());
    TakePanelKey(screen_, ui_, panel_);
    // Before the pages, which lie over it and may end the attempt that it shows.
    ShowPicture(dt_s);
    Sound();
    bool end = pages_.Draw();
    if (panel_) {
      DrawOperatorPanel(flow_, station_, screen_, times_, quality(), governor_.budget_s());
    }
    // The steps that follow a background task, or a device that holds still, come with a frame.
    if (flow_.busy() || flow_.place() == Place::kReady || script_.playing()) screen_.StayAwake();
    screen_.End();
    Measure();
    end |= script_.playing() && script_.Step(screen_, ui_, &flow_);
    return !end && StopsAsked() == 0 && !Orphaned();
  }

  const Quality& quality() const { return QualityOf(options_, governor_); }

  // The window's own close button must not lose an attempt.
  void AskToClose() {
    screen_.CancelClose();
    if (flow_.dialog() != Dialog::kNone) return;
    flow_.Open(flow_.place() == Place::kRunning    ? Dialog::kPaused
               : flow_.place() == Place::kPractice ? Dialog::kPracticePaused
                                                   : Dialog::kClose);
  }

  // The tooth, if there is one to cut.
  void ShowPicture(double dt_s) {
    warned_ = {};
    if (flow_.place() == Place::kLoss) return ShowLoss(dt_s);
    // The next person finds the helps as a fresh window has them.
    if (flow_.place() == Place::kSignIn) outline_ = depth_ = true;
    DeskAttempt* attempt = flow_.attempt();
    bool running = flow_.cutting() && attempt != nullptr;
    bool dialog = flow_.dialog() != Dialog::kNone;
    screen_.CaptureCursor(running && !dialog && attempt->by_pointer());
    // The view stays with its attempt: returning from a dialog builds nothing.
    if (!running) return;
    // Also below a dialog: the pointer device must hold still then.
    attempt->Point(screen_, dt_s, dialog);
    if (!dialog) Steer(*attempt, dt_s);
    view_hand_.Look(!dialog && attempt->held().turns_view(), attempt->view().state().device.tip_m,
                    attempt->view().camera());
    TurnHand(*attempt);
    TakeHelpKeys(*attempt, dialog);
    attempt->ShowOutline(outline_ && MayShowOutline(attempt->prepared()));
    attempt->view().Draw(screen_.width(), screen_.height(), quality());
    DrawStatus(*attempt);
    // As the bars: a student who saw or heard a warning would cut to it.
    if (MayShowProgress(attempt->prepared())) {
      warned_ = attempt->warned();
      attempt->WriteBesideBur(flow_.words(), screen_, depth_, warned_);
    }
    screen_.Show(attempt->view().result());
  }

  void ShowLoss(double dt_s) {
    screen_.CaptureCursor(false);
    LossView& loss = *flow_.loss();
    loss.Advance(dt_s);
    render::SteerCamera(screen_, loss.view().camera(), true);
    loss.view().Draw(screen_.width(), screen_.height(), quality());
    screen_.Show(loss.view().result());
  }

  // With the mouse as the handpiece, the right button turns the picture and keys choose the view.
  void Steer(DeskAttempt& attempt, double dt_s) {
    render::Camera& camera = attempt.view().camera();
    render::SteerMirror(screen_, attempt.view(), dt_s);
    const bool mirror = render::HoldsMirror(screen_, attempt.view());
    render::SteerCamera(screen_, camera, !attempt.by_pointer() && !mirror);
    if (mirror || !attempt.by_pointer() || !screen_.button(render::kMouseRight)) return;
    auto share = [&](double d) { return static_cast<float>(d / screen_.shorter_side()); };
    camera.Orbit(share(screen_.moved_x()), share(screen_.moved_y()));
    for (const render::InputEvent& event : screen_.events()) {
      if (event.kind == render::InputEvent::Kind::kWheel) {
        camera.Zoom(static_cast<float>(event.y));
      }
    }
  }

  // A hand that goes to the right goes to the right of the picture.
  void TurnHand(DeskAttempt& attempt) {
    if (!attempt.turns_with_view()) return;
    const bool turning = attempt.held().turns_view() || screen_.button(render::kMouseLeft) ||
                         screen_.button(render::kMouseRight);
    attempt.held().SetQuarters(view_hand_.Quarters(turning, attempt.view().camera()) +
                               attempt.stands_turned_deg() / 90);
  }

  bool MayShowProgress(const PreparedAttempt& prepared) const {
    return desk::MayShowProgress(prepared.exercise.graded, flow_.chosen().exam, flow_.instructor());
  }

  bool MayShowOutline(const PreparedAttempt& prepared) const {
    return desk::MayShowOutline(prepared.terms.outline, flow_.chosen().exam, flow_.instructor());
  }

  // A line to cut along and the depth are help, like the zones. The bur is the exercise's own choice.
  void TakeHelpKeys(DeskAttempt& attempt, bool dialog) {
    for (const render::InputEvent& event : screen_.events()) {
      const bool pressed =
          event.kind == render::InputEvent::Kind::kKey && event.pressed && !event.repeat && !dialog;
      if (pressed && event.code == 'T') outline_ = !outline_;
      if (pressed && event.code == 'G') depth_ = !depth_;
      if (pressed && event.code == 'N') attempt.NextBur();
    }
  }

  void DrawStatus(DeskAttempt& attempt) {
    const PreparedAttempt& prepared = attempt.prepared();
    render::PanelContent content;
    content.heading = flow_.place() == Place::kWarmUp
                          ? flow_.words().Say("warm_up.title")
                          : WordedTitle(flow_.words(), prepared.exercise.title);
    content.state = attempt.view().state();
    content.has_state = attempt.view().has_state();
    content.force_full_scale_n = static_cast<double>(prepared.profile.peak_force_mn.value) * 1e-3;
    // No scale bar: a perspective picture does not have a single scale.
    content.mm_per_pixel = 0;
    if (flow_.place() == Place::kRunning) {
      content.time_limit_s = prepared.exercise.time_limit_s;
      content.state.warnings |=
          AttemptWarnings(*attempt.run(), content.state.time_s, content.time_limit_s);
    }
    const Words& words = flow_.words();
    const Snapshot newest = attempt.newest();
    if (newest.fault != Fault::kNone) {
      content.fault =
          FaultSentence(words, newest.fault, attempt.device().problem(), attempt.lacks_realtime());
    } else if (newest.put_down) {
      content.fault = words.Say("fault.in_holder");
    }
    if ((content.state.warnings & render::kWarnLate) != 0 && attempt.lacks_realtime()) {
      content.state.warnings ^= render::kWarnLate | render::kWarnNoRealtime;
    }
    // Graded work and exams: a student who saw the zones would cut to the numbers.
    if (MayShowProgress(prepared)) {
      content.zones = attempt.zones();
      content.reach = attempt.reach();
    }
    if (content.state.warnings & render::kWarnDisk) render::HideProgress(content);
    const bool dialog = flow_.dialog() != Dialog::kNone;  // which says why itself
    const Stop stop = dialog ? Stop::kNone
                             : StopOf(newest.fault, newest.put_down,
                                      (content.state.warnings & render::kWarnDisk) != 0);
    // Arrow, burs and keys would be drawn over it.
    const bool free = stop == Stop::kNone && !dialog;
    if (free) {
      content.bur_away = attempt.view().BurAway(screen_.width(), screen_.height());
    }
    std::string keys;
    for (const char place : std::string_view(flow_.left_handed() ? "IJKL" : "WASD")) {
      keys += (keys.empty() ? "" : " ") + std::string(1, static_cast<char>(screen_.KeyAt(place)));
    }
    content.hint = attempt.by_pointer() ? words.Say("hint.pointer", {{"keys", keys}})
                                        : words.Say("hint.camera");
    if (MayShowOutline(prepared)) content.hint += "   " + words.Say("hint.outline");
    if (MayShowProgress(prepared)) {
      content.hint += "   " + words.Say("hint.depth");
    }
    const std::vector<scene::BurSpec> burs = prepared.exercise.burs();
    content.several_burs = burs.size() > 1;
    if (content.several_burs) content.hint += "   " + words.Say("hint.bur");
    const bool mirror = attempt.view().mirror().shown();
    content.hint += "   " + words.Say(mirror ? "hint.mirror_held" : "hint.mirror");
    if (dialog) content.hint.clear();
    const render::Canvas canvas = render::DrawPanel(
        content, words, screen_.fonts(), {screen_.width(), screen_.height(), flow_.left_handed()});
    ui_.Over(canvas);
    if (free) {
      DrawBurChoice(burs, attempt.view().state(), words, screen_.fonts(), ui_.AbovePage(canvas));
    }
    const bool kept = flow_.place() == Place::kRunning;
    DrawStop(stop, kept ? words.Say("stop.kept") : std::string(), screen_.fonts(), canvas);
  }

  void Sound() {
    if (!speaker_) return;
    DeskAttempt* attempt = flow_.attempt();
    if (!flow_.cutting() || attempt == nullptr) {
      speaker_->Warn(sound::Hazard::kPulp, 0);
      return speaker_->Set(0, 0);
    }
    speaker_->Warn(warned_.about, warned_.nearness);
    // The voice gets a share of the peak force, so that it sounds the same on weak and strong
    // devices.
    double full = static_cast<double>(attempt->prepared().profile.peak_force_mn.value) * 1e-3;
    const render::FrameState& state = attempt->view().state();
    const double load = glm::length(state.pressed_n) / std::max(full, 1e-3);
    const bool slows = attempt->prepared().exercise.handpiece.stall_un_m > 0;
    const double share = slows ? state.bur_speed_ratio : sound::HandpieceVoice::DroopUnder(load);
    speaker_->Set(attempt->held().speed_krpm() * share, load);
  }

  void Measure() {
    times_.Add(screen_.drawing_s());
    // Pages take less time than a tooth: they would raise the quality just before the tooth needs
    // it.
    if (flow_.cutting()) governor_.Note(screen_.drawing_s());
  }

  const DeskOptions& options_;
  render::Screen& screen_;
  render::QualityGovernor governor_;
  PictureTimes times_;
  Script& script_;
  Ui ui_;
  Workflow flow_;
  Pages pages_;
  // After what it leaves: its handler must not outlive that.
  render::DisplayWatch display_{[this] { flow_.LeaveAtOnce(); }};
  pid_t parent_ = ::getppid();
  StationWatch station_;
  ViewHand view_hand_;
  std::optional<sound::Speaker> speaker_;
  bool panel_ = false;
  bool outline_ = true, depth_ = true;  // shown, as last chosen
  Warned warned_;                       // of this frame; nothing where it may not be shown
  Clock::time_point last_ = Clock::now();
};

}  // namespace

Status SetWindowSize(const std::string& text, DeskOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const protocol::WindowSize size, protocol::ParseWindowSize(text));
  options.full_screen = false;
  options.width_px = size.width_px;
  options.height_px = size.height_px;
  return Status::Ok();
}

Status RunDesk(const DeskOptions& options) {
  if (!options.quality.empty() && render::FindQuality(options.quality) == nullptr) {
    return Status(Code::kInvalidInput,
                  "no quality '" + options.quality + "': there are best, good, fair, low",
                  "quality");
  }
  Script script;
  if (!options.script.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto read, Script::Read(options.script));
    script = std::move(read);
  }
  Opening opening(options.workplace);
  CatchStopSignals();
  try {
    render::ScreenOptions window;
    window.full_screen = options.full_screen;
    window.width_px = options.width_px;
    window.height_px = options.height_px;
    window.monitor = options.monitor;
    window.monitor_missing = [](const std::string& what) { spdlog::warn("{}", what); };
    render::Screen screen(window);
    if (opening.workplace() == nullptr) {
      ENAMEL_RETURN_IF_ERROR(OpeningDesk(options, screen, opening, script).Run());
    }
    if (opening.workplace() == nullptr) return opening.problem();
    return Desk(options, screen, *opening.workplace(), script).Run();
  } catch (const std::exception& e) {
    // Without a display, the reason why the station cannot be used is still the more important
    // error.
    return opening.problem().ok() ? render::NoDisplay(e.what()) : opening.problem();
  }
}

}  // namespace enamel::station::desk
