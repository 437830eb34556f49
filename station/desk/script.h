#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <utility>

#include "station/desk/ui.h"
#include "station/desk/workflow.h"

namespace enamel::station::desk {

// Plays a person's part to test the window: one step per line, `#` begins a comment.
//
//   page NAME          waits until this page or dialog is shown ("sign-in", "reserved",
//                      "exercises", "exercise", "ready", "running", "hand-in", "result", "loss", "practice"; "paused",
//                      "finish", "give-up", "reference", "reserve", "pin", "cut-off", "close";
//                      "trouble" where the station cannot be used)
//   see WORDS          waits until the page shows these words
//   click LABEL        the left button on the choice whose label begins so, once it is shown;
//                      LABEL #2: on the second of them. Turns the wheel until it is in view, and
//                      waits until two pictures show it at the same place
//   type TEXT          writes it, letter by letter
//   key NAME           Tab, Enter, Escape, Space, Up, Down, Left, Right, F1, or a letter; pressed and let go
//                      within a frame, as a badge reader does
//   hold NAME / let NAME      a key, Shift and Control too, or Left / Right for a mouse button
//   move DX DY N       the mouse by so many pixels in each of N frames
//   wheel N            notches, one a frame
//   frames N           waits
//   removed MM3        waits until this volume of the tooth has been removed
//   until FILE         waits until this file exists, for events outside the window
//   picture FILE       writes the current picture as PNG; words on it that are cut off or over each
//                      other (LayoutFaults) fail the script at its end
//   quit               ends the program
//
// Input enters where the window system's does (Screen::Inject). Nothing depends on the computer's
// speed: each step waits for its condition, at most kPatience.
class Script {
 public:
  // A sanitizer's build takes minutes for a score that otherwise takes seconds.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  static constexpr std::chrono::seconds kPatience{1200};
#else
  static constexpr std::chrono::seconds kPatience{240};
#endif

  // Errors: kNotFound, kInvalidInput with the line.
  static Result<Script> Read(const std::filesystem::path& file);
  Script() = default;

  // Call once a frame, after it was drawn. True when the program should end. `flow` is null if
  // there is none yet.
  bool Step(render::Screen& screen, const Ui& ui, Workflow* flow);
  // Why it gave up, or ok.
  const Status& status() const { return status_; }
  bool playing() const { return !steps_.empty(); }

 private:
  struct Line {
    int number = 0;
    std::string verb, rest;
  };
  // True when the step has been taken.
  bool Take(const Line& line, render::Screen& screen, const Ui& ui, Workflow* flow);
  bool Click(const std::string& rest, render::Screen& screen, const Ui& ui);
  bool Move(const std::string& rest, render::Screen& screen);
  bool Type(const std::string& text, render::Screen& screen);
  bool Waits(const Line& line, const Ui& ui);
  void GiveUp(const Line& line, const std::string& why, const Ui& ui);

  std::deque<Line> steps_;
  Status status_;
  std::string unreadable_;              // what pictures have shown, a line each
  int waited_ = 0;                      // frames of the step in hand
  std::pair<double, double> aimed_at_;  // where the last picture showed what is to be clicked
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
};

}  // namespace enamel::station::desk
