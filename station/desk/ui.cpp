#include "station/desk/ui.h"

#include <imgui.h>
#include <imgui_internal.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <utility>

#include "station/render/shaped_text.h"

namespace enamel::station::desk {
namespace {

using render::InputEvent;

constexpr ImU32 kFocus = IM_COL32(94, 176, 255, 255), kMain = IM_COL32(28, 112, 196, 255),
                kPlainButton = IM_COL32(58, 66, 76, 255), kDanger = IM_COL32(170, 48, 42, 255),
                kRow = IM_COL32(36, 41, 48, 255), kChosenRow = IM_COL32(30, 66, 104, 255);
constexpr float kWords_px = 28;      // of a Line, from its name
constexpr float kFromEdge = 0.015f;  // of what is over a picture, as a share of the window
constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;

ImU32 Lighter(ImU32 colour) {
  ImVec4 c = ImGui::ColorConvertU32ToFloat4(colour);
  return ImGui::ColorConvertFloat4ToU32({c.x + 0.07f, c.y + 0.07f, c.z + 0.07f, c.w});
}

void PushButtonColours(ImU32 colour) {
  ImGui::PushStyleColor(ImGuiCol_Button, colour);
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, Lighter(colour));
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, Lighter(Lighter(colour)));
}

}  // namespace

// The page's words as text, for scripts and tests.
void Ui::Say(const std::string& text) { words_ += text + "\n"; }

// Up (-1) and Down (1): the nearest choice on that side, of these the one most in line. The next in
// the round where there is none.
size_t Ui::Beside(size_t from, int down) const {
  const size_t n = shown_.size();
  if (from >= n) return 0;
  const Rect& here = shown_[from].at;
  size_t best = n;
  float least = 0;
  for (size_t i = 0; i < n; ++i) {
    const Rect& at = shown_[i].at;
    const float gap = down > 0 ? at.y0 - here.y1 : here.y0 - at.y1;
    if (gap < -1) continue;  // rows may touch
    const float aside =
        std::max({0.0f, at.x0 - here.x1, here.x0 - at.x1}) + 0.01f * std::abs(at.x0 - here.x0);
    const float distance = gap + 2 * aside;
    if (best < n && distance >= least) continue;
    best = i;
    least = distance;
  }
  return best < n ? best : (from + n + static_cast<size_t>(down + static_cast<int>(n))) % n;
}

void Ui::ReadKeys() {
  next_ = focus_;
  const size_t n = std::max<size_t>(shown_.size(), 1);
  std::optional<size_t> typed = std::exchange(typed_, std::nullopt);
  choose_ = escape_ = false;
  for (const InputEvent& event : screen_.events()) {
    // The letters, as Typed will count them.
    if (typed && event.kind == InputEvent::Kind::kCharacter)
      *typed += event.code != ' ' || *typed > 0;
    if (event.kind != InputEvent::Kind::kKey || !event.pressed) continue;
    // A held key keeps moving the focus but chooses once; in a field, arrows and space edit the
    // text.
    const bool walks = event.code == render::kKeyTab || event.code == render::kKeyDown ||
                       event.code == render::kKeyUp || event.code == render::kKeyRight ||
                       event.code == render::kKeyLeft;
    walked_ |= walks;
    bool once = !event.repeat, writing = focus_ < shown_.size() && shown_[focus_].field;
    switch (event.code) {
      case render::kKeyTab:
        next_ = (next_ + (event.mods & render::kModShift ? n - 1 : 1)) % n;
        break;
      case render::kKeyDown:
        next_ = Beside(next_, 1);
        break;
      case render::kKeyUp:
        next_ = Beside(next_, -1);
        break;
      case render::kKeyRight:
        if (!writing) next_ = (next_ + 1) % n;
        break;
      case render::kKeyLeft:
        if (!writing) next_ = (next_ + n - 1) % n;
        break;
      case render::kKeyEnter:
      case render::kKeyPadEnter:
        choose_ |= once;
        break;
      case render::kKeySpace:
        // Space is the pedal when the mouse is the handpiece: held down, it must not choose in a
        // dialog over the tooth.
        choose_ |= once && !writing && typed.value_or(0) == 0 && spaced_;
        break;
      case render::kKeyBackspace:
        if (typed && *typed > 0) --*typed;
        break;
      case render::kKeyEscape:
        escape_ |= once;
        break;
      default:
        break;
    }
  }
}

