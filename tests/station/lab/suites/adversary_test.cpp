#include "station/lab/suites/adversary.h"

#include <gtest/gtest.h>

#include "station/lab/laws/model.h"

namespace enamel::station::lab {
namespace {

using haptics::LawKind;

DeviceModel Device(size_t i) { return *ModelOf(QualifyProfiles()[i]); }

TEST(AdversaryGameTest, NoRuleGetsTheGuardAloneUnderItsFloor) {
  uint64_t seed = 1;
  for (size_t device : {0u, 1u, 2u}) {
    DeviceModel m = Device(device);
    for (const GameRules& rules : AllRules()) {
      for (int kind = 0; kind < kGameKinds; ++kind) {
        auto made = static_cast<GameKind>(kind);
        Attack a =
            PlayGame(m, rules, std::nullopt, made, ++seed, made < GameKind::kBred ? 10'000 : 36);
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
  for (LawKind law : {LawKind::kMaxwell, LawKind::kLeadMaxwell}) {
    for (const GameRules& rules : AllRules()) {
      if (!Covered(law, rules)) continue;
      for (int kind = 0; kind < kGameKinds; ++kind) {
        auto made = static_cast<GameKind>(kind);
        Attack a = PlayGame(m, rules, law, made, ++seed, made < GameKind::kBred ? 10'000 : 36);
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
    Attack now = PlayGame(omega, won.rules, std::nullopt, won.made, won.seed, won.length);
    EXPECT_EQ(now.violations, 0) << now.kind << ", " << now.made << ", lowest " << now.worst_j;
    now = PlayGame(omega, won.rules, LawKind::kLeadMaxwell, won.made, won.seed, won.length);
    EXPECT_TRUE(now.proved);
    EXPECT_EQ(now.violations, 0) << now.kind << ", " << now.made << ", lowest " << now.worst_j;
  }
}

// The games detect errors: with one undeclared tick of delay each kind beats the guard, except the
// presses, which do not depend on delay.
TEST(AdversaryGameTest, ATickOfDelayThatIsNotInTheClauseIsFound) {
  DeviceModel m = Device(0);
  for (GameKind kind :
       {GameKind::kWalk, GameKind::kDither, GameKind::kBred, GameKind::kPopulation}) {
    Attack a = PlayGame(m, {.undeclared_ticks = 1}, std::nullopt, kind, 2,
                        kind < GameKind::kBred ? 60'000 : 200);
    EXPECT_FALSE(a.proved);
    EXPECT_GT(a.violations, 0) << a.made;
  }
}

}  // namespace
}  // namespace enamel::station::lab
