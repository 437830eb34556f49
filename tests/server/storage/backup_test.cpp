#include "server/storage/backup/backup.h"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "common/base/file.h"
#include "common/base/utf8.h"
#include "server/storage/engine/database.h"
#include "server/storage/keys/folder_keyring.h"
#include "server/storage/verify/manifest.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/server/storage/recorded_attempt.h"

// Backup while a server writes, restore on an empty folder, and what goes wrong with either.
namespace enamel::server {
namespace {

using namespace testing;
namespace fs = std::filesystem;

class BackupTest : public ::testing::Test {
 protected:
  fs::path Path(const char* name) const { return folder_.path() / name; }
  Result<BackupReport> Back(const char* target, bool copy = false, const fs::path& keyring = {}) {
    BackupOptions options;
    options.data = Path("data");
    options.target = Path(target);
    options.keyring = keyring;
    options.copy = copy;
    options.software = "test";
    return BackUp(options);
  }
  Result<RestoreReport> Bring(const char* backup, const char* data,
                              std::vector<fs::path> keyrings = {}, bool accept_damage = false) {
    RestoreOptions options;
    options.backup = Path(backup);
    options.data = Path(data);
    options.keyrings = std::move(keyrings);
    options.accept_damage = accept_damage;
    return Restore(options);
  }
  void ExpectWhole(const fs::path& folder) {
    auto report = Verify({folder, {}, {}});
    ASSERT_TRUE(report.ok()) << report.status().message();
    for (const Finding& finding : report->findings)
      ADD_FAILURE() << finding.kind << " " << finding.object << ": expected " << finding.expected
                    << ", found " << finding.found;
  }
  fs::path BlobIn(const fs::path& folder, const Sha256& hash) const {
    return folder / "blobs" / hash.Hex().substr(0, 2) / hash.Hex();
  }
  static void Spoil(const fs::path& file) {
    Bytes content = *ReadFile(file);
    content.at(content.size() / 2) ^= 1;
    fs::remove(file);  // it may be a link
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()),
               static_cast<std::streamsize>(content.size()));
  }

  TempFolder folder_;
  RecordedSchool school_{Path("data")};
};

TEST_F(BackupTest, RestoredDataIsWhatWasBackedUpAndEverythingAgrees) {
  Uuid scored = school_.Record(3), open = school_.Record(2);
  school_.Score(scored);
  Bytes trace = school_.TraceOf(scored), unfinished = school_.TraceOf(open);
  auto backup = Back("backup");
  ASSERT_TRUE(backup.ok()) << backup.status().message();
  EXPECT_EQ(backup->attempts, 2u);
  EXPECT_EQ(backup->ticks, 5u * World::kTicksPerChunk);
  EXPECT_GT(backup->linked, 0u);
  EXPECT_TRUE(backup->missing.empty());
  ExpectWhole(Path("backup"));

  school_.store.reset();
  fs::remove_all(Path("data"));
  auto restored = Bring("backup", "new");
  ASSERT_TRUE(restored.ok()) << restored.status().message();
  EXPECT_TRUE(restored->verified.findings.empty());
  EXPECT_EQ(restored->verified.sealed, 1u);
  EXPECT_EQ(restored->verified.ticks, 5u * World::kTicksPerChunk);
  ExpectWhole(Path("new"));
  school_.store = OpenStore(Path("new"));
  EXPECT_EQ(school_.TraceOf(scored), trace);
  EXPECT_EQ(school_.TraceOf(open), unfinished);
  EXPECT_EQ(AsText(*school_.store->blobs.GetBlob(school_.store->results.ResultOf(scored)->series)),
            "series");
  EXPECT_EQ(*ReadFile(Path("new") / "ticket.key"),
            Bytes(school_.ticket_key.secret_key.begin(), school_.ticket_key.secret_key.end()));
  auto row = school_.store->audit.Audit(1)->front();
  EXPECT_EQ(row.action, "store.restore");
}

TEST_F(BackupTest, BackupsMadeWhileChunksComeAreEachConsistent) {
  Uuid open = school_.Record(1);
  std::atomic<bool> stop{false};
  std::atomic<uint32_t> committed{1};
  std::thread station([&] {
    while (!stop && committed < 2000) {
      if (!school_.Append(open).ok()) break;
      ++committed;
    }
  });
  for (const char* name : {"b1", "b2", "b3"}) {
    uint32_t before = committed;
    auto backup = Back(name, true);
    uint32_t after = committed + 1;  // one may be in the database and not counted yet
    ASSERT_TRUE(backup.ok()) << backup.status().message();
    EXPECT_GE(backup->ticks, uint64_t{before} * World::kTicksPerChunk);
    EXPECT_LE(backup->ticks, uint64_t{after} * World::kTicksPerChunk);
    ExpectWhole(Path(name));
  }
  stop = true;
  station.join();
}

