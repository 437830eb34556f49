#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <filesystem>

#include "common/base/file.h"
#include "server/storage/engine/verify.h"
#include "tests/server/storage/store_world.h"

// Databases of every earlier schema, kept as SQL dumps in schemas/golden/sql, are brought up to
// date with nothing lost.
namespace enamel::server {
namespace {

using namespace testing;
namespace fs = std::filesystem;

const fs::path kGolden = ENAMEL_SOURCE_DIR "/schemas/golden/sql";

void Load(const fs::path& folder, int schema) {
  auto sql = ReadFile(kGolden / ("schema_" + std::to_string(schema) + ".sql"));
  ASSERT_TRUE(sql.ok()) << sql.status().message() << ": each schema before the newest needs one";
  fs::create_directories(folder);
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "enamel.db").c_str(), &handle), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(handle, std::string(AsText(*sql)).c_str(), nullptr, nullptr, nullptr),
            SQLITE_OK)
      << sqlite3_errmsg(handle);
  sqlite3_close(handle);
}

Uuid Id(int n) {
  char text[40];
  std::snprintf(text, sizeof text, "01890a5d-ac96-774b-bcce-b3020000%04x", n);
  return *Uuid::Parse(text);
}

Sha256 HashOf(const char* text) { return HashSha256(AsBytes(text)); }

class MigrationTest : public ::testing::Test {
 protected:
  void OpenSchema1() {
    ASSERT_NO_FATAL_FAILURE(Load(Data(), 1));
    auto trace = ReadFile(kGolden / "schema_1_trace.bin");
    ASSERT_TRUE(trace.ok());
    std::string name = HashSha256(*trace).Hex();
    fs::create_directories(Data() / "blobs" / name.substr(0, 2));
    ASSERT_TRUE(WriteFileDurably(Data() / "blobs" / name.substr(0, 2) / name, *trace).ok());
    store_ = OpenStore(Data());
  }
  fs::path Data() const { return folder_.path() / "data"; }

  TempFolder folder_;
  std::unique_ptr<Store> store_;
};

TEST_F(MigrationTest, EverySchemaBeforeTheNewestIsBroughtUpToDateAndIsSound) {
  ASSERT_GE(LatestSchemaVersion(), 2);
  for (int schema = 1; schema < LatestSchemaVersion(); ++schema) {
    SCOPED_TRACE("schema " + std::to_string(schema));
    TempFolder folder;
    ASSERT_NO_FATAL_FAILURE(Load(folder.path(), schema));
    ASSERT_TRUE(OpenSqliteStore({folder.path()}).ok());
    auto report = Verify({folder.path(), {}, {}});
    ASSERT_TRUE(report.ok()) << report.status().message();
    EXPECT_EQ(report->schema, LatestSchemaVersion());
    for (const Finding& finding : report->findings) {
      for (const char* kind : {"database", "audit", "decision"})
        EXPECT_NE(finding.kind, kind) << finding.expected << " / " << finding.found;
    }
    EXPECT_GT(report->unsigned_audit, 0u);
    EXPECT_GT(report->decisions, 0u);
  }
}

TEST_F(MigrationTest, PeopleAndThingsOfSchema1AreAllThere) {
  ASSERT_NO_FATAL_FAILURE(OpenSchema1());
  EXPECT_EQ(store_->People()->size(), 4u);
  EXPECT_EQ(store_->PersonByLogin("ada")->role, Role::kInstructor);
  EXPECT_TRUE(store_->PersonByLogin("tom")->disabled);
  EXPECT_EQ(*store_->PasswordVerifier(Id(2)), "$argon2id$v=19$m=8,t=1,p=1$sam");
  EXPECT_EQ(store_->FindSession(HashOf("token"))->person, Id(2));
  EXPECT_TRUE(*store_->ShareCohort(Id(1), Id(2)));
  EXPECT_EQ(store_->Stations()->front().name, "Bench 1");
  EXPECT_TRUE(store_->StationByCredential(Id(20), HashOf("credential")).ok());
  EXPECT_EQ(store_->Profiles()->front().content, HashOf("profile"));
  EXPECT_EQ(store_->Scenes()->front().volume, HashOf("volume"));
  EXPECT_EQ(store_->ExercisesFor(Id(2))->front().version, 2);
  EXPECT_TRUE(store_->ExercisesFor(Id(2))->front().owner.IsZero()) << "the school's";
  EXPECT_TRUE(store_->ExercisesFor(Id(2))->front().shared);
  EXPECT_EQ(store_->ReferenceFor(Id(30))->value().dentist, "Dr. Example");
  EXPECT_EQ(store_->Audit(100)->back().action, "attempt.release");
  EXPECT_TRUE(store_->RetentionRules()->empty());
}

