#include "server/storage/move/move.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <utility>

#include "common/base/file.h"
#include "server/storage/backup/backup.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/query.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/keys/master_key.h"
#include "server/storage/school/school_tables.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/server/storage/recorded_attempt.h"
#include "tests/support/s3_stand_in.h"

// A school on its way to another place, and back.
namespace enamel::server {
namespace {

using namespace testing;
namespace fs = std::filesystem;

class MoveTest : public ::testing::Test {
 protected:
  MoveTest() {
    scored_ = school_.Record(3);
    open_ = school_.Record(2);
    school_.Score(scored_);
    erased_ = AddPerson(*school_.store, "gone", Role::kStudent);
    (void)school_.RecordOf(erased_, 1);
    EXPECT_TRUE(school_.store->erasures.ErasePerson(erased_, false, kSystem).ok());
    trace_ = school_.TraceOf(scored_);
    unfinished_ = school_.TraceOf(open_);
    school_.store.reset();
  }

  fs::path Path(const std::string& name) const { return folder_.path() / name; }
  // As the command does: mark, places, identity, then all else.
  Result<MoveReport> MoveTo(const fs::path& from, const fs::path& to,
                            const std::optional<DatabaseFile>& file = {}, Disk* disk = nullptr,
                            bool accept_damage = false) {
    Disk& used = disk != nullptr ? *disk : SystemDisk();
    ENAMEL_RETURN_IF_ERROR(BeginMove(from, to, used));
    ENAMEL_RETURN_IF_ERROR(
        WriteFileDurably(to / "ticket.key", *ReadFile(from / "ticket.key", 1024), 0600));
    if (file) ENAMEL_RETURN_IF_ERROR(WriteDatabaseFile(to, *file, SystemDisk()));
    return MoveSchool({from, to, accept_damage, {}, disk});
  }
  void ExpectWhole(const fs::path& folder) {
    auto report = Verify({folder, {}, {}});
    ASSERT_TRUE(report.ok()) << report.status().message();
    for (const Finding& finding : report->findings) {
      ADD_FAILURE() << finding.kind << " " << finding.object << ": expected " << finding.expected
                    << ", found " << finding.found;
    }
  }
  static std::vector<TableDigest> RowsIn(const fs::path& folder) {
    auto db = OpenDatabase(folder / "enamel.db", DbMode::kReadOnly);
    return *DigestRows(**db, *TablesOfSchool(**db));
  }
  // Without the rows that each move adds to the audit trail.
  static std::vector<TableDigest> ButAudit(std::vector<TableDigest> tables) {
    std::erase_if(tables,
                  [](const TableDigest& table) { return table.table.starts_with("audit"); });
    return tables;
  }
  void ExpectSchoolIn(const fs::path& folder) {
    StoreOptions options;
    options.folder = folder;
    auto store = OpenStore(options);
    ASSERT_TRUE(store.ok()) << store.status().message();
    school_.store = std::move(*store);
    EXPECT_EQ(school_.TraceOf(scored_), trace_);
    EXPECT_EQ(school_.TraceOf(open_), unfinished_);
    EXPECT_EQ(
        AsText(*school_.store->blobs.GetBlob(school_.store->results.ResultOf(scored_)->series)),
        "series");
    EXPECT_EQ(school_.store->people.PersonById(erased_).status().code(), Code::kNotFound);
    school_.store.reset();
  }

