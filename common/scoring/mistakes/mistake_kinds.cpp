#include <array>

#include "common/scoring/mistakes/mistakes.h"

namespace enamel::scoring {

std::string_view NameOf(MistakeKind kind) {
  constexpr std::array<std::string_view, kMistakeKinds> kNames = {
      "shifted",       "turned",   "tipped",    "over_extended", "under_extended",
      "leans_out",     "leans_in", "deep",      "shallow",       "over_reduced",
      "under_reduced", "slopes",   "groove",    "pit",           "ledge",
      "overhang",      "lip",      "corner",    "bump",          "standing",
      "wave",          "hole",     "neighbour", "pulp",          "caries",
      "contact",       "not_done", "uneven"};
  return kNames[static_cast<size_t>(kind)];
}

std::string_view UnitOf(MistakeKind kind) {
  switch (kind) {
    case MistakeKind::kTurned:
    case MistakeKind::kTipped:
    case MistakeKind::kLeansOut:
    case MistakeKind::kLeansIn:
    case MistakeKind::kSlopes:
      return "deg";
    case MistakeKind::kStanding:
    case MistakeKind::kHole:
    case MistakeKind::kPulp:
      return "mm3";
    case MistakeKind::kCaries:
    case MistakeKind::kContact:
    case MistakeKind::kNotDone:
      return "%";
    default:
      return "mm";
  }
}

std::string_view NameOf(Group group) {
  constexpr std::array<std::string_view, kGroups> kNames = {"outline", "internal_form", "margins",
                                                            "tissue_preserved", "hand"};
  return kNames[static_cast<size_t>(group)];
}

Group GroupOf(std::string_view kind) {
  if (kind == NameOf(RegionKind::kWall) || kind == whole::kContact) return Group::kOutline;
  if (kind == NameOf(RegionKind::kMargin)) return Group::kMargins;
  if (kind == whole::kElsewhere || kind == whole::kNeighbour || kind == whole::kPulp)
    return Group::kTissuePreserved;
  return Group::kInternalForm;
}

int SignOf(MistakeKind kind) {
  switch (kind) {
    case MistakeKind::kOverExtended:
    case MistakeKind::kDeep:
    case MistakeKind::kOverReduced:
    case MistakeKind::kGroove:
    case MistakeKind::kPit:
      return 1;
    case MistakeKind::kUnderExtended:
    case MistakeKind::kShallow:
    case MistakeKind::kUnderReduced:
    case MistakeKind::kLedge:
    case MistakeKind::kOverhang:
    case MistakeKind::kLip:
    case MistakeKind::kCorner:
    case MistakeKind::kBump:
    case MistakeKind::kStanding:
      return -1;
    default:
      return 0;
  }
}

}  // namespace enamel::scoring
