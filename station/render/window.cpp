#include "station/render/window.h"

#include <epoxy/gl.h>
// epoxy must come before GLFW, which would otherwise include its own OpenGL headers.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <stdexcept>

#include "station/render/panel.h"

namespace enamel::station::render {
namespace {

constexpr auto kMeshLimit = std::chrono::seconds(30);
// 60 pictures a second with a graphics card, 15 with software rendering.
constexpr double kCardBudget_s = 1.0 / 60, kSoftwareBudget_s = 1.0 / 15;

void PressKey(Camera& camera, int key) {
  switch (key) {
    case GLFW_KEY_1:
      return camera.SetView(View::kOcclusal);
    case GLFW_KEY_2:
      return camera.SetView(View::kBuccal);
    case GLFW_KEY_3:
      return camera.SetView(View::kMesial);
    case GLFW_KEY_4:
      return camera.SetView(View::kOblique);
    default:
      return;
  }
}

void Drag(const Screen& screen, Camera& camera) {
  auto share = [&](double d) { return static_cast<float>(d / screen.shorter_side()); };
  const float dx = share(screen.moved_x()), dy = share(screen.moved_y());
  if (screen.button(GLFW_MOUSE_BUTTON_LEFT)) return camera.Orbit(dx, dy);
  if (screen.button(GLFW_MOUSE_BUTTON_RIGHT) || screen.button(GLFW_MOUSE_BUTTON_MIDDLE)) {
    camera.Pan(dx, dy);
  }
}

}  // namespace

Status NoDisplay(const std::string& reason) {
  return Status(Code::kUnavailable,
                "expected a display with OpenGL 3.3, found: " + reason +
                    "; start a desktop session, set DISPLAY, use xvfb-run, or run without --window",
                "window");
}

QualityGovernor GovernorFor(const Screen& screen) {
  // The best level draws four pixels for each visible one: too slow for software rendering.
  return screen.draws_in_software() ? QualityGovernor(1, kSoftwareBudget_s)
                                    : QualityGovernor(0, kCardBudget_s);
}

void SteerCamera(const Screen& screen, Camera& camera, bool by_mouse) {
  for (const InputEvent& event : screen.events()) {
    if (event.kind == InputEvent::Kind::kKey && event.pressed) PressKey(camera, event.code);
    if (event.kind == InputEvent::Kind::kWheel && by_mouse) {
      camera.Zoom(static_cast<float>(event.y));
    }
  }
  if (by_mouse) Drag(screen, camera);
}

bool HoldsMirror(const Screen& screen, ToothView& view) {
  return view.mirror().shown() && (screen.key(kKeyLeftControl) || screen.key(kKeyRightControl));
}

void SteerMirror(const Screen& screen, ToothView& view, double dt_s) {
  constexpr float kPerNotch_mm = 1;
  constexpr double kTilt_rad_per_s = 0.6, kLongest_s = 0.1;  // the window may have hung
  MouthMirror& mirror = view.mirror();
  Camera& camera = view.camera();
  for (const InputEvent& event : screen.events()) {
    const bool key = event.kind == InputEvent::Kind::kKey && event.pressed && !event.repeat;
    if (key && event.code == 'M') mirror.Show(!mirror.shown(), camera);
  }
  if (!mirror.shown()) return;
  const auto turn = static_cast<float>(kTilt_rad_per_s * std::min(dt_s, kLongest_s));
  auto held = [&](int more, int less) {
    return static_cast<float>(static_cast<int>(screen.key(more)) -
                              static_cast<int>(screen.key(less)));
  };
  const float right = held(kKeyRight, kKeyLeft), up = held(kKeyUp, kKeyDown);
  if (right != 0 || up != 0) mirror.Tilt(turn * right, turn * up, camera);
  if (!HoldsMirror(screen, view)) return;
  const double dx = screen.moved_x(), dy = screen.moved_y();
  auto share = [&](double d) { return static_cast<float>(d / screen.shorter_side()); };
  if (dx != 0 || dy != 0) mirror.Move(share(dx), share(dy), camera);
  for (const InputEvent& event : screen.events()) {
    if (event.kind != InputEvent::Kind::kWheel) continue;
    mirror.Push(kPerNotch_mm * static_cast<float>(event.y), camera);
  }
}

Window::Window(const WindowOptions& options, const cutting::Volume& initial)
    : options_(options),
      screen_(options.screen),
      tooth_(options.view, initial, {}, options.uncut),
      governor_(GovernorFor(screen_)) {}

Result<std::unique_ptr<Window>> Window::Create(const WindowOptions& options,
                                               const cutting::Volume& initial) {
  try {
    return std::unique_ptr<Window>(new Window(options, initial));
  } catch (const std::exception& e) {
    // For any error: this window is one of several ways to run an attempt, and the others need no
    // display.
    return NoDisplay(e.what());
  }
}

void Window::DrawFrame(const Quality& quality) {
  tooth_.Draw(screen_.width(), screen_.height(), quality);
  if (options_.panel) {
    PanelContent content;
    content.heading = options_.heading;
    content.state = tooth_.state();
    content.has_state = tooth_.has_state();
    content.force_full_scale_n = options_.view.force_full_scale_n;
    content.time_limit_s = options_.time_limit_s;
    // The camera's radius is half of what fits into the height.
    content.mm_per_pixel = 2.0 * tooth_.camera().radius_mm() / screen_.shorter_side();
    content.hint = words_.Say("hint.camera");
    DrawPanel(content, words_, screen_.fonts(), {screen_.width(), screen_.height()});
  }
  screen_.Show(tooth_.result());
  screen_.End();
}

bool Window::PumpOnce() {
  bool open = screen_.Begin();
  SteerCamera(screen_, tooth_.camera());
  DrawFrame(kQualities[governor_.level()]);
  governor_.Note(screen_.drawing_s());
  return open;
}

void Window::Run(const std::function<bool()>& done) {
  while (!done() && PumpOnce()) {
  }
}

Status Window::WriteScreenshot(const std::string& path) {
  if (!tooth_.WaitIdle(kMeshLimit)) {
    return Status(Code::kUnavailable,
                  "expected the surface within 30 s, found it still being computed; "
                  "the machine is too busy or the voxels are too small",
                  "screenshot");
  }
  // Twice: the panel reaches the size of its text one frame later.
  for (int i = 0; i < 2; ++i) {
    screen_.Begin();
    DrawFrame(kQualities[0]);
  }
  return screen_.WriteScreenshot(path);
}

}  // namespace enamel::station::render
