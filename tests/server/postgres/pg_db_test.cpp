#include "server/postgres/pg_db.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <thread>
#include <vector>

#include "common/base/unix_time.h"
#include "common/sql/query.h"
#include "server/postgres/pg_text.h"
#include "tests/support/becomes.h"
#include "tests/support/missing_standbys.h"
#include "tests/support/postgres_proxy.h"

// The driver for PostgreSQL: what it keeps and converts, its errors, and how it recovers when the
// server or another transaction interferes. with_postgres.sh starts the server and names it.
namespace enamel::sql {
namespace {

using Kind = PgFailure::Kind;

class PgDbTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* server = std::getenv("ENAMEL_POSTGRES");
    if (server == nullptr) GTEST_SKIP() << "ENAMEL_POSTGRES names no server";
    server_ = server;
    // A schema for each test.
    schema_ = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    db_ = Open();
    ASSERT_TRUE(db_->Exec(("CREATE SCHEMA \"" + schema_ + "\"").c_str()).ok());
  }
  void TearDown() override {
    if (db_ == nullptr) return;
    db_->Rollback();
    EXPECT_TRUE(db_->Exec(("DROP SCHEMA \"" + schema_ + "\" CASCADE").c_str()).ok());
  }
  PgDbOptions Options() {
    PgDbOptions options;
    options.server = server_;
    options.schema = schema_;
    options.application = "enamel test";
    return options;
  }
  std::unique_ptr<PgDb> Open(bool read_only = false) {
    PgDbOptions options = Options();
    options.read_only = read_only;
    auto db = PgDb::Open(std::move(options));
    EXPECT_TRUE(db.ok()) << db.status().message();
    return std::move(db).value();
  }
  // Ends the connection from outside, as a server that dies does.
  void Cut(PgDb& db) {
    int64_t pid = 0;
    {
      Query q(db, "SELECT pg_backend_pid()");
      ASSERT_TRUE(q.Next());
      pid = q.Int(0);
    }
    auto other = Open();
    Query q(*other, "SELECT pg_terminate_backend(?1::int)");
    ASSERT_TRUE(q.BindInt(pid).Next()) << q.status().message();
  }

  static Change Insert(int64_t n) {
    return {"INSERT INTO t SELECT ?1", [n](Query& q) { q.BindInt(n); }};
  }
  static Status Commit(PgDb& db, const std::vector<Change*>& changes, bool& ran) {
    Status kept = db.RunAndCommit(changes, ran);
    if (!kept.ok()) db.Rollback();
    return kept;
  }

  std::string server_, schema_;
  std::unique_ptr<PgDb> db_;
};

TEST_F(PgDbTest, EveryTypeComesBackAsItWasBoundAlsoWhereItIsEmpty) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (a bigint, b double precision, c text, d text, e bytea, "
                        "f bytea, g text)")
                  .ok());
  {
    Query q(*db_, "INSERT INTO t VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
    q.BindInt(INT64_MIN).BindReal(0.1).BindText("čau ?1 $1").BindText("").BindBlob(Bytes{0, 255});
    EXPECT_TRUE(q.BindBlob({}).BindNull(Type::kText).Run().ok()) << q.status().message();
  }
  EXPECT_EQ(db_->Changes(), 1);
  Query q(*db_, "SELECT a, b, c, d, e, f, g FROM t");
  ASSERT_TRUE(q.Next()) << q.status().message();
  EXPECT_EQ(q.Int(0), INT64_MIN);
  EXPECT_EQ(q.Real(1), 0.1);
  EXPECT_EQ(q.Text(2), "čau ?1 $1");
  EXPECT_FALSE(q.IsNull(3)) << "an empty text is a text";
  EXPECT_EQ(q.Text(3), "");
  EXPECT_EQ(q.Blob(4), (Bytes{0, 255}));
  EXPECT_FALSE(q.IsNull(5)) << "an empty blob is a blob";
  EXPECT_TRUE(q.IsNull(6));
  EXPECT_EQ(q.Text(6), "");
  EXPECT_EQ(q.TypeOf(0), Type::kInt);
  EXPECT_EQ(q.TypeOf(1), Type::kReal);
  EXPECT_EQ(q.TypeOf(2), Type::kText);
  EXPECT_EQ(q.TypeOf(4), Type::kBlob);
  EXPECT_FALSE(q.Next());
  EXPECT_TRUE(q.status().ok());
}

// sum over bigint is numeric to PostgreSQL, a count bigint, a comparison bool.
TEST_F(PgDbTest, WhatThePostgresFunctionsGiveReadsAsANumber) {
  Query q(*db_,
          "SELECT sum(x), avg(x), count(*), 2 > 1, 1::smallint, 2::int, 1.5::real, sum(x) * 0 - "
          "9223372036854775807 FROM (VALUES (20000::bigint), (10001)) t (x)");
  ASSERT_TRUE(q.Next()) << q.status().message();
  EXPECT_EQ(q.Int(0), 30001);
  EXPECT_EQ(q.TypeOf(0), Type::kInt);
  EXPECT_EQ(q.Real(1), 15000.5);
  EXPECT_EQ(q.TypeOf(1), Type::kReal);
  EXPECT_EQ(q.Int(2), 2);
  EXPECT_EQ(q.Int(3), 1);
  EXPECT_EQ(q.Int(4), 1);
  EXPECT_EQ(q.Int(5), 2);
  EXPECT_EQ(q.Real(6), 1.5);
  EXPECT_EQ(q.Int(7), -INT64_MAX);
}