TEST_F(BackupTest, WhateverOfItFailsABackupIsWholeOrUnfinished) {
  school_.Score(school_.Record(2));
  int failures = 0;
  for (int n = 0; n < 200; ++n) {
    SCOPED_TRACE("change " + std::to_string(n) + " fails");
    TempFolder target;
    FailingDisk disk;
    disk.until_failure = n;
    BackupOptions options;
    options.data = Path("data");
    options.target = target.path() / "backup";
    options.disk = &disk;
    auto made = BackUp(options);
    if (!disk.fired) {
      EXPECT_TRUE(made.ok());
      EXPECT_GT(failures, 5);
      return;
    }
    ++failures;
    EXPECT_FALSE(made.ok());
    RestoreOptions restore;
    restore.backup = options.target;
    restore.data = target.path() / "data";
    EXPECT_FALSE(Restore(restore).ok());
    EXPECT_FALSE(fs::exists(restore.data)) << "refused before anything is written";
    EXPECT_EQ(Verify({.folder = options.target, .must_be_backup = true}).status().code(),
              Code::kInvalidInput);
    EXPECT_FALSE(fs::exists(target.path() / "backup.part")) << "a full disk needs the room";
  }
  FAIL() << "never went through";
}

TEST_F(BackupTest, WhateverOfItFailsARestoreIsWholeOrNoServerStartsOnIt) {
  school_.Score(school_.Record(2));
  ASSERT_TRUE(Back("backup").ok());
  for (int n = 0; n < 200; ++n) {
    SCOPED_TRACE("change " + std::to_string(n) + " fails");
    TempFolder target;
    FailingDisk disk;
    disk.until_failure = n;
    RestoreOptions options;
    options.backup = Path("backup");
    options.data = target.path() / "data";
    options.disk = &disk;
    auto restored = Restore(options);
    if (!disk.fired) {
      EXPECT_TRUE(restored.ok());
      return;
    }
    EXPECT_FALSE(restored.ok());
    if (!fs::exists(options.data) || fs::is_empty(options.data)) continue;
    StoreOptions open;
    open.folder = options.data;
    auto refused = OpenSqliteStore(open);
    EXPECT_EQ(refused.status().code(), Code::kConflict);
    EXPECT_NE(refused.status().message().find("did not finish"), std::string::npos);
  }
  FAIL() << "never went through";
}

TEST_F(BackupTest, PlacesThatAreNotEmptyAreLeftAlone) {
  fs::create_directories(Path("backup"));
  ASSERT_TRUE(WriteFileDurably(Path("backup") / "mine", AsBytes("x")).ok());
  EXPECT_EQ(Back("backup").status().code(), Code::kConflict);
  ASSERT_TRUE(Back("good").ok());
  EXPECT_EQ(Bring("good", "backup").status().code(), Code::kConflict);
  EXPECT_EQ(Bring("good", "data").status().code(), Code::kConflict);
  EXPECT_EQ(*ReadFile(Path("backup") / "mine"), Bytes{'x'});
  BackupOptions nothing;
  nothing.data = Path("nowhere");
  nothing.target = Path("b2");
  EXPECT_EQ(BackUp(nothing).status().code(), Code::kNotFound);
  EXPECT_EQ(Bring("nowhere", "new").status().code(), Code::kInvalidInput);
}

TEST_F(BackupTest, OfASchoolWithoutBlobsIsWhole) {
  { auto store = OpenStore(Path("young")); }
  BackupOptions options;
  options.data = Path("young");
  options.target = Path("backup");
  ASSERT_TRUE(BackUp(options).ok());
  ASSERT_FALSE(fs::exists(Path("backup") / "blobs")) << "this test is of a backup without them";
  ExpectWhole(Path("backup"));
}

// A copy of a backup that broke off looks like this.
TEST_F(BackupTest, DatabaseWithoutAManifestIsNoBackup) {
  ASSERT_TRUE(Back("backup").ok());
  fs::remove(Path("backup") / kManifestName);
  const Status refused = Verify({.folder = Path("backup"), .must_be_backup = true}).status();
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("has no manifest.json"), std::string::npos) << refused.message();
  EXPECT_EQ(NewestBackup(folder_.path()).status().code(), Code::kNotFound);
}

