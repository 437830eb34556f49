#pragma once

#include "common/language/words.h"

namespace enamel::station::desk {

// The language of these tests.
inline const language::Words kEnglish(language::Language::kEnglish);

}  // namespace enamel::station::desk
