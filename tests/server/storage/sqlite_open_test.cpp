#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/database.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/open_store.h"
#include "server/storage/recordings/ingest_rows.h"
#include "server/storage/upkeep/store_health.h"
#include "server/storage/verify/verify.h"
#include "tests/server/storage/store_world.h"

// Opening a data folder: refusals, and their messages.
namespace enamel::server {
namespace {

using namespace testing;

void ExecRaw(const std::filesystem::path& folder, const std::string& sql) {
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "enamel.db").c_str(), &handle), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(handle);
  sqlite3_close(handle);
}

std::filesystem::perms ModeOf(const std::filesystem::path& path) {
  return std::filesystem::status(path).permissions();
}
constexpr auto kOwnerOnly = std::filesystem::perms::owner_all;
constexpr auto kForAll = std::filesystem::perms(0755);

TEST(SqliteOpenTest, ADataFolderThatLetsOthersInIsPutRight) {
  TempFolder folder;
  const auto data = folder.path() / "data";
  std::filesystem::create_directory(data);
  for (const char* what : {"empty", "with a database"}) {
    std::filesystem::permissions(data, kForAll);
    auto opened = OpenSqliteStore({data});
    ASSERT_TRUE(opened.ok()) << what << ": " << opened.status().message();
    EXPECT_EQ(ModeOf(data), kOwnerOnly) << what;
  }
}