TEST_F(BackupTest, TheNewestIsOfTheDatabaseThatIsFurthestAlongWhateverTheClockSaid) {
  fs::create_directory(Path("all"));
  ASSERT_TRUE(Back("all/2031-01-01T000000").ok());
  ASSERT_TRUE(school_.store->audit.NoteAudit(kSystem, "test.row", "", "{}").ok());
  ASSERT_TRUE(Back("all/2026-01-01T000000").ok());
  fs::create_directories(Path("all") / "2032-01-01T000000.part");
  fs::create_directories(Path("all") / "2033-01-01T000000");
  EXPECT_EQ(*NewestBackup(Path("all")), Path("all") / "2026-01-01T000000");
  // After a restore the school has fewer rows, and continues from there.
  ASSERT_TRUE(Bring("all/2031-01-01T000000", "data2").ok());
  BackupOptions options;
  options.data = Path("data2");
  options.target = Path("all") / "2020-01-01T000000";
  ASSERT_TRUE(BackUp(options).ok());
  EXPECT_EQ(*NewestBackup(Path("all")), options.target);
}

TEST_F(BackupTest, TwoOfOneSecondAreBothMade) {
  const auto first = NewBackupIn(Path("all"), "night"), second = NewBackupIn(Path("all"), "night");
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(*first, Path("all") / "night");
  EXPECT_EQ(*second, Path("all") / "night-2");
  ASSERT_TRUE(Back("all/night").ok());
  ASSERT_TRUE(Back("all/night-2").ok());
  EXPECT_EQ(*NewBackupIn(Path("all"), "night"), Path("all") / "night-3");
}

TEST_F(BackupTest, WhatAKilledBackupLeftIsReplacedAndFilesOfOthersAreNot) {
  fs::create_directories(Path("backup.part") / "blobs");
  ASSERT_TRUE(WriteFileDurably(Path("backup.part") / "enamel.db", AsBytes("half")).ok());
  ASSERT_TRUE(Back("backup").ok());
  ExpectWhole(Path("backup"));
  fs::create_directories(Path("other.part"));
  ASSERT_TRUE(WriteFileDurably(Path("other.part") / "mine", AsBytes("x")).ok());
  EXPECT_EQ(Back("other").status().code(), Code::kConflict);
  EXPECT_TRUE(fs::exists(Path("other.part") / "mine"));
}

// An update that migrates, and the way back: docs/for_it.md, "Downgrade".
TEST_F(BackupTest, WhatANewerServerMigratedIsRefusedAndTheBackupBeforeItIsNot) {
  const Uuid before = school_.Record(2);
  ASSERT_TRUE(Back("backup").ok());
  const Uuid since = school_.Record(1);
  school_.store.reset();
  {
    auto newer = OpenDatabase(Path("data") / "enamel.db", DbMode::kExisting);
    ASSERT_TRUE(newer.ok()) << newer.status().message();
    std::vector<sql::Migration> migrations = SqliteMigrations();
    migrations.push_back({LatestSchemaVersion() + 1, "0002_next.sql",
                          "ALTER TABLE people ADD COLUMN next INTEGER NOT NULL DEFAULT 0"});
    ASSERT_TRUE((*newer)->Migrate(migrations).ok());
  }
  const Status refused = OpenSqliteStore({Path("data"), false, 4, {}}).status();
  EXPECT_EQ(refused.code(), Code::kVersion);
  EXPECT_NE(refused.message().find("restore"), std::string::npos) << refused.message();
  // A backup that the newer server made is no way back.
  EXPECT_EQ(Back("newer").status().code(), Code::kVersion);

  ASSERT_TRUE(Bring("backup", "restored").ok());
  school_.store = OpenStore(Path("restored"));
  EXPECT_EQ(AllChunks(school_.store->recordings, before)->size(), 2u);
  EXPECT_EQ(AllChunks(school_.store->recordings, since).status().code(), Code::kNotFound)
      << "what came after the backup is lost";
}

TEST_F(BackupTest, DamagedBackupIsNamedFileByFileAndRestoredOnlyWithTheLossAccepted) {
  Uuid scored = school_.Record(2), other = school_.Record(1);
  school_.Score(scored);
  school_.Score(other);
  Sha256 series = school_.store->results.ResultOf(scored)->series;
  Sha256 deviation = school_.store->results.ResultOf(scored)->deviation;
  Bytes kept = school_.TraceOf(other);
  ASSERT_TRUE(Back("backup", true).ok());
  Spoil(BlobIn(Path("backup"), series));
  fs::remove(BlobIn(Path("backup"), deviation));
  auto refused = Bring("backup", "new");
  EXPECT_EQ(refused.status().code(), Code::kInvalidInput);
  for (const Sha256& hash : {series, deviation})
    EXPECT_NE(refused.status().message().find(hash.Hex()), std::string::npos);
  EXPECT_EQ(Printable(refused.status().message()), refused.status().message())
      << "on one line, as programs show an error";
  auto verified = Verify({Path("backup"), {}, {}});
  EXPECT_EQ(verified->findings.size(), 2u);

  auto accepted = Bring("backup", "newer", {}, true);
  ASSERT_TRUE(accepted.ok()) << accepted.status().message();
  EXPECT_EQ(accepted->left_out.size(), 2u);
  EXPECT_EQ(accepted->verified.findings.size(), 2u) << "and known to be missing afterwards";
  school_.store = OpenStore(Path("newer"));
  EXPECT_EQ(school_.TraceOf(other), kept);
}

