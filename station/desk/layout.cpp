#include "station/desk/layout.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace enamel::station::desk {
namespace {

constexpr float kSlack_px = 1.5f;  // of letters' soft edges
// Neighbouring letters share soft edges; words over words share most of a letter.
constexpr float kOverlap = 0.4f;

struct Letter {
  ImRect at;
  ImWchar code = 0;
  bool cut_off = false;
};
// All of one draw list, in the order in which they are read.
struct Sheet {
  std::string name;
  std::vector<Letter> letters;
};

using Corner = std::pair<float, float>;
struct Shape {
  ImWchar code;
  Corner end;
};
// By the first corner of its place in the fonts' texture.
using Shapes = std::map<Corner, Shape>;

Shapes ShapesOf(const ImFontAtlas& atlas) {
  Shapes shapes;
  for (const ImFont* font : atlas.Fonts) {
    for (const ImFontGlyph& glyph : font->Glyphs) {
      shapes[{glyph.U0, glyph.V0}] = {static_cast<ImWchar>(glyph.Codepoint), {glyph.U1, glyph.V1}};
    }
  }
  return shapes;
}

// Boxes and lines are drawn with a single place of the texture, or a row of it.
bool IsLetter(const ImDrawVert& first, const ImDrawVert& last) {
  return first.uv.x != last.uv.x && first.uv.y != last.uv.y;
}

// The letters of a command, two triangles each.
void Collect(const ImDrawList& list, const ImDrawCmd& command, const Shapes& shapes, bool scrolls,
             Sheet& sheet) {
  const ImDrawIdx* index = list.IdxBuffer.Data + command.IdxOffset;
  const ImDrawVert* vertices = list.VtxBuffer.Data + command.VtxOffset;
  const ImVec4& clip = command.ClipRect;
  for (unsigned i = 0; i + 6 <= command.ElemCount;) {
    const ImDrawVert &first = vertices[index[i]], &last = vertices[index[i + 2]];
    const bool square = index[i] == index[i + 3] && index[i + 2] == index[i + 4];
    if (!square || !IsLetter(first, last)) {
      i += 3;
      continue;
    }
    i += 6;
    Letter letter{{first.pos, last.pos}};
    // One that its box has trimmed has another place in the texture.
    const auto shape = shapes.find({first.uv.x, first.uv.y});
    const bool whole = shape != shapes.end() && shape->second.end == Corner{last.uv.x, last.uv.y};
    letter.code = shape == shapes.end() ? L'…' : shape->second.code;
    const bool above = letter.at.Min.y < clip.y - kSlack_px || letter.at.Max.y > clip.w + kSlack_px;
    letter.cut_off = !whole || letter.at.Min.x < clip.x - kSlack_px ||
                     letter.at.Max.x > clip.z + kSlack_px || (above && !scrolls);
    if (scrolls && above) continue;  // out of its list, or about to be
    sheet.letters.push_back(letter);
  }
}

// The words around a letter.
std::string Around(const Sheet& sheet, size_t at) {
  constexpr size_t kAround = 16;
  const size_t from = at - std::min(at, kAround), to = std::min(sheet.letters.size(), at + kAround);
  std::string text;
  for (size_t i = from; i < to; ++i) {
    char letter[5] = {};
    ImTextCharToUtf8(letter, sheet.letters[i].code);
    text += letter;
  }
  const ImVec2 place = sheet.letters[at].at.Min;
  return "'" + text + "' at " + std::to_string(std::lround(place.x)) + ", " +
         std::to_string(std::lround(place.y)) + " in " + sheet.name;
}

// One fault for a line of letters.
void FindCutOff(const Sheet& sheet, const ImRect& window, std::vector<std::string>& faults) {
  bool before = false;
  for (size_t i = 0; i < sheet.letters.size(); ++i) {
    const Letter& letter = sheet.letters[i];
    ImRect room = window;
    room.Expand(kSlack_px);
    const bool now = letter.cut_off || !room.Contains(letter.at);
    if (now && !before) faults.push_back("cut off: " + Around(sheet, i));
    before = now;
  }
}

void FindOverlaps(const Sheet& one, const Sheet& other, std::vector<std::string>& faults) {
  bool before = false;
  for (size_t i = 0; i < one.letters.size(); ++i) {
    const ImRect& at = one.letters[i].at;
    size_t over = other.letters.size();
    for (size_t j = &one == &other ? i + 1 : 0; j < other.letters.size(); ++j) {
      ImRect shared = other.letters[j].at;
      if (!shared.Overlaps(at)) continue;
      const float smaller = std::min(at.GetArea(), shared.GetArea());
      shared.ClipWith(at);
      if (shared.GetArea() > kOverlap * smaller) over = j;
    }
    const bool now = over < other.letters.size();
    if (now && !before) {
      faults.push_back("over each other: " + Around(one, i) + " and " + Around(other, over));
    }
    before = now;
  }
}

void FindTooLong(const ImGuiWindow& window, std::vector<std::string>& faults) {
  const bool child = (window.Flags & ImGuiWindowFlags_ChildWindow) != 0;
  if (window.ScrollMax.x > 0 || (!child && window.ScrollMax.y > 0)) {
    faults.push_back("longer than its place: " + std::string(window.Name));
  }
  const float line = ImGui::GetIO().Fonts->Fonts[0]->FontSize;
  if (child && window.ScrollMax.y > 0 && window.InnerRect.GetHeight() < 3 * line) {
    faults.push_back("no room for a line: " + std::string(window.Name));
  }
}

// What dims the page below it, or is laid over all by those who know it.
bool Covers(const std::string& name) { return name == "dialog" || name == "operator"; }

}  // namespace

