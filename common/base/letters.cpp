#include "common/base/letters.h"

#include <algorithm>
#include <cctype>

namespace enamel {

std::string OtherLetters(std::string_view wanted, ByteView found) {
  const std::string_view letters = AsText(found);
  const std::string expected = "expected it to begin with " + std::string(wanted);
  const bool ours =
      letters.size() == wanted.size() && letters.starts_with("EN") &&
      std::ranges::all_of(letters, [](unsigned char c) { return std::isalpha(c) != 0; });
  if (!ours) return expected + ": this is something else or cut short";
  return expected + ", found " + std::string(letters) +
         ": it is of another kind, or of an earlier Enamel, which this program cannot read";
}

}  // namespace enamel