TEST_F(PgDbTest, QuestionMarksInsideQuotationsAreNoParameters) {
  Query q(*db_, "SELECT 'a?1''?2' || ?1 AS \"x?1\"");
  ASSERT_TRUE(q.BindText("b").Next()) << q.status().message();
  EXPECT_EQ(q.Text(0), "a?1'?2b");
  EXPECT_EQ(q.NameOf(0), "x?1");
}

TEST_F(PgDbTest, TextThatIsNoneIsRefused) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (a text)").ok());
  for (const std::string& text :
       {std::string("a\0b", 3), std::string("\xff"), std::string("\xc3")}) {
    Query q(*db_, "INSERT INTO t VALUES (?1)");
    EXPECT_EQ(q.BindText(text).Run().code(), Code::kInvalidInput);
  }
}

TEST_F(PgDbTest, StatementsAreKeptUpToANumberAndThoseInUseAlways) {
  Query rows(*db_, "SELECT n FROM generate_series(1, 3) n");
  ASSERT_TRUE(rows.Next());
  for (size_t i = 0; i < 2 * PgDb::kMaxStatements; ++i) {
    Query q(*db_, "SELECT " + std::to_string(i));
    ASSERT_TRUE(q.Next());
    EXPECT_EQ(q.Int(0), static_cast<int64_t>(i));
    EXPECT_LE(db_->kept_statements(), PgDb::kMaxStatements);
  }
  EXPECT_TRUE(rows.Next());
  EXPECT_EQ(rows.Int(0), 2) << "not taken away under its user";
  Query q(*db_, "SELECT count(*) FROM pg_prepared_statements");
  ASSERT_TRUE(q.Next());
  EXPECT_LE(q.Int(0), static_cast<int64_t>(PgDb::kMaxStatements)) << "given back at the server too";
}

TEST_F(PgDbTest, AStatementMayBeBoundWithOtherTypesNextTime) {
  for (int round = 0; round < 2; ++round) {
    Query text(*db_, "SELECT coalesce(?1, ?2) IS NULL");
    ASSERT_TRUE(text.BindNull(Type::kText).BindText("x").Next());
    EXPECT_EQ(text.Int(0), 0);
  }
  Query number(*db_, "SELECT coalesce(?1, ?2) IS NULL");
  ASSERT_TRUE(number.BindNull(Type::kInt).BindInt(1).Next()) << number.status().message();
}

TEST_F(PgDbTest, FailuresAreToldByTheirKind) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE a (id bigint PRIMARY KEY, n bigint CHECK (n > 0));"
                        "INSERT INTO a VALUES (1, 1)")
                  .ok());
  EXPECT_EQ(db_->Exec("INSERT INTO a VALUES (1, 1)").code(), Code::kConflict);
  EXPECT_EQ(db_->failure().kind, Kind::kTaken);
  EXPECT_EQ(db_->failure().state, "23505");
  EXPECT_EQ(db_->Exec("INSERT INTO a VALUES (2, 0)").code(), Code::kConflict);
  EXPECT_EQ(db_->failure().kind, Kind::kConstraint);
  Query none(*db_, "SELECT nothing FROM nowhere");
  EXPECT_FALSE(none.Next());
  EXPECT_EQ(none.status().code(), Code::kInternal);
  EXPECT_EQ(db_->failure().kind, Kind::kOwnFault);
  EXPECT_EQ(none.columns(), 0);
  EXPECT_EQ(db_->Exec("SELECT 9223372036854775807 + 1").code(), Code::kInvalidInput);
  EXPECT_EQ(db_->failure().kind, Kind::kData);
  auto reader = Open(/*read_only=*/true);
  EXPECT_EQ(reader->Exec("INSERT INTO a VALUES (3, 1)").code(), Code::kUnavailable);
  EXPECT_EQ(reader->failure().kind, Kind::kReadOnly);
  EXPECT_TRUE(db_->Exec("SELECT 1").ok());
  EXPECT_EQ(db_->failure().words, "") << "the last statement did not fail";
}

// As on a primary that becomes a standby without the connection being lost.
TEST_F(PgDbTest, AConnectionThatMayWriteAndFindsItsServerReadOnlyIsMadeAnew) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint)").ok());
  const auto demote = [&] { return db_->Exec("SET default_transaction_read_only = on"); };
  ASSERT_TRUE(demote().ok());
  EXPECT_FALSE(db_->Exec("INSERT INTO t VALUES (1)").ok());
  EXPECT_EQ(db_->failure().kind, Kind::kReadOnly);
  EXPECT_TRUE(db_->Exec("INSERT INTO t VALUES (1)").ok()) << "on another connection";
  ASSERT_TRUE(demote().ok());
  {
    Transaction refused(*db_);
    ASSERT_TRUE(refused.begun().ok());
    EXPECT_FALSE(db_->Exec("INSERT INTO t VALUES (2)").ok());
    EXPECT_TRUE(db_->must_repeat());
    EXPECT_FALSE(refused.Commit().ok());
  }
  Transaction again(*db_);
  ASSERT_TRUE(again.begun().ok());
  EXPECT_TRUE(db_->Exec("INSERT INTO t VALUES (2)").ok());
  EXPECT_TRUE(again.Commit().ok());
}

TEST_F(PgDbTest, AServerIsAskedForItsClockAndItsStandby) {
  const auto before = UnixMs();
  const auto theirs = db_->ClockMs();
  ASSERT_TRUE(theirs.ok() && *theirs);
  // The server is on this machine.
  EXPECT_GE(**theirs, before - 1);
  EXPECT_LE(**theirs, UnixMs() + 1);
  EXPECT_EQ(*db_->StandbyOf(), Standby::kNone);
}

