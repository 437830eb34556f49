#pragma once

#include <string>

#include "common/import/import_tooth.h"

namespace enamel::import {

// An import's report, for messages.
inline std::string Lines(const ImportedScene& s) {
  std::string out;
  for (const std::string& line : s.report) out += line + "\n";
  return out;
}

}  // namespace enamel::import
