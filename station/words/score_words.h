#pragma once

#include <string>
#include <string_view>

#include "common/language/words.h"
#include "common/scoring/score.h"

// The texts of scores and built-in exercises in the reader's language. The server sends both in
// English: a score with the codes of its reasons (schemas/score.md, "Reasons"), a built-in text as
// the name of its own message (schemas/words.md). The page makes the same sentences from the same
// messages; the tests of both read schemas/golden/reasons_said.json. Thread safety: as Words.
namespace enamel::station {

using language::Words;

// "Class I occlusal cavity", "Walls upright". A school's own text is returned unchanged.
std::string WordedTitle(const Words& words, std::string_view title);
// Translates instructions, or the comment of a criterion, sentence by sentence. If one sentence is
// not built in, none is translated.
std::string WordedText(const Words& words, std::string_view text);

// One sentence for each reason of a figure of the hand, then the rubric's comment. The server's own text if a
// code is unknown (a newer server).
std::string ReasonText(const Words& words, const scoring::CriterionResult& criterion);
// The same below the criterion's title: "Measured: 7.62 N (full marks up to 4.00 N, …)".
std::string DetailText(const Words& words, const scoring::CriterionResult& criterion);
std::string ReasonText(const Words& words, const scoring::CriticalResult& critical);
// Of a limit of ScoreResult::borderline, a sentence with value, limit and uncertainty.
std::string BorderlineText(const Words& words, const scoring::CriticalResult& limit);

// With at most so many decimals: 10, 9.5.
std::string NumberText(const Words& words, double value, int most_digits);

}  // namespace enamel::station
