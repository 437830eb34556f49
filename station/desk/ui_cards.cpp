// Cards to choose from, and pictures; the other widgets are in ui.cpp.
#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>

#include "station/desk/ui.h"
#include "station/render/shaped_text.h"

namespace enamel::station::desk {
namespace {

constexpr float kCardInset = 18, kCardPicture = 84, kCardGap = 16, kRightGap = 20;  // px
// A card that is narrower has a word or two on a line.
constexpr float kMinCard_em = 20;
constexpr ImU32 kCard = IM_COL32(36, 41, 48, 255), kCardBelowMouse = IM_COL32(54, 60, 68, 255);

}  // namespace

// The title in the text's size, its lines in the smallest; nothing is cut off: all of it wraps.
float Ui::HeightOf(const Card& card, float width) const {
  const ImFont &text = *fonts().text, &near = *fonts().near;
  const float wrap = width - (2 * kCardInset + kCardPicture + kCardInset) * px();
  const float right =
      card.right.empty() ? 0 : render::SizeOf(fonts(), near, card.right).x + kRightGap * px();
  float height = render::SizeOf(fonts(), text, card.title, wrap - right).y;
  for (const std::string& line : card.lines)
    height += render::SizeOf(fonts(), near, line, wrap).y + 3 * px();
  return std::max(height, kCardPicture * px()) + 2 * kCardInset * px();
}

bool Ui::DrawCard(const Card& card, float width, float height) {
  std::string said = card.title;
  for (const std::string& line : card.lines) said += " | " + line;
  Say(said + " | " + card.right);
  ImGui::PushStyleColor(ImGuiCol_Button, kCard);
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, kCardBelowMouse);
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, kCardBelowMouse);
  const bool chosen = ImGui::Button("##card", {width, height});
  ImGui::PopStyleColor(3);
  const ImVec2 lo = ImGui::GetItemRectMin(), hi = ImGui::GetItemRectMax();
  const Focused focus = Next(card.title);
  Listed(card.title, false);
  if (focus.has) Ring();
  const float inset = kCardInset * px(), side = kCardPicture * px();
  if (card.picture) {
    const float top = lo.y + 0.5f * (height - side);
    card.picture({lo.x + inset, top, lo.x + inset + side, top + side});
  }
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImFont &text = *fonts().text, &near = *fonts().near;
  const ImU32 plain = ImGui::GetColorU32(ImGuiCol_Text),
              quiet = ImGui::GetColorU32(ImGuiCol_TextDisabled);
  const float x = lo.x + 2 * inset + side;
  float y = lo.y + inset, end = hi.x - inset;
  if (!card.right.empty()) {
    const float room = render::SizeOf(fonts(), near, card.right).x;
    render::Draw(fonts(), list, near, {end - room, y}, plain, card.right);
    end -= room + kRightGap * px();
  }
  auto write = [&](const ImFont& font, ImU32 colour, const std::string& words, float most) {
    y += render::Draw(fonts(), list, font, {x, y}, colour, words, most).y;
  };
  write(text, plain, card.title, end - x);
  for (const std::string& line : card.lines) {
    y += 3 * px();
    write(near, quiet, line, hi.x - inset - x);
  }
  return chosen || focus.chosen;
}

std::optional<size_t> Ui::Cards(std::span<const Card> cards, const std::string& heading) {
  if (cards.empty()) return std::nullopt;
  if (!heading.empty()) {
    Gap(4);
    Note(heading);
  }
  ImGui::PushID(heading.c_str());
  const float inset = 8 * px(), gap = kCardGap * px();  // for the ring
  float width = 0.5f * (ImGui::GetContentRegionAvail().x - 2 * inset - gap);
  const bool two = width >= kMinCard_em * fonts().near->FontSize;
  if (!two) width = 2 * width + gap;
  std::optional<size_t> chosen;
  for (size_t i = 0; i < cards.size(); ++i) {
    float height = HeightOf(cards[i], width);
    const size_t neighbour = i ^ 1;
    if (two && neighbour < cards.size())
      height = std::max(height, HeightOf(cards[neighbour], width));
    if (!two || i % 2 == 0) {
      ImGui::SetCursorPosX(ImGui::GetCursorPosX() + inset);
    } else {
      ImGui::SameLine(0, gap);
    }
    ImGui::PushID(static_cast<int>(i));
    if (DrawCard(cards[i], width, height)) chosen = i;
    ImGui::PopID();
  }
  ImGui::PopID();
  return chosen;
}

void Ui::Pictures(std::span<const Picture> pictures, const Page& where,
                  const std::function<void()>& below) {
  const auto w = static_cast<float>(screen_.width()), h = static_cast<float>(screen_.height());
  const int columns = pictures.size() > 2 ? 2 : 1;
  const auto rows = std::ceil(static_cast<float>(pictures.size()) / static_cast<float>(columns));
  ImGui::SetNextWindowPos({where.at_x * w, where.at_y * h});
  ImGui::SetNextWindowSize({where.width * w, where.height * h});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::Begin("pictures", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBackground |
                   ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::PushFont(fonts().near);
  const float gap = 12 * px(), line = ImGui::GetTextLineHeightWithSpacing() + gap;
  const float side = rows == 0
                         ? 0
                         : std::min((where.width * w - gap * static_cast<float>(columns - 1)) /
                                        static_cast<float>(columns),
                                    where.height * h / rows - line);
  const ImVec2 from = ImGui::GetCursorPos();
  for (size_t i = 0; i < pictures.size(); ++i) {
    const auto column = static_cast<float>(static_cast<int>(i) % columns),
               row = static_cast<float>(static_cast<int>(i) / columns);
    const ImVec2 at{from.x + column * (side + gap), from.y + row * (side + line)};
    ImGui::SetCursorPos(at);
    // The texture's first row is the lowest.
    ImGui::Image(reinterpret_cast<ImTextureID>(static_cast<intptr_t>(pictures[i].texture)),
                 {side, side}, {0, 1}, {1, 0});
    ImGui::SetCursorPosX(at.x);
    render::Write(fonts(), pictures[i].caption);
    if (!blocked_) Say(pictures[i].caption);
  }
  ImGui::SetCursorPos({from.x, from.y + rows * (side + line)});
  if (below) below();
  ImGui::PopFont();
  ImGui::End();
  ImGui::PopStyleVar();
}

}  // namespace enamel::station::desk
