#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <future>
#include <thread>

#include "server/storage/folder/folder_lock.h"
#include "tests/server/storage/simulated_disk.h"
#include "tests/server/storage/store_world.h"

// After an erasure the database is rewritten, which takes longer for a larger database. Meanwhile
// changes wait and are not refused, in this process and beside it.
namespace enamel::server {
namespace {

using namespace testing;
using namespace std::chrono_literals;

constexpr auto kEnough = 120s;    // for anything that is going to happen at all
constexpr auto kBusyWait = 20ms;  // of a store that a rewrite is to outlast

// A connection of another program's.
class Other {
 public:
  Other(const std::filesystem::path& folder, const char* sql) {
    EXPECT_EQ(sqlite3_open((folder / "enamel.db").c_str(), &handle_), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(handle_);
  }
  ~Other() { sqlite3_close(handle_); }
  Other(const Other&) = delete;
  Other& operator=(const Other&) = delete;

 private:
  sqlite3* handle_ = nullptr;
};

class RewriteTest : public ::testing::Test {
 protected:
  RewriteTest() {
    disk_.SetBeforeWrite([this](const std::string& path) { LookAt(path); });
    server_ = Open(true, kBusyWait);
    beside_ = Open(false, kBusyWait);
    gone_ = AddPerson(*server_, "gone", Role::kStudent);
  }

  std::filesystem::path Data() const { return folder_.path() / "data"; }
  std::filesystem::path Mark() const { return Data() / "REWRITE"; }

  std::unique_ptr<Store> Open(bool as_server, std::chrono::milliseconds busy_wait,
                              uint64_t min_free_bytes = 0) {
    StoreOptions options;
    options.folder = Data();
    options.hold_lock = as_server;
    options.busy_wait = busy_wait;
    options.min_free_bytes = min_free_bytes;
    options.free_space_check = 0ms;
    if (as_server) {
      options.vfs = disk_.vfs();
      options.disk = &disk_;
    }
    auto store = OpenSqliteStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }

  // The log's first write after the person is deleted for good is the new database's, under the
  // lock for writing.
  void LookAt(const std::string& path) {
    if (!armed_ || !path.ends_with("-wal")) return;
    if (beside_->people.PersonById(gone_).status().code() != Code::kNotFound) return;
    armed_ = false;
    in_the_middle_();
  }
  void InTheMiddle(std::function<void()> what) {
    in_the_middle_ = std::move(what);
    armed_ = true;
  }
  Result<ErasureReport> Erase() { return server_->erasures.ErasePerson(gone_, false, kSystem); }
  using Erasure = std::future<Result<ErasureReport>>;
  // Returns in the middle of the rewrite, which continues after release_.
  Erasure EraseAndHold() {
    server_.reset();
    // It empties the log while others write: that may take as long as it likes.
    server_ = Open(true, kEnough);
    InTheMiddle([this] {
      held_.set_value();
      (void)released_.wait_for(kEnough);
    });
    Erasure erasure = std::async([this] { return Erase(); });
    EXPECT_EQ(held_.get_future().wait_for(kEnough), std::future_status::ready);
    return erasure;
  }
  void ExpectFinished(Erasure& erasure) {
    const auto report = erasure.get();
    ASSERT_TRUE(report.ok()) << report.status().message();
    EXPECT_TRUE(report->finished);
    EXPECT_EQ(server_->health.Health().waiting + beside_->health.Health().waiting, "");
    EXPECT_FALSE(std::filesystem::exists(Mark()));
  }
  // The mark of a crash, or of an unfinished erasure.
  void LeaveMark() const { std::ofstream(Mark()).close(); }
  static bool IsWaitedFor(Store& store) {
    auto until = std::chrono::steady_clock::now() + kEnough;
    while (store.health.Health().waiting.empty() && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(1ms);
    }
    return !store.health.Health().waiting.empty();
  }

  static Status Add(Store& store, const std::string& login) {
    Person person;
    person.login = login;
    person.display_name = login;
    return store.people.CreatePerson(person, "none", {}, kSystem).status();
  }

