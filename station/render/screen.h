#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "common/base/result.h"
#include "station/render/fonts.h"
#include "station/render/input.h"

namespace enamel::station::render {

class Target;

struct ScreenOptions {
  std::string title = "Enamel";
  int width_px = 1280, height_px = 800;
  bool full_screen = false;  // width and height are then the monitor's
  bool visible = true;       // false: drawn off screen, for screenshots and tests
  bool paced = true;  // false: for measuring: frames follow each other, each drawn to its end
};

// The window on the desktop: GLFW, an OpenGL 3.3 context, Dear ImGui with our letters and style,
// and what the person does. One per process, on the process's main thread. A frame:
//
//   while (screen.Begin()) { …ImGui, from screen.events() what is left…; screen.End(picture); }
//
// Errors are exceptions (std::runtime_error): only construction throws.
class Screen {
 public:
  explicit Screen(const ScreenOptions& options);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  // Collects input and begins a frame of Dear ImGui, at most 60 times a second (and no more than
  // two thirds of the time where the processor draws: the tick needs it too). False once the person
  // has closed the window; CancelClose takes that back.
  bool Begin();
  // Draws ImGui's frame over `picture` (null: over the background) and shows it.
  void End(const Target* picture);
  // Letters for this language, from the next frame on.
  void Speak(language::Language language);
  // Letters for this text too, whatever its script, from the next frame on; those of the texts named
  // last are kept. Costs one frame of some 100 ms where it has letters that were not asked for before.
  void Need(const std::string& text);
  void CancelClose();
  void Close();

  // Of this frame, in order.
  std::span<const InputEvent> events() const;
  // As if the person had done it; at most one per frame is taken.
  void Inject(const InputEvent& event);
  bool injecting() const;  // some are still waiting
  // While captured the cursor is not shown and moves without end: what is done with the mouse is
  // for something other than widgets.
  void CaptureCursor(bool capture);
  // Cursor in window pixels, and whether a mouse button or a key is held.
  double cursor_x() const;
  double cursor_y() const;
  double last_cursor_x() const;  // of the frame before
  double last_cursor_y() const;
  bool button(int button) const;
  bool key(int key) const;

  int width() const;  // of the picture, px
  int height() const;
  const Fonts& fonts() const;
  bool draws_in_software() const;
  const std::string& renderer() const;  // what OpenGL calls itself
  // Wall time of the last frame's drawing, without waiting for the display, s.
  double drawing_s() const;

  // The last frame shown as PNG. Errors: kStorage.
  Status WriteScreenshot(const std::string& path);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::station::render
