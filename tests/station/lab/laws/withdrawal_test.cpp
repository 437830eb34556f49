#include "station/lab/laws/withdrawal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

// A bur pulled back along its path has nothing ahead of it, so nothing may hold it.
namespace enamel::station::lab {
namespace {

using haptics::LawKind;

constexpr double kOpposing_n = 0.15, kRise_n = 0.1;

const cutting::Volume& Block() {
  static const cutting::Volume block = WithdrawalBlock();
  return block;
}

std::string What(const NamedBur& b, const Withdrawal& s) {
  return std::string(haptics::FindLaw(s.law)->name) + ", " + b.name + ", " + CutName(s.cut) +
         (s.turned ? ", turned, " : ", ") +
         std::to_string(static_cast<int>(s.speed_m_per_s * 1e3)) + " mm/s";
}

class FreeWithdrawalTest : public testing::TestWithParam<LawKind> {};

TEST_P(FreeWithdrawalTest, NothingHoldsABurThatGoesBackTheWayItCame) {
  double opposing = 0, rise = 0;
  int cases = 0;
  for (const NamedBur& b : WithdrawalBurs()) {
    for (Cut cut : kCuts) {
      for (bool turned : {false, true}) {
        for (double speed : {0.01, 0.03, 0.05}) {
          // Plain Maxwell has no memory: its fastest case is enough.
          if (GetParam() == LawKind::kMaxwell && speed < 0.05) continue;
          Withdrawal s{b.bur, cut, speed, turned, GetParam()};
          WithdrawalFigures f = RunWithdrawal(s, Block());
          EXPECT_GT(f.deepest_n, 0.2) << What(b, s) << ": it did not cut on the way in";
          EXPECT_LE(f.opposing_n, kOpposing_n) << What(b, s);
          EXPECT_LE(f.rise_n, kRise_n) << What(b, s);
          EXPECT_LE(f.other_n, 1e-9) << What(b, s);
          ++cases;
          EXPECT_TRUE(f.out) << What(b, s);
          opposing = std::max(opposing, f.opposing_n);
          rise = std::max(rise, f.rise_n);
        }
      }
    }
  }
  std::printf("%d cases; opposing at most %.3f N, rising at most %.3f N a tick\n", cases, opposing,
              rise);
}

INSTANTIATE_TEST_SUITE_P(Laws, FreeWithdrawalTest,
                         testing::Values(LawKind::kMaxwell, LawKind::kLeadMaxwell),
                         [](const testing::TestParamInfo<LawKind>& i) {
                           return i.param == LawKind::kMaxwell ? "Maxwell" : "LeadMaxwell";
                         });

// The claim above can fail: beside its way in the bur cuts again, and is held.
TEST(WithdrawalTest, ABurThatGoesBackBesideItsWayIsHeld) {
  Withdrawal s{WithdrawalBurs()[0].bur, Cut::kSideMill, 0.05, false, LawKind::kMaxwell};
  s.beside_m = 0.2e-3;
  EXPECT_GT(RunWithdrawal(s, Block()).opposing_n, 1);
}

// A soft hand deviates from the path: the spring's remaining force across it presses the bur, for a
// tick or two, into the floor it has passed.
constexpr double kSoftHand_n = 0.2;

TEST(WithdrawalTest, AHandOfOneNewtonAMillimetreIsNotHeldEither) {
  double opposing = 0;
  for (const NamedBur& b : WithdrawalBurs()) {
    for (Cut cut : kCuts) {
      Withdrawal s{b.bur, cut, 0.03, true};
      s.hand_n_per_m = 1000;
      WithdrawalFigures f = RunWithdrawal(s, Block());
      EXPECT_LE(f.opposing_n, kSoftHand_n) << What(b, s);
      opposing = std::max(opposing, f.opposing_n);
    }
  }
  std::printf("hand of 1 N/mm: opposing at most %.3f N\n", opposing);
}

}  // namespace
}  // namespace enamel::station::lab
