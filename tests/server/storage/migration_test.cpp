#include <gtest/gtest.h>

#include "tests/server/storage/backends.h"

// A step to the next schema, made for this test: there is no real one before the first release.
namespace enamel::server {
namespace {

using namespace testing;

class MigrationTest : public StoreSuite {
 protected:
  // A school with a recording of three chunks, and no server.
  void SetUp() override {
    World world(*store_);
    attempt_ = world.OpenedAttempt();
    world.Append(attempt_, 3);
    store_.reset();
    next_ = LatestSchemaVersion() + 1;
  }
  std::vector<sql::Migration> WithNext(const std::string& sql) const {
    std::vector<sql::Migration> out = place_->migrations();
    out.push_back({next_, "next.sql", sql});
    return out;
  }
  static Result<int64_t> Number(sql::Db& db, const std::string& sql) {
    sql::Query q(db, sql);
    const int64_t out = q.Next() ? q.Int(0) : 0;
    if (!q.status().ok()) return q.status();
    return out;
  }

  Uuid attempt_;
  int next_ = 0;
};

constexpr char kGoodStep[] =
    "ALTER TABLE attempts ADD COLUMN halves REAL NOT NULL DEFAULT 0;"
    "UPDATE attempts SET halves = chunks / 2.0;"
    "CREATE INDEX attempts_by_halves ON attempts (tenant, halves);";

TEST_P(MigrationTest, AStepKeepsEveryRowAndRunsOnce) {
  auto db = place_->Connect();
  ASSERT_EQ(*db->SchemaVersion(), next_ - 1);
  for (int start = 0; start < 2; ++start) {
    const Status done = db->Migrate(WithNext(kGoodStep));
    ASSERT_TRUE(done.ok()) << done.message();
    EXPECT_EQ(*db->SchemaVersion(), next_);
  }
  EXPECT_EQ(*Number(*db, "SELECT count(*) FROM trace_chunks"), 3);
  EXPECT_EQ(*Number(*db, "SELECT count(*) FROM people"), 1);
  EXPECT_EQ(*Number(*db, "SELECT count(*) FROM attempts WHERE halves = 1.5"), 1);
}

TEST_P(MigrationTest, AStepThatFailsInTheMiddleLeavesTheDatabaseAsItWas) {
  {
    auto db = place_->Connect();
    const Status failed =
        db->Migrate(WithNext(std::string(kGoodStep) + "INSERT INTO nowhere VALUES (1)"));
    EXPECT_FALSE(failed.ok());
    EXPECT_NE(failed.message().find("next.sql"), std::string::npos) << failed.message();
    EXPECT_EQ(*db->SchemaVersion(), next_ - 1);
    EXPECT_FALSE(Number(*db, "SELECT halves FROM attempts").ok());
  }
  Reopen();
  ASSERT_NE(store_, nullptr);
  EXPECT_EQ(AllChunks(store_->recordings, attempt_)->size(), 3u);
}

TEST_P(MigrationTest, ADatabaseOfANewerServerIsRefusedAndNotChanged) {
  ASSERT_TRUE(place_->Connect()->Migrate(WithNext(kGoodStep)).ok());
  const Status refused = place_->Try().status();
  EXPECT_EQ(refused.code(), Code::kVersion);
  for (const std::string& named :
       {"schema version " + std::to_string(next_), "knows up to " + std::to_string(next_ - 1),
        std::string("enamel-server restore"), std::string("is lost")})
    EXPECT_NE(refused.message().find(named), std::string::npos) << refused.message();
  EXPECT_EQ(*place_->Connect()->SchemaVersion(), next_);
}

INSTANTIATE_TEST_SUITE_P(Backends, MigrationTest, ::testing::ValuesIn(Backends()), BackendName);

}  // namespace
}  // namespace enamel::server
