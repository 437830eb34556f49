#pragma once

#include <cctype>
#include <string>
#include <string_view>

namespace enamel::test {

// `text` as the last part of a test's name: all but letters and digits become '_'.
inline std::string TestName(std::string_view text) {
  std::string name(text);
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}

}  // namespace enamel::test
