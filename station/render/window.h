#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/base/result.h"
#include "common/language/words.h"
#include "station/render/screen.h"
#include "station/render/tooth_view.h"

namespace enamel::station::render {

using language::Words;

struct WindowOptions {
  ScreenOptions screen;
  ViewOptions view;
  std::string heading;                     // shown in the panel: "Class I, molar 46"
  bool panel = true;                       // false: only the solid picture
  double time_limit_s = 0;                 // 0: none; the timer counts up either way
  const cutting::Volume* uncut = nullptr;  // as ToothView takes it
};

// A window that only shows one attempt: for `run --window`, screenshots and tests. Threads and
// lifetime as of Screen and ToothView.
class Window {
 public:
  // Opens the window and starts meshing a copy of `initial`. Errors: kUnavailable when there is no
  // display or no OpenGL 3.3, with what to do.
  static Result<std::unique_ptr<Window>> Create(const WindowOptions& options,
                                                const cutting::Volume& initial);

  Screen& screen() { return screen_; }
  ToothView& tooth() { return tooth_; }

  // Draws one frame and handles input. False once the operator closed the window. Waits for the
  // display's refresh, if there is one.
  bool PumpOnce();
  // Pumps until `done` returns true (asked once a frame) or the window is closed.
  void Run(const std::function<bool()>& done);
  // Waits (at most 30 s) until every brick received is meshed, draws one frame in the best quality
  // and writes it as PNG. Errors: kStorage with the path when it cannot be written; kUnavailable
  // when meshing did not end.
  Status WriteScreenshot(const std::string& path);

 private:
  Window(const WindowOptions& options, const cutting::Volume& initial);
  void DrawFrame(const Quality& quality);

  const WindowOptions options_;
  Screen screen_;
  ToothView tooth_;
  const Words words_{language::Language::kEnglish};
  QualityGovernor governor_;
};

// The error of a computer that cannot open a window, with what to do.
Status NoDisplay(const std::string& reason);

// Turns, moves and zooms the camera by this frame's input: keys 1 to 4 choose a view, left drag
// turns, right drag moves, the wheel zooms in. `by_mouse` false: keys only, because the mouse has
// another use at the moment.
void SteerCamera(const Screen& screen, Camera& camera, bool by_mouse = true);

// Shows and hides the mirror with M. While it is held, with Ctrl, the mouse moves it and the wheel
// moves it away from the viewer. The arrow keys tilt it.
void SteerMirror(const Screen& screen, ToothView& view, double dt_s);
// Mouse and wheel belong to the mirror: Ctrl is held.
bool HoldsMirror(const Screen& screen, ToothView& view);

// Budget of a picture, s, and the first quality.
QualityGovernor GovernorFor(const Screen& screen);

}  // namespace enamel::station::render