// A new page's focus is at its first choice.
void Ui::Enter(const std::string& name) {
  moved_ = false;
  fresh_ = name != page_;
  if (fresh_) {
    page_ = name;
    focus_ = 0;
    moved_ = true;
    walked_ = false;
    choose_ = escape_ = false;  // the key that opened the page
    screen_.DropWaiting();
  } else if (next_ != focus_) {
    // Among the last frame's choices: this frame's are only known at its end.
    focus_ = next_;
    moved_ = true;
  }
  count_ = 0;
  choices_.clear();
  words_.clear();
}

void Ui::Begin(const std::string& name, const Page& page) {
  ReadKeys();
  by_keys_ = page.keys;
  dialog_before_ = dialog_;
  dialog_ = false;
  // A dialog is drawn after its page, so its presence is known from the last frame.
  blocked_ = dialog_before_;
  if (!blocked_) Enter(name);
  auto w = static_cast<float>(screen_.width()), h = static_cast<float>(screen_.height());
  const float width =
      std::max(page.width * w, std::min(page.least_em * fonts().text->FontSize, 0.97f * w));
  if (page.on_floor) {
    const render::Canvas canvas = CanvasNow();
    const float margin = kFromEdge * w;
    ImGui::SetNextWindowPos(
        {canvas.left_handed ? margin : w - margin, canvas.floor - kFromEdge * h}, ImGuiCond_Always,
        {canvas.left_handed ? 0.0f : 1.0f, 1});
  } else {
    ImGui::SetNextWindowPos({page.at_x * w - 0.5f * (width - page.width * w), page.at_y * h});
  }
  on_floor_ = page.on_floor;
  ImGui::SetNextWindowSize({width, page.see_through ? 0 : page.height * h});
  ImGui::PushStyleColor(ImGuiCol_WindowBg,
                        page.see_through ? ImVec4{0.06f, 0.07f, 0.08f, 0.86f} : ImVec4{0, 0, 0, 0});
  ImGui::Begin("page", nullptr, kFixed);
  ImGui::PopStyleColor();
  ImGui::BeginDisabled(blocked_);
  ImGui::PushFont(fonts().text);
  list_.clear();
  after_button_ = beside_ = false;
}

void Ui::End() {
  if (!list_.empty()) {
    below_[list_] = ImGui::GetCursorPosY() - list_end_;
    list_.clear();
  }
  page_top_ = on_floor_ ? ImGui::GetWindowPos().y : FLT_MAX;
  ImGui::PopFont();
  ImGui::EndDisabled();
  ImGui::End();
}

bool Ui::pressed(int key) const {
  if (blocked_ || fresh_) return false;
  for (const InputEvent& event : screen_.events()) {
    if (event.kind != InputEvent::Kind::kKey || event.repeat) continue;
    if (event.pressed && event.code == key) return true;
  }
  return false;
}

// Without a picture the lines of keys are not there.
render::Canvas Ui::CanvasNow() const {
  return canvas_.value_or(render::Canvas{screen_.width(), screen_.height(), false,
                                         static_cast<float>(screen_.height())});
}

void Ui::EndFrame() {
  canvas_.reset();
  // A dialog's settings end with it.
  if (!dialog_) spaced_ = true;
  if (dialog_before_ && !dialog_) page_.clear();  // the page below restarts in the next frame
  shown_ = choices_;
  shown_page_ = page_;
  shown_words_ = words_;
}

void Ui::BeginDialog(const std::string& name, const std::string& title, Space space) {
  bool first = !dialog_before_;
  dialog_ = true;
  spaced_ = space == Space::kChooses;
  blocked_ = false;
  by_keys_ = true;
  if (first) {
    next_ = focus_;
    choose_ = escape_ = false;  // the key that opened it
  }
  Enter(name);
  auto w = static_cast<float>(screen_.width()), h = static_cast<float>(screen_.height());
  ImGui::GetBackgroundDrawList()->AddRectFilled({0, 0}, {w, h}, IM_COL32(0, 0, 0, 150));
  ImGui::SetNextWindowPos({0.5f * w, 0.5f * h}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({0.72f * w, 0});
  ImGui::SetNextWindowFocus();
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4{0.13f, 0.15f, 0.18f, 1});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {44 * px(), 36 * px()});
  ImGui::Begin("dialog", nullptr, kFixed & ~ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
  ImGui::PushFont(fonts().text);
  Title(title);
  Gap(12);
}

void Ui::EndDialog() {
  ImGui::PopFont();
  ImGui::End();
}

