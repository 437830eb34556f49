#include "station/desk/exercise_words.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <string_view>
#include <utility>

#include "common/scene/builtin/builtin.h"
#include "common/scene/restoration.h"
#include "station/desk/problem_words.h"
#include "station/render/panel.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
namespace {

// "3 days", "5 hours", "1 minute".
std::string SpanText(const Words& words, int64_t span_ms) {
  int64_t minutes = std::max<int64_t>(span_ms, 0) / 60'000;
  // From two on, so that nearly two days are not shown as one.
  if (minutes >= 2 * 24 * 60) return words.Say("span.days", {{"count", minutes / (24 * 60)}});
  if (minutes >= 2 * 60) return words.Say("span.hours", {{"count", minutes / 60}});
  return words.Say("span.minutes", {{"count", minutes}});
}

// In this computer's time zone, as ISO 8601 writes it: the same for every language.
std::string DateText(int64_t unix_ms) {
  const auto at = static_cast<std::time_t>(unix_ms / 1000);
  std::tm local{};
  localtime_r(&at, &local);
  char text[32];
  const size_t size = std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local);
  return {text, size};
}

// "occlusal", for the landmark that an exercise cuts at.
std::string SurfaceKey(const Catalogue::Facts& facts) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kSurfaces = {{
      {"occlusal_centre", "surface.occlusal"},
      {"caries", "surface.occlusal"},
      {"chamber", "surface.occlusal"},
      {"mesial_box", "surface.mesial"},
      {"class_5", "surface.buccal"},
      {"labial_face", "surface.labial"},
      {"crown_top", "surface.crown"},
  }};
  for (const auto& [landmark, key] : kSurfaces) {
    if (landmark == facts.landmark) return std::string(key);
  }
  return {};
}

}  // namespace

std::string FactsText(const Words& words, const scene::Exercise& exercise,
                      const std::string& scene_title, bool exam) {
  // An exam's score is held back whatever its exercise says.
  std::string facts = words.Say(exercise.graded || exam ? "exercise.graded" : "exercise.practice",
                                {{"scene", WordedTitle(words, scene_title)}});
  if (exercise.time_limit_s > 0) {
    facts = words.Say("exercise.time",
                      {{"facts", facts}, {"time", render::TimerText(exercise.time_limit_s)}});
  }
  const auto material = scene::RestorationName(exercise.rubric.restoration);
  if (material.empty()) return facts;
  return words.Say("restoration." + std::string(material), {{"facts", facts}});
}

std::string PlaceText(const Words& words, const Catalogue::Exercise& exercise) {
  if (!exercise.facts || exercise.facts->tooth == 0) return {};
  const Catalogue::Facts& facts = *exercise.facts;
  const std::string key = SurfaceKey(facts), tooth = std::to_string(facts.tooth);
  std::string text = key.empty() ? words.Say("card.tooth", {{"tooth", tooth}})
                                 : words.Say("card.tooth_surface",
                                             {{"tooth", tooth}, {"surface", words.Say(key)}});
  if (facts.caries) text = words.Say("card.with_caries", {{"place", text}});
  if (facts.neighbours) text = words.Say("card.between_neighbours", {{"place", text}});
  return text;
}

Card CardOf(const Words& words, const Catalogue::Exercise& exercise, int64_t now_unix_ms) {
  Card card;
  card.title = WordedTitle(words, exercise.title);
  if (std::string place = PlaceText(words, exercise); !place.empty()) card.lines.push_back(place);
  std::string terms = AssignmentText(words, exercise, now_unix_ms);
  if (exercise.facts && exercise.refusal.ok()) {
    terms = words.Say(exercise.facts->graded ? "card.graded" : "card.practice", {{"terms", terms}});
  }
  card.lines.push_back(terms);
  if (exercise.best_score) {
    card.lines.push_back(
        words.Say("card.best", {{"score", words.Decimal(*exercise.best_score, 0)}}));
  }
  if (!exercise.last_remark.empty()) {
    card.lines.push_back(words.Say("card.remark", {{"text", exercise.last_remark}}));
  }
  if (exercise.exam) card.right = words.Say("exercises.exam");
  if (exercise.facts) {
    card.picture = [facts = *exercise.facts](const Rect& at) { DrawToothSymbol(facts, at); };
  }
  return card;
}

std::string AssignmentText(const Words& words, const Catalogue::Exercise& exercise,
                           int64_t now_unix_ms) {
  if (!exercise.refusal.ok()) return RefusalText(words, exercise);
  std::string due, left;
  if (exercise.due_unix_ms > 0) {
    const int64_t span_ms = exercise.due_unix_ms - now_unix_ms;
    due = span_ms / 60'000 < 0
              ? words.Say("assignment.late")
              : words.Say("assignment.due", {{"date", DateText(exercise.due_unix_ms)},
                                             {"span", SpanText(words, span_ms)}});
  }
  if (exercise.attempt_limit > 0) {
    left = words.Say("assignment.left", {{"count", int64_t{exercise.attempts_left}}});
  }
  if (!due.empty() && !left.empty()) {
    return words.Say("assignment.due_and_left", {{"due", due}, {"left", left}});
  }
  if (due.empty() && left.empty()) return words.Say("assignment.free");
  return due.empty() ? left : due;
}

std::string DeviceText(const Words& words, std::string_view profile,
                       std::span<const Catalogue::Profile> profiles) {
  // Its title is the server's, in English.
  if (profile == "pointer") return words.Say("device.no_force");
  const auto listed = std::ranges::find(profiles, profile, &Catalogue::Profile::name);
  if (listed != profiles.end()) return listed->title;
  // Without the server.
  for (const scene::DeviceProfile& known : scene::BuiltinProfiles()) {
    if (known.name == profile) return known.title;
  }
  return std::string(profile);
}

std::string CutOffText(const Words& words, const SpooledAttempt& attempt, const std::string& device,
                       int64_t now_unix_ms) {
  return words.Say(
      "cut_off.text",
      {{"device", device}, {"span", SpanText(words, now_unix_ms - attempt.created_unix_ms)}});
}

std::string HandedInText(const Words& words, const SpooledAttempt& attempt,
                         const std::string& device, int64_t now_unix_ms) {
  return words.Say(
      attempt.complete() ? "handed_in.whole" : "handed_in.partly",
      {{"span", SpanText(words, now_unix_ms - attempt.created_unix_ms)}, {"device", device}});
}

std::string ReservedText(const Words& words, const ReservedAttempt& reserved,
                         const std::string& device, int64_t now_unix_ms) {
  return words.Say("reserved.row",
                   {{"person", reserved.ticket.person},
                    {"device", device},
                    {"span", SpanText(words, reserved.ticket.expires_unix_ms - now_unix_ms)}});
}

std::string RefusalText(const Words& words, const Catalogue::Exercise& exercise) {
  const Status& refusal = exercise.refusal;
  if (refusal.ok()) return {};
  if (refusal.field() == "opens") {
    return words.Say("assignment.opens", {{"date", DateText(exercise.opens_unix_ms)}});
  }
  if (refusal.field() == "due") {
    return words.Say("assignment.over", {{"date", DateText(exercise.due_unix_ms)}});
  }
  if (refusal.field() == "attempt_limit") {
    return words.Say("assignment.used", {{"count", int64_t{exercise.attempt_limit}}});
  }
  if (refusal.field() == "stations") {
    return words.Say("assignment.stations", {{"stations", exercise.stations}});
  }
  return ProblemText(words, refusal);
}

}  // namespace enamel::station::desk