TEST_F(PgDbTest, StandbysThatAreMissingAreTold) {
  test::MissingStandbys missing(*db_);
  for (const char* names : {"a", "first 2 (a, b)", "ANY 1 (a)"}) {
    missing.Name(names);
    // The server reads its settings in its own time.
    EXPECT_TRUE(test::Becomes([&] { return *db_->StandbyOf() == Standby::kMissing; })) << names;
  }
}

TEST_F(PgDbTest, AServerThatIsNotThereIsToldAtOnce) {
  PgDbOptions options = Options();
  options.server = "host=/nowhere dbname=x";
  auto db = PgDb::Open(std::move(options));
  ASSERT_FALSE(db.ok());
  EXPECT_EQ(db.status().code(), Code::kUnavailable);
  EXPECT_NE(db.status().message().find("/nowhere"), std::string::npos) << db.status().message();
}

TEST_F(PgDbTest, AServerThatRefusesIsToldByTheCause) {
  ASSERT_TRUE(db_->Exec("DO $$ BEGIN CREATE ROLE stranger LOGIN; EXCEPTION WHEN duplicate_object "
                        "THEN NULL; END $$")
                  .ok());
  const std::string socket = server_.substr(0, server_.find(" user="));
  struct Case {
    std::string server;
    Kind kind;
    const char* words;
  };
  for (const Case& one : {
           Case{socket + " user=enamel dbname=nowhere", Kind::kNoDatabase, "\"nowhere\""},
           Case{socket + " user=nobody dbname=postgres", Kind::kSignIn, "\"nobody\""},
           Case{server_ + " options='-c default_transaction_read_only=on'", Kind::kReadOnly,
                "read-only"},
           Case{"host=/nowhere dbname=x", Kind::kNotThere, "/nowhere"},
           Case{"host=/nowhere," + socket.substr(5) + " user=enamel dbname=nowhere",
                Kind::kNoDatabase, "/nowhere"},
       }) {
    PgDbOptions options = Options();
    options.server = one.server;
    PgFailure failure;
    options.explain = [&](const PgFailure& told) {
      failure = told;
      return Status(CodeOf(told.kind), told.words);
    };
    EXPECT_EQ(PgDb::Open(options).status().code(), Code::kUnavailable) << one.server;
    EXPECT_EQ(failure.kind, one.kind) << one.server << ": " << failure.words;
    EXPECT_TRUE(failure.opening);
    EXPECT_NE(failure.words.find(one.words), std::string::npos) << failure.words;
    EXPECT_EQ(failure.words.find(failure.state.empty() ? "LOCATION" : failure.state),
              std::string::npos)
        << failure.words;
  }
  PgDbOptions options = Options();
  options.server = socket + " user=stranger dbname=postgres";
  auto stranger = PgDb::Open(options);
  ASSERT_TRUE(stranger.ok()) << stranger.status().message();
  EXPECT_FALSE((*stranger)->Exec("SELECT 1 FROM enamel_none.x").ok());
  EXPECT_FALSE((*stranger)->Migrate({{1, "first", "CREATE TABLE x (n bigint)"}}).ok());
  EXPECT_EQ((*stranger)->failure().kind, Kind::kNotAllowed);
}

TEST(PgTextTest, StateOfARefusalIsInItsWords) {
  for (const auto& [words, state, left] : std::vector<std::array<std::string, 3>>{
           {"connection to server at \"10.0.0.5\", port 5432 failed: FATAL:  28P01: password "
            "authentication failed for user \"enamel\"",
            "28P01",
            "connection to server at \"10.0.0.5\", port 5432 failed: FATAL:  password "
            "authentication failed for user \"enamel\""},
           {"FATAL:  57P03: the database system is starting up", "57P03",
            "FATAL:  the database system is starting up"},
           {"failed: session is read-only", "25006", "failed: session is read-only"},
           {"failed: Connection refused", "", "failed: Connection refused"},
           {"FATAL:  no: state", "", "FATAL:  no: state"},
           {":  28P0", "", ":  28P0"},
       }) {
    std::string text = words;
    EXPECT_EQ(TakeState(text), state);
    EXPECT_EQ(text, left);
  }
}

TEST_F(PgDbTest, ATransactionIsAllOrNothing) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint PRIMARY KEY)").ok());
  {
    Transaction dropped(*db_);
    ASSERT_TRUE(dropped.begun().ok());
    ASSERT_TRUE(db_->Exec("INSERT INTO t VALUES (1)").ok());
  }
  {
    Transaction failed(*db_);
    ASSERT_TRUE(db_->Exec("INSERT INTO t VALUES (2)").ok());
    EXPECT_FALSE(db_->Exec("INSERT INTO t VALUES (2)").ok());
    EXPECT_FALSE(failed.Commit().ok()) << "PostgreSQL itself calls this a success";
  }
  {
    Transaction kept(*db_);
    ASSERT_TRUE(db_->Exec("INSERT INTO t VALUES (3); SAVEPOINT one").ok());
    EXPECT_FALSE(db_->Exec("INSERT INTO t VALUES (3)").ok());
    ASSERT_TRUE(db_->Exec("ROLLBACK TO one; RELEASE one").ok());
    EXPECT_TRUE(kept.Commit().ok());
  }
  Query q(*db_, "SELECT sum(n) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 3);
}

