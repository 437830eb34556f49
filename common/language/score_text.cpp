#include "common/language/score_text.h"

#include "common/scoring/reasons.h"

namespace enamel::language {
namespace {

std::string Key(const char* kind, std::string_view name) {
  return std::string(kind) + '.' + std::string(name);
}

}  // namespace

std::string MistakeText(const Words& words, const scoring::Mistake& mistake) {
  return words.Say(
      Key("mistake", NameOf(mistake.kind)),
      {{"place", PlaceText(words, mistake.place)}, {"size", SizeText(words, mistake)}});
}

std::string RemedyText(const Words& words, const scoring::Mistake& mistake) {
  return words.Say(Key("mistake_do", NameOf(mistake.kind)));
}

std::string PlaceText(const Words& words, std::string_view place) {
  const std::string key = Key("place", place);
  return words.Has(key) ? words.Say(key) : std::string(place);
}

std::string GroupText(const Words& words, scoring::Group group) {
  return words.Say(Key("group", NameOf(group)));
}

std::string StateText(const Words& words, scoring::State state) {
  return words.Say(Key("grade_state", NameOf(state)));
}

std::string SizeText(const Words& words, const scoring::Mistake& mistake) {
  constexpr int kMaxDigits = 4;
  const std::string_view unit = UnitOf(mistake.kind);
  int digits = unit == "%" ? 0 : scoring::UsualDigits(unit);
  while (digits < kMaxDigits && words.Decimal(mistake.size, digits) == words.Decimal(0, digits)) {
    ++digits;
  }
  return scoring::WithUnit(words.Decimal(mistake.size, digits), unit);
}

}  // namespace enamel::language
