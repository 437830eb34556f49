#include "server/live/board_keeper.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/storage/engine/query.h"
#include "server/storage/store_engine.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server {
namespace {

using namespace server::testing;

// One of the servers of a school, whose rows are in the same database.
struct OneServer {
  explicit OneServer(const std::filesystem::path& folder, bool shared = true)
      : store(OpenStore(folder, [this] { return away; })),
        keeper(board, *store, shared, BoardKeeper::ByHand()) {}
  bool away = false;  // the database: nothing can be written
  std::unique_ptr<Store> store;
  StationBoard board;
  BoardKeeper keeper;
};

class BoardKeeperTest : public ::testing::Test {
 protected:
  // Gives what its station knows it by.
  uint64_t Say(OneServer& at) {
    AnnotationRow row;
    row.attempt = attempt_;
    row.tick = 5;
    row.text = "stop";
    row.to_chair = true;
    const auto said = at.store->remarks.AddAnnotation(row, {world_.student, "test"});
    EXPECT_TRUE(said.ok()) << said.status().message();
    const auto all = at.store->live.ChairRemarks(0);
    for (const ChairRemark& remark : *all) {
      if (remark.id != said->remark_id) continue;
      at.board.remarks().Put(remark);
      said_ms_ = remark.sent_ms;
    }
    return said->remark_id;
  }
  RemarkState StateAt(OneServer& at, size_t index = 0) {
    return at.board.remarks().Of(attempt_).at(index).state;
  }
  RemarkState StoredState() { return one_.store->live.ChairRemarks(0)->at(0).state; }
  void Exec(const std::string& sql) {
    const Status done =
        one_.store->engine->rows.Write([&](sql::Db& db) { return db.Exec(sql.c_str()); });
    EXPECT_TRUE(done.ok()) << done.message();
  }
  int64_t Count(const std::string& table) {
    return *one_.store->engine->rows.Read([&](sql::Db& db) -> Result<int64_t> {
      sql::Query q(db, "SELECT count(*) FROM " + table);
      if (!q.Next()) return q.status();
      return q.Int(0);
    });
  }
  // Every change of a row of `table` becomes a row of `log`.
  void Log(const std::string& table, const std::string& log) {
    Exec("CREATE TABLE " + log + " (one INTEGER)");
    for (const char* change : {"INSERT", "UPDATE", "DELETE"}) {
      Exec("CREATE TRIGGER " + log + "_" + change + " AFTER " + change + " ON " + table +
           " BEGIN INSERT INTO " + log + " VALUES (1); END");
    }
  }

