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
  std::string heading;      // who and what, shown in the panel: "Class I, molar 46"
  bool panel = true;        // false: only the solid picture
  double time_limit_s = 0;  // 0: none; the timer counts up either way
};

// A window that shows one attempt and nothing else: for `run --window`, screenshots and tests.
// Threads and lifetime as of Screen and ToothView.
class Window {
 public:
  // Opens the window and begins to mesh `initial` (copied).
  // Errors: kUnavailable when there is no display or no OpenGL 3.3, with what to do.
  static Result<std::unique_ptr<Window>> Create(const WindowOptions& options,
                                                const cutting::Volume& initial);

  Screen& screen() { return screen_; }
  ToothView& tooth() { return tooth_; }

  // Draws one frame and handles input. False once the operator closed the window.
  // Waits for the display's refresh where there is one.
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

// The error of a computer that cannot open a window: what to do about it.
Status NoDisplay(const std::string& reason);

// Turns, moves and zooms by what the person did in this frame: keys 1 to 4 for the views, left drag
// turns, right drag moves, the wheel comes nearer. `by_mouse` false: keys only, because the mouse
// is something else just now.
void SteerCamera(const Screen& screen, Camera& camera, bool by_mouse = true);

// Budget of a picture, s, and the quality to begin with.
QualityGovernor GovernorFor(const Screen& screen);

}  // namespace enamel::station::render
