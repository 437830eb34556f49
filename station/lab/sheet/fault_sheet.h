#pragma once

#include <functional>
#include <string>

#include "common/base/result.h"
#include "common/language/words.h"

// All that a score can say of a mistake, on one sheet for a dentist to read and judge.
namespace enamel::station::lab {

struct FaultSheetOptions {
  language::Language language = language::Language::kEnglish;
  int32_t voxel_nm = 100'000;  // of the teeth that the pictures are cut from
};

// The sheet as an HTML document that needs nothing else: for each fault of the catalogue
// (common/scoring/remedies.h) its name, the sentence said, why it matters, every remedy and two
// sections of a tooth. The sentence is of the cut in the picture, as measured; moments and numbers
// of strokes are examples. `progress` (0..1) may be empty. Errors: kInternal where an example is not
// said to have the fault it shows; those of MakeExample and BuildBuiltinScene. Blocks, a minute at
// 0.1 mm. Thread safety: a function, any thread.
Result<std::string> FaultSheet(const FaultSheetOptions& options,
                               const std::function<void(double)>& progress = {});

}  // namespace enamel::station::lab
