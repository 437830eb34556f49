#include "server/live/board_keeper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace enamel::server {
namespace {

constexpr UnixMs kSaidMs = 1'700'000'000'000;

// What the servers of a school have in common.
struct Rows {
  std::vector<ChairRemark> remarks;
  std::map<Uuid, std::vector<StationLink>> links;  // of each server
  bool away = false;
};

// One server's way to it.
class OneServersRows final : public LiveStore {
 public:
  explicit OneServersRows(Rows& rows) : rows_(rows) {}
  Result<std::vector<ChairRemark>> ChairRemarks(UnixMs since_ms) override {
    ++reads;
    if (rows_.away) return Away();
    std::vector<ChairRemark> out;
    std::ranges::copy_if(rows_.remarks, std::back_inserter(out),
                         [&](const ChairRemark& remark) { return remark.sent_ms >= since_ms; });
    return out;
  }
  Status MoveRemarks(const std::vector<ChairRemark>& moved) override {
    if (rows_.away) return Away();
    for (const ChairRemark& remark : moved) {
      const auto at = std::ranges::find(rows_.remarks, remark.id, &ChairRemark::id);
      if (at != rows_.remarks.end()) *at = remark;
    }
    return Status::Ok();
  }
  Status KeepLinks(const std::vector<StationLink>& come, const std::vector<Uuid>& gone,
                   bool anew) override {
    if (rows_.away) return Away();
    ++link_calls;
    written += come.size() + gone.size();
    if (!anew && !rows_.links.contains(server)) return {Code::kNotFound, "taken for gone"};
    if (anew) rows_.links[server].clear();
    auto& mine = rows_.links[server];
    for (const StationLink& link : come) {
      std::erase_if(mine, [&](const StationLink& old) { return old.station == link.station; });
      mine.push_back(link);
    }
    std::erase_if(mine, [&](const StationLink& old) {
      return std::ranges::find(gone, old.station) != gone.end();
    });
    return Status::Ok();
  }
  Result<std::vector<StationLink>> LinksElsewhere() override {
    if (rows_.away) return Away();
    std::vector<StationLink> out;
    for (const auto& [other, links] : rows_.links) {
      if (other != server) out.insert(out.end(), links.begin(), links.end());
    }
    return out;
  }

  const Uuid server = Uuid::New();
  int reads = 0, link_calls = 0;
  size_t written = 0;

 private:
  static Status Away() { return {Code::kUnavailable, "the database is away"}; }
  Rows& rows_;
};

struct OneServer {
  explicit OneServer(Rows& rows, bool shared = true)
      : store(rows), keeper(board, store, shared, BoardKeeper::ByHand()) {}
  OneServersRows store;
  StationBoard board;
  BoardKeeper keeper;
};

class BoardKeeperTest : public ::testing::Test {
 protected:
  // As AddAnnotation and the board of the server where it is said have it.
  void Say(OneServer& at, uint64_t id) {
    const ChairRemark remark{attempt_, id, "stop", "Ada", 5, kSaidMs, RemarkState::kWaiting, 0};
    rows_.remarks.push_back(remark);
    at.board.remarks().Put(remark);
  }
  RemarkState StateAt(OneServer& at, size_t index = 0) {
    return at.board.remarks().Of(attempt_).at(index).state;
  }

