#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "server/live/station_board.h"
#include "server/storage/store_engine.h"
#include "tests/server/http/running_server.h"
#include "tests/support/becomes.h"

// The health figures that operators get.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

class HealthTest : public testing::Test {
 protected:
  json::value Health() {
    RawResponse answer = root_.Get("/api/v1/health");
    EXPECT_EQ(answer.status, 200) << answer.body;
    return Parsed(answer);
  }

  HttpOptions Options(StationBoard& board) const {
    HttpOptions out;
    out.stations = &board;
    out.backups.folder = school_.folder.path() / "backups";
    out.backups.program = school_.folder.path() / "backup";
    return out;
  }

  inline static const Actor kBy{{}, "test"};
  School school_;
  StationBoard board_;
  RunningServer server_{school_, Options(board_)};
  Visitor root_{server_.port(), "root"};
};

TEST_F(HealthTest, FiguresAreThoseOfTheStore) {
  const json::value health = Health();
  EXPECT_EQ(health.at("ingest").at("takes_recordings"), true);
  EXPECT_EQ(health.at("ingest").at("sealed"), 2) << "sam's and tom's attempts";
  EXPECT_GT(health.at("commits").at("count").to_number<int64_t>(), 0);
  EXPECT_EQ(health.at("commits").at("timed"), health.at("commits").at("count"));
  EXPECT_GT(health.at("commits").at("p99_s").to_number<double>(), 0);
  EXPECT_GT(health.at("disk").at("database_bytes").to_number<int64_t>(), 0);
  EXPECT_EQ(health.at("sign_ins").at("signed_in"), 1);
  EXPECT_EQ(health.at("jobs").at("queued"), 2) << "nobody runs them here";
  EXPECT_LE(health.at("started_ms").to_number<int64_t>(), health.at("now_ms").to_number<int64_t>());
}

TEST_F(HealthTest, StationIsOnlineWhileItIsConnected) {
  EXPECT_EQ(Health().at("stations").at("enrolled"), 1);
  EXPECT_EQ(Health().at("stations").at("online"), 0);
  auto connection = board_.Enter(school_.station);
  EXPECT_EQ(Health().at("stations").at("online"), 1);
  connection.reset();
  EXPECT_EQ(Health().at("stations").at("online"), 0);
}

