#pragma once

#include <algorithm>
#include <cfloat>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "station/render/panel.h"
#include "station/render/screen.h"

struct ImFont;

// The few widgets of the student's window, large, for keyboard or mouse, on Dear ImGui.
namespace enamel::station::desk {

struct Rect {
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool Holds(float x, float y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

// A choice on the page shown: for the keyboard, for scripts, and for tests.
struct Choice {
  std::string label;
  Rect at;  // window pixels
  bool field = false;
  bool visible = true;                   // false: scrolled out of its list
  bool whole = true;                     // all of it is in view
  bool in_list = false, chosen = false;  // scrolls with others; marked as the one in use
};

// One of several to choose from, with a picture at its left.
struct Card {
  std::string title;
  std::vector<std::string> lines;               // below the title, quieter
  std::string right;                            // a word at the title's end: "EXAM"; empty: none
  std::function<void(const Rect& at)> picture;  // draws into the current ImGui window
};

// A square picture with a line below it. `texture` is OpenGL's.
struct Picture {
  unsigned texture = 0;
  std::string caption;
};

// Draws one page after another on one screen. In a frame:
//
//   ui.Begin("sign-in");  ui.Title(…); if (ui.Button("Sign in")) …; ui.End();
//   if (…) { ui.BeginDialog(…); …; ui.EndDialog(); }
//   ui.EndFrame();
//
// Every choice takes part in one round of Tab and shows when it has the focus. Up and Down move to
// the nearest choice there, Left and Right as Tab does.
// Enter or the space bar chooses it, once per key press. The focus starts at a page's first choice.
// A page or dialog answers no key that was pressed before it was shown.
// Words may be in any script that the system has fonts for (station/render/shaped_text.h).
// Sizes are in pixels of a picture 1080 high and scaled. Not thread-safe.
class Ui {
 public:
  // kSmall is read from the chair, for what few people need.
  enum class Look { kPlain, kMain, kDanger, kSmall };
  // In dialogs over a running attempt the space bar is the bur's pedal, and pressing it must not
  // choose.
  enum class Space { kChooses, kIsThePedal };

  explicit Ui(render::Screen& screen) : screen_(screen) {}

  // A page that fills the screen; `name` identifies it. `at_x`, `width`: its column, as shares of
  // the screen's width. `see_through`: over a picture, as high as its content.
  struct Page {
    float at_x = 0.1f, at_y = 0.07f, width = 0.8f, height = 0.86f;  // shares of the screen
    bool see_through = false;
    bool keys = true;  // false: keys choose nothing here, they have another meaning
    // A see-through page then stands on the canvas's floor, away from the panel, wherever `at_x` and
    // `at_y` are.
    bool on_floor = false;
    // Wider about its middle, where `width` is less than so many sizes of the text's font: a line has
    // to hold some words.
    float least_em = 0;
  };
  // A page that stands on the floor, with as much of the width.
  static Page OnFloor(float width) { return {0, 0, width, 0, true, false, true}; }
  // Sets the canvas below this frame's page, before Begin; without a call it is the whole window.
  void Over(const render::Canvas& canvas) { canvas_ = canvas; }
  // Cuts a canvas off above the page that stood on its floor in the last frame.
  render::Canvas AbovePage(render::Canvas canvas) const {
    canvas.floor = std::min(canvas.floor, page_top_);
    return canvas;
  }
  void Begin(const std::string& name, const Page& page);
  void Begin(const std::string& name) { Begin(name, Page()); }
  void End();
  // A page over the page, after its End; nothing on the page below can be chosen meanwhile.
  void BeginDialog(const std::string& name, const std::string& title,
                   Space space = Space::kChooses);
  void EndDialog();
  void EndFrame();

  void Title(const std::string& text);    // read from 2 m
  void Large(const std::string& text);    // the same letters in a line of its own
  void OneLine(const std::string& text);  // the same, smaller where it would not fit
  void Text(const std::string& text);     // wrapped
  void Note(const std::string& text);     // the same, quieter
  void Problem(const std::string& text);  // an error; begins with a capital
  void Gap(float px = 24);
  // A square to draw into, in the current ImGui window.
  Rect Square(float px);
  void Indent();  // the next button, as the words of a Line
  // The next button begins beside the last, where the page has room for it and nothing is between.
  void SameLine() { beside_ = after_button_; }
  // True when chosen.
  bool Button(const std::string& label, Look look = Look::kPlain, bool enabled = true);
  // One line of a list: a title, words below it, words at the right. True when chosen. Rows may
  // have the same title.
  bool Row(const std::string& title, const std::string& detail, const std::string& right,
           bool chosen = false);
  // Cards in two columns, or in one on a narrow page, as high as their words, below a heading of their
  // own on this page. The one chosen, or none.
  std::optional<size_t> Cards(std::span<const Card> cards, const std::string& heading = {});
  // Adds the letters typed in this frame to `text`, and takes its last away with Backspace; not
  // while a field takes them. Behind a letter the space bar writes, and chooses nothing.
  void Typed(std::string& text);
  bool Check(const std::string& label, bool& value);
  // One line of text, which takes letters whenever it has the focus. True when Enter was pressed in
  // it.
  bool Field(const std::string& label, std::string& text, bool secret = false);
  void Bar(const std::string& label, double share);
  // A number as large as the page allows, and its maximum.
  void Score(const std::string& number, const std::string& of);
  // One line of a table: a name, a value at the right, words below it. `lost`: highlighted.
  void Line(const std::string& name, const std::string& value, const std::string& words, bool lost);

  // A message over a see-through page's picture, below the panel: who sends it, its text, and the key
  // that dismisses it. The message is as wide as the page allows; a long one has smaller letters.
  void Remark(const std::string& who, const std::string& text, const std::string& key);

  // Pictures at the right of the window, beside a page that leaves room there: after the page's End.
  // Below each other, or from three on in two columns. `below` draws under them, in the same small
  // letters.
  void Pictures(std::span<const Picture> pictures, const Page& where,
                const std::function<void()>& below = {});

  // A part of the page that scrolls. What follows it up to the page's end keeps its height.
  void BeginList(const char* name);
  void EndList();

  // Esc was pressed in this frame, for the page or dialog in use.
  bool escape() const { return escape_ && !blocked_; }
  // Whether this key (render::Key; for letters the capital) was pressed in this frame, as escape().
  bool pressed(int key) const;
  // Moves the focus to the choice with this label, from the next frame on.
  void Focus(const std::string& label) { wanted_ = label; }
  float px() const { return screen_.fonts().scale; }
  const render::Fonts& fonts() const { return screen_.fonts(); }
  // Of the last whole frame.
  const std::vector<Choice>& choices() const { return shown_; }
  const std::string& page() const { return shown_page_; }
  // Words shown in the last whole frame, in order.
  const std::string& words() const { return shown_words_; }

 private:
  struct Focused {
    bool has = false;     // this choice has the focus
    bool moved = false;   // and got it in this frame
    bool chosen = false;  // by keyboard
  };
  // Registers a choice of the page in use.
  Focused Next(const std::string& label);
  void Listed(const std::string& label, bool field);
  size_t Beside(size_t from, int down) const;
  render::Canvas CanvasNow() const;
  float HeightOf(const Card& card, float width) const;
  bool DrawCard(const Card& card, float width, float height);
  void Ring();
  void ReadKeys();
  void Enter(const std::string& name);
  void Say(const std::string& text);
  void Write(const std::string& text, bool even);

  render::Screen& screen_;
  std::optional<render::Canvas> canvas_;  // of this frame
  float page_top_ = FLT_MAX;              // of the last page on the floor
  std::string page_, shown_page_, wanted_, words_, shown_words_;
  std::vector<Choice> choices_, shown_;
  bool on_floor_ = false;                        // the page in use
  bool dialog_ = false, dialog_before_ = false;  // a dialog is shown: in this frame, in the last
  bool blocked_ = false;                         // nothing can be chosen: it is under a dialog
  size_t focus_ = 0, count_ = 0;
  size_t next_ = 0;  // the focus after this frame's keys
  bool choose_ = false, escape_ = false, moved_ = false, by_keys_ = true;
  bool walked_ = false;  // somebody has moved the focus on this page
  bool spaced_ = true;   // the space bar chooses
  std::optional<size_t>
      typed_;                  // letters that Typed had in the last frame; none: it was not called
  bool fresh_ = false;         // the page or dialog in use is shown for the first time
  bool after_button_ = false;  // drawn last
  bool beside_ = false;        // SameLine was called after it
  // Of a page's list: height of what follows it, as last drawn, and where the list ended.
  std::map<std::string, float> below_;
  float list_end_ = 0;
  std::string list_;  // of the page being drawn; empty: none
};

}  // namespace enamel::station::desk
