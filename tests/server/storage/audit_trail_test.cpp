#include "server/storage/audit/audit_trail.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>

#include "tests/server/storage/store_world.h"

// The database itself refuses to change the audit trail, whoever asks.
namespace enamel::server {
namespace {

using namespace testing;

class AuditTrailTest : public ::testing::Test {
 protected:
  AuditTrailTest() : store_(OpenStore(folder_.path())) {
    ada_ = AddPerson(*store_, "ada", Role::kStudent);
    EXPECT_EQ(sqlite3_open((folder_.path() / "enamel.db").c_str(), &db_), SQLITE_OK);
  }
  ~AuditTrailTest() override { sqlite3_close(db_); }

  // What SQLite says; empty when it did it.
  std::string Run(const std::string& sql) {
    char* error = nullptr;
    sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, &error);
    std::string out = error == nullptr ? "" : error;
    sqlite3_free(error);
    return out;
  }
  const std::string redact_ =
      "UPDATE audit SET before_json = '{\"erased\":true}', after_json = '{\"erased\":true}', state "
      "= "
      "CASE state WHEN '' THEN '' ELSE '{\"erased\":true}' END, salt = NULL";

  TempFolder folder_;
  std::unique_ptr<Store> store_;
  sqlite3* db_ = nullptr;
  Uuid ada_;
};

TEST_F(AuditTrailTest, RowsAreNeitherChangedNorDeleted) {
  EXPECT_EQ(Run("DELETE FROM audit"), "audit rows are never deleted");
  for (const char* change :
       {"actor = zeroblob(16)", "at_ms = 0", "action = 'x'", "object = ''", "via = ''",
        "subject = ''", "state = ''", "salt = NULL", "signature = NULL",
        "content_hash = zeroblob(32)", "before_json = '{}', after_json = '{\"role\":\"admin\"}'"}) {
    EXPECT_EQ(Run(std::string("UPDATE audit SET ") + change), "audit rows are never changed")
        << change;
  }
  EXPECT_EQ(store_->audit.Audit(10)->size(), 1u);
}

// With every change the newest row about its subject is looked up: a roster of 5000 people read
// 10 000 rows for each of them.
TEST_F(AuditTrailTest, RowsAboutASubjectAreFoundByTheirIndex) {
  std::string plan;
  const std::string sql = std::string("EXPLAIN QUERY PLAN SELECT id FROM audit WHERE ") +
                          kAboutSubject + " ORDER BY id DESC LIMIT 1";
  sqlite3_exec(
      db_, sql.c_str(),
      [](void* out, int columns, char** values, char**) {
        *static_cast<std::string*>(out) += values[columns - 1];
        return 0;
      },
      &plan, nullptr);
  EXPECT_NE(plan.find("audit_by_subject"), std::string::npos) << plan;
  EXPECT_EQ(plan.find("TEMP B-TREE"), std::string::npos) << plan;
}

TEST_F(AuditTrailTest, OnlyWhatIsToldOfAPersonWhoIsGoneIsOverwritten) {
  EXPECT_EQ(Run(redact_), "audit rows are never changed") << "ada is there";
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  EXPECT_EQ(Run(redact_ + " WHERE object = '" + cohort.Text() + "'"),
            "audit rows are never changed")
      << "no person";
  ASSERT_TRUE(store_->erasures.ErasePerson(ada_, false, kSystem).ok());
  EXPECT_EQ(Run(redact_ + " WHERE object = '" + ada_.Text() + "'"), "");
  EXPECT_EQ(Run("UPDATE audit SET actor = randomblob(16) WHERE object = '" + ada_.Text() + "'"),
            "audit rows are never changed");
}

TEST_F(AuditTrailTest,
       WhatIsToldOfAttemptsIsOverwrittenOnceTheirPersonIsGoneAlsoAfterARetentionRule) {
  World world(*store_);
  AttemptRow attempt = world.NewAttempt();
  ASSERT_TRUE(store_->judging.FlagAttempt(attempt.id, kExcused, "was ill", kSystem).ok());
  const std::string about = redact_ + " WHERE object = '" + attempt.id.Text() + "'";
  EXPECT_EQ(Run(about + " AND action = 'attempt.flag'"), "audit rows are never changed")
      << "the student is there";
  ASSERT_TRUE(store_->retention.SetRetention({"unfinished", 14}, kSystem).ok());
  ASSERT_TRUE(store_->retention.ApplyRetention(UnixMs{1} << 42, false, kSystem).ok());
  ASSERT_EQ(store_->attempts.AttemptById(attempt.id).status().code(), Code::kNotFound);
  EXPECT_EQ(Run(about + " AND action = 'attempt.flag'"), "audit rows are never changed")
      << "the attempt is gone, the student is there";
  ASSERT_TRUE(store_->erasures.ErasePerson(world.student, false, kSystem).ok());
  auto rows = *store_->audit.Audit(1000);
  EXPECT_TRUE(std::ranges::none_of(rows, [](const AuditRow& row) {
    return row.after_json.find("was ill") != std::string::npos;
  }));
  EXPECT_EQ(Run(about + " AND action = 'attempt.flag'"), "");
  EXPECT_EQ(Run(about + " AND action = 'attempt.ticket'"), "audit rows are never changed")
      << "whose it was";
}

}  // namespace
}  // namespace enamel::server
