#include "common/sqlite/sqlite_db.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/sql/query.h"
#include "tests/support/temp_folder.h"

// The driver for SQLite: what it opens, keeps and converts, and its errors.
namespace enamel::sql {
namespace {

namespace fs = std::filesystem;
using Mode = SqliteDbOptions::Mode;
using Kind = SqliteFailure::Kind;

class SqliteDbTest : public ::testing::Test {
 protected:
  fs::path File() const { return folder_.path() / "a.db"; }
  Result<std::unique_ptr<SqliteDb>> TryOpen(Mode mode, bool damaged = false, int32_t id = 0) {
    SqliteDbOptions options;
    options.mode = mode;
    options.damaged = damaged;
    options.application_id = id;
    options.explain = [this](const SqliteFailure& failure) {
      told_ = failure;
      return Status(CodeOf(failure.kind), failure.words);
    };
    return SqliteDb::Open(File(), std::move(options));
  }
  std::unique_ptr<SqliteDb> Open(Mode mode = Mode::kCreate) {
    auto db = TryOpen(mode);
    EXPECT_TRUE(db.ok()) << db.status().message();
    return std::move(db).value();
  }

  test::TempFolder folder_;
  SqliteFailure told_;
};

TEST_F(SqliteDbTest, StatementsAreKeptUpToANumberAndThoseInUseAlways) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t (n INTEGER); INSERT INTO t VALUES (1), (2), (3)").ok());
  Query rows(*db, "SELECT n FROM t ORDER BY n");
  ASSERT_TRUE(rows.Next());
  for (size_t i = 0; i < 4 * SqliteDb::kMaxStatements; ++i) {
    std::string sql = "SELECT " + std::to_string(i);
    Query q(*db, sql);
    ASSERT_TRUE(q.Next());
    EXPECT_EQ(q.Int(0), static_cast<int64_t>(i));
    EXPECT_LE(db->kept_statements(), SqliteDb::kMaxStatements);
  }
  EXPECT_TRUE(rows.Next());
  EXPECT_EQ(rows.Int(0), 2) << "not taken away under its user";
}

TEST_F(SqliteDbTest, EveryTypeComesBackAsItWasBoundAlsoWhereItIsEmpty) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t (a, b, c, d, e, f, g)").ok());
  {
    Query q(*db, "INSERT INTO t VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
    q.BindInt(INT64_MIN).BindReal(0.1).BindText("čau").BindText("").BindBlob(Bytes{0, 255});
    EXPECT_TRUE(q.BindBlob({}).BindNull(Type::kText).Run().ok());
  }
  Query q(*db, "SELECT a, b, c, d, e, f, g FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), INT64_MIN);
  EXPECT_EQ(q.Real(1), 0.1);
  EXPECT_EQ(q.Text(2), "čau");
  EXPECT_FALSE(q.IsNull(3)) << "an empty text is a text";
  EXPECT_EQ(q.Text(3), "");
  EXPECT_EQ(q.Blob(4), (Bytes{0, 255}));
  EXPECT_FALSE(q.IsNull(5)) << "an empty blob is a blob";
  EXPECT_TRUE(q.IsNull(6));
  EXPECT_EQ(q.Text(6), "");
  EXPECT_FALSE(q.Next());
  EXPECT_TRUE(q.status().ok());
}

TEST_F(SqliteDbTest, TextThatIsNoneIsRefused) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t (a TEXT)").ok());
  for (const std::string& text :
       {std::string("a\0b", 3), std::string("\xff"), std::string("\xc3")}) {
    Query q(*db, "INSERT INTO t VALUES (?1)");
    EXPECT_EQ(q.BindText(text).Run().code(), Code::kInvalidInput);
  }
}

TEST_F(SqliteDbTest, ColumnsAreFoundByNameAndThoseThatAreNotThereReadAsNothing) {
  auto db = Open();
  Query q(*db, "SELECT 7 AS seven, 'x' AS letter");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.columns(), 2);
  EXPECT_EQ(q.NameOf(1), "letter");
  EXPECT_EQ(q.Int("seven"), 7);
  EXPECT_EQ(q.Text("letter"), "x");
  EXPECT_EQ(q.ColumnNamed("eight"), -1);
  EXPECT_TRUE(q.IsNull("eight"));
  EXPECT_EQ(q.Int("eight"), 0);
  EXPECT_EQ(q.Text("eight"), "");
  EXPECT_EQ(q.Blob("eight"), Bytes{});
  EXPECT_TRUE(q.Id(0).IsZero()) << "no 16 bytes";
}

