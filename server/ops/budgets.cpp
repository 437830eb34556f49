#include "server/ops/budgets.h"

#include <algorithm>

namespace enamel::server::ops {

uint64_t LimitOf(const BudgetKind& kind, const Budgets& budgets) {
  const auto limit = static_cast<uint64_t>(budgets.*kind.limit);
  return kind.unit == BudgetUnit::kMib ? limit << 20 : limit;
}

Status OverBudget(const BudgetKind& kind, const Budgets& budgets, const std::string& why) {
  std::string limit = std::to_string(budgets.*kind.limit);
  if (kind.unit == BudgetUnit::kMib) limit += " MiB";
  if (kind.unit == BudgetUnit::kPercent) limit += " %";
  return {Code::kUnavailable, why + " (budget " + std::string(kind.name) + ": " + limit + ")",
          std::string(kind.name)};
}

bool IsOverBudget(const Status& status) {
  return status.code() == Code::kUnavailable &&
         std::ranges::any_of(kBudgets,
                             [&](const BudgetKind* kind) { return kind->name == status.field(); });
}

void AddBudgets(MetricsText& text, std::span<const BudgetUse> uses) {
  for (const BudgetUse& use : uses) {
    text.Gauge("enamel_budget_limit", "What a budget allows; bytes where its name ends in _mib.",
               static_cast<double>(use.limit), {{"budget", use.kind->name}});
  }
  for (const BudgetUse& use : uses) {
    const std::string of =
        use.party == PartyKind::kNone ? std::string() : NameOf(use.party) + (" " + use.of);
    text.Gauge("enamel_budget_use", "Use of a budget by the party that uses most now.",
               static_cast<double>(use.most), {{"budget", use.kind->name}, {"of", of}});
  }
  for (const BudgetUse& use : uses) {
    text.Counter("enamel_budget_refused_total", "What a budget refused, cut off or made wait.",
                 static_cast<double>(use.refused), {{"budget", use.kind->name}});
  }
}

const char* NameOf(PartyKind kind) {
  switch (kind) {
    case PartyKind::kNone:
      break;
    case PartyKind::kStation:
      return "station";
    case PartyKind::kPerson:
      return "person";
    case PartyKind::kAddress:
      return "address";
  }
  return "";
}

}  // namespace enamel::server::ops
