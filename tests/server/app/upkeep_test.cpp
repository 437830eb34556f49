#include "server/commands/upkeep.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

#include <boost/json.hpp>
#include <cstdlib>
#include <thread>

#include "common/base/file.h"
#include "server/app/caretaker.h"
#include "server/commands/personal_data.h"
#include "server/jobs/backup_run.h"
#include "server/results/result_files.h"
#include "server/storage/engine/lease.h"
#include "server/storage/open_store.h"
#include "server/storage/store_engine.h"
#include "tests/server/storage/recorded_attempt.h"
#include "tests/server/storage/simulated_disk.h"
#include "tests/support/becomes.h"

// The commands that keep, copy, export and erase data: their output and refusals.
namespace enamel::server::app {
namespace {

using namespace server::testing;
namespace fs = std::filesystem;
namespace json = boost::json;

class UpkeepTest : public ::testing::Test {
 protected:
  fs::path Path(const char* name) const { return folder_.path() / name; }
  // Runs the command and returns its output.
  template <typename Command>
  std::string Said(const Command& command, Status& status) {
    ::testing::internal::CaptureStdout();
    status = command();
    return ::testing::internal::GetCapturedStdout();
  }
  json::object Json(const char* name) const {
    return json::parse(AsText(*ReadFile(Path(name)))).as_object();
  }

