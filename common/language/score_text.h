#pragma once

#include <string>
#include <string_view>

#include "common/language/words.h"
#include "common/scoring/mistakes/mistakes.h"

// The words of a score's mistakes, regions and groups in the language of its reader, made of their codes:
// schemas/words/*/exercise.json. Thread safety: as Words.
namespace enamel::language {

// Says what was done, in a short line without a full stop: "Distal wall: over-extended by 0.32 mm".
std::string MistakeText(const Words& words, const scoring::Mistake& mistake);
// Tells the hand what to do differently next time, in a sentence.
std::string RemedyText(const Words& words, const scoring::Mistake& mistake);
// Names a region, or a kind of region: "Distal wall". Empty for the whole. Returns a name that no catalogue has
// unchanged.
std::string PlaceText(const Words& words, std::string_view place);
// "Outline".
std::string GroupText(const Words& words, scoring::Group group);
// "To be changed".
std::string StateText(const Words& words, scoring::State state);
// Says a mistake's size with its unit, as finely as people act on it and never as 0, as the page does: "0.32 mm", "12.0°",
// "1.40 mm³", "8 %".
std::string SizeText(const Words& words, const scoring::Mistake& mistake);

}  // namespace enamel::language
