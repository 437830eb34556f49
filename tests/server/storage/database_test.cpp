#include "server/storage/engine/database.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <future>

#include "server/storage/store_engine.h"
#include "tests/server/storage/simulated_disk.h"
#include "tests/server/storage/store_world.h"

// enamel.db as the server opens it: how much it keeps, and how it reports failures.
namespace enamel::server {
namespace {

using namespace enamel::server::testing;

class DatabaseTest : public ::testing::Test {
 protected:
  std::unique_ptr<SqliteDb> Open() {
    auto db = OpenDatabase(folder_.path() / "enamel.db", DbMode::kCreate);
    EXPECT_TRUE(db.ok()) << db.status().message();
    return std::move(db).value();
  }
  TempFolder folder_;
};

// Everybody may request lists; their statements must not stay in memory.
TEST_F(DatabaseTest, ListsAskedForInThousandsOfWaysTakeNoMoreMemory) {
  auto store = OpenStore(folder_.path());
  World world(*store);
  auto ask = [&](uint32_t salt) {
    AttemptFilter filter;
    filter.person = world.student;
    filter.limit = 1 + salt % 200;
    filter.flags = 1 + salt % 511;
    filter.state = static_cast<AttemptState>(1 + salt % 7);
    if (salt % 2 == 0) filter.before = Uuid::New();
    EXPECT_TRUE(store->attempts.Attempts(filter).ok());
  };
  for (uint32_t salt = 0; salt < 200; ++salt) ask(salt);
  const int64_t before = sqlite3_memory_used();
  for (uint32_t salt = 200; salt < 4000; ++salt) ask(salt);
  EXPECT_LT(sqlite3_memory_used() - before, 1 << 20);
}

TEST_F(DatabaseTest, AReaderOfTheStoreKeepsFourMebibytesOfTheFile) {
  const auto store = OpenStore(folder_.path());
  const auto kibibytes = store->engine->rows.Read([](Db& db) -> Result<int64_t> {
    Query q(db, "SELECT -cache_size FROM pragma_cache_size WHERE ?1 = ?1");
    if (q.Next()) return q.Int(0);
    return q.status();
  });
  ASSERT_TRUE(kibibytes.ok()) << kibibytes.status().message();
  EXPECT_EQ(*kibibytes, 4096);
}

TEST_F(DatabaseTest, FailuresTellWhatToDoButNoPathAndNoneOfSqlitesWords) {
  auto db = Open(), other = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE a (id INTEGER PRIMARY KEY);"
                       "CREATE TABLE b (a INTEGER NOT NULL REFERENCES a (id))")
                  .ok());
  Status missing = db->Exec("INSERT INTO b VALUES (7)");
  EXPECT_EQ(missing.code(), Code::kConflict);
  ASSERT_TRUE(db->Exec("BEGIN; SELECT count(*) FROM a").ok());
  ASSERT_TRUE(other->Exec("INSERT INTO a VALUES (1)").ok());
  Status busy = db->Exec("INSERT INTO a VALUES (2)");  // what it has read is no longer so
  EXPECT_EQ(busy.code(), Code::kUnavailable);
  Status wrong = other->Exec("SELECT nothing FROM nowhere");
  EXPECT_EQ(wrong.code(), Code::kInternal);
  for (const Status& status : {missing, busy, wrong}) {
    EXPECT_FALSE(status.message().empty());
    for (const char* inner : {"enamel.db", "/tmp", "constraint", "locked", "SQL", "nowhere"}) {
      EXPECT_EQ(status.message().find(inner), std::string::npos) << status.message();
    }
  }
}

// SQLite itself never waits for whoever empties the log already.
TEST_F(DatabaseTest, EmptyingTheLogWaitsForAnotherConnectionThatDoesItJustNow) {
  std::atomic<bool> armed{false};
  std::promise<void> held, release;
  SimulatedDisk disk(folder_.path());
  disk.SetBeforeWrite([&](const std::string& path) {
    if (path != "enamel.db" || !armed.exchange(false)) return;
    held.set_value();
    (void)release.get_future().wait_for(std::chrono::minutes(2));
  });
  auto other = OpenDatabase(folder_.path() / "enamel.db", DbMode::kCreate, disk.vfs());
  ASSERT_TRUE(other.ok()) << other.status().message();
  ASSERT_TRUE((*other)->Exec("CREATE TABLE t (n INTEGER); INSERT INTO t VALUES (1)").ok());
  auto db = Open();
  armed = true;
  auto first = std::async([&] { return (*other)->EmptyLog(); });
  ASSERT_EQ(held.get_future().wait_for(std::chrono::minutes(2)), std::future_status::ready);
  db->SetBusyWait(std::chrono::milliseconds(20));
  EXPECT_EQ(db->EmptyLog().code(), Code::kUnavailable) << "not for ever";
  db->SetBusyWait(std::chrono::minutes(2));
  auto second = std::async([&] { return db->EmptyLog(); });
  EXPECT_EQ(second.wait_for(std::chrono::milliseconds(100)), std::future_status::timeout);
  release.set_value();
  EXPECT_TRUE(first.get().ok());
  Status emptied = second.get();
  EXPECT_TRUE(emptied.ok()) << emptied.message();
}

}  // namespace
}  // namespace enamel::server