  TempFolder folder_;
  RecordedSchool school_{Path("data")};
};

TEST_F(UpkeepTest, BackupRestoreAndVerifyAgreeInWordsAndNumbers) {
  school_.Score(school_.Record(2));
  Status status;
  std::string said = Said(
      [&] {
        return Backup({Path("data"), Path("backup"), {}, Path("b.json"), false});
      },
      status);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_NE(said.find("1 attempt, 500 ticks"), std::string::npos) << said;
  EXPECT_EQ(Json("b.json").at("ticks").to_number<int>(), 500);
  EXPECT_EQ(school_.store->audit.Audit(1)->front().action, "store.backup");

  said = Said([&] { return VerifyFolder({Path("backup"), {}, Path("v.json")}); }, status);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_NE(said.find("everything agrees"), std::string::npos) << said;
  EXPECT_TRUE(Json("v.json").at("ok").as_bool());

  said = Said(
      [&] {
        return RestoreBackup({Path("backup"), Path("new"), Path("r.json"), {}, false});
      },
      status);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_NE(said.find("everything agrees"), std::string::npos) << said;
  EXPECT_EQ(Json("r.json").at("verified").at("ticks").to_number<int>(), 500);
}

TEST_F(UpkeepTest, BackupThatTheServerStartsIsWholeAndNotedOnce) {
  school_.Score(school_.Record(2));
  fs::create_directory(Path("backups"));
  BackupRun run(*school_.store);
  run.Into({.folder = Path("backups"), .program = ENAMEL_SERVER_PROGRAM});
  ASSERT_TRUE(run.Start(kSystem).ok());
  ASSERT_TRUE(test::Becomes([&] { return !run.Look()->running; }));
  ASSERT_FALSE(run.Look()->failed) << run.Look()->failed->problem;
  AuditFilter made;
  made.action = kBackupMade;
  const auto rows = *school_.store->audit.FindAudit(made);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(json::parse(rows[0].after_json).at("missing"), 0);
  Status status;
  const std::string said = Said([&] { return VerifyFolder({.newest = Path("backups")}); }, status);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_NE(said.find(rows[0].object), std::string::npos) << said;
  // And it can be restored.
  BackupRun drills(*school_.store);
  drills.Into({.folder = Path("backups"),
               .program = ENAMEL_SERVER_PROGRAM,
               .look = std::chrono::milliseconds(1)});
  ASSERT_TRUE(test::Becomes([&] { return drills.Look()->drill.has_value(); }));
  EXPECT_EQ(drills.Look()->drill->problem, "");
  EXPECT_EQ(drills.Look()->drill->place, rows[0].object);
  EXPECT_FALSE(fs::exists(Path("data") / "drill"));
}

TEST_F(UpkeepTest, BackupThatFailedIsNotVerified) {
  fs::create_directory(Path("failed"));
  fs::copy_file(Path("data") / "enamel.db", Path("failed") / "enamel.db");
  const Status refused = VerifyFolder({.folder = Path("failed"), .is_backup = true});
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("has no manifest.json"), std::string::npos);
  EXPECT_EQ(VerifyFolder({.newest = folder_.path()}).code(), Code::kNotFound);
}

TEST_F(UpkeepTest, BackupOfTheCommandLineThatFailsIsSeenByTheServer) {
  folder_.Write("full/file", "");
  Status status;
  Said([&] { return Backup({Path("data"), Path("full"), {}, {}, false}); }, status);
  EXPECT_EQ(status.code(), Code::kConflict);
  const auto now = BackupRun(*school_.store).Look();
  ASSERT_TRUE(now->failed);
  EXPECT_EQ(now->failed->problem, status.message());
}

TEST_F(UpkeepTest, VerifyThatFindsSomethingFailsAndNamesIt) {
  Uuid scored = school_.Record(1);
  school_.Score(scored);
  Sha256 series = school_.store->results.ResultOf(scored)->series;
  fs::remove(Path("data") / "blobs" / series.Hex().substr(0, 2) / series.Hex());
  Status status;
  std::string said = Said([&] { return VerifyFolder({Path("data"), {}, Path("v.json")}); }, status);
  EXPECT_EQ(status.code(), Code::kStorage);
  EXPECT_NE(said.find(series.Hex()), std::string::npos) << said;
  auto facts = Json("v.json");
  EXPECT_FALSE(facts.at("ok").as_bool());
  EXPECT_EQ(facts.at("findings").as_array().at(0).at("object").as_string(), series.Hex());
}

TEST_F(UpkeepTest, ExportHasWhatIsKeptAndTheRecordingReads) {
  Uuid scored = school_.Record(2), open = school_.Record(1);
  school_.Score(scored);
  Uuid cohort = *school_.store->cohorts.CreateCohort("year 1", kSystem);
  ASSERT_TRUE(school_.store->cohorts.AddToCohort(cohort, school_.world.student, kSystem).ok());
  Status status;
  Uuid teacher = AddPerson(*school_.store, "teacher", Role::kInstructor);
  const Actor by{teacher, "page"};
  AttemptResult again = *school_.store->results.ResultOf(scored);
  again.score = 71;
  ASSERT_TRUE(school_.store->results.FinishAttempt(scored, again, {}).ok());
  ASSERT_TRUE(
      school_.store->judging.OverrideScore(scored, ScoreOverride{75, "a point more", {}, 0}, by)
          .ok());
  AnnotationRow remark;
  remark.attempt = scored;
  remark.author = teacher;
  remark.text = "well done";
  ASSERT_TRUE(school_.store->remarks.AddAnnotation(remark, by).ok());
  SavedText saved;
  saved.text = "the wall leans";
  saved.shared = true;
  ASSERT_TRUE(school_.store->saved_texts.AddSavedText(saved, by).ok());
  saved.text = "too deep";
  ASSERT_TRUE(
      school_.store->saved_texts.AddSavedText(saved, Actor{school_.world.student, "page"}).ok());
  SessionRow session{HashSha256(AsBytes("token")),
                     school_.store->people.PersonByLogin("student")->id};
  session.expires_ms = 1;
  session.via = "page";
  session.address = "203.0.113.7";
  session.device = "Firefox on Linux";
  ASSERT_TRUE(school_.store->sessions.CreateSession(session).ok());
  Said([&] { return ExportPerson(Path("data"), "student", Path("copy")); }, status);
  ASSERT_TRUE(status.ok()) << status.message();
  auto root = Json("copy/export.json");
  EXPECT_EQ(root.at("person").at("login").as_string(), "student");
  EXPECT_EQ(root.at("cohorts").as_array().at(0).as_string(), "year 1");
  EXPECT_EQ(root.at("sessions").at(0).at("address").as_string(), "203.0.113.7");
  EXPECT_EQ(root.at("sessions").at(0).at("device").as_string(), "Firefox on Linux");
  ASSERT_EQ(root.at("saved_texts").as_array().size(), 1u) << "none that others share";
  EXPECT_EQ(root.at("saved_texts").at(0).at("text").as_string(), "too deep");
  EXPECT_EQ(root.at("saved_texts").at(0).at("shared"), true);
  ASSERT_EQ(root.at("attempts").as_array().size(), 2u);
  for (const json::value& attempt : root.at("attempts").as_array()) {
    // Its tooth is only a text: no surface can be made of it, and all else is there.
    if (const json::value* problems = attempt.as_object().if_contains("problems")) {
      ASSERT_EQ(problems->as_array().size(), 1u);
      EXPECT_EQ(problems->at(0).as_string().find("surface.ensf: "), 0u) << problems->at(0);
    }
    for (const json::value& file : attempt.at("files").as_array())
      EXPECT_TRUE(fs::exists(Path("copy") / std::string(file.as_string())));
  }
  const json::value* told = nullptr;
  for (const json::value& attempt : root.at("attempts").as_array()) {
    if (attempt.at("id").as_string() == scored.Text()) told = &attempt;
  }
  ASSERT_NE(told, nullptr);
  EXPECT_EQ(told->at("override").at("by").as_string(), "Name of teacher");
  EXPECT_EQ(told->at("annotations").at(0).at("by").as_string(), "Name of teacher");
  ASSERT_EQ(told->at("results").as_array().size(), 2u);
  EXPECT_EQ(told->at("results").at(0).at("score").to_number<double>(), 71);
  EXPECT_TRUE(fs::exists(Path("copy") / "attempts" / scored.Text() / "score_1.json"));
  auto trace = ReadFile(Path("copy") / "attempts" / scored.Text() / "recording.entrace");
  ASSERT_TRUE(trace.ok()) << trace.status().message();
  auto file = trace::DecodeTraceFile(*trace);
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ(file->chunks, *AllChunks(school_.store->recordings, scored));
  EXPECT_TRUE(file->seal.has_value());
  EXPECT_EQ(*ReadFile(Path("copy") / "attempts" / scored.Text() / "forces.json"),
            Bytes({'s', 'e', 'r', 'i', 'e', 's'}));
  EXPECT_TRUE(fs::exists(Path("copy") / "attempts" / open.Text() / "recording.entrace"));
  EXPECT_EQ(*ReadFile(Path("copy") / "attempts" / scored.Text() / kResultFile),
            school_.store->results.ResultOf(scored)->document);
  std::string whole(AsText(*ReadFile(Path("copy") / "export.json")));
  EXPECT_EQ(whole.find("verifier"), std::string::npos);
  EXPECT_EQ(school_.store->audit.Audit(1)->front().action, "person.export");
  EXPECT_EQ(ExportPerson(Path("data"), "student", Path("copy")).code(), Code::kConflict);
  EXPECT_EQ(ExportPerson(Path("data"), "nobody", Path("copy2")).code(), Code::kNotFound);
}

TEST_F(UpkeepTest, ErasingWantsTheLoginTwice) {
  EXPECT_EQ(ErasePerson(Path("data"), "student", "students", false).field(), "confirm");
  EXPECT_TRUE(school_.store->people.PersonByLogin("student").ok());
  Status status;
  Said([&] { return ErasePerson(Path("data"), "student", "student", false); }, status);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_FALSE(school_.store->people.PersonByLogin("student").ok());
}

TEST_F(UpkeepTest, RetentionTellsBeforeItDoes) {
  Uuid scored = school_.Record(1);
  school_.Score(scored);
  Status status;
  std::string said = Said([&] { return Retention({Path("data"), "", {}, false}); }, status);
  EXPECT_NE(said.find("kept indefinitely"), std::string::npos);
  said = Said([&] { return Retention({Path("data"), "recordings", 30, false}); }, status);
  EXPECT_NE(said.find("0 recordings"), std::string::npos) << said;
  EXPECT_NE(said.find("1 more is due and kept"), std::string::npos) << "not released: " << said;
  ASSERT_TRUE(school_.store->judging.ReleaseAttempt(scored, Actor{}).ok());
  said = Said([&] { return Retention({Path("data"), "", {}, false}); }, status);
  EXPECT_NE(said.find("would be removed now: 0 unfinished attempts, 1 recording,"),
            std::string::npos)
      << said;
  said = Said([&] { return Retention({Path("data"), "", {}, true}); }, status);
  EXPECT_NE(said.find("removed: 0 unfinished attempts, 1 recording,"), std::string::npos) << said;
  EXPECT_EQ(Retention({Path("data"), "recordings", -4, false}).field(), "days");
}

// The upkeep lease is a database server's: of a file, the folder's lock is enough.
TEST(PgCaretakerTest, AnErasureThatALeaseHoldsUpIsTriedUntilItIsFinished) {
  const char* server = std::getenv("ENAMEL_POSTGRES");
  if (server == nullptr) GTEST_SKIP() << "ENAMEL_POSTGRES names no server";
  TempFolder folder;
  PostgresOptions options{server, "caretaker", {folder.path(), true}};
  auto store = std::move(OpenPostgresStore(options)).value();
  ASSERT_TRUE(store->engine->rewriter.Mark().ok());
  auto other = Lease::Take(std::move(store->engine->rows.OpenWriter()).value(), "upkeep");
  ASSERT_TRUE(other.ok()) << other.status().message();
  ASSERT_EQ(store->erasures.FinishErasures().field(), kLeaseHeld);
  Caretaker::Intervals intervals;
  intervals.health = intervals.held = std::chrono::milliseconds(1);
  Caretaker caretaker(*store, intervals);
  other->reset();
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (*store->engine->rewriter.IsMarked() && std::chrono::steady_clock::now() < until) {
    std::this_thread::yield();
  }
  EXPECT_FALSE(*store->engine->rewriter.IsMarked());
}

// The log reports once that recordings stop and once that they resume.
TEST(CaretakerTest, FullDiskIsLoggedOnceAndSoIsItsEnd) {
  auto said = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(16);
  auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", said));
  {
    TempFolder folder;
    SimulatedDisk disk(folder.path());
    StoreOptions options;
    options.folder = folder.path();
    options.vfs = disk.vfs();
    options.disk = &disk;
    options.min_free_bytes = 1 << 20;
    options.free_space_check = std::chrono::milliseconds(0);
    auto store = std::move(OpenSqliteStore(options)).value();
    Caretaker::Intervals intervals;
    intervals.health = std::chrono::milliseconds(1);
    auto wait_for = [&](const char* text) {
      for (int i = 0; i < 5000; ++i) {
        for (const std::string& line : said->last_formatted()) {
          if (line.find(text) != std::string::npos) return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
      return false;
    };
    disk.SetFree(0);
    Caretaker caretaker(*store, intervals);
    EXPECT_TRUE(wait_for("no recordings are taken"));
    disk.SetFree(std::nullopt);
    EXPECT_TRUE(wait_for("recordings are taken again"));
  }
  spdlog::set_default_logger(before);
  EXPECT_EQ(said->last_formatted().size(), 2u);
}

}  // namespace
}  // namespace enamel::server::app
