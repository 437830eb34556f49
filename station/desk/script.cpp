#include "station/desk/script.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string_view>
#include <utility>

#include "station/desk/layout.h"

namespace enamel::station::desk {
namespace {

using render::InputEvent;
using render::Screen;

// The smallest window that a chair is meant to have (station/README.md).
constexpr int kMinWidth_px = 900, kMinHeight_px = 600;

constexpr std::array<std::string_view, 14> kVerbs = {
    "page", "see",   "click",  "type",    "key",   "hold",    "let",
    "move", "wheel", "frames", "removed", "until", "picture", "quit"};

int KeyOf(const std::string& name) {
  constexpr std::array<std::pair<std::string_view, int>, 12> kNamed = {{
      {"Tab", render::kKeyTab},
      {"Enter", render::kKeyEnter},
      {"Escape", render::kKeyEscape},
      {"Space", render::kKeySpace},
      {"Up", render::kKeyUp},
      {"Down", render::kKeyDown},
      {"Left", render::kKeyLeft},
      {"Right", render::kKeyRight},
      {"F1", render::kKeyF1},
      {"Shift", render::kKeyLeftShift},
      {"Control", render::kKeyLeftControl},
      {"Backspace", render::kKeyBackspace},
  }};
  for (const auto& [known, key] : kNamed) {
    if (known == name) return key;
  }
  return name.size() == 1 ? name[0] : -1;  // letters and digits are ASCII
}

void Hold(Screen& screen, const std::string& name, bool down) {
  if (name == "Left") return screen.Inject(InputEvent::Button(render::kMouseLeft, down));
  if (name == "Right") return screen.Inject(InputEvent::Button(render::kMouseRight, down));
  screen.Inject(InputEvent::Key(KeyOf(name), down));
}

double Removed_mm3(Workflow* flow) {
  if (flow == nullptr || flow->attempt() == nullptr) return 0;
  const auto& removed = flow->attempt()->view().state().removed_mm3;
  return std::accumulate(removed.begin(), removed.end(), 0.0);
}

}  // namespace

Result<Script> Script::Read(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) return Status(Code::kNotFound, "cannot read the script " + file.string(), "script");
  Script script;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line);
    Line step;
    step.number = number;
    if (!(words >> step.verb) || step.verb[0] == '#') continue;
    std::getline(words >> std::ws, step.rest);
    if (std::find(kVerbs.begin(), kVerbs.end(), step.verb) == kVerbs.end()) {
      return Status(Code::kInvalidInput,
                    file.string() + ":" + std::to_string(number) + ": no step '" + step.verb + "'",
                    "script");
    }
    script.steps_.push_back(step);
  }
  return script;
}

bool Script::Step(Screen& screen, const Ui& ui, Workflow* flow) {
  // One step a frame, and none before the window has processed the last one.
  if (steps_.empty() || screen.injecting()) return false;
  Line line = steps_.front();
  if (line.verb == "quit") {
    if (!unreadable_.empty()) status_ = Status(Code::kInternal, unreadable_, "script");
    return true;
  }
  ++waited_;
  if (Take(line, screen, ui, flow)) {
    steps_.pop_front();
    waited_ = 0;
    aimed_at_ = {};
    since_ = std::chrono::steady_clock::now();
  } else if (std::chrono::steady_clock::now() - since_ > kPatience) {
    // By the clock, not by frames: a busy computer draws few.
    GiveUp(line, "waited " + std::to_string(kPatience.count()) + " s in vain", ui);
  }
  return !status_.ok();
}

void Script::GiveUp(const Line& line, const std::string& why, const Ui& ui) {
  status_ =
      Status(Code::kUnavailable,
             "script, line " + std::to_string(line.number) + ": " + line.verb + " " + line.rest +
                 ": " + why + "; on page '" + ui.page() + "' with:\n" + ui.words(),
             "script");
}