std::vector<std::string> LayoutFaults(std::span<const Choice> choices) {
  std::vector<std::string> faults;
  const ImDrawData& drawn = *ImGui::GetDrawData();
  const ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  const Shapes shapes = ShapesOf(atlas);
  const ImRect whole(drawn.DisplayPos.x, drawn.DisplayPos.y,
                     drawn.DisplayPos.x + drawn.DisplaySize.x,
                     drawn.DisplayPos.y + drawn.DisplaySize.y);
  std::vector<Sheet> sheets;
  for (int i = 0; i < drawn.CmdListsCount; ++i) {
    const ImDrawList& list = *drawn.CmdLists[i];
    Sheet sheet{list._OwnerName != nullptr ? list._OwnerName : "", {}};
    const ImGuiWindow* window = ImGui::FindWindowByName(sheet.name.c_str());
    const bool scrolls = window != nullptr && (window->Flags & ImGuiWindowFlags_ChildWindow) != 0;
    for (const ImDrawCmd& command : list.CmdBuffer) {
      // Pictures have textures of their own.
      if (command.UserCallback != nullptr || command.GetTexID() != atlas.TexID) continue;
      Collect(list, command, shapes, scrolls, sheet);
    }
    // A dialog's page can be read again once it is closed.
    if (Covers(sheet.name)) sheets.clear(), faults.clear();
    if (window != nullptr) FindTooLong(*window, faults);
    sheets.push_back(std::move(sheet));
  }
  for (size_t i = 0; i < sheets.size(); ++i) {
    FindCutOff(sheets[i], whole, faults);
    for (size_t j = i; j < sheets.size(); ++j) FindOverlaps(sheets[i], sheets[j], faults);
  }
  for (const Choice& choice : choices) {
    if (choice.whole || (choice.in_list && !choice.chosen)) continue;
    faults.push_back((choice.in_list ? "chosen and not seen: [" : "not whole: [") + choice.label +
                     "] at " + std::to_string(std::lround(choice.at.x0)) + ", " +
                     std::to_string(std::lround(choice.at.y0)) + " to " +
                     std::to_string(std::lround(choice.at.x1)) + ", " +
                     std::to_string(std::lround(choice.at.y1)));
  }
  return faults;
}

}  // namespace enamel::station::desk
