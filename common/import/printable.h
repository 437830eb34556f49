#pragma once

#include <algorithm>
#include <string>

namespace enamel::import {

// Printable ASCII of at most 200 characters, so that documents and messages stay valid whatever a
// file or a part of it is called.
inline std::string Printable(std::string text) {
  text.resize(std::min<size_t>(text.size(), 200));
  for (char& c : text) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return text;
}

}  // namespace enamel::import