// Each reads what the other changes: one after the other is the only way, so that one must go
// again.
TEST_F(PgDbTest, TransactionsThatMeetEndWithOneToRepeat) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (id bigint PRIMARY KEY, n bigint);"
                        "INSERT INTO t VALUES (1, 0), (2, 0)")
                  .ok());
  auto other = Open();
  Transaction a(*db_), b(*other);
  auto change = [](PgDb& db, int from, int to) {
    const std::string sql = "UPDATE t SET n = (SELECT n FROM t WHERE id = " + std::to_string(from) +
                            ") + 1 WHERE id = " + std::to_string(to);
    return db.Exec(sql.c_str());
  };
  Status first = change(*db_, 1, 2);
  Status second = change(*other, 2, 1);
  if (first.ok()) first = a.Commit();
  if (second.ok()) second = b.Commit();
  EXPECT_NE(first.ok(), second.ok());
  EXPECT_NE(db_->must_repeat(), other->must_repeat());
  EXPECT_EQ((first.ok() ? second : first).code(), Code::kUnavailable);
}

TEST_F(PgDbTest, ASnapshotIsOfOneMomentAndOnlyReads) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint)").ok());
  auto other = Open();
  const auto count = [](PgDb& db) {
    Query q(db, "SELECT count(*) FROM t");
    EXPECT_TRUE(q.Next()) << q.status().message();
    return q.Int(0);
  };
  {
    Transaction moment(*db_, Isolation::kSnapshot);
    EXPECT_EQ(count(*db_), 0);
    ASSERT_TRUE(other->Exec("INSERT INTO t VALUES (1)").ok());
    EXPECT_EQ(count(*db_), 0);
    EXPECT_TRUE(moment.Commit().ok());
  }
  EXPECT_EQ(count(*db_), 1);
  Transaction moment(*db_, Isolation::kSnapshot);
  EXPECT_FALSE(db_->Exec("INSERT INTO t VALUES (2)").ok());
}

TEST_F(PgDbTest, ATransactionBeginsOnANewConnectionWhereTheOldOneHasEnded) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint)").ok());
  for (int i = 0; i < 3; ++i) {
    Cut(*db_);
    Transaction next(*db_);
    ASSERT_TRUE(next.begun().ok()) << next.begun().message();
    ASSERT_TRUE(db_->Exec("INSERT INTO t VALUES (1)").ok());
    ASSERT_TRUE(next.Commit().ok());
  }
  Query q(*db_, "SELECT count(*) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 3);
}

// Each new connection gets its settings and a prepared statement. Where one of these fails the
// connection stays open, but must not count as usable.
TEST_F(PgDbTest, AConnectionThatWasNotSetUpToTheEndIsMadeAnew) {
  ASSERT_TRUE(db_->Migrate({{1, "table", "CREATE TABLE t (n bigint)"}}).ok());
  int fails_at = -1;
  PgDbOptions options = Options();
  options.fail_next = [&] { return fails_at >= 0 && fails_at-- == 0; };
  auto opened = PgDb::Open(std::move(options));
  ASSERT_TRUE(opened.ok()) << opened.status().message();
  PgDb& db = **opened;
  int failed = 0;
  for (int at = 0; at < 5; ++at) {
    Cut(db);
    // It finds out that the connection has ended, and makes another.
    EXPECT_FALSE(db.Exec("SELECT 1").ok());
    fails_at = at;
    failed += db.Exec("SELECT 1").ok() ? 0 : 1;
    fails_at = -1;
    Transaction next(db);
    ASSERT_TRUE(next.begun().ok())
        << "failed at statement " << at << ": " << next.begun().message();
    ASSERT_TRUE(db.Exec("INSERT INTO t VALUES (1)").ok());
    ASSERT_TRUE(next.Commit().ok());
  }
  EXPECT_EQ(failed, 3) << "the settings, the statement that is prepared, and what was asked";
  Query q(*db_, "SELECT count(*) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 5);
}

TEST_F(PgDbTest, AReaderWhoseConnectionHasEndedAsksAgain) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint); INSERT INTO t VALUES (5)").ok());
  auto reader = Open(/*read_only=*/true);
  const auto read = [&](int64_t n) {
    Query q(*reader, "SELECT n FROM t WHERE n = ?1");
    const bool found = q.BindInt(n).Next();
    EXPECT_TRUE(q.status().ok()) << q.status().message();
    return found;
  };
  EXPECT_TRUE(read(5));
  for (int i = 0; i < 3; ++i) {
    Cut(*reader);
    EXPECT_TRUE(read(5));
    EXPECT_FALSE(read(6));
  }
  Transaction moment(*reader, Isolation::kSnapshot);
  EXPECT_TRUE(read(5));
  Cut(*reader);
  Query q(*reader, "SELECT n FROM t WHERE n = ?1");
  EXPECT_FALSE(q.BindInt(5).Next()) << "its moment is over";
  EXPECT_EQ(q.status().code(), Code::kUnavailable);
}

TEST_F(PgDbTest, ALostConnectionEndsTheTransactionAndIsMadeAnewForTheNext) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint)").ok());
  {
    Query q(*db_, "SELECT count(*) FROM t");
    ASSERT_TRUE(q.Next());
  }
  {
    Transaction cut(*db_);
    ASSERT_TRUE(db_->Exec("INSERT INTO t VALUES (1)").ok());
    Cut(*db_);
    EXPECT_EQ(db_->Exec("INSERT INTO t VALUES (2)").code(), Code::kUnavailable);
    EXPECT_EQ(db_->failure().kind, Kind::kNotThere);
    EXPECT_EQ(db_->Exec("INSERT INTO t VALUES (3)").code(), Code::kUnavailable)
        << "not half of it in another connection";
    EXPECT_FALSE(cut.Commit().ok());
  }
  {
    Transaction next(*db_);
    ASSERT_TRUE(next.begun().ok());
    Query q(*db_, "INSERT INTO t VALUES (?1)");
    ASSERT_TRUE(q.BindInt(4).Run().ok()) << q.status().message();
    ASSERT_TRUE(next.Commit().ok());
  }
  Query q(*db_, "SELECT count(*) FROM t");
  ASSERT_TRUE(q.Next()) << "prepared anew: " << q.status().message();
  EXPECT_EQ(q.Int(0), 1);
}

