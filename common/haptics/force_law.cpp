#include "common/haptics/force_law.h"

#include <array>

namespace enamel::haptics {
namespace {

constexpr std::array kLaws = {
    LawEntry{LawKind::kMaxwell, "maxwell",
             "spring Kc to an anchor that moves through tissue as F/B; passive (coupling.h)",
             &MakeMaxwell},
    LawEntry{LawKind::kGatedMaxwell, "gated-maxwell",
             "Maxwell whose anchor waits while the force is below what the hand's speed calls for", &MakeGatedMaxwell},
    LawEntry{LawKind::kPaperDamping, "eq1", "Liu et al. 2008 eq. 1: R = B V from one tick's difference",
             &MakePaperDamping},
    LawEntry{LawKind::kPaperLimited, "eq17", "Liu et al. 2008 eq. 1 with the limiter of eq. 17 as printed",
             &MakePaperLimited},
};

}  // namespace

std::span<const LawEntry> ForceLaws() { return kLaws; }

const LawEntry* FindLaw(std::string_view name) {
  for (const auto& law : kLaws) if (law.name == name) return &law;
  return nullptr;
}

const LawEntry* FindLaw(LawKind kind) {
  for (const auto& law : kLaws) if (law.kind == kind) return &law;
  return nullptr;
}

}  // namespace enamel::haptics
