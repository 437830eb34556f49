#include "station/desk/result_losses.h"

#include <algorithm>
#include <cmath>

#include "station/render/panel.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
namespace {

const scoring::Deduction* PlaceOf(const scoring::ScoreResult& score, size_t mistake) {
  const scoring::Deduction* found = nullptr;
  auto shown_before = [](const scoring::Deduction& a, const scoring::Deduction& b) {
    if (a.strokes.empty() != b.strokes.empty()) return !a.strokes.empty();
    return a.volume_m3 > b.volume_m3;
  };
  for (const scoring::Deduction& each : score.deductions) {
    if (each.mistake != mistake) continue;
    if (found == nullptr || shown_before(each, *found)) found = &each;
  }
  return found;
}

uint64_t Ticks(double seconds, uint32_t rate_hz) {
  return static_cast<uint64_t>(std::llround(seconds * rate_hz));
}

}  // namespace

std::vector<Loss> LossesOf(const scoring::ScoreResult& score) {
  std::vector<Loss> out;
  for (size_t i = 0; i < score.mistakes.size(); ++i) {
    const scoring::Mistake& mistake = score.mistakes[i];
    if (mistake.points >= scoring::kWorthAdvice) out.push_back({&mistake, PlaceOf(score, i)});
  }
  return out;
}

std::string CountText(const Words& words, const scoring::ScoreResult& score) {
  if (score.mistakes.empty()) return words.Say("result.no_mistake");
  const auto count = static_cast<int64_t>(LossesOf(score).size());
  return count == 0 ? words.Say("result.small_mistakes")
                    : words.Say("result.mistakes", {{"count", count}});
}

std::string LostText(const Words& words, double points) {
  if (points <= kLossShown) return "0";
  return "\u2212" + NumberText(words, points, 1);
}

std::string StrokeText(const Words& words, const scoring::Deduction& place) {
  if (place.strokes.empty()) return {};
  const scoring::FaultStroke& stroke = place.strokes.front();
  return words.Say("result.stroke", {{"stroke", std::to_string(stroke.number)},
                                     {"moment", render::TimerText(stroke.first_s)}});
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