// The connection breaks at each message of a transaction in turn: before it, right after it and at
// its answer. A caller that repeats what must be repeated has it kept once, and a commit reported
// as kept is kept.
TEST_F(PgDbTest, ATransactionThatLosesItsConnectionAnywhereIsKeptOnceOrToBeRepeated) {
  ASSERT_TRUE(db_->Migrate({{1, "0001_a.sql", "CREATE TABLE t (n bigint)"}}).ok());
  test::PostgresProxy proxy(server_);
  PgDbOptions options = Options();
  options.server = proxy.server();
  auto db = PgDb::Open(std::move(options));
  ASSERT_TRUE(db.ok()) << db.status().message();
  // With kRowLocks a COMMIT that comes late finds nothing that has changed since, and is kept.
  // Every third sends its statements before the first answer.
  auto once = [&](int64_t n) -> Status {
    Transaction transaction(**db, n % 2 == 0 ? Isolation::kSerial : Isolation::kRowLocks);
    ENAMEL_RETURN_IF_ERROR(transaction.begun());
    if (n % 3 == 0) {
      Change insert = Insert(n), none = Insert(n);
      none.sql += " WHERE false";
      bool ran = false;
      Status kept = Commit(**db, {&none, &insert}, ran);
      EXPECT_LE(insert.rows, kept.ok() ? 1 : 0);
      return kept;
    }
    Query q(**db, "INSERT INTO t VALUES (?1)");
    ENAMEL_RETURN_IF_ERROR(q.BindInt(n).Run());
    return transaction.Commit();
  };
  ASSERT_TRUE(once(-1).ok());
  constexpr int kWays = 6;
  int64_t done = 0;
  for (const auto cut : {test::PostgresProxy::Cut::kBefore, test::PostgresProxy::Cut::kAfter,
                         test::PostgresProxy::Cut::kAnswer, test::PostgresProxy::Cut::kLate}) {
    bool met = true;
    // Each place six times: for either isolation, and sent together or not.
    for (int place = 0; met || place % kWays != 0; ++place) {
      ASSERT_LT(place, 600);
      if (place % kWays == 0) met = false;
      proxy.CutAt(place / kWays, cut);
      Status kept = once(done);
      for (int tries = 1; !kept.ok() && tries < 3; ++tries) {
        // A connection that breaks at BEGIN has begun nothing.
        EXPECT_EQ(kept.code(), Code::kUnavailable) << kept.message();
        kept = once(done);
      }
      EXPECT_TRUE(kept.ok()) << kept.message();
      ++done;
      met = proxy.Disarm() || met;
    }
  }
  EXPECT_GT(done, 150);
  Query q(*db_, "SELECT count(*), count(DISTINCT n) FROM t WHERE n >= 0");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), done) << "doubled or lost";
  EXPECT_EQ(q.Int(1), done);
}

TEST_F(PgDbTest, StatementsThatAreSentTogetherTellWhatEachHasChanged) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint UNIQUE CHECK (n < 100))").ok());
  std::vector<Change> changes;
  for (int64_t n = 0; n < 50; ++n) changes.push_back(Insert(n));
  // They see each other, in their order. Two texts, each prepared once.
  changes.push_back({"UPDATE t SET n = n + 50 WHERE n < ?1", [](Query& q) { q.BindInt(20); }});
  changes.push_back({"UPDATE t SET n = n + 50 WHERE n < ?1", [](Query& q) { q.BindInt(30); }});
  std::vector<Change*> all;
  for (Change& change : changes) all.push_back(&change);
  bool ran = false;
  ASSERT_TRUE(db_->Begin(Isolation::kRowLocks).ok());
  ASSERT_TRUE(Commit(*db_, all, ran).ok());
  EXPECT_TRUE(ran);
  for (size_t i = 0; i < 50; ++i) EXPECT_EQ(changes[i].rows, 1);
  EXPECT_EQ(changes[50].rows, 20);
  EXPECT_EQ(changes[51].rows, 10);
  EXPECT_EQ(db_->kept_statements(), 2u);
}

// Also where they are far more than what a connection holds under way.
TEST_F(PgDbTest, TheServerIsAskedOnceForStatementsThatAreSentTogether) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint, b bytea)").ok());
  test::PostgresProxy proxy(server_);
  PgDbOptions options = Options();
  options.server = proxy.server();
  auto db = PgDb::Open(std::move(options));
  ASSERT_TRUE(db.ok()) << db.status().message();
  const Bytes many(65536, 7);
  std::vector<Change> changes;
  for (int64_t n = 0; n < 100; ++n) {
    changes.push_back(
        {"INSERT INTO t VALUES (?1, ?2)", [n, &many](Query& q) { q.BindInt(n).BindBlob(many); }});
  }
  std::vector<Change*> all;
  for (Change& change : changes) all.push_back(&change);
  // The first time the statement is prepared.
  for (const bool prepared : {false, true}) {
    bool ran = false;
    ASSERT_TRUE((*db)->Begin(Isolation::kRowLocks).ok());
    const int before = proxy.asked();
    ASSERT_TRUE(Commit(**db, all, ran).ok());
    EXPECT_EQ(proxy.asked() - before, prepared ? 1 : 2);
  }
  Query q(*db_, "SELECT sum(length(b)) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 2 * 100 * 65536);
}

