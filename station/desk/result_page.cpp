// The dearest losses on the result page, and the page that shows one on the tooth.
#include <imgui.h>

#include "station/desk/pages.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
namespace {

std::string LossText(const Words& words, const Loss& loss) {
  return loss.gate != nullptr ? ReasonText(words, *loss.gate) : DetailText(words, *loss.criterion);
}

// Over the picture, below the page.
void DrawRing(const LossView::Ring& ring, float px) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImVec2 middle{ring.middle_px.x, ring.middle_px.y};
  // Bright on dark, to be seen on enamel as on the background.
  list->AddCircle(middle, ring.radius_px, IM_COL32(0, 0, 0, 200), 0, 8 * px);
  list->AddCircle(middle, ring.radius_px, IM_COL32(255, 200, 60, 255), 0, 4 * px);
}

}  // namespace

void Pages::Losses(const std::vector<Loss>& losses) {
  for (const Loss& loss : losses) {
    const bool gate = loss.gate != nullptr;
    ui_.Line(
        WordedTitle(flow_.words(), loss.title()),
        gate ? flow_.words().Decimal(100 * loss.gate->share, 0) + " %" : Points(*loss.criterion),
        LossText(flow_.words(), loss), true);
    if (loss.place == nullptr) continue;
    if (ui_.Button(Say("result.show"), Ui::Look::kSmall, !flow_.busy())) flow_.ShowLoss(loss);
    ui_.Gap(8);
  }
}

void Pages::ShownLoss() {
  const Loss& loss = flow_.loss_shown();
  ui_.Begin("loss", {0.02f, 0.04f, 0.34f, 0.5f, true});
  ui_.Text(WordedTitle(flow_.words(), loss.title()));
  ui_.Note(LossText(flow_.words(), loss));
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

}  // namespace enamel::station::desk