  TempFolder folder_;
  OneServer one_{folder_.path()}, two_{folder_.path()};
  World world_{*one_.store};
  Uuid attempt_ = world_.OpenedAttempt();
  const Uuid station_ = Uuid::New();
  UnixMs said_ms_ = 0;
};

TEST_F(BoardKeeperTest, ARemarkReachesTheServerOfItsStationAndItsStateComesBack) {
  const uint64_t id = Say(one_);
  two_.keeper.LookAtRemarks(said_ms_);
  ASSERT_EQ(two_.board.remarks().Take(attempt_).size(), 1u);
  two_.keeper.LookAtRemarks(said_ms_);
  one_.keeper.LookAtRemarks(said_ms_);
  EXPECT_EQ(StateAt(one_), RemarkState::kSent);
  two_.board.remarks().Shown(attempt_, id, said_ms_ + 70);
  two_.keeper.LookAtRemarks(said_ms_);
  one_.keeper.LookAtRemarks(said_ms_);
  EXPECT_EQ(StateAt(one_), RemarkState::kShown);
  EXPECT_EQ(one_.board.remarks().Of(attempt_)[0].shown_ms, said_ms_ + 70);
}

TEST_F(BoardKeeperTest, ARemarkThatWaitsOutlivesTheServer) {
  for (bool shared : {true, false}) {
    attempt_ = world_.OpenedAttempt();
    OneServer before(folder_.path(), shared);
    const uint64_t first = Say(before), second = Say(before);
    (void)before.board.remarks().Take(attempt_);
    before.board.remarks().Shown(attempt_, first, said_ms_);
    before.keeper.LookAtRemarks(said_ms_);
    OneServer after(folder_.path(), shared);
    after.keeper.LookAtRemarks(said_ms_);
    const auto taken = after.board.remarks().Take(attempt_);
    ASSERT_EQ(taken.size(), 1u);
    EXPECT_EQ(taken[0].id, second);
    EXPECT_EQ(StateAt(after), RemarkState::kShown);
  }
}

TEST_F(BoardKeeperTest, AServerThatIsAloneReadsOnce) {
  OneServer alone(folder_.path(), /*shared=*/false);
  Say(one_);
  Exec("ALTER TABLE annotations RENAME TO annotations_away");
  alone.keeper.LookAtRemarks(said_ms_);
  Exec("ALTER TABLE annotations_away RENAME TO annotations");
  alone.keeper.LookAtRemarks(said_ms_);
  EXPECT_EQ(alone.board.remarks().Of(attempt_).size(), 1u);
  Say(one_);
  for (int i = 0; i < 5; ++i) alone.keeper.LookAtRemarks(said_ms_);
  EXPECT_EQ(alone.board.remarks().Of(attempt_).size(), 1u) << "nobody else says anything";
}

TEST_F(BoardKeeperTest, WhatCouldNotBeStoredIsStoredLater) {
  Say(one_);
  (void)one_.board.remarks().Take(attempt_);
  one_.away = true;
  one_.keeper.LookAtRemarks(said_ms_);
  EXPECT_EQ(StoredState(), RemarkState::kWaiting);
  one_.away = false;
  one_.keeper.LookAtRemarks(said_ms_);
  EXPECT_EQ(StoredState(), RemarkState::kSent);
}

TEST_F(BoardKeeperTest, AnAttemptThatWasSealedElsewhereGoes) {
  Say(one_);
  one_.keeper.LookAtRemarks(said_ms_);
  const Status sealed =
      two_.store->seals.SealAttempt(World::SealOf(world_.Append(attempt_, 1)), said_ms_);
  ASSERT_TRUE(sealed.ok()) << sealed.message();
  one_.keeper.LookAtRemarks(said_ms_ + 1000);
  EXPECT_EQ(one_.board.remarks().Of(attempt_).size(), 1u) << "it may have been said just now";
  one_.keeper.LookAtRemarks(said_ms_ + 120'000);
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
  Log("station_links", "written");
  Log("running_servers", "heard");
  std::vector<std::unique_ptr<StationBoard::Connection>> all;
  for (int i = 0; i < 50; ++i) all.push_back(one_.board.Enter(Uuid::New()));
  auto mine = one_.board.Enter(station_, false);
  for (int i = 0; i < 10; ++i) one_.keeper.LookAtLinks();
  EXPECT_EQ(Count("written"), 51);
  EXPECT_EQ(Count("heard"), 10) << "it is heard all the same";
  auto newer = one_.board.Enter(station_, true);
  mine.reset();
  all.pop_back();
  one_.keeper.LookAtLinks();
  EXPECT_EQ(Count("written"), 53);
  two_.keeper.LookAtLinks();
  EXPECT_TRUE(two_.board.ShowsRemarks(station_));
}

TEST_F(BoardKeeperTest, WhoWasTakenForGoneSaysAllOfItAgain) {
  auto connection = one_.board.Enter(station_, true);
  one_.keeper.LookAtLinks();
  Exec("DELETE FROM station_links; DELETE FROM running_servers");
  two_.keeper.LookAtLinks();
  EXPECT_FALSE(two_.board.Connected(station_));
  one_.keeper.LookAtLinks();
  two_.keeper.LookAtLinks();
  EXPECT_TRUE(two_.board.Connected(station_));
}

}  // namespace
}  // namespace enamel::server