void Ui::Remark(const std::string& who, const std::string& text, const std::string& key) {
  constexpr float kWidth = 0.58f;
  constexpr size_t kLongBytes = 160;
  auto w = static_cast<float>(screen_.width()), h = static_cast<float>(screen_.height());
  const render::Canvas canvas = CanvasNow();
  ImGui::SetNextWindowPos(
      {(canvas.left_handed ? 1 - kFromEdge : kFromEdge) * w, canvas.floor - kFromEdge * h},
      ImGuiCond_Always, {canvas.left_handed ? 1.0f : 0.0f, 1});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {kWidth * w, h});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4{0.10f, 0.25f, 0.42f, 0.88f});
  ImGui::Begin("remark", nullptr,
               kFixed | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs);
  ImGui::PopStyleColor();
  ImGui::PushFont(fonts().near);
  render::Write(fonts(), who + "   ");
  ImGui::SameLine();
  ImGui::TextDisabled("%s", key.c_str());
  ImGui::PopFont();
  ImGui::PushFont(text.size() > kLongBytes ? fonts().near : fonts().text);
  render::Write(fonts(), text, kWidth * w - 48 * px() - ImGui::GetCursorPosX());
  ImGui::PopFont();
  ImGui::End();
  // Part of the page below it, not of a dialog.
  if (!blocked_) Say(who + "\n" + text);
}

Ui::Focused Ui::Next(const std::string& label) {
  if (blocked_) return {};
  // By name: the field may come later in the page than the request.
  if (!wanted_.empty() && wanted_ == label) {
    wanted_.clear();
    focus_ = count_;
    moved_ = true;
  }
  Focused out;
  out.has = count_++ == focus_ && by_keys_;
  out.moved = out.has && moved_;
  out.chosen = out.has && choose_;
  if (out.moved) {
    ImGui::SetScrollHereY(0.5f);
    ImGui::ClearActiveID();  // a field being edited
  }
  return out;
}

void Ui::Listed(const std::string& label, bool field) {
  if (blocked_) return;
  ImVec2 lo = ImGui::GetItemRectMin(), hi = ImGui::GetItemRectMax();
  const ImRect seen = ImGui::GetCurrentWindow()->ClipRect;
  const bool visible = seen.Contains({0.5f * (lo.x + hi.x), 0.5f * (lo.y + hi.y)});
  ImRect room = seen;
  room.Expand(1);  // of soft edges
  const bool in_list = (ImGui::GetCurrentWindow()->Flags & ImGuiWindowFlags_ChildWindow) != 0;
  choices_.push_back(
      {label, {lo.x, lo.y, hi.x, hi.y}, field, visible, room.Contains(ImRect(lo, hi)), in_list});
  // Mouse and keys share one focus: after a click, Tab continues from there.
  if (ImGui::IsItemClicked()) focus_ = count_ - 1;
}

// Wide, to be found from the handpiece's distance, not a keyboard's.
void Ui::Ring() {
  ImVec2 lo = ImGui::GetItemRectMin(), hi = ImGui::GetItemRectMax();
  float out = 4 * px();
  ImGui::GetWindowDrawList()->AddRect({lo.x - out, lo.y - out}, {hi.x + out, hi.y + out}, kFocus,
                                      16 * px(), 0, 5 * px());
}

void Ui::Title(const std::string& text) { Large(text); }

void Ui::Large(const std::string& text) {
  ImGui::PushFont(fonts().far);
  Write(text, true);
  ImGui::PopFont();
}

void Ui::OneLine(const std::string& text) {
  const float width = render::SizeOf(fonts(), *fonts().far, text).x;
  if (width <= ImGui::GetContentRegionAvail().x) return Large(text);
  Text(text);
}

void Ui::Text(const std::string& text) { Write(text, false); }

void Ui::Write(const std::string& text, bool even) {
  Say(text);
  after_button_ = beside_ = false;
  render::Write(fonts(), text, ImGui::GetContentRegionAvail().x, even);
}

void Ui::Note(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  Text(text);
  ImGui::PopStyleColor();
}

// Messages begin with a small letter, as in a log; on a page they are sentences.
void Ui::Problem(const std::string& text) {
  if (text.empty()) return;
  std::string sentence = text;
  if (sentence[0] >= 'a' && sentence[0] <= 'z') sentence[0] = static_cast<char>(sentence[0] - 32);
  ImGui::PushStyleColor(ImGuiCol_Text, ImVec4{1, 0.62f, 0.50f, 1});
  Text(sentence);
  ImGui::PopStyleColor();
}

