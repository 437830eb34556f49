#pragma once

#include <array>
#include <string_view>

#include "common/scene/types.h"

// The names of restorative materials in documents. Thread safety: functions, any thread.
namespace enamel::scene {

struct RestorationEntry {
  Restoration restoration;
  std::string_view name;  // "amalgam"
};
inline constexpr std::array kRestorations = {RestorationEntry{Restoration::kAmalgam, "amalgam"},
                                             RestorationEntry{Restoration::kComposite, "composite"},
                                             RestorationEntry{Restoration::kCeramic, "ceramic"}};

// Empty for kNone.
constexpr std::string_view RestorationName(Restoration restoration) {
  for (const RestorationEntry& entry : kRestorations) {
    if (entry.restoration == restoration) return entry.name;
  }
  return {};
}

}  // namespace enamel::scene
