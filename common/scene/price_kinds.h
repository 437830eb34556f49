#pragma once

#include <algorithm>
#include <array>
#include <string_view>

// The kinds of RubricPrice::of. Thread safety: constants.
namespace enamel::scene {

struct PriceKind {
  std::string_view of;    // a kind of region (scoring::NameOf), or of damage to the whole
  std::string_view unit;  // of its sizes
  // A document's members for the sizes. nullptr: the kind lacks that side.
  const char *over, *left;
  bool is_needed;  // what has it costs: a rubric without its price cannot score it
};

inline constexpr std::array<PriceKind, 12> kPriceKinds = {
    {{"floor", "mm", "over_mm", "left_mm", true},
     {"wall", "mm", "over_mm", "left_mm", true},
     {"table", "mm", "over_mm", "left_mm", true},
     {"axial_wall", "mm", "over_mm", "left_mm", true},
     {"margin", "mm", "over_mm", "left_mm", true},
     {"face", "mm", "over_mm", "left_mm", true},
     {"line_angle", "mm", "over_mm", "left_mm", true},
     {"elsewhere", "mm3", "over_mm3", nullptr, false},
     {"neighbour", "mm", "over_mm", nullptr, false},
     {"pulp", "mm3", "over_mm3", nullptr, false},
     {"caries", "%", nullptr, "left_percent", false},
     {"contact", "%", nullptr, "left_percent", true}}};

// nullptr: nothing that has a price is called so.
constexpr const PriceKind* FindPriceKind(std::string_view of) {
  const auto* found = std::ranges::find(kPriceKinds, of, &PriceKind::of);
  return found == kPriceKinds.end() ? nullptr : found;
}

}  // namespace enamel::scene