  TempFolder folder_;
  RecordedSchool school_{Path("data")};
  Uuid scored_, open_, erased_;
  Bytes trace_, unfinished_;
};

TEST_F(MoveTest, EveryTableIsOneOfTheSchoolOrKnownToBeOneOfTheInstallation) {
  auto db = OpenDatabase(Path("data") / "enamel.db", DbMode::kReadOnly);
  auto tables = TablesOfSchool(**db);
  ASSERT_TRUE(tables.ok()) << tables.status().message();
  std::set<std::string> names;
  for (const auto& table : *tables) {
    EXPECT_TRUE(names.insert(table.name).second);
    // Referenced tables come first.
    sql::Query q(**db, "SELECT \"table\" FROM pragma_foreign_key_list(?1)");
    for (q.BindText(table.name); q.Next();) EXPECT_TRUE(names.contains(q.Text(0))) << table.name;
  }
  EXPECT_GT(names.size(), 30u);
  const std::set<std::string> installation{"blobs",           "person_keys",   "server_identity",
                                           "leases",          "rewrite_due",   "sign_in_counters",
                                           "running_servers", "station_links", "write_probe",
                                           "schools",         "move_marks"};
  sql::Query q(**db,
               "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite%'");
  while (q.Next()) {
    EXPECT_NE(names.contains(q.Text(0)), installation.contains(q.Text(0))) << q.Text(0);
  }
}

TEST_F(MoveTest, ADigestNoticesEveryChange) {
  const auto before = RowsIn(Path("data"));
  fs::copy_file(Path("data") / "enamel.db", Path("copy.db"));
  auto db = OpenDatabase(Path("copy.db"), DbMode::kExisting);
  const auto tables = *TablesOfSchool(**db);
  EXPECT_EQ(Differences(before, *DigestRows(**db, tables)), "");
  for (const char* change :
       {"UPDATE people SET display_name = display_name || ' ' WHERE login = 'student'",
        "UPDATE attempts SET score = score + 1e-12 WHERE score IS NOT NULL",
        "DELETE FROM jobs WHERE id = (SELECT max(id) FROM jobs)",
        "UPDATE attempts SET ticks = ticks + 1"}) {
    ASSERT_TRUE((*db)->Exec((std::string("SAVEPOINT s; ") + change).c_str()).ok()) << change;
    EXPECT_NE(Differences(before, *DigestRows(**db, tables)), "") << change;
    ASSERT_TRUE((*db)->Exec("ROLLBACK TO s; RELEASE s").ok());
  }
}

TEST_F(MoveTest, AllOfASchoolComesAlongAndTheOldPlaceIsClosed) {
  const auto rows = RowsIn(Path("data"));
  auto moved = MoveTo(Path("data"), Path("new"));
  ASSERT_TRUE(moved.ok()) << moved.status().message();
  EXPECT_EQ(Differences(ButAudit(rows), ButAudit(moved->tables)), "");
  EXPECT_EQ(moved->keys, 1u);
  EXPECT_EQ(moved->erased, 1u);
  EXPECT_GT(moved->blobs, 3u);
  EXPECT_EQ(Differences(moved->tables, RowsIn(Path("new"))), "");
  ExpectWhole(Path("new"));
  ExpectSchoolIn(Path("new"));
  StoreOptions old;
  old.folder = Path("data");
  const Status closed = OpenStore(old).status();
  EXPECT_EQ(closed.code(), Code::kConflict);
  EXPECT_NE(closed.message().find(Path("new").string()), std::string::npos) << closed.message();
  fs::remove(Path("data") / kMovedMark);
  EXPECT_TRUE(OpenStore(old).ok()) << "nothing was deleted";
}

TEST_F(MoveTest, AMoveThatIsBrokenOffAnywhereGoesOn) {
  const auto rows = RowsIn(Path("data"));
  int failures = 0;
  bool fired = true;
  for (int n = 0; fired; ++n) {
    const fs::path to = Path("new" + std::to_string(n));
    FailingDisk disk;
    disk.until_failure = n;
    auto moved = MoveTo(Path("data"), to, {}, &disk);
    fired = disk.fired;
    disk.until_failure = -1;
    if (!moved.ok()) {
      ++failures;
      StoreOptions half;
      half.folder = to;
      EXPECT_FALSE(fs::exists(to / "enamel.db") && OpenStore(half).ok())
          << "a server would start on half of it, after " << n << " changes of the disk";
      moved = MoveTo(Path("data"), to, {}, &disk);
    }
    ASSERT_TRUE(moved.ok()) << n << ": " << moved.status().message();
    EXPECT_EQ(Differences(ButAudit(rows), ButAudit(moved->tables)), "") << n;
    ExpectSchoolIn(to);
    // For the next.
    fs::remove(Path("data") / kMovedMark);
  }
  EXPECT_GT(failures, 10);
}

TEST_F(MoveTest, RowsThatASealLeftBehindGoFirstAndAreNoChange) {
  {
    // As after a server was killed following a seal: the blob exists, and so do the rows.
    auto db = OpenDatabase(Path("data") / "enamel.db", DbMode::kExisting);
    sql::Query q(**db,
                 "WITH RECURSIVE n(i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i < 4999) "
                 "INSERT INTO trace_chunks SELECT c.tenant, ?1, 100 + n.i, c.hash, c.bytes, "
                 "c.received_ms FROM n, (SELECT * FROM trace_chunks LIMIT 1) c");
    ASSERT_TRUE(q.BindBlob(scored_.view()).Run().ok()) << q.status().message();
  }
  auto moved = MoveTo(Path("data"), Path("new"));
  ASSERT_TRUE(moved.ok()) << moved.status().message();
  const auto chunks = std::ranges::find(moved->tables, "trace_chunks", &TableDigest::table);
  EXPECT_EQ(chunks->rows, 2u) << "those of the attempt that is not sealed";
}

TEST_F(MoveTest, WhatIsInTheWayIsNamed) {
  fs::create_directories(Path("taken"));
  ASSERT_TRUE(WriteFileDurably(Path("taken") / "mine", AsBytes("x")).ok());
  EXPECT_EQ(MoveTo(Path("data"), Path("taken")).status().code(), Code::kConflict);
  ASSERT_TRUE(BeginMove(Path("elsewhere"), Path("new"), SystemDisk()).ok());
  const Status other = MoveTo(Path("data"), Path("new")).status();
  EXPECT_EQ(other.code(), Code::kConflict);
  EXPECT_NE(other.message().find("elsewhere"), std::string::npos) << other.message();
  StoreOptions running;
  running.folder = Path("data");
  running.hold_lock = true;
  auto server = OpenStore(running);
  ASSERT_TRUE(server.ok());
  EXPECT_EQ(MoveTo(Path("data"), Path("beside")).status().code(), Code::kUnavailable);
}

TEST_F(MoveTest, ASchoolThatWasMovedIsNotMovedFromItsOldPlaceOnceMore) {
  ASSERT_TRUE(MoveTo(Path("data"), Path("new")).ok());
  for (const char* to : {"new", "other"}) {
    const Status refused = MoveTo(Path("data"), Path(to)).status();
    EXPECT_EQ(refused.code(), Code::kConflict) << to;
    EXPECT_NE(refused.message().find(Path("new").string()), std::string::npos) << refused.message();
  }
  EXPECT_TRUE(fs::exists(Path("data") / kMovedMark)) << "it stays closed";
  EXPECT_FALSE(fs::exists(Path("other")));
  EXPECT_EQ(MoveTo(Path("new"), Path("new") / "inside").status().code(), Code::kInvalidInput);
}

TEST_F(MoveTest, ASecondMoveBesideTheFirstLeavesItsMark) {
  ASSERT_TRUE(BeginMove(Path("data"), Path("new"), SystemDisk()).ok());
  ASSERT_TRUE(WriteFileDurably(Path("new") / "ticket.key",
                               *ReadFile(Path("data") / "ticket.key", 1024), 0600)
                  .ok());
  bool tried = false;
  MoveOptions options{Path("data"), Path("new")};
  options.progress = [&](const std::string& what, uint64_t, uint64_t) {
    if (what != "keys" || std::exchange(tried, true)) return;
    EXPECT_EQ(MoveSchool({Path("data"), Path("new")}).status().code(), Code::kUnavailable);
    EXPECT_FALSE(MoveTo(Path("data"), Path("third")).ok());
    EXPECT_TRUE(fs::exists(Path("data") / kMovedMark));
  };
  ASSERT_TRUE(MoveSchool(options).ok());
  EXPECT_TRUE(fs::exists(Path("data") / kMovedMark));
}

TEST_F(MoveTest, WhatACommandChangesMeanwhileIsNotLost) {
  StoreOptions beside;
  beside.folder = Path("data");
  auto command = OpenStore(beside);
  ASSERT_TRUE(command.ok());
  ASSERT_TRUE(BeginMove(Path("data"), Path("new"), SystemDisk()).ok());
  ASSERT_TRUE(WriteFileDurably(Path("new") / "ticket.key",
                               *ReadFile(Path("data") / "ticket.key", 1024), 0600)
                  .ok());
  bool changed = false;
  MoveOptions options{Path("data"), Path("new")};
  options.progress = [&](const std::string& what, uint64_t, uint64_t) {
    if (what != "keys" || std::exchange(changed, true)) return;
    EXPECT_FALSE(OpenStore(beside).ok()) << "one that begins now is refused";
    (void)AddPerson(**command, "late", Role::kStudent);
  };
  const Status refused = MoveSchool(options).status();
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("people"), std::string::npos) << refused.message();
  EXPECT_TRUE(OpenStore(beside).ok()) << "the school goes on where it was";
  options.progress = {};
  ASSERT_TRUE(MoveSchool(options).ok());
  StoreOptions moved;
  moved.folder = Path("new");
  EXPECT_TRUE((*OpenStore(moved))->people.PersonByLogin("late").ok());
}

TEST_F(MoveTest, ABlobThatIsLostIsNamedAndEverythingElseComesAlong) {
  StoreOptions options;
  options.folder = Path("data");
  const Sha256 lost = (*OpenStore(options))->results.ResultOf(scored_)->series;
  const fs::path file = Path("data") / "blobs" / lost.Hex().substr(0, 2) / lost.Hex();
  fs::rename(file, Path("kept"));
  const Status refused = MoveTo(Path("data"), Path("new")).status();
  EXPECT_EQ(refused.code(), Code::kStorage);
  EXPECT_NE(refused.message().find(lost.Hex()), std::string::npos) << refused.message();
  fs::rename(Path("kept"), file);
  auto moved = MoveTo(Path("data"), Path("new"));
  ASSERT_TRUE(moved.ok()) << moved.status().message();
  EXPECT_EQ(moved->there_before, moved->blobs - 1) << "it goes on where it stopped";
  fs::remove(Path("data") / kMovedMark);
  fs::remove(file);
  auto accepted = MoveTo(Path("data"), Path("newer"), {}, nullptr, /*accept_damage=*/true);
  ASSERT_TRUE(accepted.ok()) << accepted.status().message();
  EXPECT_EQ(accepted->missing, std::vector{lost});
}

// To PostgreSQL and S3 stores, a backup from there, and back.
class PgMoveTest : public MoveTest {
 protected:
  void SetUp() override {
    const char* server = std::getenv("ENAMEL_POSTGRES");
    if (server == nullptr) GTEST_SKIP() << "ENAMEL_POSTGRES names no server";
    file_.server = server;
    file_.schema = "s" + Uuid::New().Text();
    std::ofstream(Path("s3.key")) << R"({"version": 1, "access_key": ")"
                                  << blobs_.credentials().access_key << R"(", "secret_key": ")"
                                  << blobs_.credentials().secret_key << "\"}";
    fs::permissions(Path("s3.key"), fs::perms::owner_read | fs::perms::owner_write);
    file_.blobs = Place(blobs_, "blobs/");
    file_.keys = KeysInS3{Place(keys_, "keys/"), Path("master.key").string()};
    ASSERT_TRUE(EnsureMasterKey(Path("master.key"), SystemDisk()).ok());
  }
  void TearDown() override {
    if (file_.server.empty()) return;
    auto db = OpenPgDatabase(file_.server, {}, /*read_only=*/false, {});
    EXPECT_TRUE(
        (*db)->Exec(("DROP SCHEMA IF EXISTS \"" + file_.schema + "\" CASCADE").c_str()).ok());
  }
  PlaceInS3 Place(const test::S3StandIn& store, const std::string& prefix) const {
    return {store.endpoint(),       test::S3StandIn::kRegion, test::S3StandIn::kBucket, prefix, "",
            Path("s3.key").string()};
  }

