#include "server/jobs/backup_run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "server/storage/backup/backup.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/open_store.h"
#include "tests/support/becomes.h"
#include "tests/support/temp_folder.h"

// How the server follows a backup's process, with scripts in its place. That of the real program is
// in tests/server/app/upkeep_test.cpp.
namespace enamel::server {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class BackupRunTest : public ::testing::Test {
 protected:
  BackupRunTest() {
    fs::create_directory(folder_.path() / "backups");
    StoreOptions options;
    options.folder = folder_.path() / "data";
    store_ = *OpenStore(options);
    place_.folder = folder_.path() / "backups";
    place_.program = folder_.path() / "program";
  }
  // In place of `enamel-server backup TARGET --data DATA --report`.
  void Program(const std::string& script) const {
    folder_.Write("program", "#!/bin/sh\ntarget=$2 data=$4\n" + script + "\n");
    fs::permissions(place_.program, fs::perms::owner_all);
  }
  std::unique_ptr<BackupRun> Made() const {
    auto out = std::make_unique<BackupRun>(*store_);
    out->Into(place_);
    return out;
  }
  static bool Runs(const BackupRun& run) { return run.Look()->running.has_value(); }
  // Why the backup that was started failed.
  static std::string Problem(const BackupRun& run) {
    EXPECT_TRUE(test::Becomes([&] { return !Runs(run); }));
    const auto failed = run.Look()->failed;
    return failed ? failed->problem : "";
  }
  static Status StartOf(BackupRun& run) { return run.Start({{}, "page"}); }

  test::TempFolder folder_;
  std::unique_ptr<Store> store_;
  BackupRun::Place place_;
};

TEST_F(BackupRunTest, ShowsWhatItsProcessSaysAndNotesTheEnd) {
  const std::string go = (folder_.path() / "go").string();
  Program(R"(echo '{"phase":"blobs","done":3,"all":9}'
while [ ! -e )" +
          go + R"( ]; do sleep 0.02; done
echo '{"files":9,"bytes":4000,"missing":1}')");
  const auto run = Made();
  ASSERT_TRUE(StartOf(*run).ok());
  ASSERT_TRUE(test::Becomes([&] { return run->Look()->running->phase == "blobs"; }));
  EXPECT_EQ(run->Look()->running->done, 3u);
  EXPECT_EQ(run->Look()->running->all, 9u);
  const Status again = StartOf(*run);
  EXPECT_EQ(again.code(), Code::kConflict);
  EXPECT_NE(again.message().find("a backup is running"), std::string::npos);
  folder_.Write("go", "");
  ASSERT_TRUE(test::Becomes([&] { return !Runs(*run); }));
  EXPECT_FALSE(run->Look()->failed);
  const auto made = *store_->audit.NewestOf(kBackupMade);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->after_json, R"({"files":9,"bytes":4000,"missing":1})");
  EXPECT_EQ(fs::path(made->object).parent_path(), place_.folder);
  EXPECT_EQ((*store_->audit.NewestOf(kBackupStarted))->object, made->object);
}

TEST_F(BackupRunTest, FailureIsKeptWithItsReasonAndTakesNoRoom) {
  Program(R"(mkdir "$target.part/blobs"; echo '{"problem":"the disk is full"}'; exit 1)");
  const auto run = Made();
  ASSERT_TRUE(StartOf(*run).ok());
  EXPECT_EQ(Problem(*run), "the disk is full");
  EXPECT_TRUE(fs::is_empty(place_.folder));
  EXPECT_EQ(Problem(*Made()), "the disk is full") << "after a restart too";
  ASSERT_TRUE(store_->audit.NoteAudit({{}, "command line"}, kBackupMade, "/b", "{}").ok());
  EXPECT_FALSE(run->Look()->failed) << "one was made since";
}

TEST_F(BackupRunTest, ProcessThatDiesOrCannotBeStartedIsNamed) {
  Program("kill -9 $$");
  const auto run = Made();
  ASSERT_TRUE(StartOf(*run).ok());
  EXPECT_NE(Problem(*run).find("ended by signal 9"), std::string::npos) << Problem(*run);
  fs::remove(place_.program);
  ASSERT_TRUE(StartOf(*run).ok());
  EXPECT_NE(Problem(*run).find("cannot start"), std::string::npos) << Problem(*run);
}

// It holds the lock as a backup does: shared.
constexpr char kHangs[] = R"(exec 9>"$data/UPKEEP"; flock -s 9
echo '{"phase":"blobs","done":1,"all":2}'; exec sleep 1000)";

TEST_F(BackupRunTest, OneThatHangsIsEndedAndItsLockWithIt) {
  Program(kHangs);
  place_.silence = 3s;
  const auto run = Made();
  ASSERT_TRUE(StartOf(*run).ok());
  const std::string problem = Problem(*run);
  EXPECT_NE(problem.find("without progress while it copied the blobs"), std::string::npos)
      << problem;
  EXPECT_TRUE(TakeUpkeepLock(folder_.path() / "data", FolderLock::Mode::kExclusive).ok());
  EXPECT_TRUE(StartOf(*run).ok());
}

TEST_F(BackupRunTest, OneThatTakesTooLongIsEnded) {
  Program(R"(while true; do echo '{"phase":"keys","done":1,"all":2}'; sleep 0.02; done)");
  place_.most = 300ms;
  const auto run = Made();
  ASSERT_TRUE(StartOf(*run).ok());
  EXPECT_NE(Problem(*run).find("took longer"), std::string::npos) << Problem(*run);
}