TEST_F(SqliteDbTest, AValueOfAnyTypeIsTakenOverFromAnotherRow) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t (v)").ok());
  {
    Query from(*db, "SELECT 1, 2.5, 'text', x'00ff', NULL");
    ASSERT_TRUE(from.Next());
    for (int column = -1; column < from.columns(); ++column) {
      Query q(*db, "INSERT INTO t VALUES (?1)");
      EXPECT_TRUE(q.BindSame(from, column).Run().ok());
    }
  }
  Query q(*db, "SELECT group_concat(typeof(v) || ':' || quote(v), ' ') FROM t ORDER BY rowid");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Text(0), "null:NULL integer:1 real:2.5 text:'text' blob:X'00FF' null:NULL");
}

TEST_F(SqliteDbTest, AStatementThatIsNoneFailsOnceAndBindsAndReadsNothing) {
  auto db = Open();
  Query q(*db, "SELECT nothing FROM nowhere");
  q.BindInt(1).BindText("x").BindNull(Type::kInt);
  EXPECT_FALSE(q.Next());
  EXPECT_EQ(q.status().code(), Code::kInternal);
  EXPECT_EQ(q.columns(), 0);
  EXPECT_EQ(q.Int(0), 0);
  EXPECT_TRUE(q.IsNull(0));
  Query too_many(*db, "SELECT ?1");
  EXPECT_FALSE(too_many.BindInt(1).BindInt(2).Next()) << "there is no ?2";
  EXPECT_EQ(db->failure().kind, Kind::kOwnFault);
}

TEST_F(SqliteDbTest, FailuresAreToldByTheirKind) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE a (id INTEGER PRIMARY KEY, n INTEGER CHECK (n > 0));"
                       "INSERT INTO a VALUES (1, 1)")
                  .ok());
  EXPECT_EQ(db->Exec("INSERT INTO a VALUES ('no number', 1)").code(), Code::kInvalidInput);
  EXPECT_EQ(db->failure().kind, Kind::kData);
  EXPECT_EQ(db->Exec("INSERT INTO a VALUES (1, 1)").code(), Code::kConflict);
  EXPECT_EQ(db->failure().kind, Kind::kTaken);
  EXPECT_EQ(db->Exec("INSERT INTO a VALUES (2, 0)").code(), Code::kConflict);
  EXPECT_EQ(db->failure().kind, Kind::kConstraint);
  auto other = Open();
  ASSERT_TRUE(other->Begin(Isolation::kSerial).ok());
  db->SetBusyWait(std::chrono::milliseconds(1));
  EXPECT_EQ(db->Begin(Isolation::kSerial).code(), Code::kUnavailable);
  EXPECT_EQ(db->failure().kind, Kind::kBusy);
  EXPECT_FALSE(told_.opening);
  EXPECT_EQ(told_.path, File().string());
  other->Rollback();
  EXPECT_TRUE(db->Exec("SELECT 1").ok());
  EXPECT_EQ(db->failure().words, "") << "the last statement did not fail";
  auto reader = Open(Mode::kReadOnly);
  EXPECT_FALSE(reader->Exec("INSERT INTO a VALUES (3, 3)").ok());
  EXPECT_EQ(reader->failure().kind, Kind::kNotWritable);
}

// Between two looks more time goes by than the whole patience.
TEST_F(SqliteDbTest, PatienceStartsWhenWhatWasWorthWaitingForEnds) {
  auto db = Open();
  auto other = Open();
  ASSERT_TRUE(other->Begin(Isolation::kSerial).ok());
  int looks = 0;
  db->SetBusyWait(std::chrono::milliseconds(1), [&] {
    if (++looks < 4) return true;
    other->Rollback();
    return false;
  });
  EXPECT_TRUE(db->Begin(Isolation::kSerial).ok());
  EXPECT_EQ(looks, 4);
  EXPECT_FALSE(db->waits());
}