  test::S3StandIn blobs_, keys_;
  DatabaseFile file_;
};

TEST_F(PgMoveTest, ThereAndBackIsIdentical) {
  const auto rows = RowsIn(Path("data"));
  auto there = MoveTo(Path("data"), Path("cluster"), file_);
  ASSERT_TRUE(there.ok()) << there.status().message();
  EXPECT_EQ(Differences(ButAudit(rows), ButAudit(there->tables)), "");
  EXPECT_FALSE(fs::exists(Path("cluster") / "enamel.db"));
  ExpectSchoolIn(Path("cluster"));

  BackupOptions backup;
  backup.data = Path("cluster");
  backup.target = Path("backup");
  backup.software = "test";
  auto made = BackUp(backup);
  ASSERT_TRUE(made.ok()) << made.status().message();
  EXPECT_EQ(made->attempts, 2u);
  EXPECT_TRUE(made->missing.empty());
  ExpectWhole(Path("backup"));
  RestoreOptions restore;
  restore.backup = Path("backup");
  restore.data = Path("restored");
  auto restored = Restore(restore);
  ASSERT_TRUE(restored.ok()) << restored.status().message();
  EXPECT_TRUE(restored->verified.findings.empty());
  ExpectSchoolIn(Path("restored"));

  auto back = MoveTo(Path("cluster"), Path("back"));
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(Differences(ButAudit(rows), ButAudit(RowsIn(Path("back")))), "");
  EXPECT_EQ(back->keys, there->keys);
  EXPECT_EQ(back->erased, there->erased);
  EXPECT_EQ(*ReadFile(Path("back") / "keyring" / (school_.world.student.Text() + ".key"), 64),
            *ReadFile(Path("data") / "keyring" / (school_.world.student.Text() + ".key"), 64));
  ExpectWhole(Path("back"));
  ExpectSchoolIn(Path("back"));
  // The trail continues from the backup's end.
  auto since = Verify({Path("back"), {}, {}, Path("backup")});
  ASSERT_TRUE(since.ok()) << since.status().message();
  EXPECT_TRUE(since->findings.empty()) << since->findings[0].kind;
}