TEST_F(PgDbTest, OfStatementsThatAreSentTogetherOneThatFailsTakesBackAll) {
  ASSERT_TRUE(db_->Migrate({{1, "a", "CREATE TABLE t (n bigint UNIQUE CHECK (n < 100))"}}).ok());
  for (const int64_t bad : {1, 500}) {  // there already; refused
    for (size_t place = 0; place < 3; ++place) {
      std::vector<Change> changes{Insert(1), Insert(2), Insert(3)};
      changes.insert(changes.begin() + static_cast<std::ptrdiff_t>(place) + (bad == 1 ? 1 : 0),
                     Insert(bad));
      std::vector<Change*> all;
      for (Change& change : changes) all.push_back(&change);
      bool ran = true;
      ASSERT_TRUE(db_->Begin(Isolation::kRowLocks).ok());
      EXPECT_EQ(Commit(*db_, all, ran).code(), Code::kConflict);
      EXPECT_FALSE(ran);
      EXPECT_FALSE(db_->must_repeat());
      EXPECT_EQ(db_->failure().kind, bad == 1 ? Kind::kTaken : Kind::kConstraint);
      // The connection is as before.
      Query q(*db_, "SELECT count(*) FROM t");
      ASSERT_TRUE(q.Next()) << q.status().message();
      EXPECT_EQ(q.Int(0), 0);
    }
  }
  // And so after one that cannot be bound.
  Change text{"INSERT INTO t SELECT ?1::bigint",
              [](Query& q) { q.BindText(std::string_view("\0", 1)); }};
  bool ran = true;
  ASSERT_TRUE(db_->Begin(Isolation::kRowLocks).ok());
  EXPECT_EQ(Commit(*db_, {&text}, ran).code(), Code::kInvalidInput);
  EXPECT_FALSE(ran);
  ASSERT_TRUE(db_->Begin(Isolation::kRowLocks).ok());
  Change good = Insert(7);
  EXPECT_TRUE(Commit(*db_, {&good}, ran).ok());
  EXPECT_EQ(good.rows, 1);
  // A change that returns rows does not fail.
  Change giving{"INSERT INTO t SELECT ?1 RETURNING n", [](Query& q) { q.BindInt(8); }};
  ASSERT_TRUE(db_->Begin(Isolation::kRowLocks).ok());
  EXPECT_TRUE(Commit(*db_, {&giving}, ran).ok());
  EXPECT_EQ(giving.rows, 1);
}

// Ends like a deadlock: with the request to repeat, not with an error of one statement.
TEST_F(PgDbTest, StatementsThatAreSentTogetherAndMeetOthersAreToBeRepeated) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint); INSERT INTO t VALUES (1)").ok());
  auto other = Open();
  ASSERT_TRUE(db_->Begin(Isolation::kSerial).ok());
  {
    Query q(*db_, "SELECT n FROM t");
    ASSERT_TRUE(q.Next());
  }
  ASSERT_TRUE(other->Exec("UPDATE t SET n = 2").ok());
  Change change{"UPDATE t SET n = ?1", [](Query& q) { q.BindInt(3); }};
  bool ran = true;
  EXPECT_EQ(Commit(*db_, {&change}, ran).code(), Code::kUnavailable);
  EXPECT_TRUE(db_->must_repeat());
  ASSERT_TRUE(db_->Begin(Isolation::kSerial).ok());
  EXPECT_TRUE(Commit(*db_, {&change}, ran).ok());
  EXPECT_EQ(change.rows, 1);
}