TEST(SqliteOpenTest, AFolderOfOtherThingsIsNotClosedButRefused) {
  TempFolder folder;
  const auto home = folder.path() / "home";
  std::filesystem::create_directory(home);
  ASSERT_TRUE(WriteFileDurably(home / "letter.txt", AsBytes("hello")).ok());
  std::filesystem::permissions(home, kForAll);
  Status refused = OpenSqliteStore({home}).status();
  EXPECT_EQ(refused.code(), Code::kForbidden);
  EXPECT_NE(refused.message().find("0755"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("chmod 700"), std::string::npos) << refused.message();
  EXPECT_EQ(ModeOf(home), kForAll);
  EXPECT_FALSE(std::filesystem::exists(home / "enamel.db"));
  std::filesystem::permissions(home, kOwnerOnly);
  EXPECT_TRUE(OpenSqliteStore({home}).ok());
}

TEST(SqliteOpenTest, NewerDatabaseIsRefusedAndSaysWhatToDo) {
  TempFolder folder;
  OpenStore(folder.path());
  ExecRaw(folder.path(), "PRAGMA user_version = " + std::to_string(LatestSchemaVersion() + 1));
  auto refused = OpenSqliteStore({folder.path()});
  EXPECT_EQ(refused.status().code(), Code::kVersion);
  EXPECT_NE(refused.status().message().find("newer enamel-server"), std::string::npos);
}

TEST(SqliteOpenTest, DatabaseOfAnotherProgramIsRefusedInOneSentenceAndNothingIsChanged) {
  TempFolder folder;
  const auto data = folder.path() / "data";
  std::filesystem::create_directory(data);
  std::filesystem::permissions(data, kForAll);
  // As a server from before the first release left it, and one that says nothing of itself.
  for (const char* id : {"0x456e6d6c", "0"}) {
    SCOPED_TRACE(id);
    std::filesystem::remove(data / "enamel.db");
    ExecRaw(data, std::string("PRAGMA application_id = ") + id +
                      "; CREATE TABLE theirs (x); PRAGMA user_version = 23");
    const Bytes before = *ReadFile(data / "enamel.db");
    const Status refused = OpenSqliteStore({data}).status();
    EXPECT_EQ(refused.code(), Code::kVersion);
    EXPECT_NE(refused.message().find("nothing in"), std::string::npos) << refused.message();
    if (id[1] == 'x') {
      EXPECT_NE(refused.message().find("move the folder " + data.string() + " away"),
                std::string::npos)
          << refused.message();
      EXPECT_NE(refused.message().find("--data"), std::string::npos) << refused.message();
      EXPECT_EQ(*ReadFile(data / "enamel.db"), before);
      EXPECT_EQ(ModeOf(data), kForAll);
      EXPECT_EQ(std::distance(std::filesystem::directory_iterator(data), {}), 1);
      EXPECT_EQ(Verify({data, {}, {}}).status().code(), Code::kVersion);
    }
  }
}

TEST(SqliteOpenTest, SecondServerOnTheFolderIsRefusedAndTheCommandLineIsNot) {
  TempFolder folder;
  auto server = OpenSqliteStore({folder.path(), true});
  ASSERT_TRUE(server.ok()) << server.status().message();
  auto second = OpenSqliteStore({folder.path(), true});
  EXPECT_EQ(second.status().code(), Code::kUnavailable);
  EXPECT_NE(second.status().message().find("another enamel-server"), std::string::npos);
  auto command_line = OpenSqliteStore({folder.path(), false});
  ASSERT_TRUE(command_line.ok()) << command_line.status().message();
  AddPerson(**command_line, "ada", Role::kAdmin);
  EXPECT_TRUE((*server)->people.PersonByLogin("ada").ok());
}

// Locks are a process's, not a connection's: a child asks whether its parent still has some. Without
// them another program deletes the log under a running server.
TEST(SqliteOpenTest, EveryConnectionThatIsOpenedLeavesTheLocksOfTheOthers) {
  TempFolder folder;
  auto server = OpenSqliteStore({folder.path(), true});
  ASSERT_TRUE(server.ok()) << server.status().message();
  AddPerson(**server, "ada", Role::kAdmin);
  ASSERT_TRUE(OpenDatabase(folder.path() / "enamel.db", DbMode::kReadOnly).ok());
  const std::string path = (folder.path() / "enamel.db").string();
  const pid_t child = ::fork();
  if (child == 0) {
    const int fd = ::open(path.c_str(), O_RDWR);
    struct flock lock {};
    lock.l_type = F_WRLCK;
    ::_exit(fd >= 0 && ::fcntl(fd, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), 0) << "no lock is left on " << path;
}

TEST(SqliteOpenTest, JobOfAKilledServerIsTakenAgainAtOnce) {
  TempFolder folder;
  Uuid attempt;
  {
    auto server = OpenSqliteStore({folder.path(), true});
    World world(**server);
    attempt = world.OpenedAttempt();
    ASSERT_TRUE((*server)->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
    ASSERT_TRUE((*server)->jobs.LeaseJob(1000, 120'000)->has_value());
  }
  auto command_line = OpenSqliteStore({folder.path(), false});
  EXPECT_FALSE((*command_line)->jobs.LeaseJob(1001, 120'000)->has_value())
      << "its lease still runs";
  auto restarted = OpenSqliteStore({folder.path(), true});
  auto job = (*restarted)->jobs.LeaseJob(1001, 120'000);
  ASSERT_TRUE(job.ok() && job->has_value());
  EXPECT_EQ((*job)->attempt, attempt);
  EXPECT_EQ((*job)->tries, 2u);
}

TEST(SqliteOpenTest, AuditKeepsItsOrderWhenTheClockIsSetBack) {
  TempFolder folder;
  auto store = OpenStore(folder.path());
  ASSERT_TRUE(store->audit.NoteAudit(kSystem, "test.first", "a", "{}").ok());
  // As if it had been written a century later.
  const std::string later = "03ffffffffff7fffbfffffffffffffff";
  auto db = OpenDatabase(folder.path() / "enamel.db", DbMode::kReadOnly);
  AuditHead head = **FindAuditHead(**db, Uuid{});
  std::ranges::copy(*FromHex(later), head.last_id.bytes.begin());
  head.signature = SignAuditHead(head, ReadTicketKey(folder.path())->secret_key);
  ExecRaw(folder.path(),
          "DROP TRIGGER audit_is_not_changed; DROP TRIGGER audit_heads_only_advance; "
          "UPDATE audit SET id = x'" +
              later + "' WHERE action = 'test.first'; UPDATE audit_heads SET last_id = x'" + later +
              "', signature = x'" + ToHex(head.signature) + "'");
  for (const char* action : {"test.second", "test.third"}) {
    ASSERT_TRUE(store->audit.NoteAudit(kSystem, action, "a", "{}").ok());
  }
  auto rows = *store->audit.Audit(3);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].action, "test.third");
  EXPECT_EQ(rows[1].action, "test.second");
  EXPECT_EQ(rows[2].action, "test.first");
}

TEST(SqliteOpenTest, DamagedDatabaseTakesNoRecordingsAndSaysSo) {
  TempFolder folder;
  Uuid attempt;
  {
    auto store = OpenStore(folder.path());
    World world(*store);
    attempt = world.OpenedAttempt();
    world.Append(attempt, 40);
  }
  Bytes content = *ReadFile(folder.path() / "enamel.db");
  ASSERT_GT(content.size(), 20u * 4096);
  for (size_t page = 8; page * 4096 + 200 < content.size(); ++page) {
    std::fill_n(content.begin() + static_cast<std::ptrdiff_t>(page * 4096), 200, 0xff);
  }
  ASSERT_TRUE(WriteFileDurably(folder.path() / "enamel.db", content).ok());
  auto opened = OpenSqliteStore({folder.path()});
  if (!opened.ok()) {
    EXPECT_NE(opened.status().message().find("damaged, restore a backup"), std::string::npos);
    return;
  }
  Status read = AllChunks((*opened)->recordings, attempt).status();
  EXPECT_EQ(read.code(), Code::kStorage) << read.message();
  StoreHealth health = (*opened)->health.Health();
  EXPECT_FALSE(health.takes_recordings);
  EXPECT_NE(health.problem.find("restore a backup"), std::string::npos) << health.problem;
  EXPECT_EQ((*opened)->blobs.PutBlob(AsBytes("more")).status().code(), Code::kUnavailable);
}

int64_t RowsOf(const std::filesystem::path& folder, const std::string& table) {
  sqlite3* handle = nullptr;
  sqlite3_stmt* statement = nullptr;
  EXPECT_EQ(sqlite3_open((folder / "enamel.db").c_str(), &handle), SQLITE_OK);
  sqlite3_prepare_v2(handle, ("SELECT count(*) FROM " + table).c_str(), -1, &statement, nullptr);
  int64_t rows = sqlite3_step(statement) == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : -1;
  sqlite3_finalize(statement);
  sqlite3_close(handle);
  return rows;
}

TEST(SqliteOpenTest, RowsOfASealedRecordingGoInTheBackgroundAndThoseOfAnOpenOneStay) {
  TempFolder folder;
  Uuid sealed, open;
  std::vector<ChunkPut> chunks;
  for (int start = 0; start < 2; ++start) {
    auto server = OpenSqliteStore({folder.path(), true});
    ASSERT_TRUE(server.ok()) << server.status().message();
    if (start == 0) {
      World world(**server);
      open = world.OpenedAttempt();
      world.Append(open, 3);
      sealed = world.OpenedAttempt();
      chunks = world.Append(sealed, 300);
      ASSERT_TRUE((*server)->seals.SealAttempt(World::SealOf(chunks), 200).ok());
      continue;  // stopped before all of them are gone, as a rule
    }
    for (int i = 0; i < 3000 && RowsOf(folder.path(), "trace_chunks") > 3; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(AllChunks((*server)->recordings, sealed)->size(), 300u);
    EXPECT_EQ(AllChunks((*server)->recordings, open)->size(), 3u);
    EXPECT_TRUE((*server)->ingest.AppendChunk(chunks[7]).ok()) << "sent again after the seal";
  }
  EXPECT_EQ(RowsOf(folder.path(), "trace_chunks"), 3);
}

TEST(SqliteOpenTest, FolderThatIsAFileIsRefused) {
  TempFolder folder;
  std::filesystem::path file = folder.path() / "file";
  ExecRaw(folder.path(), "VACUUM");
  std::filesystem::copy_file(folder.path() / "enamel.db", file);
  auto refused = OpenSqliteStore({file});
  EXPECT_EQ(refused.status().code(), Code::kStorage);
  EXPECT_NE(refused.status().message().find("data folder"), std::string::npos);
}

TEST(SqliteOpenTest, FolderThatMayNotBeWrittenIsRefused) {
  if (::geteuid() == 0) GTEST_SKIP() << "skipped: root may write everywhere";
  TempFolder folder;
  std::filesystem::permissions(
      folder.path(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  auto refused = OpenSqliteStore({folder.path()});
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
  EXPECT_EQ(refused.status().code(), Code::kStorage);
  EXPECT_NE(refused.status().message().find("not writable"), std::string::npos);
}

TEST(SqliteOpenTest, FolderOfAnotherUserIsRefusedForRoot) {
  if (::geteuid() != 0) GTEST_SKIP() << "skipped: only root could open it at all";
  TempFolder folder;
  ASSERT_EQ(::chown(folder.path().c_str(), 12345, 12345), 0);
  auto refused = OpenSqliteStore({folder.path()});
  EXPECT_EQ(refused.status().code(), Code::kForbidden);
  EXPECT_NE(refused.status().message().find("12345"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SqliteOpenTest, DamagedBlobIsRefusedNotReturned) {
  TempFolder folder;
  auto store = OpenStore(folder.path());
  Sha256 hash = PutText(*store, "content");
  auto path = folder.path() / "blobs" / hash.Hex().substr(0, 2) / hash.Hex();
  std::filesystem::resize_file(path, 3);
  EXPECT_EQ(store->blobs.GetBlob(hash).status().code(), Code::kStorage);
}

}  // namespace
}  // namespace enamel::server