void Ui::Gap(float height) {
  after_button_ = beside_ = false;
  ImGui::Dummy({1, height * px()});
}

Rect Ui::Square(float side) {
  Gap(0);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::Dummy({side * px(), side * px()});
  return {at.x, at.y, at.x + side * px(), at.y + side * px()};
}

void Ui::Indent() { ImGui::SetCursorPosX(ImGui::GetCursorPosX() + kWords_px * px()); }

bool Ui::Button(const std::string& label, Look look, bool enabled) {
  Say("[" + label + "]");
  // In the small letters, too, where the page has no room for the large ones.
  ImFont* font = fonts().far;
  ImVec2 words = render::SizeOf(fonts(), *font, label);
  const bool small = look == Look::kSmall || words.x + 60 * px() > ImGui::GetContentRegionAvail().x;
  if (small) {
    font = fonts().text;
    words = render::SizeOf(fonts(), *font, label);
  }
  ImGui::PushFont(font);
  PushButtonColours(look == Look::kMain ? kMain : look == Look::kDanger ? kDanger : kPlainButton);
  const float padding = (small ? 18 : 30) * px(), apart = 28 * px();
  if (std::exchange(beside_, false)) {
    const float width = words.x + 2 * padding;
    const float end = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
    if (ImGui::GetItemRectMax().x + apart + width <= end) {
      // A small one beside a large one is at its middle.
      const float height = ImGui::GetFontSize() + 24 * px(),
                  lower = 0.5f * (ImGui::GetItemRectSize().y - height);
      ImGui::SameLine(0, apart);
      if (lower > 0) ImGui::SetCursorPosY(ImGui::GetCursorPosY() + lower);
    } else {
      // As far apart as they would be side by side: the ring around one would touch the other.
      ImGui::SetCursorPosY(ImGui::GetCursorPosY() + apart - ImGui::GetStyle().ItemSpacing.y);
    }
  }
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {padding, 12 * px()});
  ImGui::BeginDisabled(!enabled);
  // Distinguishes buttons with the same label.
  ImGui::PushID(static_cast<int>(std::ranges::count(choices_, label, &Choice::label)));
  const ImVec2 size{words.x + 2 * padding, words.y + 24 * px()};
  bool chosen = ImGui::Button(("##" + label).c_str(), size);
  const ImVec2 lo = ImGui::GetItemRectMin();
  render::Draw(fonts(), *ImGui::GetWindowDrawList(), *font, {lo.x + padding, lo.y + 12 * px()},
               ImGui::GetColorU32(ImGuiCol_Text), label);
  ImGui::PopID();
  ImGui::EndDisabled();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor(3);
  ImGui::PopFont();
  after_button_ = true;
  // Not in the list: the keys skip what cannot be chosen.
  if (!enabled) return false;
  Focused focus = Next(label);
  Listed(label, false);
  // Not even the only choice of a page loses something by Enter alone: that key is often pressed
  // before the page is read.
  if (look == Look::kDanger && !walked_) focus = {};
  if (focus.has) Ring();
  return chosen || focus.chosen;
}

bool Ui::Row(const std::string& title, const std::string& detail, const std::string& right,
             bool chosen_row) {
  Say(title + " | " + detail + " | " + right);
  const ImFont &far = *fonts().far, &text = *fonts().text;
  const float inset = 12 * px(), side = 26 * px(), between = 6 * px();
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + inset);
  const float width = ImGui::GetContentRegionAvail().x - inset;
  const ImVec2 right_size = render::SizeOf(fonts(), text, right);
  // The word on the right says what choosing does.
  const float wrap = width - 2 * side - (right.empty() ? 0 : right_size.x + 16 * px());
  const float title_height = render::SizeOf(fonts(), far, title, wrap).y;
  const float height =
      title_height + render::SizeOf(fonts(), text, detail, wrap).y + between + 24 * px();
  PushButtonColours(chosen_row ? kChosenRow : kRow);
  // Distinguishes rows with the same title.
  ImGui::PushID(static_cast<int>(std::ranges::count(choices_, title, &Choice::label)));
  bool chosen = ImGui::Button(("##" + title).c_str(), {width, height});
  ImGui::PopID();
  ImGui::PopStyleColor(3);
  Focused focus = Next(title);
  Listed(title, false);
  if (!blocked_) choices_.back().chosen = chosen_row;
  if (focus.has) Ring();
  ImVec2 lo = ImGui::GetItemRectMin(), hi = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  ImU32 plain = ImGui::GetColorU32(ImGuiCol_Text),
        quiet = ImGui::GetColorU32(ImGuiCol_TextDisabled);
  const float x = lo.x + side, top = lo.y + 8 * px();
  render::Draw(fonts(), list, far, {x, top}, plain, title, wrap);
  render::Draw(fonts(), list, text, {x, top + title_height + between}, quiet, detail, wrap);
  render::Draw(fonts(), list, text,
               {hi.x - side - right_size.x, lo.y + 0.5f * (height - right_size.y)}, plain, right);
  return chosen || focus.chosen;
}