// Nobody can know whether it was kept. Repeating it could do it twice, so the error does not ask
// for that.
TEST_F(PgDbTest, ACommitThatNobodyCanTellAboutIsSaidToBeInDoubtAndNotToBeRepeated) {
  ASSERT_TRUE(db_->Migrate({{1, "0001_a.sql", "CREATE TABLE t (n bigint)"}}).ok());
  test::PostgresProxy proxy(server_);
  PgDbOptions options = Options();
  options.server = proxy.server();
  options.in_doubt = std::chrono::milliseconds(1);
  auto db = PgDb::Open(std::move(options));
  ASSERT_TRUE(db.ok()) << db.status().message();
  Transaction transaction(**db);
  ASSERT_TRUE((*db)->Exec("INSERT INTO t VALUES (1)").ok());
  proxy.Refuse();
  proxy.CutAt(0, test::PostgresProxy::Cut::kAnswer);
  const Status told = transaction.Commit();
  EXPECT_EQ(told.code(), Code::kUnavailable);
  EXPECT_EQ(told.field(), "in_doubt");
  EXPECT_FALSE((*db)->must_repeat());
  Query q(*db_, "SELECT count(*) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 1) << "it was kept, and the answer lost";
}

// The old connection is at its COMMIT still, waiting for a standby, when the new one asks.
TEST_F(PgDbTest, ACommitThatIsStillUnderWayIsWaitedFor) {
  ASSERT_TRUE(
      db_->Migrate({{1, "0001_a.sql",
                     "CREATE TABLE t (n bigint);"
                     "CREATE FUNCTION hold() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN "
                     "PERFORM pg_advisory_xact_lock_shared(77); RETURN NULL; END $$;"
                     "CREATE CONSTRAINT TRIGGER slow AFTER INSERT ON t DEFERRABLE INITIALLY "
                     "DEFERRED FOR EACH ROW EXECUTE FUNCTION hold()"}})
          .ok());
  auto other = Open();
  ASSERT_TRUE(other->Exec("SELECT pg_advisory_lock(77)").ok());
  test::PostgresProxy proxy(server_);
  PgDbOptions options = Options();
  options.server = proxy.server();
  auto db = PgDb::Open(std::move(options));
  ASSERT_TRUE(db.ok()) << db.status().message();
  std::atomic<bool> told{false};
  Status kept;
  std::jthread writer([&] {
    Transaction transaction(**db);
    ASSERT_TRUE((*db)->Exec("INSERT INTO t VALUES (1)").ok());
    proxy.CutAt(0, test::PostgresProxy::Cut::kAfter);
    kept = transaction.Commit();
    told = true;
  });
  // Both the COMMIT and who asks about it are waiting.
  for (int64_t waiting = 0; waiting < 2;) {
    Query q(*other, "SELECT count(*) FROM pg_stat_activity WHERE wait_event_type = 'Lock'");
    ASSERT_TRUE(q.Next());
    waiting = q.Int(0);
    EXPECT_FALSE(told);
    if (told) break;
  }
  ASSERT_TRUE(other->Exec("SELECT pg_advisory_unlock(77)").ok());
  writer.join();
  EXPECT_TRUE(kept.ok()) << kept.message();
  Query q(*db_, "SELECT count(*) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 1);
}

// A restarted primary has commits that its standby lacks: the check whether a COMMIT was kept waits
// for the standby.
TEST_F(PgDbTest, ACommitWhoseAnswerWasLostIsToldOnceAStandbyHasIt) {
  ASSERT_TRUE(db_->Migrate({{1, "0001_a.sql", "CREATE TABLE t (n bigint)"}}).ok());
  auto other = Open();
  const auto waits_for_standby = [&]() -> int64_t {
    Query q(*other, "SELECT max(pid) FROM pg_stat_activity WHERE wait_event = 'SyncRep'");
    return q.Next() ? q.Int(0) : 0;
  };
  std::atomic<bool> told{false};
  Status kept;
  // After `missing`: it waits for what that ends.
  std::jthread writer;
  {
    test::MissingStandbys missing(*other);
    missing.Name("nobody");
    ASSERT_TRUE(test::Becomes([&] { return *other->StandbyOf() == Standby::kMissing; }));
    writer = std::jthread([&] {
      Transaction transaction(*db_);
      ASSERT_TRUE(db_->Exec("INSERT INTO t VALUES (1)").ok());
      kept = transaction.Commit();
      told = true;
    });
    int64_t first = 0;
    ASSERT_TRUE(test::Becomes([&] { return (first = waits_for_standby()) != 0; }));
    {
      Query q(*other, "SELECT pg_terminate_backend(?1::int)");
      ASSERT_TRUE(q.BindInt(first).Next()) << q.status().message();
    }
    EXPECT_TRUE(test::Becomes([&] {
      const int64_t second = waits_for_standby();
      return told || (second != 0 && second != first);
    })) << "who asks does not wait";
    EXPECT_FALSE(told);
  }
  writer.join();
  EXPECT_TRUE(kept.ok()) << kept.message();
  Query q(*db_, "SELECT count(*) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 1);
}

TEST_F(PgDbTest, AServerOnAnotherMachineNeedsTlsWithItsCertificateChecked) {
  for (const char* server :
       {"host=db.example dbname=x", "host=127.0.0.1,192.0.2.7 dbname=x sslmode=require",
        "postgresql://enamel@db.example/x?sslmode=prefer", "hostaddr=192.0.2.7",
        "service=school"}) {
    PgDbOptions options = Options();
    options.server = server;
    const Status refused = PgDb::Open(std::move(options)).status();
    EXPECT_EQ(refused.code(), Code::kInvalidInput) << server << ": " << refused.message();
    EXPECT_NE(refused.message().find("verify-full"), std::string::npos) << refused.message();
  }
  PgDbOptions options = Options();
  options.server = "host=localhost port=1 dbname=x";
  EXPECT_EQ(PgDb::Open(std::move(options)).status().code(), Code::kUnavailable) << "nobody listens";
}

TEST_F(PgDbTest, AServerThatHangsIsLeftAndAskedAgainWhenItRuns) {
  test::PostgresProxy proxy(server_);
  PgDbOptions options = Options();
  options.server = proxy.server();
  options.patience = std::chrono::milliseconds(20);
  auto opened = PgDb::Open(std::move(options));
  ASSERT_TRUE(opened.ok());
  PgDb& db = **opened;
  ASSERT_TRUE(db.Exec("CREATE TABLE t (n bigint)").ok());
  // A slow statement of a server that answers is waited for.
  EXPECT_TRUE(Query(db, "SELECT pg_sleep(0.1)").Next());
  proxy.Hang();
  EXPECT_EQ(db.Exec("INSERT INTO t VALUES (1)").code(), Code::kUnavailable);
  EXPECT_NE(db.failure().words.find("no answer"), std::string::npos) << db.failure().words;
  proxy.Hang(false);
  ASSERT_TRUE(db.Exec("INSERT INTO t VALUES (2)").ok()) << db.failure().words;
}

// One after another, they would take two seconds each.
TEST_F(PgDbTest, HostsThatHangDoNotDelayTheOneThatAnswers) {
  constexpr int kHanging = 9;
  std::vector<std::unique_ptr<test::PostgresProxy>> hanging;
  std::string hosts;
  for (int i = 0; i < kHanging; ++i) {
    hanging.push_back(std::make_unique<test::PostgresProxy>(server_));
    hanging.back()->Hang();
    const std::string& words = hanging.back()->server();
    hosts += words.substr(5, words.find(' ') - 5) + ",";
  }
  PgDbOptions options = Options();
  options.server = "host=" + hosts + server_.substr(5);
  const auto begun = std::chrono::steady_clock::now();
  ASSERT_TRUE(PgDb::Open(std::move(options)).ok());
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(kHanging));
}

TEST_F(PgDbTest, AServerOfAnEarlierTimelineIsLeftAndItsTransactionRepeated) {
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint)").ok());
  PgDbOptions options = Options();
  options.newest = std::make_shared<std::atomic<int64_t>>(0);
  auto opened = PgDb::Open(options);
  ASSERT_TRUE(opened.ok());
  PgDb& db = **opened;
  EXPECT_EQ(*options.newest, 1) << "a new server's";
  for (const bool together : {false, true}) {
    *options.newest = 1;
    ASSERT_TRUE(db.Begin(Isolation::kRowLocks).ok());
    Change change = Insert(1);
    ASSERT_TRUE(together || change.Run(db).ok());
    // Another connection has met the server that was promoted meanwhile.
    *options.newest = 2;
    bool ran = true;
    EXPECT_FALSE((together ? Commit(db, {&change}, ran) : db.Commit()).ok());
    EXPECT_TRUE(db.must_repeat());
    db.Rollback();
    const Status again = db.Begin(Isolation::kRowLocks);
    EXPECT_EQ(again.code(), Code::kUnavailable);
    EXPECT_EQ(again.field(), kReplacedField);
  }
  EXPECT_EQ(PgDb::Open(options).status().field(), kReplacedField);
  *options.newest = 1;
  ASSERT_TRUE(db.Begin(Isolation::kRowLocks).ok());
  Query q(db, "SELECT count(*) FROM t");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 0);
}

