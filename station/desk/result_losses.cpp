#include "station/desk/result_losses.h"

#include <algorithm>
#include <cmath>

#include "station/render/panel.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
namespace {

const scoring::Deduction* PlaceOf(const scoring::ScoreResult& score, const std::string& metric) {
  const scoring::Deduction* found = nullptr;
  auto shown_before = [](const scoring::Deduction& a, const scoring::Deduction& b) {
    if (a.strokes.empty() != b.strokes.empty()) return !a.strokes.empty();
    return a.volume_m3 > b.volume_m3;
  };
  for (const scoring::Deduction& each : score.deductions) {
    if (each.criterion != metric) continue;
    if (found == nullptr || shown_before(each, *found)) found = &each;
  }
  return found;
}

uint64_t Ticks(double seconds, uint32_t rate_hz) {
  return static_cast<uint64_t>(std::llround(seconds * rate_hz));
}

}  // namespace

std::vector<Loss> DearestLosses(const scoring::ScoreResult& score) {
  std::vector<Loss> out;
  for (const scoring::GateResult& g : score.gates) {
    if (g.share < 1) out.push_back({&g, nullptr, PlaceOf(score, g.name)});
  }
  for (const scoring::CriterionResult& c : score.criteria) {
    if (c.max_points - c.points > kLossShown) {
      out.push_back({nullptr, &c, PlaceOf(score, c.name)});
    }
  }
  std::ranges::stable_sort(out, [](const Loss& a, const Loss& b) {
    if (a.gate != nullptr && b.gate != nullptr) return a.gate->share < b.gate->share;
    if (a.gate != nullptr || b.gate != nullptr) return a.gate != nullptr;
    return a.points() > b.points();
  });
  out.resize(std::min(out.size(), kLossesShown));
  return out;
}

std::string NextStep(const Words& words, const scoring::ScoreResult& score) {
  const std::vector<Loss> losses = DearestLosses(score);
  if (losses.empty()) return {};
  const Loss& dearest = losses.front();
  const std::string title = WordedTitle(words, dearest.title());
  if (dearest.gate != nullptr) return words.Say("result.next_all", {{"title", title}});
  return words.Say("result.next",
                   {{"title", title}, {"points", NumberText(words, dearest.points(), 1)}});
}

std::string PlaceOfLossText(const Words& words, const scoring::Deduction& place) {
  if (place.left) return words.Say("loss.left");
  if (place.strokes.empty()) return words.Say("loss.place");
  const scoring::FaultStroke& stroke = place.strokes.front();
  return words.Say("loss.stroke", {{"stroke", std::to_string(stroke.number)},
                                   {"moment", render::TimerText(stroke.first_s)}});
}

ShownTicks TicksToShow(const scoring::Deduction& place, uint32_t rate_hz) {
  if (place.strokes.empty()) return {};
  const scoring::FaultStroke& stroke = place.strokes.front();
  const uint64_t first = stroke.first_tick, before = Ticks(kBeforeStroke_s, rate_hz);
  uint64_t from = first - std::min(first, before);
  uint64_t to = first + Ticks(stroke.lasts_s + kAfterStroke_s, rate_hz);
  const uint64_t most = Ticks(kLongestShown_s, rate_hz);
  if (to - from > most) {
    // The fault's half tick may be another stroke's.
    const uint64_t half = std::clamp(place.half_tick, from + most / 2, to - most / 2);
    from = half - most / 2;
    to = half + most / 2;
  }
  return {from, to};
}

}  // namespace enamel::station::desk