TEST_F(SqliteDbTest, OnlyCreateMakesAFileThatIsNotThere) {
  for (Mode mode : {Mode::kExisting, Mode::kReadOnly}) {
    EXPECT_FALSE(TryOpen(mode).ok());
    EXPECT_TRUE(told_.opening);
    EXPECT_EQ(told_.kind, Kind::kNotWritable);
    EXPECT_FALSE(fs::exists(File()));
  }
  EXPECT_TRUE(TryOpen(Mode::kCreate).ok());
  EXPECT_TRUE(fs::exists(File()));
}

TEST_F(SqliteDbTest, WhatIsNoDatabaseIsToldAsDamaged) {
  std::ofstream(File()) << std::string(5000, 'x');
  for (bool damaged : {false, true}) {
    EXPECT_FALSE(TryOpen(Mode::kExisting, damaged).ok());
    EXPECT_EQ(told_.kind, Kind::kDamaged);
  }
}

TEST_F(SqliteDbTest, ATableOfADamagedFileIsReadAsFarAsItGoes) {
  {
    auto db = Open();
    ASSERT_TRUE(db->Exec("CREATE TABLE t (n INTEGER, b BLOB); WITH RECURSIVE c(n) AS (SELECT 1 "
                         "UNION ALL SELECT n + 1 FROM c WHERE n < 1000) INSERT INTO t SELECT n, "
                         "zeroblob(1000) FROM c; PRAGMA wal_checkpoint(TRUNCATE)")
                    .ok());
  }
  fs::resize_file(File(), fs::file_size(File()) / 2 / 4096 * 4096);
  auto db = TryOpen(Mode::kReadOnly, true);
  ASSERT_TRUE(db.ok()) << db.status().message();
  int rows = 0;
  Query q(**db, "SELECT n FROM t ORDER BY rowid");
  while (q.Next()) ++rows;
  EXPECT_FALSE(q.status().ok());
  EXPECT_GT(rows, 100);
  EXPECT_LT(rows, 1000);
  EXPECT_TRUE((*db)->damaged());
}

TEST_F(SqliteDbTest, ATransactionThatIsNotCommittedHasNeverBeen) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t (n INTEGER)").ok());
  {
    Transaction lost(*db);
    ASSERT_TRUE(lost.begun().ok());
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES (1)").ok());
    EXPECT_EQ(db->Changes(), 1);
    Transaction inside(*db);
    EXPECT_FALSE(inside.begun().ok()) << "there is one at a time";
  }
  {
    Transaction kept(*db);
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES (2)").ok());
    EXPECT_TRUE(kept.Commit().ok());
  }
  db->Rollback();  // nothing to do
  Query q(*db, "SELECT sum(n) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 2);
}

TEST_F(SqliteDbTest, ASnapshotIsOfOneMomentAndKeepsNobodyFromWriting) {
  auto db = Open(), other = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t (n INTEGER)").ok());
  const auto count = [](SqliteDb& db) {
    Query q(db, "SELECT count(*) FROM t");
    EXPECT_TRUE(q.Next()) << q.status().message();
    return q.Int(0);
  };
  {
    Transaction moment(*db, Isolation::kSnapshot);
    EXPECT_EQ(count(*db), 0);
    ASSERT_TRUE(other->Exec("INSERT INTO t VALUES (1)").ok());
    EXPECT_EQ(count(*db), 0);
    EXPECT_TRUE(moment.Commit().ok());
  }
  EXPECT_EQ(count(*db), 1);
}

const std::vector<Migration> kTwo = {{1, "0001_a.sql", "CREATE TABLE a (n INTEGER)"},
                                     {2, "0002_b.sql", "CREATE TABLE b (n INTEGER)"}};

