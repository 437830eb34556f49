#pragma once

#include <string>
#include <string_view>

namespace enamel {

// `text` as people compare names when they search: lower case, without accents, ligatures and
// full-width forms taken apart ("Zoë Ñandú" is "zoe nandu", "Łukasz Groß" is "lukasz gross"). For
// Latin, Greek, Cyrillic, Armenian and Georgian; other scripts lose accents at most. Bytes that are
// not UTF-8 stay. Pure function, any thread.
std::string Folded(std::string_view text);

}  // namespace enamel
