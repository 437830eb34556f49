#include "common/haptics/force_law.h"

#include <array>

namespace enamel::haptics {
namespace {

constexpr std::array kLaws = {
    LawEntry{LawKind::kMaxwell, "maxwell",
             "spring Kc to an anchor that moves through tissue as F/B; passive (coupling.h)",
             &MakeMaxwell},
    LawEntry{LawKind::kLeadMaxwell, "lead-maxwell",
             "Maxwell whose spring is stiffer for slow motion than for fast", &MakeLeadMaxwell},
    LawEntry{LawKind::kPaperDamping, "eq1",
             "Liu et al. 2008 eq. 1: R = B V from one tick's difference", &MakePaperDamping},
    LawEntry{LawKind::kPaperLimited, "eq17",
             "Liu et al. 2008 eq. 1 with the limiter of eq. 17 as printed", &MakePaperLimited},
    LawEntry{LawKind::kPaperSymmetric, "eq17-symmetric",
             "eq. 12 on both slopes, velocity from an adaptive window", &MakePaperSymmetric},
    LawEntry{LawKind::kVirtualCoupling, "virtual-coupling",
             "Adams-Hannaford: spring and damper to a tool in tissue", &MakeVirtualCoupling},
    LawEntry{LawKind::kPassivityControlled, "eq1-popc",
             "eq. 1 with passivity observer and controller (Hannaford-Ryu)",
             &MakePassivityControlled},
    LawEntry{LawKind::kEnergyBounded, "eq1-bounded", "eq. 1 under the energy bound (Kim-Ryu)",
             &MakeEnergyBounded},
};

}  // namespace

std::span<const LawEntry> ForceLaws() { return kLaws; }

const LawEntry* FindLaw(std::string_view name) {
  for (const auto& law : kLaws)
    if (law.name == name) return &law;
  return nullptr;
}

const LawEntry* FindLaw(LawKind kind) {
  for (const auto& law : kLaws)
    if (law.kind == kind) return &law;
  return nullptr;
}

}  // namespace enamel::haptics
