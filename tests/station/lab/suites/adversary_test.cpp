#include "station/lab/suites/adversary.h"

#include <gtest/gtest.h>

#include "station/lab/laws/model.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

using haptics::LawKind;

DeviceModel Device(size_t i) { return *ModelOf(ShippedProfiles()[i]); }

TEST(AdversaryGameTest, NoRuleGetsTheGuardAloneUnderItsFloor) {
  uint64_t seed = 1;
  for (size_t device : {0u, 1u, 2u}) {
    DeviceModel m = Device(device);
    for (const GameRules& rules : AllRules()) {
      for (int kind = 0; kind < kGameKinds; ++kind) {
        auto made = static_cast<GameKind>(kind);
        Attack a = PlayGame(m, rules, {}, made, ++seed, made < GameKind::kBred ? 10'000 : 36);
        EXPECT_TRUE(a.proved);
        EXPECT_GT(a.ticks, 70);
        EXPECT_EQ(a.violations, 0) << m.name << ": " << a.kind << ", " << a.made << ", seed "
                                   << seed << ", lowest " << a.worst_j;
      }
    }
  }
}

TEST(AdversaryGameTest, NoRuleThatTheLawsCoverGetsThemUnderTheirFloor) {
  uint64_t seed = 1000;
  DeviceModel m = Device(0);
  for (const Target& target : {Target{LawKind::kMaxwell}, Target{LawKind::kLeadMaxwell},
                               Target{LawKind::kLeadMaxwell, false, true}}) {
    for (const GameRules& rules : AllRules()) {
      for (int kind = 0; kind < kGameKinds; ++kind) {
        auto made = static_cast<GameKind>(kind);
        Attack a = PlayGame(m, rules, target, made, ++seed, made < GameKind::kBred ? 10'000 : 36);
        EXPECT_EQ(a.violations, 0) << a.law << ": " << a.kind << ", " << a.made << ", seed " << seed
                                   << ", lowest " << a.worst_j;
      }
    }
  }
}

// Games that were won against guards without a tank, which clipped at a wall and knew no delay.
struct Won {
  GameRules rules;
  GameKind made;
  uint64_t seed;
  int64_t length;
};
const Won kWon[] = {
    {{.delay_ticks = 1}, GameKind::kDither, 64, 20'000},
    {{.delay_ticks = 2}, GameKind::kDither, 124, 20'000},
    {{.gaps = true}, GameKind::kPress, 36, 20'000},
    {{.gaps = true}, GameKind::kBred, 38, 200},
    {{.gaps = true}, GameKind::kPopulation, 40, 200},
    {{.noise_counts = 1, .lattice = true, .driver_rounds = true, .bounds = true, .gaps = true},
     GameKind::kPress,
     326,
     20'000},
};

TEST(AdversaryGameTest, GamesThatWereWonAreLostAgainstTheGuardWithATank) {
  DeviceModel omega = Device(0);
  for (const Won& won : kWon) {
    Attack now = PlayGame(omega, won.rules, {}, won.made, won.seed, won.length);
    EXPECT_EQ(now.violations, 0) << now.kind << ", " << now.made << ", lowest " << now.worst_j;
    now = PlayGame(omega, won.rules, {LawKind::kLeadMaxwell}, won.made, won.seed, won.length);
    EXPECT_TRUE(now.proved);
    EXPECT_EQ(now.violations, 0) << now.kind << ", " << now.made << ", lowest " << now.worst_j;
  }
}

// The whole core, in a hollow of hard and soft tissue: counts, suspension, gaps and cuts are its own.
TEST(AdversaryGameTest, NoRuleGetsTheWholeCoreUnderItsFloor) {
  uint64_t seed = 2000;
  DeviceModel m = Device(1);
  int64_t felt = 0;
  for (const GameRules& rules : AllRules()) {
    if (rules.bounds) continue;
    for (GameKind kind : {GameKind::kWalk, GameKind::kPress, GameKind::kBred}) {
      const bool spare = ++seed % 2 == 0;
      Attack a = PlayGame(m, rules, {LawKind::kLeadMaxwell, true, spare}, kind, seed,
                          kind < GameKind::kBred ? 4000 : 12);
      EXPECT_EQ(a.violations, 0) << a.law << ": " << a.kind << ", " << a.made << ", seed " << seed
                                 << ", lowest " << a.worst_j;
      felt += a.extracted_j > 0;
    }
  }
  EXPECT_GT(felt, 20) << "the bur must have been in contact";
}

// The games detect errors: each thing that the theorem excludes is pumped by some kind of game.
TEST(AdversaryGameTest, WhatTheTheoremExcludesIsFound) {
  DeviceModel m = Device(0);
  for (const GameRules& rules : ExcludedRules()) {
    int found = 0;
    for (GameKind kind : {GameKind::kWalk, GameKind::kDither, GameKind::kBred}) {
      Attack a = PlayGame(m, rules, {}, kind, 2, kind < GameKind::kBred ? 60'000 : 200);
      EXPECT_FALSE(a.proved);
      found += a.violations > 0;
    }
    EXPECT_GT(found, 0) << rules.Name();
  }
  Attack law = PlayGame(m, {.over_clause = 2}, {haptics::kDefaultLaw}, GameKind::kWalk, 2, 60'000);
  EXPECT_GT(law.violations, 0) << "the default law at twice the clause";
}

// Laws without a proof lose energy to hands that get none from the default law.
TEST(AdversaryGameTest, LawsWithoutAProofArePumpedByGamesThatTheDefaultHolds) {
  for (LawKind law :
       {LawKind::kPaperDamping, LawKind::kVirtualCoupling, LawKind::kPassivityControlled}) {
    int64_t violations = 0;
    for (size_t device : {0u, 1u, 2u}) {
      violations += PlayGame(Device(device), {}, {law}, GameKind::kBred, 3, 60).violations;
      const Attack held =
          PlayGame(Device(device), {}, {haptics::kDefaultLaw}, GameKind::kBred, 3, 60);
      EXPECT_EQ(held.violations, 0);
    }
    EXPECT_GT(violations, 0) << haptics::FindLaw(law)->name;
  }
}

}  // namespace
}  // namespace enamel::station::lab
