#include "station/desk/exercise_list.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "station/desk/exercise_words.h"
#include "station/desk/pages.h"
#include "station/words/score_words.h"

namespace enamel::station::desk {
namespace {

constexpr int64_t kWeek_ms = int64_t{7} * 24 * 60 * 60 * 1000;

// Latin letters of Unicode's first block, where a capital is 32 below its small letter.
uint32_t Small(uint32_t code) {
  const bool ascii = code >= 'A' && code <= 'Z';
  const bool latin = code >= 0xC0 && code <= 0xDE && code != 0xD7;
  return ascii || latin ? code + 32 : code;
}

std::u32string Folded(std::string_view text) {
  std::u32string out;
  while (!text.empty()) {
    const std::optional<uint32_t> code = NextCodePoint(text);
    if (!code) text.remove_prefix(1);
    out += static_cast<char32_t>(code ? Small(*code) : 0xFFFD);
  }
  return out;
}

}  // namespace

const char* HeadingOf(ListGroup group) {
  switch (group) {
    case ListGroup::kDue:
      return "list.due";
    case ListGroup::kGraded:
      return "list.graded";
    case ListGroup::kPractice:
      return "list.practice";
    case ListGroup::kDone:
      return "list.done";
  }
  return "";
}

ListGroup GroupOf(const Catalogue::Exercise& exercise, int64_t now_unix_ms) {
  if (exercise.attempt_limit > 0 && exercise.attempts_left == 0) return ListGroup::kDone;
  const bool open = exercise.refusal.ok();
  if (open && exercise.due_unix_ms > 0 && exercise.due_unix_ms - now_unix_ms <= kWeek_ms) {
    return ListGroup::kDue;
  }
  const bool graded = exercise.exam || !exercise.facts || exercise.facts->graded;
  return graded ? ListGroup::kGraded : ListGroup::kPractice;
}

bool Matches(std::string_view typed, std::span<const std::string> texts) {
  const std::u32string wanted = Folded(typed);
  std::u32string all;
  for (const std::string& text : texts) all += Folded(text) + U"\n";
  for (size_t at = 0; at < wanted.size();) {
    const size_t end = std::min(wanted.find(U' ', at), wanted.size());
    if (all.find(wanted.substr(at, end - at)) == std::u32string::npos) return false;
    at = end + 1;
  }
  return true;
}

std::vector<size_t> Listed(const language::Words& words,
                           std::span<const Catalogue::Exercise> exercises, ListGroup group,
                           std::string_view typed, int64_t now_unix_ms) {
  std::vector<size_t> out;
  for (size_t i = 0; i < exercises.size(); ++i) {
    if (GroupOf(exercises[i], now_unix_ms) != group) continue;
    const std::array texts = {WordedTitle(words, exercises[i].title),
                              PlaceText(words, exercises[i])};
    if (Matches(typed, texts)) out.push_back(i);
  }
  if (group == ListGroup::kDue) {
    std::ranges::stable_sort(out, {}, [&](size_t i) { return exercises[i].due_unix_ms; });
  }
  return out;
}

void Ui::Typed(std::string& text) {
  const bool in_field = focus_ < shown_.size() && shown_[focus_].field;
  if (blocked_ || in_field) return;
  const std::string before = text;
  for (const render::InputEvent& event : screen_.events()) {
    const bool erase = event.kind == render::InputEvent::Kind::kKey && event.pressed &&
                       event.code == render::kKeyBackspace;
    while (erase && !text.empty()) {
      const bool begins = (static_cast<unsigned char>(text.back()) & 0xC0) != 0x80;
      text.pop_back();
      if (begins) break;
    }
    if (event.kind != render::InputEvent::Kind::kCharacter) continue;
    // A space before any letter chooses what has the focus.
    if (event.code == ' ' && text.empty()) continue;
    std::array<char, 5> letter{};
    ImTextCharToUtf8(letter.data(), static_cast<unsigned>(event.code));
    text += letter.data();
  }
  typed_ = 0;
  for (std::string_view rest = text; !rest.empty(); ++*typed_) {
    if (!NextCodePoint(rest)) rest.remove_prefix(1);
  }
  // What had it may be gone.
  if (text != before) focus_ = 0;
}

std::vector<Pages::Section> Pages::Sections(bool grouped) {
  const Words& words = flow_.words();
  const auto& all = flow_.exercises();
  const int64_t now = UnixMs();
  std::vector<Section> out(1);
  const auto add = [&](Card card, std::function<void()> step) {
    out.back().cards.push_back(std::move(card));
    out.back().steps.push_back(std::move(step));
  };
  const auto add_attempt = [&](const SpooledAttempt& attempt, std::string_view title,
                               const std::string& text, std::string_view right,
                               std::function<void()> step) {
    Card card = AttemptCard(attempt, title, text, right);
    std::vector<std::string> texts = card.lines;
    texts.push_back(card.title);
    if (Matches(search_, texts)) add(std::move(card), std::move(step));
  };
  const auto add_exercises = [&](const std::vector<size_t>& indices) {
    for (const size_t i : indices) {
      add(CardOf(words, all[i], now), [this, i] { flow_.ChooseExercise(i); });
    }
  };
  for (size_t i = 0; i < flow_.cut_off().size(); ++i) {
    const SpooledAttempt& attempt = flow_.cut_off()[i];
    add_attempt(attempt, "exercises.cut_off",
                CutOffText(words, attempt, flow_.DeviceNamed(attempt.profile), now),
                "exercises.go_on", [this, i] { flow_.OpenCutOff(i); });
  }
  if (grouped) {
    for (const ListGroup group : kListGroups) {
      out.push_back({Say(HeadingOf(group)), {}, {}});
      add_exercises(Listed(words, all, group, search_, now));
    }
  } else {
    std::vector<size_t> in_order(all.size());
    std::iota(in_order.begin(), in_order.end(), size_t{0});
    add_exercises(in_order);
  }
  // They are done, whatever the list is.
  for (size_t i = 0; i < flow_.handed_in().size(); ++i) {
    const SpooledAttempt& attempt = flow_.handed_in()[i];
    add_attempt(attempt, "exercises.result",
                HandedInText(words, attempt, flow_.DeviceNamed(attempt.profile), now),
                "exercises.look", [this, i] { flow_.OpenHandedIn(i); });
  }
  return out;
}

void Pages::ExerciseList() {
  const bool grouped = flow_.exercises().size() >= kLongList;
  if (!grouped) search_.clear();
  if (grouped) {
    ui_.Typed(search_);
    ui_.Note(search_.empty() ? Say("list.search") : Say("list.searching", {{"typed", search_}}));
  }
  const std::vector<Section> sections = Sections(grouped);
  ui_.BeginList("exercises");
  std::function<void()> chosen;
  bool any = false;
  for (const Section& section : sections) {
    any |= !section.cards.empty();
    if (const auto one = ui_.Cards(section.cards, section.heading)) chosen = section.steps[*one];
  }
  if (flow_.exercises().empty() && !flow_.busy()) ui_.Text(Say("exercises.none"));
  if (!any && !search_.empty()) ui_.Text(Say("list.nothing"));
  ui_.EndList();
  // Once all is drawn: a step may change what there is.
  if (chosen) chosen();
}

}  // namespace enamel::station::desk