TEST_F(PgDbTest, ACommitThatHangsIsKeptOnceOrToBeRepeated) {
  ASSERT_TRUE(db_->Migrate({}).ok());
  ASSERT_TRUE(db_->Exec("CREATE TABLE t (n bigint)").ok());
  for (const bool together : {false, true}) {
    test::PostgresProxy proxy(server_);
    PgDbOptions options = Options();
    options.server = proxy.server();
    options.patience = std::chrono::milliseconds(20);
    auto opened = PgDb::Open(std::move(options));
    ASSERT_TRUE(opened.ok());
    PgDb& db = **opened;
    // Refusing beside hanging: otherwise each check would take its two seconds.
    std::jthread back([&] {
      ASSERT_TRUE(test::Becomes([&] { return proxy.refused() > 0; }));
      proxy.Hang(false);
      proxy.Refuse(false);
    });
    Status kept;
    int64_t before = 0;
    {
      Query q(*db_, "SELECT count(*) FROM t");
      ASSERT_TRUE(q.Next());
      before = q.Int(0);
    }
    bool begun = true;
    do {
      kept = db.Begin(Isolation::kRowLocks);
      begun = kept.ok();
      if (!begun) continue;
      Change change = Insert(1);
      bool ran = true;
      if (!together && !change.Run(db).ok()) continue;
      if (proxy.refused() == 0) {
        proxy.Refuse();
        proxy.Hang();
      }
      kept = together ? Commit(db, {&change}, ran) : db.Commit();
    } while (!kept.ok() && (!begun || db.must_repeat()));
    EXPECT_TRUE(kept.ok()) << kept.message();
    Query q(*db_, "SELECT count(*) FROM t");
    ASSERT_TRUE(q.Next());
    EXPECT_EQ(q.Int(0), before + 1);
  }
}

TEST_F(PgDbTest, MigrationsRunOnceAlsoWhenManyStartAtOnce) {
  const std::vector<Migration> steps = {{3, "0003_a.sql", "CREATE TABLE a (n bigint)"},
                                        {4, "0004_b.sql", "INSERT INTO a VALUES (1)"}};
  EXPECT_EQ(*db_->SchemaVersion(), 0);
  std::atomic<int> done{0};
  {
    std::vector<std::jthread> starters;
    for (int i = 0; i < 8; ++i) {
      starters.emplace_back([&] {
        auto db = Open();
        const Status status = db->Migrate(steps);
        EXPECT_TRUE(status.ok()) << status.message();
        done += status.ok() ? 1 : 0;
      });
    }
  }
  EXPECT_EQ(done, 8);
  EXPECT_EQ(*db_->SchemaVersion(), 4);
  Query q(*db_, "SELECT count(*) FROM a");
  ASSERT_TRUE(q.Next());
  EXPECT_EQ(q.Int(0), 1);
  PgDbOptions options = Options();
  options.application = "another";
  auto other = PgDb::Open(std::move(options));
  ASSERT_TRUE(other.ok());
  EXPECT_EQ((*other)->SchemaVersion().status().code(), Code::kVersion);
}

TEST_F(PgDbTest, AMigrationThatFailsLeavesTheDatabaseAsItWas) {
  EXPECT_FALSE(db_->Migrate({{1, "0001_a.sql", "CREATE TABLE a (n bigint)"},
                             {2, "0002_b.sql", "CREATE TABLE a (n bigint)"}})
                   .ok());
  EXPECT_EQ(*db_->SchemaVersion(), 0);
  EXPECT_FALSE(db_->Exec("SELECT * FROM a").ok());
}

}  // namespace
}  // namespace enamel::sql