bool Ui::Check(const std::string& label, bool& value) {
  Say(std::string(value ? "[x] " : "[ ] ") + label);
  // The box does not wrap its label.
  ImGui::BeginGroup();
  bool changed = ImGui::Checkbox(("##" + label).c_str(), &value);
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  render::Write(fonts(), label, ImGui::GetContentRegionAvail().x);
  if (ImGui::IsItemClicked()) {
    value = !value;
    changed = true;
  }
  ImGui::EndGroup();
  Focused focus = Next(label);
  Listed(label, false);
  if (focus.has) Ring();
  if (focus.chosen) {
    value = !value;
    changed = true;
  }
  return changed;
}

bool Ui::Field(const std::string& label, std::string& text, bool secret) {
  Say(label + ": " + (secret ? std::string(text.size(), '*') : text));
  ImGui::TextUnformatted(label.c_str());
  Focused focus = Next(label);
  // Enter and a click beside the field end its editing, but the ring stays. Not while it is edited:
  // that would select the text each time.
  if (focus.moved || (focus.has && ImGui::GetActiveID() == 0)) ImGui::SetKeyboardFocusHere();
  ImGui::PushFont(fonts().far);
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - 8 * px());
  bool entered =
      ImGui::InputText(("##" + label).c_str(), &text,
                       ImGuiInputTextFlags_EnterReturnsTrue |
                           (secret ? ImGuiInputTextFlags_Password : ImGuiInputTextFlags_None));
  ImGui::PopFont();
  Listed(label, true);
  if (focus.has) Ring();
  return entered;
}

void Ui::Bar(const std::string& label, double share) {
  if (!label.empty()) Text(label);
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, kMain);
  ImGui::ProgressBar(static_cast<float>(std::clamp(share, 0.0, 1.0)), {-1, 34 * px()}, "");
  ImGui::PopStyleColor();
}

void Ui::Score(const std::string& number, const std::string& of) {
  Say(number + of);
  float top = ImGui::GetCursorPosY(), height = fonts().score->FontSize;
  ImGui::PushFont(fonts().score);
  ImGui::TextUnformatted(number.c_str());
  ImGui::PopFont();
  ImGui::SameLine();
  ImGui::PushFont(fonts().far);
  // On the number's base line, as far as the two fonts' heights allow.
  ImGui::SetCursorPosY(top + 0.62f * height);
  ImGui::TextUnformatted(of.c_str());
  ImGui::PopFont();
  ImGui::SetCursorPosY(top + height);
}

void Ui::Line(const std::string& name, const std::string& value, const std::string& words,
              bool lost) {
  Say(name + " | " + value + " | " + words);
  ImVec4 colour = lost ? ImVec4{1, 0.78f, 0.50f, 1} : ImGui::GetStyleColorVec4(ImGuiCol_Text);
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  const ImVec2 from = ImGui::GetCursorPos();
  const float width = render::SizeOf(fonts(), *ImGui::GetFont(), value).x;
  const float at = ImGui::GetContentRegionMax().x - width - 30 * px();
  ImGui::SetCursorPosX(at);
  render::Write(fonts(), value);
  ImGui::SetCursorPos(from);
  // A long name continues below itself.
  render::Write(fonts(), name, at - from.x - 12 * px());
  ImGui::PopStyleColor();
  if (!words.empty()) {
    ImGui::Indent(kWords_px * px());
    Note(words);
    ImGui::Unindent(kWords_px * px());
  }
}

void Ui::BeginList(const char* name) {
  constexpr float kButtons_px = 110;  // in its first frame
  list_ = name;
  const auto known = below_.find(list_);
  const float below = known == below_.end() ? kButtons_px * px() : known->second;
  ImGui::BeginChild(name, {0, -std::max(below, 1.0f)}, false);
  Gap(8);  // for the ring around the first
}
void Ui::EndList() {
  ImGui::EndChild();
  list_end_ = ImGui::GetCursorPosY();
}

}  // namespace enamel::station::desk