TEST_F(SqliteDbTest, MigrationsThatAreMissingRunOnceAndAllOrNone) {
  auto db = Open();
  EXPECT_EQ(*db->SchemaVersion(), 0);
  ASSERT_TRUE(db->Migrate({kTwo[0]}).ok());
  EXPECT_EQ(*db->SchemaVersion(), 1);
  auto broken = kTwo;
  broken.push_back({3, "0003_c.sql", "CREATE TABLE c (n INTEGER); INSERT INTO nowhere VALUES (1)"});
  Status failed = db->Migrate(broken);
  EXPECT_NE(failed.message().find("0003_c.sql"), std::string::npos) << failed.message();
  EXPECT_EQ(*db->SchemaVersion(), 1);
  EXPECT_FALSE(db->Exec("SELECT n FROM b").ok()) << "nor is the one before it there";
  ASSERT_TRUE(db->Migrate(kTwo).ok());
  EXPECT_TRUE(db->Exec("SELECT n FROM b").ok());
  EXPECT_TRUE(db->Migrate(kTwo).ok()) << "nothing to do";
  EXPECT_TRUE(db->Migrate({kTwo[0]}).ok()) << "a newer file is left as it is";
  EXPECT_EQ(*db->SchemaVersion(), 2);
}

TEST_F(SqliteDbTest, TwoThatMigrateAtOnceBothSucceed) {
  std::array<Status, 4> done;
  std::vector<std::thread> threads;
  for (Status& mine : done) {
    threads.emplace_back([&mine, file = File()] {
      auto db = SqliteDb::Open(file, {});
      mine = db.ok() ? (*db)->Migrate(kTwo) : db.status();
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Status& mine : done) EXPECT_TRUE(mine.ok()) << mine.message();
  EXPECT_EQ(*Open()->SchemaVersion(), 2);
}

TEST_F(SqliteDbTest, AFileOfAnotherProgramIsNotTakenForOurs) {
  ASSERT_TRUE((*TryOpen(Mode::kCreate, false, 7))->Migrate(kTwo).ok());
  EXPECT_EQ(*(*TryOpen(Mode::kExisting, false, 7))->SchemaVersion(), 2);
  auto other = TryOpen(Mode::kExisting, false, 8);
  EXPECT_EQ((*other)->SchemaVersion().status().code(), Code::kVersion);
  EXPECT_EQ((*other)->Migrate(kTwo).code(), Code::kVersion);
}

TEST_F(SqliteDbTest, AMemberOfJsonIsFound) {
  auto db = Open();
  Query q(*db, "SELECT " + db->JsonMember("?1", "person"));
  ASSERT_TRUE(q.BindText(R"({"person":"who","other":1})").Next());
  EXPECT_EQ(q.Text(0), "who");
}

TEST_F(SqliteDbTest, WhatIsDeletedIsOverwrittenWhereThatIsAsked) {
  auto db = Open();
  ASSERT_TRUE(db->OverwriteDeleted(true).ok());
  ASSERT_TRUE(db->Exec("CREATE TABLE t (b TEXT); INSERT INTO t VALUES ('NotToBeFoundAgain')").ok());
  ASSERT_TRUE(db->EmptyLog().ok());
  auto found = [&] {
    std::ifstream in(File(), std::ios::binary);
    const std::string all((std::istreambuf_iterator<char>(in)), {});
    return all.find("NotToBeFoundAgain") != std::string::npos;
  };
  EXPECT_TRUE(found());
  ASSERT_TRUE(db->Exec("DELETE FROM t").ok());
  ASSERT_TRUE(db->EmptyLog().ok());
  EXPECT_FALSE(found());
}

TEST_F(SqliteDbTest, StoppingEndsARewriteAndLetsOrdinaryWritesThrough) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t (n INTEGER); WITH RECURSIVE c(n) AS (SELECT 1 UNION ALL "
                       "SELECT n + 1 FROM c WHERE n < 100000) INSERT INTO t SELECT n FROM c")
                  .ok());
  EXPECT_TRUE(db->Rewrite().ok());
  db->StopWaiting();
  EXPECT_EQ(db->Rewrite().code(), Code::kUnavailable);
  EXPECT_EQ(db->EmptyLog().code(), Code::kUnavailable);
  EXPECT_TRUE(db->Exec("UPDATE t SET n = n + 1").ok());
}

}  // namespace
}  // namespace enamel::sql
