#pragma once

#include <string>
#include <string_view>

#include "common/language/words.h"
#include "common/scoring/score.h"

// What a score and a built-in exercise say, in the language of the window. The server gives both in English: a score
// with the codes of its reasons (schemas/score.md, "Reasons"), a built-in text as the name of its own message
// (schemas/words.md). The page makes the same sentences of the same messages: schemas/golden/reasons_said.json is read
// by the tests of both. Thread safety: as Words.
namespace enamel::station::desk {

using language::Words;

// "Class I occlusal cavity", "Walls upright". What a school has written comes back as it is.
std::string WordedTitle(const Words& words, std::string_view title);
// Instructions, or the comment of a criterion: sentence by sentence. Where one of them is not built in, none is
// translated.
std::string WordedText(const Words& words, std::string_view text);

// Each reason a sentence, then the rubric's comment. The server's own text where a code is not known, of a newer server,
// or there is none, of scores before version 4.
std::string ReasonText(const Words& words, const scoring::CriterionResult& criterion);
std::string ReasonText(const Words& words, const scoring::GateResult& gate);

// At most so many decimals: 10, 9.5.
std::string NumberText(const Words& words, double value, int most_digits);

}  // namespace enamel::station::desk
