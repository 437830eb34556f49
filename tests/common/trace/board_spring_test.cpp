#include <gtest/gtest.h>

#include <algorithm>

#include "common/board/board.h"
#include "common/haptics/guard.h"
#include "common/trace/columns.h"
#include "tests/common/trace/sample.h"

// A core whose spring is on the board: the reference firmware ticks eight times between two ticks of
// the core, some reports are lost, and what the board reports is all that a replay gets of it.
namespace enamel::trace {
namespace {

constexpr int kInner = 8;

struct CutRun {
  std::vector<Tick> ticks;
  uint64_t state_hash = 0;
  double force_off_n = 0;  // most that the core's force is off the board's at the reading
  int off = 0;             // ticks in which the rest point is not where it is expected
  double most_n = 0;
};

core::CoreParams Params(uint32_t delay) {
  core::CoreParams p = sample::MakeHeader().params;
  p.law = haptics::LawKind::kLeadMaxwell;
  p.spring_on_board = true;
  p.kc_mn_per_mm = 5000;
  p.bus_delay_ticks = delay;
  return p;
}

// Readings between those of two ticks are on the straight line, in whole counts.
EnVec ReadingAt(const core::CoreParams& p, const std::array<int32_t, 3>& from,
                const std::array<int32_t, 3>& to, int i) {
  std::array<double, 3> at;
  for (size_t a = 0; a < 3; ++a)
    at[a] =
        (from[a] + (to[a] - from[a]) * i / kInner) * static_cast<double>(p.resolution_nm[a]) * 1e-9;
  return {at[0], at[1], at[2]};
}

EnCommand CommandOf(const core::SpringWish& wish, const core::CoreParams& p) {
  EnCommand c{};
  c.motors_on = true;
  c.spring_on = wish.on;
  c.follow = wish.follow;
  c.rest_m = haptics::ToBoard(dvec3(wish.rest_nm[0], wish.rest_nm[1], wish.rest_nm[2]) * 1e-9);
  c.share = 1;
  c.bound_n = p.peak_force_mn * 1e-3;
  return c;
}

EnBoard BoardOf(const core::CoreParams& p) {
  EnBoardParams b{};
  b.tick_s = 1e-3 / kInner;
  b.delay_ticks = 1;
  b.kc_n_per_m = p.kc_mn_per_mm;
  b.cell = core::TipCellOf(p).board();
  b.peak_n = p.peak_force_mn * 1e-3;
  b.damping_n_s_per_m = 2;
  EnBoard board;
  EXPECT_TRUE(EnBoardStart(&board, &b));
  return board;
}

CutRun Cut(uint32_t delay, int lost_every) {
  const core::CoreParams p = Params(delay);
  const std::vector<core::TickInput> path = sample::CutInputs(6000);
  core::Core core(p, sample::MakeBlock());
  EnBoard board = BoardOf(p);
  std::vector<EnCommand> under_way(delay, EnCommand{});
  CutRun run;
  for (size_t k = 0; k < path.size(); ++k) {
    core::TickInput input = path[k];
    dvec3 felt(0);
    for (int i = 1; i <= kInner; ++i) {
      const EnVec at = ReadingAt(p, path[k == 0 ? 0 : k - 1].counts, input.counts, i);
      felt = haptics::FromBoard(EnBoardTick(&board, at));
    }
    EnPoseReport told{};
    EnBoardTell(&board, &told);
    input.rest_off_nm =
        core.RestOff_nm(input.counts, {told.rest_nm[0], told.rest_nm[1], told.rest_nm[2]});
    input.share_lost = static_cast<uint16_t>(65535 - told.share);
    const core::TickOutput out = core.Step(input);
    if (out.spring.on && board.running)
      run.force_off_n = std::max(run.force_off_n, glm::length(out.pressed_n() - felt));
    run.most_n = std::max(run.most_n, glm::length(felt));
    run.off += input.rest_off_nm != std::array<int32_t, 3>{};
    run.ticks.push_back({input, out.witness});
    under_way.push_back(CommandOf(out.spring, p));
    if (lost_every == 0 || k % static_cast<size_t>(lost_every) != 7)
      EnBoardObey(&board, &under_way.front(), static_cast<uint32_t>(k));
    under_way.erase(under_way.begin());
  }
  run.state_hash = core.state_hash();
  return run;
}

TEST(BoardSpringTest, WhatTheCoreRecordsIsWhatTheBoardGives) {
  for (uint32_t delay : {0u, 1u}) {
    const CutRun run = Cut(delay, 0);
    EXPECT_GT(run.most_n, 0.5) << "the hand cuts";
    // Half a nanometre of rounding per axis.
    EXPECT_LE(run.force_off_n, 5000 * std::sqrt(3.0) * 0.5e-9 + 1e-9) << delay;
    EXPECT_LT(run.off, static_cast<int>(run.ticks.size()) / 4) << delay;
  }
}

TEST(BoardSpringTest, AReplayOfWhatTheBoardReportedIsTheSameToTheBit) {
  for (uint32_t delay : {0u, 1u}) {
    const CutRun run = Cut(delay, 50);
    core::Core core(Params(delay), sample::MakeBlock());
    const auto decoded = DecodeColumns(EncodeColumns(std::span(run.ticks).first(1000)), 1000);
    ASSERT_TRUE(decoded.ok());
    for (size_t k = 0; k < run.ticks.size(); ++k) {
      const Tick& tick = k < 1000 ? (*decoded)[k] : run.ticks[k];
      ASSERT_EQ(core.Step(tick.input).witness, run.ticks[k].witness) << k;
    }
    EXPECT_EQ(core.state_hash(), run.state_hash);
  }
}

TEST(BoardSpringTest, AChangedReportIsAnotherRecording) {
  const CutRun run = Cut(0, 0);
  core::Core core(Params(0), sample::MakeBlock());
  for (size_t k = 0; k < run.ticks.size(); ++k) {
    core::TickInput input = run.ticks[k].input;
    if (k == 3000) ++input.rest_off_nm[2];
    core.Step(input);
  }
  EXPECT_NE(core.state_hash(), run.state_hash);
}

size_t PackedBytes(const std::vector<Tick>& ticks) {
  size_t bytes = 0;
  for (size_t from = 0; from + 500 <= ticks.size(); from += 500) {
    ChunkHead head;
    head.previous.bytes.fill(1);
    bytes +=
        EncodeChunk(head, std::span(ticks).subspan(from, 500), sample::StationKeys().secret_key)
            .size();
  }
  return bytes;
}

// The limit is 2.
TEST(BoardSpringTest, TheReportCostsLessThanTwoBytesATick) {
  for (uint32_t delay : {0u, 1u}) {
    for (int lost_every : {0, 50}) {
      const CutRun run = Cut(delay, lost_every);
      std::vector<Tick> without = run.ticks;
      for (Tick& t : without) {
        t.input.rest_off_nm = {};
        t.input.share_lost = 0;
      }
      const double more = (static_cast<double>(PackedBytes(run.ticks)) -
                           static_cast<double>(PackedBytes(without))) /
                          static_cast<double>(run.ticks.size());
      EXPECT_LE(more, 2) << delay << ", " << lost_every;
      RecordProperty("delay_" + std::to_string(delay) + "_lost_" + std::to_string(lost_every),
                     std::to_string(more) + " bytes, off " + std::to_string(run.off));
    }
  }
}

}  // namespace
}  // namespace enamel::trace
