#include <gtest/gtest.h>
#include <sqlite3.h>

#include "server/storage/sqlite_store.h"
#include "tests/server/storage/store_world.h"

// Opening a data folder: what is refused, and in which words.
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

TEST(SqliteOpenTest, NewerDatabaseIsRefusedAndSaysWhatToDo) {
  TempFolder folder;
  OpenStore(folder.path());
  ExecRaw(folder.path(), "PRAGMA user_version = " + std::to_string(LatestSchemaVersion() + 1));
  auto refused = OpenSqliteStore({folder.path()});
  EXPECT_EQ(refused.status().code(), Code::kVersion);
  EXPECT_NE(refused.status().message().find("newer enamel-server"), std::string::npos);
}

TEST(SqliteOpenTest, DatabaseOfAnotherProgramIsRefused) {
  TempFolder folder;
  ExecRaw(folder.path(), "CREATE TABLE theirs (x); PRAGMA user_version = 1");
  EXPECT_EQ(OpenSqliteStore({folder.path()}).status().code(), Code::kVersion);
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
  EXPECT_TRUE((*server)->PersonByLogin("ada").ok());
}

TEST(SqliteOpenTest, JobOfAKilledServerIsTakenAgainAtOnce) {
  TempFolder folder;
  Uuid attempt;
  {
    auto server = OpenSqliteStore({folder.path(), true});
    World world(**server);
    attempt = world.OpenedAttempt();
    ASSERT_TRUE((*server)->SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
    ASSERT_TRUE((*server)->LeaseJob(1000, 120'000)->has_value());
  }
  auto command_line = OpenSqliteStore({folder.path(), false});
  EXPECT_FALSE((*command_line)->LeaseJob(1001, 120'000)->has_value()) << "its lease still runs";
  auto restarted = OpenSqliteStore({folder.path(), true});
  auto job = (*restarted)->LeaseJob(1001, 120'000);
  ASSERT_TRUE(job.ok() && job->has_value());
  EXPECT_EQ((*job)->attempt, attempt);
  EXPECT_EQ((*job)->tries, 2u);
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
  EXPECT_EQ(store->GetBlob(hash).status().code(), Code::kStorage);
}

}  // namespace
}  // namespace enamel::server
