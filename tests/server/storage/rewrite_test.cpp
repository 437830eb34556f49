#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <future>
#include <thread>

#include "tests/server/storage/simulated_disk.h"
#include "tests/server/storage/store_world.h"

// After an erasure the database is written anew, which takes as long as the database is large: who
// writes meanwhile waits and is not refused, in this process and beside it.
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
    disk_.SetBeforeWrite([this](const std::string& path) { Hold(path); });
    server_ = Open(true, 10s);
    beside_ = Open(false, kBusyWait);
    gone_ = AddPerson(*server_, "gone", Role::kStudent);
  }

  std::filesystem::path Data() const { return folder_.path() / "data"; }
  std::filesystem::path Mark() const { return Data() / "REWRITE"; }

  std::unique_ptr<Store> Open(bool as_server, std::chrono::milliseconds busy_wait) {
    SqliteOptions options;
    options.folder = Data();
    options.hold_lock = as_server;
    options.busy_wait = busy_wait;
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
  void Hold(const std::string& path) {
    if (!holds_ || !path.ends_with("-wal") || beside_->PersonById(gone_).ok()) return;
    holds_ = false;
    held_.set_value();
    (void)released_.wait_for(kEnough);
  }

  static Status Add(Store& store, const std::string& login) {
    Person person;
    person.login = login;
    person.display_name = login;
    return store.CreatePerson(person, "none", {}, kSystem).status();
  }

  TempFolder folder_;
  SimulatedDisk disk_{folder_.path()};
  std::unique_ptr<Store> server_, beside_;
  Uuid gone_;
  std::atomic<bool> holds_{false};
  std::promise<void> held_, release_;
  std::future<void> released_ = release_.get_future();
};

TEST_F(RewriteTest, NobodyIsRefusedHoweverLongItTakes) {
  holds_ = true;
  auto erasure = std::async([&] { return server_->ErasePerson(gone_, false, kSystem); });
  ASSERT_EQ(held_.get_future().wait_for(kEnough), std::future_status::ready);
  auto here = std::async([&] { return Add(*server_, "here"); });
  auto beside = std::async([&] { return Add(*beside_, "beside"); });
  auto until = std::chrono::steady_clock::now() + kEnough;
  while (beside_->Health().waiting.empty() && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_FALSE(beside_->Health().waiting.empty()) << "it has waited for longer than it does else";
  StoreHealth health = server_->Health();
  EXPECT_NE(health.waiting.find("erased"), std::string::npos) << health.waiting;
  EXPECT_TRUE(health.takes_recordings);
  EXPECT_EQ(here.wait_for(0s), std::future_status::timeout);
  EXPECT_EQ(beside.wait_for(0s), std::future_status::timeout);
  release_.set_value();
  Status in_here = here.get(), next_to_it = beside.get();
  EXPECT_TRUE(in_here.ok()) << in_here.message();
  EXPECT_TRUE(next_to_it.ok()) << next_to_it.message();
  auto report = erasure.get();
  EXPECT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(server_->PersonByLogin("beside").ok());
  EXPECT_EQ(server_->Health().waiting + beside_->Health().waiting, "");
  EXPECT_FALSE(std::filesystem::exists(Mark()));
}

TEST_F(RewriteTest, OtherProgramsThatKeepTheDatabaseAreWaitedForNoLongerThanUsual) {
  Other writer(Data(), "BEGIN IMMEDIATE");
  EXPECT_EQ(Add(*beside_, "late").code(), Code::kUnavailable);
  EXPECT_EQ(beside_->Health().waiting, "");
}

// Of a program that reads for long, as verify does, the pages that it reads stay in the log.
TEST_F(RewriteTest, IsFinishedWithTheRulesOfRetentionWhenAReaderKeepsTheOldPages) {
  server_.reset();
  server_ = Open(true, kBusyWait);
  {
    Other reader(Data(), "BEGIN; SELECT count(*) FROM people");
    auto report = server_->ErasePerson(gone_, false, kSystem);
    EXPECT_TRUE(report.ok()) << report.status().message();
    EXPECT_EQ(server_->PersonById(gone_).status().code(), Code::kNotFound);
    EXPECT_TRUE(std::filesystem::exists(Mark()));
    EXPECT_TRUE(Add(*server_, "next").ok());
  }
  auto applied = server_->ApplyRetention(1, false, kSystem);
  EXPECT_TRUE(applied.ok()) << applied.status().message();
  EXPECT_FALSE(std::filesystem::exists(Mark()));
}

}  // namespace
}  // namespace enamel::server
