#pragma once

#include <span>
#include <string_view>

namespace enamel::language {

// A file of schemas/words/, unchanged.
struct Catalogue {
  std::string_view language;  // its folder: "de"
  std::string_view part;      // its name: "window"
  std::string_view text;
};

std::span<const Catalogue> Catalogues();

}  // namespace enamel::language
