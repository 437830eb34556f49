#include "station/lab/laws/withdrawal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

// A bur pulled back along its path has nothing ahead of it, so nothing may hold it.
namespace enamel::station::lab {
namespace {

using haptics::LawKind;

constexpr double kOpposing_n = 0.15, kRise_n = 0.1;  // or Kc delta where that is more
// Values reached where the goals above are missed: README of common/haptics, "What falls short". No
// case pulls harder than kWorst_n, and at most kBeyond of the 168 miss one of the goals.
constexpr double kWorst_n = 0.17;
constexpr int kBeyond = 8;

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
  int cases = 0, beyond = 0;
  for (const NamedBur& b : WithdrawalBurs()) {
    for (Cut cut : kCuts) {
      for (bool turned : {false, true}) {
        for (double speed : {0.01, 0.03, 0.05}) {
          // Plain Maxwell has no memory: its fastest case is enough.
          if (GetParam() == LawKind::kMaxwell && speed < 0.05) continue;
          Withdrawal s{b.bur, cut, speed, turned, GetParam()};
          WithdrawalFigures f = RunWithdrawal(s, Block());
          EXPECT_GT(f.deepest_n, 0.2) << What(b, s) << ": it did not cut on the way in";
          EXPECT_LE(f.opposing_n, kWorst_n) << What(b, s);
          EXPECT_LE(f.rise_n, kWorst_n) << What(b, s);
          const double cell_n = s.kc_n_per_m * s.cell_m;
          ++cases;
          beyond += f.opposing_n > std::max(kOpposing_n, cell_n) ||
                    f.rise_n > std::max(kRise_n, cell_n) || f.other_n > 1e-9;
          EXPECT_TRUE(f.out) << What(b, s);
          opposing = std::max(opposing, f.opposing_n);
          rise = std::max(rise, f.rise_n);
        }
      }
    }
  }
  EXPECT_LE(beyond, GetParam() == LawKind::kMaxwell ? 0 : kBeyond);
  std::printf("%d of %d cases hold every goal; ", cases - beyond, cases);
  std::printf("opposing at most %.3f N, rising at most %.3f N a tick\n", opposing, rise);
}

INSTANTIATE_TEST_SUITE_P(Laws, FreeWithdrawalTest,
                         testing::Values(LawKind::kMaxwell, LawKind::kTankMaxwell),
                         [](const testing::TestParamInfo<LawKind>& i) {
                           return i.param == LawKind::kMaxwell ? "Maxwell" : "TankMaxwell";
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
