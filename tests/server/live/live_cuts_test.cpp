#include "server/live/live_cuts.h"

#include <gtest/gtest.h>

#include "tests/server/storage/store_world.h"

namespace enamel::server {
namespace {

trace::Tick At(double x_mm, double y_mm, double z_mm, double force_n = 1) {
  trace::Tick tick;
  auto unit = [](double mm) { return static_cast<int32_t>(mm * 1e4); };
  tick.witness.anchor_100nm = {unit(x_mm), unit(y_mm), unit(z_mm)};
  tick.witness.force_computed_mn[2] = static_cast<int32_t>(force_n * 1e3);
  return tick;
}

class LiveCutsTest : public ::testing::Test {
 protected:
  void Commit(const std::vector<trace::Tick>& ticks) {
    const trace::ChunkHead head{.attempt = attempt_,
                                .seq = seal_.chunks,
                                .first_tick = seal_.ticks,
                                .previous = seal_.last_chunk};
    Bytes bytes = trace::EncodeChunk(head, ticks, world_.keys.secret_key);
    const auto decoded = *trace::DecodeChunkHead(bytes);
    seal_.last_chunk = decoded.hash;
    ++seal_.chunks;
    seal_.ticks += ticks.size();
    const Status added =
        store_->ingest.AppendChunk({attempt_, decoded.head, decoded.hash, std::move(bytes), 100});
    ASSERT_TRUE(added.ok()) << added.message();
  }
  LiveCuts::Cut Cut(uint32_t from = 0) {
    auto cut = cuts_.Get(store_->recordings, attempt_, from);
    EXPECT_TRUE(cut.ok()) << cut.status().message();
    return cut.ok() ? *cut : LiveCuts::Cut{};
  }

  server::testing::TempFolder folder_;
  std::unique_ptr<Store> store_ = server::testing::OpenStore(folder_.path());
  server::testing::World world_{*store_};
  const Uuid attempt_ = world_.OpenedAttempt();
  trace::Seal seal_{attempt_, 0, 0, server::testing::World::HeaderHash(), 0};
  LiveCuts cuts_;
};

TEST_F(LiveCutsTest, KeepsTheLowestPlaceOfTheTipWhereItPressed) {
  Commit({At(0.1, 0.1, -1), At(0.2, 0.2, -2.005), At(0.1, 0.1, -1.5), At(0.1, 0.1, -3, 0),
          At(-0.1, 0.3, 0.5)});
  const auto cut = Cut();
  EXPECT_EQ(cut.chunks, 1u);
  ASSERT_EQ(cut.columns.size(), 2u);
  EXPECT_EQ(cut.columns[0].x, -1);
  EXPECT_EQ(cut.columns[0].y, 1);
  EXPECT_EQ(cut.columns[0].lowest_um, 500);
  EXPECT_EQ(cut.columns[1].x, 0);
  EXPECT_EQ(cut.columns[1].lowest_um, -2020) << "down to a whole step; in the air is no contact";
}

TEST_F(LiveCutsTest, EachBurHasItsOwnColumns) {
  auto other = At(0.1, 0.1, -1);
  other.input.flags |= core::BurFlags(2);
  Commit({At(0.2, 0.2, -2), other});
  const auto cut = Cut();
  ASSERT_EQ(cut.columns.size(), 2u);
  EXPECT_EQ(cut.columns[0].bur, 0u);
  EXPECT_EQ(cut.columns[0].lowest_um, -2000);
  EXPECT_EQ(cut.columns[1].bur, 2u);
  EXPECT_EQ(cut.columns[1].lowest_um, -1000);
}

TEST_F(LiveCutsTest, WhoHasSeenSomeGetsWhatBecameDeeperSince) {
  Commit({At(0.1, 0.1, -1), At(1.1, 0.1, -1)});
  const auto first = Cut();
  EXPECT_EQ(first.columns.size(), 2u);
  EXPECT_TRUE(Cut(first.chunks).columns.empty());
  Commit({At(1.1, 0.1, -0.5), At(0.1, 0.1, -1.5)});
  const auto then = Cut(first.chunks);
  EXPECT_EQ(then.chunks, 2u);
  ASSERT_EQ(then.columns.size(), 1u);
  EXPECT_EQ(then.columns[0].lowest_um, -1500);
  EXPECT_EQ(Cut().columns.size(), 2u) << "another viewer";
}

// The server was restarted, or had to forget it: the numbers are the same.
TEST_F(LiveCutsTest, ReadsAnAttemptFromItsBeginningAndAfterALongTime) {
  constexpr uint32_t kChunks = 245;
  for (uint32_t i = 0; i < kChunks; ++i) Commit({At(0.3 * i, 0, -1)});
  EXPECT_EQ(Cut().columns.size(), kChunks);
  for (uint32_t i = 0; i < kChunks; ++i) Commit({At(0.3 * i, 0, -2)});
  const auto cut = Cut(kChunks);
  EXPECT_EQ(cut.columns.size(), kChunks);
  LiveCuts fresh;
  EXPECT_EQ(fresh.Get(store_->recordings, attempt_, 0)->columns.size(), cut.columns.size());
}

TEST_F(LiveCutsTest, OnlySoManyColumnsAreKept) {
  for (int row = 0; row < 5; ++row) {
    std::vector<trace::Tick> ticks;
    for (int i = 0; i < 1000; ++i) ticks.push_back(At(0.25 * i, 0.3 * row, 0));
    Commit(ticks);
  }
  EXPECT_EQ(Cut().columns.size(), CutColumns::kMaxColumns);
}

}  // namespace
}  // namespace enamel::server
