// The dearest losses on the result page, and the page that shows one on the tooth.
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "common/language/score_text.h"
#include "station/desk/pages.h"
#include "station/desk/stop_sign.h"
#include "station/render/materials.h"

namespace enamel::station::desk {
namespace {

// Over the picture, below the page.
void DrawRing(const LossView::Ring& ring, float px) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImVec2 middle{ring.middle_px.x, ring.middle_px.y};
  // Bright on dark, to be seen on enamel as on the background.
  list->AddCircle(middle, ring.radius_px, IM_COL32(0, 0, 0, 200), 0, 8 * px);
  list->AddCircle(middle, ring.radius_px, IM_COL32(255, 200, 60, 255), 0, 4 * px);
}

// The scale of the deviation, from less removed to more.
void DrawScale(float width, float height) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 from = ImGui::GetCursorScreenPos();
  const float step = width / render::kDeviationSteps;
  for (int i = 0; i < render::kDeviationSteps; ++i) {
    const uint32_t c = render::DeviationColour(i);
    const auto x = from.x + step * static_cast<float>(i);
    list->AddRectFilled({x, from.y}, {x + step, from.y + height},
                        IM_COL32(c >> 16, c >> 8 & 255, c & 255, 255));
  }
  ImGui::Dummy({width, height});
}

// Points of 100 from attempt to attempt; a ring around the one shown.
void DrawCurve(const std::vector<AttemptProgress::Score>& scores, const Uuid& shown, float width,
               float height, float px) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float dot = 5 * px, inset = 3 * dot, figures = ImGui::CalcTextSize("100").x + 12 * px;
  ImVec2 from = ImGui::GetCursorScreenPos();
  from.x += figures;
  width -= figures;
  const ImU32 quiet = IM_COL32(255, 255, 255, 60), line = IM_COL32(120, 180, 255, 255);
  auto place = [&](size_t i) {
    const float along =
        scores.size() < 2 ? 0.5f : static_cast<float>(i) / static_cast<float>(scores.size() - 1);
    const auto up = static_cast<float>(std::clamp(scores[i].score, 0.0, 100.0) / 100);
    return ImVec2{from.x + inset + along * (width - 2 * inset),
                  from.y + height - inset - up * (height - 2 * inset)};
  };
  for (const auto& [share, points] : {std::pair{0.0f, "100"}, {0.5f, "50"}, {1.0f, "0"}}) {
    const float y = from.y + inset + share * (height - 2 * inset);
    list->AddLine({from.x, y}, {from.x + width, y}, quiet, std::max(1.0f, px));
    const ImVec2 size = ImGui::CalcTextSize(points);
    list->AddText({from.x - size.x - 6 * px, y - 0.5f * size.y},
                  ImGui::GetColorU32(ImGuiCol_TextDisabled), points);
  }
  for (size_t i = 0; i < scores.size(); ++i) {
    if (i > 0) list->AddLine(place(i - 1), place(i), line, 3 * px);
    list->AddCircleFilled(place(i), dot, line);
    if (scores[i].attempt == shown) {
      list->AddCircle(place(i), 2 * dot, IM_COL32(255, 255, 255, 255), 0, 3 * px);
    }
  }
  ImGui::Dummy({figures + width, height});
}

}  // namespace

std::vector<Picture> Pages::PicturesOfResult() {
  std::vector<Picture> out;
  const ResultPictures* all = flow_.pictures();
  if (all == nullptr) return out;
  auto add = [&](const ResultPictures::Still& still, const char* caption) {
    if (still) out.push_back({render::TextureOf(*still), Say(caption)});
  };
  add(all->before, "result.before");
  add(all->after, "result.after");
  add(all->target, "result.target");
  add(all->deviation, "result.deviation");
  return out;
}

void Pages::BelowPictures() {
  constexpr float kScale_px = 18, kCurve_px = 120;
  const float width = ImGui::GetContentRegionAvail().x;
  if (flow_.pictures() != nullptr && flow_.pictures()->deviation) {
    DrawScale(width, kScale_px * ui_.px());
    ui_.Text(
        Say("result.scale", {{"range", flow_.words().Decimal(render::kDeviationRange_mm, 1)}}));
  }
  const auto& progress = flow_.progress();
  if (!progress || !flow_.score() || progress->scores.size() < 2) return;
  DrawCurve(progress->scores, flow_.result_attempt(), width, kCurve_px * ui_.px(), ui_.px());
  ui_.Text(Say("result.curve", {{"count", std::to_string(progress->scores.size())}}));
}

void Pages::Losses(const std::vector<Loss>& losses) {
  const Words& words = flow_.words();
  for (const Loss& loss : losses) {
    ui_.Line(language::MistakeText(words, *loss.mistake), LostText(words, loss.mistake->points),
             language::RemedyText(words, *loss.mistake), true);
    if (loss.place == nullptr) continue;
    if (const std::string stroke = StrokeText(words, *loss.place); !stroke.empty()) {
      ui_.Indent();
      ui_.Note(stroke);
    }
    ui_.Indent();
    if (ui_.Button(Say("result.show"), Ui::Look::kSmall, !flow_.busy())) flow_.ShowLoss(loss);
    ui_.Gap(8);
  }
}

void Pages::ShownLoss() {
  const Loss& loss = flow_.loss_shown();
  ui_.Begin("loss", {0.02f, 0.04f, 0.34f, 0.5f, true});
  ui_.Text(language::MistakeText(flow_.words(), *loss.mistake));
  ui_.Note(language::RemedyText(flow_.words(), *loss.mistake));
  ui_.Text(PlaceOfLossText(flow_.words(), *loss.place));
  LossView& view = *flow_.loss();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  DrawRing(view.RingIn(static_cast<int>(size.x), static_cast<int>(size.y)), ui_.px());
  if (!view.drawn()) ui_.Note(Say("ready.drawing"));
  ui_.Problem(flow_.problem());
  ui_.Gap(8);
  if (!loss.place->strokes.empty()) {
    if (ui_.Button(Say("loss.again"), Ui::Look::kMain, view.over() && !flow_.busy())) {
      flow_.ShowLoss(loss);
    }
    ui_.SameLine();
  }
  const bool back = ui_.Button(Say("exercise.back")) || ui_.escape();
  ui_.End();
  if (back) flow_.LeaveLoss();
}

// As while an attempt runs: keys and mouse belong to the handpiece.
void Pages::Practice() {
  ui_.Begin("practice", Ui::OnFloor(0.38f));
  ui_.Text(Say("practice.note"));
  if (flow_.attempt()->by_pointer()) {
    ui_.OneLine(Say("practice.keys"));
  } else if (ui_.Button(Say("running.pause"))) {
    flow_.Open(Dialog::kPracticePaused);
  }
  if (ui_.escape() || ui_.pressed('F')) flow_.Open(Dialog::kPracticePaused);
  ui_.End();
}

void Pages::PracticePaused() {
  ui_.BeginDialog("practice-paused", Say("paused.title"), Ui::Space::kIsThePedal);
  DrawStopSign(Stop::kPaused, ui_.Square(kSign_px));
  ui_.Text(Say("practice.note"));
  ui_.Gap(12);
  if (ui_.Button(Say("paused.go_on"), Ui::Look::kMain) || ui_.escape()) flow_.CloseDialog();
  ui_.SameLine();
  const bool unrecorded = flow_.way() == Way::kPractice;
  if (ui_.Button(Say(unrecorded ? "practice.end_unrecorded" : "practice.end"))) flow_.EndPractice();
  ui_.EndDialog();
}

}  // namespace enamel::station::desk
