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

// The sheet as an HTML document that needs nothing else: for each kind of mistake the sentence said, why it
// matters, the advice and two sections of a tooth. The sentence is of the cut in the picture, as measured. At the end
// is a heavy hand, which no tooth shows. `progress` (0..1) may be empty. Errors: those of Make (examples.h) and
// BuildBuiltinScene. Blocks, a minute at 0.1 mm. Thread safety: a function, any thread.
Result<std::string> FaultSheet(const FaultSheetOptions& options,
                               const std::function<void(double)>& progress = {});

}  // namespace enamel::station::lab