TEST_F(BackupTest, DamagedDatabaseIsNeverRestored) {
  school_.Score(school_.Record(1));
  ASSERT_TRUE(Back("backup").ok());
  Spoil(Path("backup") / "enamel.db");
  EXPECT_EQ(Bring("backup", "new", {}, true).status().code(), Code::kInvalidInput);
}

TEST_F(BackupTest, BlobDamagedAtTheSourceIsReportedAndTheRestIsBackedUp) {
  Uuid scored = school_.Record(1);
  school_.Score(scored);
  Sha256 series = school_.store->results.ResultOf(scored)->series;
  Spoil(BlobIn(Path("data"), series));
  auto backup = Back("backup");
  ASSERT_TRUE(backup.ok()) << backup.status().message();
  EXPECT_EQ(backup->missing, std::vector{series});
  EXPECT_FALSE(fs::exists(BlobIn(Path("backup"), series)));
  EXPECT_TRUE(Bring("backup", "new").ok());
}

TEST_F(BackupTest, ErasedPersonStaysErasedWhenAnOlderBackupIsRestoredWithTheNewestKeyRing) {
  Uuid other = AddPerson(*school_.store, "other", Role::kStudent);
  Uuid theirs = school_.RecordOf(other, 2), kept = school_.Record(1);
  school_.Score(theirs);
  school_.Score(kept);
  ASSERT_TRUE(Back("inside").ok());
  fs::path ring = Path("ring");
  ASSERT_TRUE(Back("apart", false, ring).ok());
  ASSERT_TRUE(school_.store->erasures.ErasePerson(other, false, kSystem).ok());

  // Keys apart, mirrored again with the next backup: nothing opens the old one's recordings.
  ASSERT_TRUE(Back("next", false, ring).ok());
  EXPECT_FALSE(fs::exists(Path("apart") / "keyring"));
  EXPECT_EQ(Bring("apart", "no-keys").status().code(), Code::kConflict) << "asks for --keyring";
  auto restored = Bring("apart", "new", {ring});
  ASSERT_TRUE(restored.ok()) << restored.status().message();
  EXPECT_EQ(restored->erased_again, 1u);
  EXPECT_TRUE(restored->verified.findings.empty());
  auto store = OpenStore(Path("new"));
  EXPECT_EQ(store->people.PersonById(other).status().code(), Code::kNotFound);
  EXPECT_EQ(store->attempts.AttemptById(theirs).status().code(), Code::kNotFound);
  EXPECT_TRUE(AllChunks(store->recordings, kept).ok());
  EXPECT_FALSE(FolderKeyring(Path("new") / "keyring", SystemDisk()).Find(other).ok());

  // Keys inside: the newest ring still lists the erased people.
  auto again = Bring("inside", "new2", {Path("data") / "keyring"});
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_EQ(again->erased_again, 1u);
  EXPECT_EQ(OpenStore(Path("new2"))->people.PersonById(other).status().code(), Code::kNotFound);
}

TEST_F(BackupTest, SessionsAndOpenCodesDoNotComeBack) {
  Sha256 token = HashSha256(AsBytes("token")), code = HashSha256(AsBytes("another"));
  ASSERT_TRUE(
      school_.store->sessions.CreateSession({token, school_.world.student, 1, 1, 1000, "page"})
          .ok());
  ASSERT_TRUE(school_.store->stations.AddEnrolCode(code, 1000, kSystem).ok());
  ASSERT_TRUE(Back("backup").ok());
  ASSERT_TRUE(Bring("backup", "new").ok());
  auto store = OpenStore(Path("new"));
  EXPECT_FALSE(store->sessions.FindSession(token).ok());
  EXPECT_FALSE(store->stations.EnrolStation(code, {}, {}, 10).ok());
}

TEST_F(BackupTest, NothingIsRemovedWhileABackupIsMade) {
  school_.Score(school_.Record(1));
  bool asked = false;
  BackupOptions options;
  options.data = Path("data");
  options.target = Path("backup");
  options.progress = [&](const std::string&, uint64_t, uint64_t) {
    if (asked) return;
    asked = true;
    auto refused = school_.store->erasures.ErasePerson(school_.world.student, true, kSystem);
    EXPECT_EQ(refused.status().code(), Code::kUnavailable);
    EXPECT_TRUE(school_.store->people.PersonById(school_.world.student).ok());
  };
  ASSERT_TRUE(BackUp(options).ok());
  EXPECT_TRUE(asked);
  EXPECT_TRUE(school_.store->erasures.ErasePerson(school_.world.student, true, kSystem).ok());
}

}  // namespace
}  // namespace enamel::server