  Rows rows_;
  OneServer one_{rows_}, two_{rows_};
  const Uuid attempt_ = Uuid::New(), station_ = Uuid::New();
};

TEST_F(BoardKeeperTest, ARemarkReachesTheServerOfItsStationAndItsStateComesBack) {
  Say(one_, 1);
  two_.keeper.LookAtRemarks(kSaidMs);
  ASSERT_EQ(two_.board.remarks().Take(attempt_).size(), 1u);
  two_.keeper.LookAtRemarks(kSaidMs);
  one_.keeper.LookAtRemarks(kSaidMs);
  EXPECT_EQ(StateAt(one_), RemarkState::kSent);
  two_.board.remarks().Shown(attempt_, 1, kSaidMs + 70);
  two_.keeper.LookAtRemarks(kSaidMs);
  one_.keeper.LookAtRemarks(kSaidMs);
  EXPECT_EQ(StateAt(one_), RemarkState::kShown);
  EXPECT_EQ(one_.board.remarks().Of(attempt_)[0].shown_ms, kSaidMs + 70);
}

TEST_F(BoardKeeperTest, ARemarkThatWaitsOutlivesTheServer) {
  for (bool shared : {true, false}) {
    rows_ = {};
    OneServer before(rows_, shared);
    Say(before, 1);
    Say(before, 2);
    (void)before.board.remarks().Take(attempt_);
    before.board.remarks().Shown(attempt_, 1, kSaidMs);
    before.keeper.LookAtRemarks(kSaidMs);
    OneServer after(rows_, shared);
    after.keeper.LookAtRemarks(kSaidMs);
    const auto taken = after.board.remarks().Take(attempt_);
    ASSERT_EQ(taken.size(), 1u);
    EXPECT_EQ(taken[0].id, 2u);
    EXPECT_EQ(StateAt(after), RemarkState::kShown);
  }
}

TEST_F(BoardKeeperTest, AServerThatIsAloneReadsOnce) {
  OneServer alone(rows_, /*shared=*/false);
  rows_.away = true;
  alone.keeper.LookAtRemarks(kSaidMs);
  rows_.away = false;
  for (int i = 0; i < 5; ++i) alone.keeper.LookAtRemarks(kSaidMs);
  EXPECT_EQ(alone.store.reads, 2);
}

TEST_F(BoardKeeperTest, WhatCouldNotBeStoredIsStoredLater) {
  Say(one_, 1);
  (void)one_.board.remarks().Take(attempt_);
  rows_.away = true;
  one_.keeper.LookAtRemarks(kSaidMs);
  EXPECT_EQ(rows_.remarks[0].state, RemarkState::kWaiting);
  rows_.away = false;
  one_.keeper.LookAtRemarks(kSaidMs);
  EXPECT_EQ(rows_.remarks[0].state, RemarkState::kSent);
}

TEST_F(BoardKeeperTest, AnAttemptThatWasSealedElsewhereGoes) {
  Say(one_, 1);
  one_.keeper.LookAtRemarks(kSaidMs);
  rows_.remarks.clear();
  one_.keeper.LookAtRemarks(kSaidMs + 1000);
  EXPECT_EQ(one_.board.remarks().Of(attempt_).size(), 1u) << "it may have been said just now";
  one_.keeper.LookAtRemarks(kSaidMs + 120'000);
  EXPECT_TRUE(one_.board.remarks().Of(attempt_).empty());
}

TEST_F(BoardKeeperTest, AStationIsConnectedForAllServers) {
  auto connection = one_.board.Enter(station_, true);
  one_.keeper.LookAtLinks();
  EXPECT_FALSE(two_.board.Connected(station_));
  two_.keeper.LookAtLinks();
  EXPECT_TRUE(two_.board.Connected(station_));
  EXPECT_TRUE(two_.board.ShowsRemarks(station_));
  connection.reset();
  one_.keeper.LookAtLinks();
  two_.keeper.LookAtLinks();
  EXPECT_FALSE(two_.board.Connected(station_));
  EXPECT_FALSE(two_.board.ShowsRemarks(station_));
}

TEST_F(BoardKeeperTest, OnlyWhatChangedIsWritten) {
  std::vector<std::unique_ptr<StationBoard::Connection>> all;
  for (int i = 0; i < 50; ++i) all.push_back(one_.board.Enter(Uuid::New()));
  auto mine = one_.board.Enter(station_, false);
  for (int i = 0; i < 10; ++i) one_.keeper.LookAtLinks();
  EXPECT_EQ(one_.store.written, 51u);
  EXPECT_EQ(one_.store.link_calls, 10) << "it is heard all the same";
  auto newer = one_.board.Enter(station_, true);
  mine.reset();
  all.pop_back();
  one_.keeper.LookAtLinks();
  EXPECT_EQ(one_.store.written, 53u);
  two_.keeper.LookAtLinks();
  EXPECT_TRUE(two_.board.ShowsRemarks(station_));
}

TEST_F(BoardKeeperTest, WhoWasTakenForGoneSaysAllOfItAgain) {
  auto connection = one_.board.Enter(station_, true);
  one_.keeper.LookAtLinks();
  rows_.links.clear();
  two_.keeper.LookAtLinks();
  EXPECT_FALSE(two_.board.Connected(station_));
  one_.keeper.LookAtLinks();
  two_.keeper.LookAtLinks();
  EXPECT_TRUE(two_.board.Connected(station_));
}

}  // namespace
}  // namespace enamel::server