TEST_F(HealthTest, AttemptOfWhichNothingComesIsLateUntilItIsGivenUp) {
  EXPECT_EQ(Health().at("recordings").at("open"), 1);
  EXPECT_TRUE(Health().at("recordings").at("late").as_array().empty());
  const Uuid silent = school_.RecordingAttempt(
      school_.sue, [&](AttemptRow& row) { row.ticketed_ms = school_.now_ms - 5 * 60'000; });
  school_.RecordingAttempt(
      school_.tom, [&](AttemptRow& row) { row.ticketed_ms = school_.now_ms - 25ll * 60 * 60'000; });
  const json::value recordings = Health().at("recordings");
  EXPECT_EQ(recordings.at("open"), 2) << "what was silent for a day is counted no more";
  ASSERT_EQ(recordings.at("late").as_array().size(), 1u);
  EXPECT_EQ(recordings.at("late").at(0).at("attempt_id").as_string(), silent.Text().c_str());
}

// Data that one party sends, or a wrong statement of the program, must not count as a fault of the database.
TEST_F(HealthTest, OnlyAFaultOfTheStoreItselfIsTheDatabasesProblem) {
  const auto write = [&](const char* sql) {
    return school_.store->engine->rows.Write([&](Db& db) { return Query(db, sql).Run(); }).code();
  };
  const auto problem = [&] {
    const json::value ingest = Health().at("ingest");
    const std::string words(ingest.at("problem").as_string());
    EXPECT_EQ(ingest.at("takes_recordings"), words.empty());
    return words;
  };
  ASSERT_EQ(write("INSERT INTO tenants (tenant, name) VALUES (?1 + 1, hex(zeroblob(2000000000)))"),
            Code::kInvalidInput);
  EXPECT_EQ(problem(), "") << "refused data";
  ASSERT_EQ(write("INSERT INTO nowhere VALUES (?1)"), Code::kInternal);
  EXPECT_EQ(problem(), "") << "a fault of the program";
  school_.before_write = [] { return true; };
  ASSERT_EQ(write("UPDATE tenants SET name = name WHERE tenant = ?1"), Code::kStorage);
  EXPECT_NE(problem().find("could not be written to the database; the server's log says why"),
            std::string::npos);
  EXPECT_EQ(root_.Get("/readyz").status, 503);
  school_.before_write = {};
  ASSERT_EQ(write("UPDATE tenants SET name = name WHERE tenant = ?1"), Code::kOk);
  EXPECT_EQ(problem(), "");
}

TEST_F(HealthTest, LastBackupAndRulesAreTold) {
  EXPECT_TRUE(Health().at("backup").is_null());
  EXPECT_TRUE(Health().at("retention").as_array().empty());
  ASSERT_TRUE(
      school_.store->audit.NoteAudit(kBy, "store.backup", "/b/1", R"({"missing":0,"bytes":5})")
          .ok());
  ASSERT_TRUE(
      school_.store->audit.NoteAudit(kBy, "store.backup", "/b/2", R"({"missing":2,"bytes":7})")
          .ok());
  ASSERT_TRUE(school_.store->retention.SetRetention({"recordings", 730}, kBy).ok());
  EXPECT_TRUE(Health().at("backups").at("drill").is_null());
  ASSERT_TRUE(school_.store->audit.NoteAudit(kBy, "store.drill", "/b/1", "{}").ok());
  EXPECT_EQ(Health().at("backups").at("drill").at("problem"), "");
  ASSERT_TRUE(
      school_.store->audit.NoteAudit(kBy, "store.drill_failed", "/b/2", R"({"problem":"no key"})")
          .ok());
  const json::value health = Health();
  EXPECT_EQ(health.at("backups").at("drill").at("place"), "/b/2");
  EXPECT_EQ(health.at("backups").at("drill").at("problem"), "no key");
  EXPECT_EQ(health.at("backup").at("missing"), 2) << "of the newest";
  EXPECT_EQ(health.at("backup").at("place"), "/b/2");
  EXPECT_EQ(health.at("backup").at("bytes"), 7);
  EXPECT_GT(health.at("backup").at("at_ms").to_number<int64_t>(), 0);
  ASSERT_EQ(health.at("retention").as_array().size(), 1u);
  EXPECT_EQ(health.at("retention").at(0).at("what"), "recordings");
  EXPECT_EQ(health.at("retention").at(0).at("days"), 730);
}

// The process is a script here.
TEST_F(HealthTest, AdminStartsABackupAndSeesWhyItFailed) {
  const auto refused = root_.Post("/api/v1/backups");
  EXPECT_EQ(refused.status, 409);
  EXPECT_NE(refused.body.find("does not exist; mount its disk"), std::string::npos) << refused.body;
  std::filesystem::create_directory(school_.folder.path() / "backups");
  school_.folder.Write("backup",
                       "#!/bin/sh\necho '{\"phase\":\"blobs\",\"done\":1,\"all\":2}'\n"
                       "read unused <\"$0.fifo\"\necho '{\"problem\":\"no room\"}'\nexit 1\n");
  std::filesystem::permissions(school_.folder.path() / "backup", std::filesystem::perms::owner_all);
  const std::string fifo = (school_.folder.path() / "backup.fifo").string();
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const auto started = root_.Post("/api/v1/backups");
  ASSERT_EQ(started.status, 202) << started.body;
  EXPECT_EQ(Parsed(started).at("running").at("here"), true);
  ASSERT_TRUE(
      test::Becomes([&] { return Health().at("backups").at("running").at("phase") == "blobs"; }));
  EXPECT_EQ(root_.Post("/api/v1/backups").status, 409);
  std::ofstream(fifo) << "go\n";
  ASSERT_TRUE(test::Becomes([&] { return Health().at("backups").at("running").is_null(); }));
  EXPECT_EQ(Health().at("backups").at("failed").at("problem"), "no room");
  EXPECT_TRUE(Health().at("backup").is_null());
  for (const char* action : {"store.backup_start", "store.backup_failed"}) {
    AuditFilter asked;
    asked.action = action;
    asked.actor = school_.root;
    EXPECT_EQ(school_.store->audit.FindAudit(asked)->size(), 1u) << action;
  }
}

}  // namespace
}  // namespace enamel::server::http
