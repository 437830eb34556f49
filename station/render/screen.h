#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "station/render/fonts.h"
#include "station/render/input.h"

namespace enamel::station::render {

class Target;

struct ScreenOptions {
  std::string title = "Enamel";
  int width_px = 1280, height_px = 800;
  bool full_screen = false;  // width and height are then the monitor's
  std::string monitor;  // to be on: its name, or its number, 0 the first; empty: the primary one
  // Called with a line for the log when that monitor is missing: at the start, and when it is unplugged.
  // The window is on the primary one then.
  std::function<void(const std::string&)> monitor_missing;
  double pixel_mm = 0;  // of the monitor; 0: as it says of itself
  bool visible = true;  // false: drawn off screen, for screenshots and tests
  bool paced = true;    // false, for measuring: frames follow each other, each drawn to its end
};

// The window on the desktop: GLFW, an OpenGL 3.3 context, Dear ImGui with our fonts and style, and
// the person's input. One per process, on the process's main thread. A frame:
//
//   while (screen.Begin()) { screen.Show(picture); …ImGui, unused screen.events()…; screen.End(); }
//
// Errors are exceptions (std::runtime_error): only construction throws.
class Screen {
 public:
  explicit Screen(const ScreenOptions& options);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  // Collects input and begins a frame of Dear ImGui, at most 60 times a second. Without a graphics
  // card it uses at most two thirds of the time, because the tick needs the processor too. Once some
  // frames looked the same, nothing is held and nobody does anything, it begins ten a second and waits
  // for input in between, which ends the wait at once. False once the person has closed the window;
  // CancelClose revokes that.
  bool Begin();
  // The next frame comes as soon as usual, even if this one looks like the last.
  void StayAwake();
  // Lays a picture under ImGui's frame; without one the background has one colour. It is copied at
  // once: a page that is drawn over it may end the attempt, and with it the picture.
  void Show(const Target& picture);
  // Draws ImGui's frame and shows it; nothing is drawn where it looks like the frame before.
  void End();
  // Loads this language's letters, from the next frame on.
  void Speak(language::Language language);
  void CancelClose();
  void Close();

  // This frame's events, in order. Events behind a key or click that may choose something come in a
  // later frame: a page answers it first.
  std::span<const InputEvent> events() const;
  // Acts as if the person had done it. The events of one call come between two frames, those of
  // the next call a frame later.
  void Inject(std::vector<InputEvent> events);
  void Inject(const InputEvent& event) { Inject(std::vector{event}); }
  bool injecting() const;  // some are still waiting
  // Drops keys, letters and clicks of earlier frames that still wait: they were meant for what was
  // shown then. Releases stay.
  void DropWaiting();
  // While captured the cursor is hidden and moves without limit: the mouse does not control
  // widgets.
  void CaptureCursor(bool capture);
  // Cursor in window pixels, and whether a mouse button or a key is held.
  double cursor_x() const;
  double cursor_y() const;
  // How far a hand moved the mouse in this frame, px. Not what the window system does: it puts the
  // cursor elsewhere when the window gets or loses the keyboard, captures or frees the cursor, or is
  // moved or resized, and when the cursor enters. Nor a step of a captured cursor that is larger than
  // a hand's (kLargestStep in screen.cpp), as a remote desktop makes.
  double moved_x() const;
  double moved_y() const;
  bool button(int button) const;
  bool key(int key) const;
  // The key at this place of a US keyboard, by what is printed on it here (Keyboard::At).
  int KeyAt(int place) const;
  // In this frame another window had the keyboard, however briefly, or this one was iconified.
  // Everything held counts as let go when that begins, and nothing moves until it ends. A click asks
  // for the keyboard.
  bool away() const;

  int width() const;  // of the picture, px
  int height() const;
  int shorter_side() const { return std::max(1, std::min(width(), height())); }
  const Fonts& fonts() const;
  bool draws_in_software() const;
  const std::string& renderer() const;  // OpenGL's own name
  // Wall time of drawing the last frame, without waiting for the display, s.
  double drawing_s() const;
  uint64_t drawn() const;  // frames so far that were drawn

  // The last frame shown as PNG. Errors: kStorage.
  Status WriteScreenshot(const std::string& path);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::station::render