bool Script::Waits(const Line& line, const Ui& ui) {
  if (line.verb == "page") return ui.page() != line.rest;
  return ui.words().find(line.rest) == std::string::npos;
}

bool Script::Take(const Line& line, Screen& screen, const Ui& ui, Workflow* flow) {
  if (line.verb == "page" || line.verb == "see") return !Waits(line, ui);
  if (line.verb == "click") return Click(line.rest, screen, ui);
  if (line.verb == "type") return Type(line.rest, screen);
  if (line.verb == "key") {
    screen.Inject(
        {InputEvent::Key(KeyOf(line.rest), true), InputEvent::Key(KeyOf(line.rest), false)});
    return true;
  }
  if (line.verb == "hold" || line.verb == "let") {
    Hold(screen, line.rest, line.verb == "hold");
    return true;
  }
  if (line.verb == "move") return Move(line.rest, screen);
  if (line.verb == "wheel") {
    int notches = std::atoi(line.rest.c_str());
    for (int i = 0; i < std::abs(notches); ++i) {
      screen.Inject(InputEvent::Wheel(notches > 0 ? 1 : -1));
    }
    return true;
  }
  if (line.verb == "frames") return waited_ >= std::atoi(line.rest.c_str());
  if (line.verb == "removed") return Removed_mm3(flow) >= std::atof(line.rest.c_str());
  if (line.verb == "until") return std::filesystem::exists(line.rest);
  // A window that is smaller than any chair's has no room for all words.
  const bool has_room = screen.width() >= kMinWidth_px && screen.height() >= kMinHeight_px;
  for (const std::string& fault :
       has_room ? LayoutFaults(ui.choices()) : std::vector<std::string>()) {
    unreadable_ += (unreadable_.empty() ? "" : "\n") + line.rest + ": " + fault;
  }
  if (Status written = screen.WriteScreenshot(line.rest); !written.ok()) status_ = written;
  return true;
}

bool Script::Click(const std::string& rest, Screen& screen, const Ui& ui) {
  auto mark = rest.rfind(" #");
  int nth = mark == std::string::npos ? 1 : std::atoi(rest.c_str() + mark + 2);
  // " #2" at the end means the second of that name; anything that is not a number belongs to the
  // label.
  const std::string label = nth > 0 ? rest.substr(0, mark) : rest;
  for (const Choice& choice : ui.choices()) {
    // By its beginning: labels may end in changing text, such as a time.
    if (!choice.label.starts_with(label) || --nth > 0) continue;
    const double x = 0.5 * (choice.at.x0 + choice.at.x1), y = 0.5 * (choice.at.y0 + choice.at.y1);
    if (!choice.visible) {
      // Scrolls the list under the middle of the window, as a person does, and looks again.
      screen.Inject(InputEvent::Cursor(x, 0.5 * screen.height()));
      screen.Inject(InputEvent::Wheel(y > 0.5 * screen.height() ? -1 : 1));
      return false;
    }
    // A neighbour that has just appeared may move it in the next picture.
    const std::pair<double, double> place{x, y};
    if (std::exchange(aimed_at_, place) != place) return false;
    screen.Inject(InputEvent::Cursor(x, y));
    Hold(screen, "Left", true);
    Hold(screen, "Left", false);
    return true;
  }
  return false;
}

bool Script::Move(const std::string& rest, Screen& screen) {
  double dx = 0, dy = 0;
  int frames = 1;
  std::istringstream(rest) >> dx >> dy >> frames;
  for (int i = 1; i <= frames; ++i) {
    screen.Inject(InputEvent::Cursor(screen.cursor_x() + i * dx, screen.cursor_y() + i * dy));
  }
  return true;
}

bool Script::Type(const std::string& text, Screen& screen) {
  for (char c : text) screen.Inject(InputEvent::Character(static_cast<unsigned char>(c)));
  return true;
}

}  // namespace enamel::station::desk
