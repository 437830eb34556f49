#include "server/storage/audit/actor.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/audit/audit_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/backup/backup.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/folder/disk.h"
#include "server/storage/open_store.h"
#include "server/storage/verify/manifest.h"
#include "tests/server/storage/decided_school.h"

// Rows of the audit trail that are taken away, put in, moved or cut off are found
// (schemas/audit.md).
namespace enamel::server {
namespace {

using namespace testing;

// The school at rest, so that its database is one file that can be put back after each edit.
class VerifyTrailTest : public DecidedSchoolTest {
 protected:
  VerifyTrailTest() {
    ExpectWhole("before anything is changed");
    rows_ = Rows();
    school_.store.reset();
    Keep("kept.db");
  }
  struct Row {
    Uuid id;
    std::string action;
  };
  // In the order of the trail.
  std::vector<Row> Rows() {
    std::vector<Row> out;
    const auto trail = school_.store->audit.Audit(1000);
    for (const AuditRow& row : *trail) out.push_back({row.id, row.action});
    std::ranges::reverse(out);
    return out;
  }
  void Keep(const char* name) {
    fs::copy_file(Data() / "enamel.db", folder_.path() / name,
                  fs::copy_options::overwrite_existing);
  }
  void PutBack(const char* name) {
    fs::remove(Data() / "enamel.db-wal");
    fs::remove(Data() / "enamel.db-shm");
    fs::copy_file(folder_.path() / name, Data() / "enamel.db",
                  fs::copy_options::overwrite_existing);
  }
  static bool FindsTrail(const VerifyReport& report) {
    return std::ranges::any_of(report.findings,
                               [](const Finding& finding) { return finding.kind == "audit"; });
  }
  // In the trail, besides any other findings; restores the database.
  void ExpectTrailEditFound(const std::string& edit) {
    SCOPED_TRACE(edit);
    Sql(without_triggers_ + edit);
    const VerifyReport report = Look();
    EXPECT_TRUE(FindsTrail(report)) << Told(report);
    PutBack("kept.db");
  }
  static std::string Found(const VerifyReport& report, const std::string& object) {
    for (const Finding& finding : report.findings) {
      if (finding.kind == "audit" && finding.object == object) return finding.found;
    }
    return "";
  }
  Result<std::unique_ptr<SqliteDb>> Connect() {
    return OpenDatabase(Data() / "enamel.db", DbMode::kExisting);
  }
  // A row about nothing in a chain of its own, as another server would write it.
  Status WriteIn(const Uuid& chain) {
    ENAMEL_ASSIGN_OR_RETURN(auto db, Connect());
    const AuditSigner signer(school_.ticket_key.secret_key, chain);
    db->SetCompanion(&signer);
    ENAMEL_RETURN_IF_ERROR(db->Begin(sql::Isolation::kSerial));
    ENAMEL_RETURN_IF_ERROR(
        WriteAudit(*db, Actor{{}, "another server"}, "store.backup", "", "{}", "{}"));
    return db->Commit();
  }

