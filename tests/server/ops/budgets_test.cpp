#include "server/ops/budgets.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace enamel::server::ops {
namespace {

TEST(BudgetsTest, ARefusalNamesItsBudgetAndTheLimit) {
  Budgets limits;
  limits.bodies_mib = 12;
  const Status refused = OverBudget(kBodies, limits, "too much has begun to come");
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_EQ(refused.message(), "too much has begun to come (budget bodies_mib: 12 MiB)");
  EXPECT_EQ(refused.field(), "bodies_mib");
  EXPECT_TRUE(IsOverBudget(refused));
  EXPECT_FALSE(IsOverBudget(Status(Code::kUnavailable, "busy")));
  EXPECT_EQ(LimitOf(kBodies, limits), size_t{12} << 20);
}

TEST(BudgetsTest, EachHasANameOfItsOwnAndADefaultWithinItsBounds) {
  std::set<std::string_view> names;
  const Budgets defaults;
  for (const BudgetKind* kind : kBudgets) {
    EXPECT_TRUE(names.insert(kind->name).second) << kind->name;
    EXPECT_GE(defaults.*kind->limit, kind->least) << kind->name;
    EXPECT_LE(defaults.*kind->limit, kind->most) << kind->name;
  }
}

TEST(BudgetsTest, MetricsNameWhoUsesMost) {
  BudgetUse use;
  use.kind = &kBodies;
  use.limit = 100;
  use.most = 40;
  use.party = PartyKind::kAddress;
  use.of = "192.0.2.1";
  use.refused = 3;
  BudgetUse none;
  none.kind = &kViews;
  none.limit = 512;
  MetricsText text;
  const BudgetUse both[] = {use, none};
  AddBudgets(text, both);
  const std::string out = text.Take();
  for (const char* line :
       {"\nenamel_budget_limit{budget=\"bodies_mib\"} 100\n",
        "\nenamel_budget_limit{budget=\"views\"} 512\n",
        "\nenamel_budget_use{budget=\"bodies_mib\",of=\"address 192.0.2.1\"} 40\n",
        "\nenamel_budget_use{budget=\"views\",of=\"\"} 0\n",
        "\nenamel_budget_refused_total{budget=\"bodies_mib\"} 3\n"}) {
    EXPECT_NE(out.find(line), std::string::npos) << line << out;
  }
}

}  // namespace
}  // namespace enamel::server::ops