// The other servers' folders have no mark.
TEST_F(PgMoveTest, NoOtherServersFolderOpensAPlaceThatWasMovedOrIsHalfThere) {
  const auto open_from_another = [&](const std::string& name) {
    const fs::path second = Path(name);
    fs::create_directories(second);
    fs::copy_file(Path("data") / "ticket.key", second / "ticket.key");
    EXPECT_TRUE(WriteDatabaseFile(second, file_, SystemDisk()).ok());
    StoreOptions options;
    options.folder = second;
    return OpenStore(options).status();
  };
  // Half there: the keys cannot be put.
  keys_.FailNext(test::S3StandIn::Fault::kForbidden, -1, "PUT");
  EXPECT_FALSE(MoveTo(Path("data"), Path("cluster"), file_).ok());
  keys_.FailNext(test::S3StandIn::Fault::kNone, 0);
  const Status half = open_from_another("while");
  EXPECT_EQ(half.code(), Code::kConflict);
  EXPECT_NE(half.message().find("not finished"), std::string::npos) << half.message();
  ASSERT_TRUE(MoveTo(Path("data"), Path("cluster"), file_).ok());
  StoreOptions beside;
  beside.folder = Path("second");
  EXPECT_TRUE(open_from_another("second").ok()) << "it is whole";
  auto worker = OpenStore(beside);
  ASSERT_TRUE(worker.ok());
  ASSERT_TRUE((*worker)->judging.Rescore(scored_, "again", kSystem).ok());

  // A move back that fails opens it again, one that is done does not.
  Disk& system = SystemDisk();
  FailingDisk disk;
  disk.until_failure = 3;
  EXPECT_FALSE(MoveTo(Path("cluster"), Path("back"), {}, &disk).ok());
  EXPECT_TRUE(open_from_another("third").ok());
  ASSERT_TRUE(MoveTo(Path("cluster"), Path("again"), {}, &system).ok());
  const Status closed = open_from_another("fourth");
  EXPECT_EQ(closed.code(), Code::kConflict);
  EXPECT_NE(closed.message().find("moved out"), std::string::npos) << closed.message();
  const auto job = (*worker)->jobs.LeaseJob(enamel::UnixMs(), 60'000);
  ASSERT_TRUE(job.ok());
  EXPECT_FALSE(job->has_value())
      << "a worker that was there before scores nothing in the old place";
}

TEST_F(PgMoveTest, ANegativeZeroComesBack) {
  ASSERT_TRUE(MoveTo(Path("data"), Path("cluster"), file_).ok());
  {
    auto db = OpenPgDatabase(file_.server, file_.schema, /*read_only=*/false, {});
    ASSERT_TRUE((*db)->Exec("UPDATE attempts SET score = '-0' WHERE score IS NOT NULL").ok());
  }
  const auto back = MoveTo(Path("cluster"), Path("back"));
  EXPECT_TRUE(back.ok()) << back.status().message();
}

TEST_F(PgMoveTest, AStoreThatGoesAwayIsTriedAgain) {
  for (auto* store : {&blobs_, &keys_}) {
    const fs::path to = Path(store == &blobs_ ? "one" : "two");
    // Another place each.
    DatabaseFile file = file_;
    file.schema = file_.schema + to.filename().string();
    file.blobs->prefix = to.filename().string() + "/";
    file.keys->bucket.prefix = to.filename().string() + "/";
    store->FailNext(test::S3StandIn::Fault::kForbidden, -1, "PUT");
    EXPECT_FALSE(MoveTo(Path("data"), to, file).ok());
    store->FailNext(test::S3StandIn::Fault::kNone, 0);
    auto moved = MoveTo(Path("data"), to, file);
    EXPECT_TRUE(moved.ok()) << moved.status().message();
    ExpectSchoolIn(to);
    fs::remove(Path("data") / kMovedMark);
    auto db = OpenPgDatabase(file_.server, {}, /*read_only=*/false, {});
    EXPECT_TRUE((*db)->Exec(("DROP SCHEMA \"" + file.schema + "\" CASCADE").c_str()).ok());
  }
}

TEST_F(PgMoveTest, OtherRowsInTheNewPlaceAreLeftAlone) {
  ASSERT_TRUE(MoveTo(Path("data"), Path("cluster"), file_).ok());
  fs::remove(Path("data") / kMovedMark);
  {
    StoreOptions options;
    options.folder = Path("data");
    auto store = OpenStore(options);
    (void)AddPerson(**store, "new", Role::kStudent);
  }
  const Status refused = MoveTo(Path("data"), Path("again"), file_).status();
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("people: expected 2 rows"), std::string::npos)
      << refused.message();
  DatabaseFile other = file_;
  other.schema = "another";
  EXPECT_EQ(MoveTo(Path("cluster"), Path("third"), other).status().code(), Code::kInvalidInput);
}

TEST_F(PgMoveTest, AServerThatRunsElsewhereIsInTheWay) {
  ASSERT_TRUE(MoveTo(Path("data"), Path("cluster"), file_).ok());
  fs::create_directories(Path("second"));
  fs::copy_file(Path("cluster") / "ticket.key", Path("second") / "ticket.key");
  fs::copy_file(Path("cluster") / "database.json", Path("second") / "database.json");
  {
    StoreOptions second;
    second.folder = Path("second");
    second.hold_lock = true;
    auto server = OpenStore(second);
    ASSERT_TRUE(server.ok()) << server.status().message();
    ASSERT_TRUE((*server)->live.KeepLinks({}, {}, true).ok());
  }
  const Status refused = MoveTo(Path("cluster"), Path("back")).status();
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("stop them all"), std::string::npos) << refused.message();
}

}  // namespace
}  // namespace enamel::server