TEST_F(BackupRunTest, StopOfTheServerEndsItAndTheNextStartSaysSo) {
  Program(kHangs);
  auto run = Made();
  ASSERT_TRUE(StartOf(*run).ok());
  ASSERT_TRUE(test::Becomes([&] { return run->Look()->running->phase == "blobs"; }));
  run.reset();
  EXPECT_TRUE(TakeUpkeepLock(folder_.path() / "data", FolderLock::Mode::kExclusive).ok());
  EXPECT_NE(Problem(*Made()).find("the server stopped"), std::string::npos);
}

TEST_F(BackupRunTest, IsRefusedWhileTheCommandLineMakesOneOrDataIsRemoved) {
  Program("exit 1");
  const auto run = Made();
  const auto refused = [&](FolderLock::Mode mode) {
    const auto lock = TakeUpkeepLock(folder_.path() / "data", mode);
    EXPECT_TRUE(lock.ok());
    const Status status = StartOf(*run);
    EXPECT_EQ(status.code(), Code::kConflict);
    return status.message();
  };
  EXPECT_NE(refused(FolderLock::Mode::kShared).find("a backup of"), std::string::npos);
  EXPECT_NE(refused(FolderLock::Mode::kExclusive).find("are being removed"), std::string::npos);
  EXPECT_FALSE(*store_->audit.NewestOf(kBackupStarted)) << "what is refused was not started";
}

// A restore drill of the newest backup, in place of `enamel-server restore BACKUP --data INTO
// --report`.
class RestoreDrillTest : public BackupRunTest {
 protected:
  RestoreDrillTest() {
    BackupOptions options;
    options.data = folder_.path() / "data";
    options.target = place_.folder / "b1";
    EXPECT_TRUE(BackUp(options).ok());
    EXPECT_TRUE(store_->audit.NoteAudit({{}, "command line"}, kBackupMade, "b1", "{}").ok());
    place_.look = 5ms;
  }
  // How the next one ends.
  BackupRun::Drill Tried(const std::string& script) {
    Program("[ $1 = restore ] && mkdir \"$4\" || exit 1\n" + script);
    const auto before = *BackupRun::LastDrill(store_->audit);
    auto run = Made();
    const auto ended = [&] {
      const auto now = run->Look()->drill;
      return now && (!before || now->problem != before->problem);
    };
    EXPECT_TRUE(test::Becomes(ended));
    run.reset();
    EXPECT_FALSE(fs::exists(folder_.path() / "data" / "drill"));
    return BackupRun::LastDrill(store_->audit)->value_or(BackupRun::Drill());
  }
};

TEST_F(RestoreDrillTest, IsMadeOfTheNewestBackupAndItsResultIsKept) {
  const BackupRun::Drill passed = Tried(R"(echo '{"files":3,"bytes":9,"findings":0}')");
  EXPECT_EQ(passed.problem, "");
  EXPECT_EQ(passed.place, (place_.folder / "b1").string());
  place_.drill = 0ms;
  const BackupRun::Drill found =
      Tried(R"(echo '{"files":3,"bytes":9,"findings":2,"first":"blob 7"}')");
  EXPECT_NE(found.problem.find("2 findings in what was restored"), std::string::npos);
  EXPECT_NE(found.problem.find("the first: blob 7"), std::string::npos);
  place_.drill_again = 0ms;
  EXPECT_EQ(Tried(R"(echo '{"problem":"a key is missing"}'; exit 1)").problem, "a key is missing");
  fs::remove_all(place_.folder / "b1");
  EXPECT_NE(Tried("").problem.find("no finished backup"), std::string::npos);
}

TEST_F(RestoreDrillTest, IsNotMadeWhereTheDataDiskHasNoRoomForIt) {
  store_.reset();
  StoreOptions options;
  options.folder = folder_.path() / "data";
  options.min_free_bytes = uint64_t{1} << 60;
  store_ = *OpenStore(options);
  EXPECT_NE(Tried("").problem.find("MiB free"), std::string::npos);
}

TEST_F(RestoreDrillTest, IsDueOnceAWeekAndAgainTheDayAfterOneThatFailed) {
  Tried(R"(echo '{"problem":"a key is missing"}'; exit 1)");
  AuditFilter begun;
  begun.action = kDrillStarted;
  const auto begun_so_far = [&] { return store_->audit.FindAudit(begun)->size(); };
  const auto run = Made();
  // A backup of the page is begun after many looks at whether a drill is due.
  Program("exit 1");
  ASSERT_TRUE(StartOf(*run).ok());
  Problem(*run);
  EXPECT_EQ(begun_so_far(), 1u);
}

TEST_F(BackupRunTest, NeedsAFolderThatIsThere) {
  fs::remove(place_.folder);
  EXPECT_NE(StartOf(*Made()).message().find("does not exist; mount its disk"), std::string::npos);
  EXPECT_FALSE(fs::exists(place_.folder)) << "a disk may belong there";
  place_.folder.clear();
  const Status none = StartOf(*Made());
  EXPECT_EQ(none.code(), Code::kConflict);
  EXPECT_NE(none.message().find("no folder for backups is set"), std::string::npos);
}

}  // namespace
}  // namespace enamel::server