  TempFolder folder_;
  SimulatedDisk disk_{folder_.path()};
  std::unique_ptr<Store> server_, beside_;
  Uuid gone_;
  std::atomic<bool> armed_{false};
  std::function<void()> in_the_middle_;
  std::promise<void> held_, release_;
  std::future<void> released_ = release_.get_future();
};

// One at a time: whoever writes after the rewrite has only the usual patience with the other.
TEST_F(RewriteTest, WriterOfTheSameServerIsNotRefusedHoweverLongItTakes) {
  auto erasure = EraseAndHold();
  auto here = std::async([&] { return Add(*server_, "here"); });
  EXPECT_EQ(here.wait_for(2 * kBusyWait), std::future_status::timeout);
  const StoreHealth health = server_->health.Health();
  EXPECT_NE(health.waiting.find("erased"), std::string::npos) << health.waiting;
  EXPECT_TRUE(health.takes_recordings);
  release_.set_value();
  const Status added = here.get();
  EXPECT_TRUE(added.ok()) << added.message();
  ExpectFinished(erasure);
}

TEST_F(RewriteTest, WriterBesideItIsNotRefusedHoweverLongItTakes) {
  auto erasure = EraseAndHold();
  auto beside = std::async([&] { return Add(*beside_, "beside"); });
  EXPECT_TRUE(IsWaitedFor(*beside_));
  EXPECT_EQ(beside.wait_for(2 * kBusyWait), std::future_status::timeout);
  release_.set_value();
  const Status added = beside.get();
  EXPECT_TRUE(added.ok()) << added.message();
  ExpectFinished(erasure);
  EXPECT_TRUE(server_->people.PersonByLogin("beside").ok());
}

TEST_F(RewriteTest, OtherProgramsThatKeepTheDatabaseAreWaitedForNoLongerThanUsual) {
  Other writer(Data(), "BEGIN IMMEDIATE");
  EXPECT_EQ(Add(*beside_, "late").code(), Code::kUnavailable);
  LeaveMark();
  EXPECT_EQ(Add(*beside_, "later").code(), Code::kUnavailable) << "a mark alone is no erasure";
  EXPECT_EQ(beside_->health.Health().waiting, "");
}

TEST_F(RewriteTest, StartWaitsNeitherForAnotherProgramNorForWhatIsLeftToRewrite) {
  server_.reset();
  LeaveMark();
  {
    Other writer(Data(), "BEGIN IMMEDIATE");
    server_ = Open(true, kBusyWait);
    EXPECT_TRUE(server_->people.PersonById(gone_).ok());
    EXPECT_EQ(server_->jobs.LeaseJob(1, 1).status().code(), Code::kUnavailable);
  }
  EXPECT_TRUE(server_->jobs.LeaseJob(1, 1).ok());
  EXPECT_TRUE(std::filesystem::exists(Mark()));
  Status finished = server_->erasures.FinishErasures();
  EXPECT_TRUE(finished.ok()) << finished.message();
  EXPECT_FALSE(std::filesystem::exists(Mark()));
}

TEST_F(RewriteTest, OnceStoppingNobodyWaitsForAnErasureBeside) {
  Other writer(Data(), "BEGIN IMMEDIATE");
  LeaveMark();
  auto erases = TakeUpkeepLock(Data(), FolderLock::Mode::kExclusive);
  ASSERT_TRUE(erases.ok()) << erases.status().message();
  auto waits = std::async([&] { return Add(*server_, "here"); });
  ASSERT_TRUE(IsWaitedFor(*server_));
  auto touch = std::async([&] { return server_->sessions.TouchSession({}, 1); });
  EXPECT_EQ(touch.wait_for(kEnough), std::future_status::ready) << "who reads is not kept waiting";
  server_->StopWaiting();
  ASSERT_EQ(waits.wait_for(kEnough), std::future_status::ready);
  EXPECT_EQ(waits.get().code(), Code::kUnavailable);
  EXPECT_EQ(server_->erasures.FinishErasures().code(), Code::kUnavailable);
}

TEST_F(RewriteTest, StopInTheMiddleLeavesTheRestToTheNextStart) {
  InTheMiddle([this] { server_->StopWaiting(); });
  auto report = Erase();
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_FALSE(report->finished);
  EXPECT_EQ(server_->people.PersonById(gone_).status().code(), Code::kNotFound);
  EXPECT_TRUE(std::filesystem::exists(Mark()));
  server_.reset();
  server_ = Open(true, kBusyWait);
  EXPECT_TRUE(server_->erasures.FinishErasures().ok());
  EXPECT_FALSE(std::filesystem::exists(Mark()));
}

TEST_F(RewriteTest, IsLeftForLaterWhereThereIsNoRoomForTwoMoreDatabases) {
  constexpr uint64_t kKeptFree = 16 << 20;
  server_.reset();
  server_ = Open(true, kBusyWait, kKeptFree);
  const uint64_t size = std::filesystem::file_size(Data() / "enamel.db") +
                        std::filesystem::file_size(Data() / "enamel.db-wal");
  disk_.SetFree(kKeptFree + size);
  auto report = Erase();
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_FALSE(report->finished);
  EXPECT_EQ(server_->people.PersonById(gone_).status().code(), Code::kNotFound);
  EXPECT_TRUE(std::filesystem::exists(Mark()));
  EXPECT_EQ(server_->erasures.FinishErasures().code(), Code::kStorage);
  EXPECT_TRUE(server_->health.Health().takes_recordings) << server_->health.Health().problem;
  disk_.SetFree(kKeptFree + 3 * size);
  Status finished = server_->erasures.FinishErasures();
  EXPECT_TRUE(finished.ok()) << finished.message();
  EXPECT_FALSE(std::filesystem::exists(Mark()));
}

TEST_F(RewriteTest, DiskThatFillsUpAllTheSameHasItsRoomBack) {
  // The last connection to close empties the log: from now on it has only the rewrite.
  beside_.reset();
  server_.reset();
  server_ = Open(true, kBusyWait);
  beside_ = Open(false, kBusyWait);
  InTheMiddle([this] { disk_.SetFree(64 << 10); });
  auto report = Erase();
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_FALSE(report->finished);
  EXPECT_TRUE(std::filesystem::exists(Mark()));
  EXPECT_EQ(std::filesystem::file_size(Data() / "enamel.db-wal"), 0u);
  EXPECT_TRUE(Add(*server_, "next").ok());
  EXPECT_TRUE(server_->health.Health().takes_recordings) << server_->health.Health().problem;
  EXPECT_TRUE(server_->people.PersonByLogin("next").ok());
}

// They are what makes room.
TEST_F(RewriteTest, RulesOfRetentionApplyAlsoWhereThereIsNoRoomForIt) {
  World world(*server_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(server_->retention.SetRetention({"unfinished", 14}, kSystem).ok());
  LeaveMark();
  disk_.SetFree(200'000);
  constexpr UnixMs kMuchLater = 1'000ll * 24 * 60 * 60 * 1000;
  auto applied = server_->retention.ApplyRetention(kMuchLater, false, kSystem);
  ASSERT_TRUE(applied.ok()) << applied.status().message();
  EXPECT_EQ(applied->unfinished.size(), 1u);
  EXPECT_FALSE(server_->attempts.AttemptById(attempt).ok());
  EXPECT_TRUE(std::filesystem::exists(Mark()));
}

// Of a program that reads for long, as verify does, the pages that it reads stay in the log.
TEST_F(RewriteTest, IsFinishedWithTheRulesOfRetentionWhenAReaderKeepsTheOldPages) {
  {
    Other reader(Data(), "BEGIN; SELECT count(*) FROM people");
    auto report = Erase();
    ASSERT_TRUE(report.ok()) << report.status().message();
    EXPECT_FALSE(report->finished);
    EXPECT_EQ(server_->people.PersonById(gone_).status().code(), Code::kNotFound);
    EXPECT_TRUE(std::filesystem::exists(Mark()));
    EXPECT_TRUE(Add(*server_, "next").ok());
  }
  auto applied = server_->retention.ApplyRetention(1, false, kSystem);
  EXPECT_TRUE(applied.ok()) << applied.status().message();
  EXPECT_FALSE(std::filesystem::exists(Mark()));
}

}  // namespace
}  // namespace enamel::server