  std::vector<Row> rows_;
};

TEST_F(VerifyTrailTest, EachRowThatIsTakenAwayIsFound) {
  ASSERT_GT(rows_.size(), 20u);
  for (const Row& row : rows_) {
    SCOPED_TRACE(row.action);
    ExpectTrailEditFound("DELETE FROM audit WHERE id = " + Id(row.id));
  }
}

TEST_F(VerifyTrailTest, GapNamesTheRowAfterItAndHowManyRowsAreMissing) {
  Sql(without_triggers_ + "DELETE FROM audit WHERE number BETWEEN 5 AND 7");
  EXPECT_EQ(Found(Look(), rows_.at(7).id.Text()), "3 rows taken away, from row 5 on");
}

TEST_F(VerifyTrailTest, EachKindOfRowThatIsChangedInAnyColumnIsFound) {
  std::map<std::string, Uuid> kinds;
  for (const Row& row : rows_) kinds.emplace(row.action, row.id);
  for (const auto& [action, id] : kinds) {
    SCOPED_TRACE(action);
    for (const char* edit :
         {"at_ms = at_ms + 1", "actor = randomblob(16)", "via = 'x'", "action = 'x'",
          "object = 'x'", "before_json = '{\"x\":1}'", "after_json = '{\"x\":1}'",
          "subject = 'device x'", "state = '{}'", "salt = randomblob(32)",
          "content_hash = randomblob(32)", "signature = randomblob(64)", "chain = randomblob(16)",
          "number = number + 1000", "previous = randomblob(32)", "id = randomblob(16)"}) {
      ExpectTrailEditFound("UPDATE audit SET " + std::string(edit) + " WHERE id = " + Id(id));
    }
  }
}

TEST_F(VerifyTrailTest, EachTwoRowsThatChangePlacesAreFound) {
  for (size_t i = 1; i < rows_.size(); ++i) {
    const std::string one = Id(rows_[i - 1].id), two = Id(rows_[i].id);
    ExpectTrailEditFound("UPDATE audit SET id = zeroblob(16) WHERE id = " + one +
                         "; UPDATE audit SET id = " + one + " WHERE id = " + two +
                         "; UPDATE audit SET id = " + two + " WHERE id = zeroblob(16)");
    const std::string a = std::to_string(i), b = std::to_string(i + 1);
    ExpectTrailEditFound("UPDATE audit SET number = 5000 WHERE number = " + a +
                         "; UPDATE audit SET number = " + a + " WHERE number = " + b +
                         "; UPDATE audit SET number = " + b + " WHERE number = 5000");
  }
}

TEST_F(VerifyTrailTest, RowThatIsPutInOrDoubledIsFound) {
  for (const Row& row : rows_) {
    ExpectTrailEditFound(
        "INSERT INTO audit SELECT tenant, x'ff" + std::string(30, '7') +
        "', at_ms, actor, via, action, object, before_json, after_json, subject, state, salt, "
        "content_hash, signature, chain, 5000, previous FROM audit WHERE id = " +
        Id(row.id));
  }
}

TEST_F(VerifyTrailTest, EndThatIsCutOffIsFoundHoweverMuchIsCut) {
  const size_t all = rows_.size();
  for (size_t left = 0; left < all; ++left) {
    const std::string cut = "DELETE FROM audit WHERE number > " + std::to_string(left);
    ExpectTrailEditFound(cut);
    if (left == 0) continue;
    const std::string last = Id(rows_[left - 1].id);
    ExpectTrailEditFound(cut + "; DELETE FROM audit_heads");
    // As if it had ended there, without the key.
    ExpectTrailEditFound(cut + "; UPDATE audit_heads SET number = " + std::to_string(left) +
                         ", last_id = " + last);
    ExpectTrailEditFound(cut + "; UPDATE audit_heads SET number = " + std::to_string(left) +
                         ", last_id = " + last +
                         ", signature = (SELECT signature FROM audit WHERE id = " + last + ")");
  }
}

TEST_F(VerifyTrailTest, EndThatIsChangedOrTakenAwayIsFound) {
  for (const char* edit : {"DELETE FROM audit_heads", "UPDATE audit_heads SET number = number + 1",
                           "UPDATE audit_heads SET number = number - 1",
                           "UPDATE audit_heads SET hash = randomblob(32)",
                           "UPDATE audit_heads SET last_id = randomblob(16)",
                           "UPDATE audit_heads SET signature = randomblob(64)",
                           "UPDATE audit_heads SET chain = randomblob(16)"}) {
    ExpectTrailEditFound(edit);
  }
}

TEST_F(VerifyTrailTest, CutEndIsNotMendedByWhatIsWrittenAfterwards) {
  const std::string cut = "DELETE FROM audit WHERE number > " + std::to_string(rows_.size() - 2);
  const std::string last = Id(rows_[rows_.size() - 3].id);
  for (const std::string& edit :
       {cut, cut + "; DELETE FROM audit_heads",
        cut + "; UPDATE audit_heads SET number = number - 2, last_id = " + last}) {
    SCOPED_TRACE(edit);
    Sql(without_triggers_ + edit);
    {
      auto store = OpenStore(Data());
      for (int i = 0; i < 3; ++i)
        ASSERT_TRUE(store->audit.NoteAudit(kSystem, "store.backup", "", "{}").ok());
    }
    const VerifyReport report = Look();
    EXPECT_TRUE(FindsTrail(report)) << Told(report);
    PutBack("kept.db");
  }
}

TEST_F(VerifyTrailTest, OlderCopyThatIsPutBackAgreesWithItselfAndNotWithABackup) {
  {
    auto store = OpenStore(Data());
    ASSERT_TRUE(store->judging.OverrideScore(graded_, std::nullopt, kSystem, {}).ok());
  }
  const fs::path backup = folder_.path() / "backup";
  ASSERT_TRUE(BackUp({Data(), backup, {}, false, "test"}).ok());
  auto look = [&](const fs::path& folder) { return *Verify({folder, {}, {}, backup}); };
  EXPECT_TRUE(look(Data()).findings.empty()) << Told(look(Data()));
  EXPECT_TRUE(look(backup).findings.empty()) << Told(look(backup));
  {
    auto store = OpenStore(Data());
    ASSERT_TRUE(store->audit.NoteAudit(kSystem, "store.backup", "", "{}").ok());
  }
  EXPECT_TRUE(look(Data()).findings.empty()) << "it went on" << Told(look(Data()));
  PutBack("kept.db");
  EXPECT_TRUE(Look().findings.empty()) << "which the document says";
  EXPECT_TRUE(FindsTrail(look(Data())));
  {
    auto store = OpenStore(Data());
    for (int i = 0; i < 3; ++i)
      ASSERT_TRUE(store->audit.NoteAudit(kSystem, "store.backup", "", "{}").ok());
  }
  EXPECT_TRUE(FindsTrail(look(Data()))) << "as long again, with other rows";
}

TEST_F(VerifyTrailTest, BackupWhoseManifestSaysAnotherEndIsFound) {
  const fs::path backup = folder_.path() / "backup";
  ASSERT_TRUE(BackUp({Data(), backup, {}, false, "test"}).ok());
  Manifest manifest = *ReadManifest(backup);
  ASSERT_EQ(manifest.trail.size(), 1u);
  EXPECT_EQ(manifest.trail.front().number, rows_.size());
  EXPECT_TRUE(VerifyAuditHead(manifest.trail.front(), school_.ticket_key.public_key));
  manifest.trail.front().hash.bytes[0] ^= 1;
  ASSERT_TRUE(SystemDisk().Replace(backup / kManifestName, AsBytes(ToJson(manifest))).ok());
  EXPECT_TRUE(FindsTrail(*Verify({backup, {}, {}})));
  EXPECT_EQ(Verify({Data(), {}, {}, folder_.path()}).status().code(), Code::kInvalidInput);
}

TEST_F(VerifyTrailTest, ServersThatWriteBesideEachOtherHaveAChainEach) {
  const Uuid other = Uuid::New(), third = Uuid::New();
  for (const Uuid& chain : {other, third, other, other, third}) {
    Status written = WriteIn(chain);
    ASSERT_TRUE(written.ok()) << written.message();
    ASSERT_TRUE(OpenStore(Data())->audit.NoteAudit(kSystem, "store.backup", "", "{}").ok());
  }
  const VerifyReport report = Look();
  EXPECT_TRUE(report.findings.empty()) << Told(report);
  EXPECT_EQ(report.trail.size(), 3u);
  Keep("kept.db");
  const std::string of = " WHERE chain = " + Id(other);
  for (int number = 1; number <= 3; ++number) {
    ExpectTrailEditFound("DELETE FROM audit" + of + " AND number = " + std::to_string(number));
  }
  ExpectTrailEditFound("DELETE FROM audit" + of);
  ExpectTrailEditFound("DELETE FROM audit_heads" + of);
}

}  // namespace
}  // namespace enamel::server
