#pragma once

#include <string>
#include <string_view>

#include "common/language/words.h"
#include "common/scoring/mistakes/mistakes.h"

// The words of a score's mistakes, regions and groups in the language of its reader, made of their codes:
// schemas/words/*/exercise.json. Thread safety: as Words.
namespace enamel::language {

// What was done, a short line without a full stop: "Distal wall: over-extended by 0.32 mm".
std::string MistakeText(const Words& words, const scoring::Mistake& mistake);
// What the hand does differently next time, a sentence.
std::string RemedyText(const Words& words, const scoring::Mistake& mistake);
// "Distal wall": of a region's name, or of a kind of region. Empty for the whole; a name that no catalogue has is
// returned unchanged.
std::string PlaceText(const Words& words, std::string_view place);
// "Outline".
std::string GroupText(const Words& words, scoring::Group group);
// "To be changed".
std::string StateText(const Words& words, scoring::State state);
// A mistake's size as finely as people act on it, with its unit: "0.32 mm", "12°", "1.40 mm³", "8 %".
std::string SizeText(const Words& words, const scoring::Mistake& mistake);

}  // namespace enamel::language
