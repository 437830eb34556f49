#include "server/app/peers.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "server/app/data_folder.h"
#include "server/app/school.h"
#include "server/jobs/backup_run.h"
#include "server/stations/station_server.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/query.h"
#include "server/storage/open_store.h"
#include "server/storage/store_engine.h"
#include "tests/support/becomes.h"
#include "tests/support/postgres_proxy.h"
#include "tests/support/temp_folder.h"

// Two servers of one school, each with its own way to the database: whose trouble is it?
namespace enamel::server::app {
namespace {

using namespace std::chrono_literals;
using test::PostgresProxy;

class PgPeersTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* server = std::getenv("ENAMEL_POSTGRES");
    if (server == nullptr) GTEST_SKIP() << "ENAMEL_POSTGRES names no server";
    way_.emplace(server);
    way_of_other_.emplace(server);
    server_ = server;
    here_ = Open(folder_, way_->server());
    for (const char* name : {"station.crt", "station.key", "ticket.key"}) {
      std::filesystem::copy_file(folder_.path() / name, folder_of_other_.path() / name);
    }
    auto other = Open(folder_of_other_, way_of_other_->server());
    other_ = std::make_unique<School>(std::move(other), identity_, SchoolOptions{.job_threads = 0});
    Store& store = other_->store();
    other_->services().measure = [&store] { return MeasuredBy(store); };
    stations::StationServerOptions options;
    options.port = 0;
    options.certificate = identity_.certificate;
    options.private_key = identity_.private_key;
    link_.emplace(io_, options, other_->services(), pool_);
    const auto port = link_->Start();
    ASSERT_TRUE(port.ok()) << port.status().message();
    port_ = *port;
    thread_ = std::jthread([this] { io_.run(); });
    store.look.ListenAt("127.0.0.1", port_);
    ASSERT_TRUE(store.look.Beat().ok());
    ASSERT_TRUE(here_->look.Beat().ok());
  }
  void TearDown() override {
    if (server_.empty()) return;
    Hang(*way_, false);
    Hang(*way_of_other_, false);
    if (link_) link_->Stop();
    if (thread_.joinable()) thread_.join();
    link_.reset();
    other_.reset();
    here_.reset();
    auto db = OpenPgDatabase(server_, {}, /*read_only=*/false, {});
    EXPECT_TRUE(db.ok() && (*db)->Exec("DROP SCHEMA peers CASCADE").ok());
  }
  std::unique_ptr<Store> Open(const test::TempFolder& folder, const std::string& server) {
    PostgresOptions options;
    options.server = server;
    options.schema = "peers";
    options.folder.folder = folder.path();
    options.folder.hold_lock = true;
    auto store = OpenPostgresStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    auto identity = EnsureMatchingIdentity(folder.path(), (*store)->identity);
    EXPECT_TRUE(identity.ok()) << identity.status().message();
    identity_ = *identity;
    return std::move(store).value();
  }
  // Refusing beside hanging: nobody waits for the check.
  static void Hang(PostgresProxy& way, bool on = true) {
    way.Refuse(on);
    way.Hang(on);
  }

  test::TempFolder folder_, folder_of_other_;
  std::optional<PostgresProxy> way_, way_of_other_;
  std::string server_;
  ServerIdentity identity_;
  std::unique_ptr<Store> here_;
  std::unique_ptr<School> other_;
  boost::asio::io_context io_;
  StorePool pool_{2};
  std::optional<stations::StationServer> link_;
  uint16_t port_ = 0;
  std::jthread thread_;
};

TEST_F(PgPeersTest, ADatabaseThatHangsForAllIsToldFromOneThatHangsHere) {
  Peers peers(*here_, identity_.fingerprint, 20ms);
  EXPECT_FALSE(peers.view()) << "nobody is asked while all is well";
  Hang(*way_of_other_);
  Hang(*way_);
  EXPECT_FALSE(here_->look.Beat().ok());
  EXPECT_FALSE(other_->store().look.Beat().ok());
  ASSERT_TRUE(test::Becomes([&] {
    const auto view = peers.view();
    return view && view->answered == 1 && view->database == 1;
  })) << "its last heartbeat is older than the trouble";
  Hang(*way_of_other_, false);
  ASSERT_TRUE(test::Becomes([&] {
    const auto view = peers.view();
    return other_->store().look.Beat().ok() && view && view->answered == 1 && view->database == 0;
  })) << "it has committed one since";
  Hang(*way_, false);
  ASSERT_TRUE(test::Becomes([&] { return here_->look.Beat().ok() && !peers.view(); }));
}

TEST_F(PgPeersTest, AnAddressAtWhichAnotherServerAnswersDoesNotCount) {
  auto db = OpenPgDatabase(server_, "peers", /*read_only=*/false, {});
  ASSERT_TRUE(db.ok());
  Query q(**db, "UPDATE write_probe SET server = ?2 WHERE tenant = ?1 AND port = ?3");
  ASSERT_TRUE(q.Bind(Uuid::New()).Bind(int64_t{port_}).Run().ok());
  ASSERT_TRUE(here_->look.Beat().ok());
  ASSERT_EQ(here_->look.peers().size(), 1u);
  Hang(*way_);
  EXPECT_FALSE(here_->look.Beat().ok());
  Peers peers(*here_, identity_.fingerprint, 20ms);
  ASSERT_TRUE(test::Becomes([&] { return peers.view().has_value(); }));
  EXPECT_EQ(peers.view()->asked, 1u);
  EXPECT_EQ(peers.view()->answered, 0u);
}

TEST_F(PgPeersTest, ABackupOfAnotherServerIsSeenHereAndKeepsASecondOut) {
  BackupRun run(*here_);
  run.Into({.folder = folder_.path()});
  {
    const auto others = other_->store().engine->rewriter.TakeUpkeep();
    ASSERT_TRUE(others.ok()) << others.status().message();
    const Actor by{{}, "page"};
    ASSERT_TRUE(other_->store().audit.NoteAudit(by, kBackupStarted, "/b/1", "{}").ok());
    const auto now = run.Look();
    ASSERT_TRUE(now->running);
    EXPECT_FALSE(now->running->here);
    const Status refused = run.Start(by);
    EXPECT_EQ(refused.code(), Code::kConflict);
    EXPECT_NE(refused.message().find("another server of this school makes a backup"),
              std::string::npos)
        << refused.message();
  }
  ASSERT_TRUE(run.Look()->failed) << "it was not finished, and nobody is at it";
}

}  // namespace
}  // namespace enamel::server::app
