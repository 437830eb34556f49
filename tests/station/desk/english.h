#pragma once

#include "common/language/words.h"

namespace enamel::station::desk {

// What these tests read.
inline const language::Words kEnglish(language::Language::kEnglish);

}  // namespace enamel::station::desk