TEST_F(MigrationTest, AssignmentsOfSchema10StayWithTheVersionThatWasTheNewest) {
  ASSERT_NO_FATAL_FAILURE(Load(Data(), 10));
  store_ = OpenStore(Data());
  const std::vector<AssignmentRow> rows = *store_->Assignments({});
  ASSERT_EQ(rows.size(), 2u);
  for (const AssignmentRow& row : rows) {
    EXPECT_EQ(row.version_id, Id(31));
    EXPECT_EQ(row.version, 2);
  }
}

TEST_F(MigrationTest, RecordingsOfSchema1ReadAsTheyWereAndGoOn) {
  ASSERT_NO_FATAL_FAILURE(OpenSchema1());
  EXPECT_EQ(store_->AttemptById(Id(40))->state, AttemptState::kTicketed);
  auto open = store_->AttemptChunks(Id(41));
  ASSERT_TRUE(open.ok()) << open.status().message();
  EXPECT_EQ(AsText(open->at(1)), "second chunk, as the station sent it");
  auto sealed = store_->AttemptChunks(Id(42));
  ASSERT_TRUE(sealed.ok()) << sealed.status().message();
  EXPECT_EQ(AsText(sealed->at(0)), "first chunk, as the station sent it");
  AttemptRow scored = *store_->AttemptById(Id(43));
  EXPECT_EQ(scored.score, 71.5);
  EXPECT_TRUE(scored.critical_fail && scored.released);
  EXPECT_EQ(scored.expired_ms, 0);
  EXPECT_EQ(store_->ResultOf(Id(43))->reference, Id(42));
  EXPECT_EQ(store_->AttemptById(Id(45))->state, AttemptState::kQuarantined);
  EXPECT_EQ(store_->Jobs("queued")->front().error, "disk full");
  EXPECT_TRUE(store_->OpenAttempt(Id(40), AsBytes("header")).ok());
}

TEST_F(MigrationTest, PersonOfSchema1IsErasedWithRecordingsThatHaveNoKey) {
  ASSERT_NO_FATAL_FAILURE(OpenSchema1());
  auto report = store_->ErasePerson(Id(2), false, kSystem);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_EQ(report->attempts, 5u);
  EXPECT_EQ(report->blobs, 0u) << "the trace is another person's too";
  EXPECT_TRUE(store_->AttemptChunks(Id(42)).ok());
  auto other = store_->ErasePerson(Id(1), true, kSystem);
  ASSERT_TRUE(other.ok()) << other.status().message();
  EXPECT_EQ(other->blobs, 1u) << "now it is nobody's";
}

TEST_F(MigrationTest, PersonOfSchema4IsErasedWithTheWordsInTheAuditTrail) {
  ASSERT_NO_FATAL_FAILURE(Load(Data(), 4));
  store_ = OpenStore(Data());
  auto told = [&](const std::string& words) {
    auto rows = *store_->Audit(100);
    return std::ranges::any_of(
        rows, [&](const AuditRow& row) { return row.after_json.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(told("please look again"));
  auto report = store_->ErasePerson(Id(1), true, kSystem);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_FALSE(told("please look again"));
  EXPECT_TRUE(told("year 3")) << "what tells nothing of a person stays";
}

}  // namespace
}  // namespace enamel::server
