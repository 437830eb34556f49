#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "server/storage/backup/backup.h"
#include "tests/server/storage/store_world.h"

// After an erasure neither the database's files nor a backup hold a word of or about the person,
// not even where rows were moved about before.
namespace enamel::server {
namespace {

using namespace testing;
namespace fs = std::filesystem;

// Files below the folder that contain the text.
std::vector<std::string> FilesWith(const fs::path& folder, const std::string& text) {
  std::vector<std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), {});
    if (bytes.find(text) != std::string::npos) out.push_back(entry.path().filename());
  }
  return out;
}

class ErasedWordsTest : public ::testing::Test {
 protected:
  ErasedWordsTest() {
    teacher_ = AddPerson(*store_, "teacher", Role::kInstructor);
    Person person;
    person.login = "quixote";
    person.display_name = "Dulcinea Quixote";
    gone_ = *store_->people.CreatePerson(person, "verifier", {}, kSystem);
    PersonEdit rename;
    rename.display_name = "Aldonza Lorenzo";
    EXPECT_TRUE(store_->people.EditPerson(gone_, rename, 1, kSystem).ok());
    RosterRow row;
    row.row = 2;
    row.login = "quixote";
    row.display_name = "Alonso Quijano";
    row.cohort = "year 3";
    EXPECT_TRUE(store_->roster.ImportRoster({row}, {}, kSystem).ok());
  }

  Uuid Scored(const Uuid& person) {
    Uuid attempt = world_.NewAttemptOf(person).id;
    EXPECT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
    EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(world_.Append(attempt, 1)), 200).ok());
    AttemptResult result;
    result.score = 80;
    result.score_json = *store_->blobs.PutAttemptBlob(attempt, AsBytes("score of Mancha"));
    EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
    EXPECT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
    return attempt;
  }

  // Long ones fill pages of their own, which are freed when the row goes.
  AnnotationRow Remark(const Uuid& attempt, const std::string& text, size_t bytes) {
    AnnotationRow row;
    row.attempt = attempt;
    row.author = teacher_;
    row.text = text;
    while (row.text.size() < bytes) row.text += " " + text;
    return *store_->remarks.AddAnnotation(row, Actor{teacher_, "page"});
  }

  // Everything that people may say about an attempt, some of it taken back again.
  void SayAll(const Uuid& attempt, const Uuid& person, const std::string& words) {
    const Actor by{teacher_, "page"};
    for (size_t bytes : {0, 300, 3000, 9000}) {
      AnnotationRow remark = Remark(attempt, words, bytes);
      AnnotationRow edited = remark;
      edited.text = "edited " + words;
      edited = *store_->remarks.ReplaceAnnotation(edited, by);
      if (bytes > 200)
        EXPECT_TRUE(store_->remarks.DeleteAnnotation(edited.id, edited.revision, by).ok());
    }
    EXPECT_TRUE(store_->judging.OverrideScore(attempt, ScoreOverride{50, words, {}, 0}, by).ok());
    EXPECT_TRUE(
        store_->judging.OverrideScore(attempt, ScoreOverride{60, "later " + words, {}, 0}, by)
            .ok());
    EXPECT_TRUE(store_->judging.FlagAttempt(attempt, kExcused, words, by).ok());
    EXPECT_TRUE(store_->appeals.FileAppeal(attempt, words, Actor{person, "page"}).ok());
    EXPECT_TRUE(store_->appeals.AnswerAppeal(attempt, false, words, by).ok());
  }

  TempFolder folder_;
  std::unique_ptr<Store> store_ = OpenStore(folder_.path() / "data");
  World world_{*store_};
  Uuid teacher_, gone_;
};

TEST_F(ErasedWordsTest, AreNeitherInTheDatabaseNorInABackup) {
  std::vector<Uuid> others;
  for (int i = 0; i < 40; ++i) {
    others.push_back(AddPerson(*store_, "other" + std::to_string(i), Role::kStudent));
  }
  // Rows of many people between each other, so that pages split and fill up again.
  for (size_t i = 0; i < others.size(); ++i) {
    SayAll(Scored(others[i]), others[i], "Rocinante" + std::to_string(i));
    if (i % 8 == 0) SayAll(Scored(gone_), gone_, "Sancho Panza");
  }
  SavedText saved;
  saved.text = "Sancho Panza says";
  for (const bool kept : {false, true}) {
    saved = *store_->saved_texts.AddSavedText(saved, Actor{gone_, "page"});
    saved.text = "again Sancho Panza";
    saved = *store_->saved_texts.ReplaceSavedText(saved, Actor{teacher_, "page"});
    saved.text = "Sancho Panza says";
    if (!kept) {
      EXPECT_TRUE(store_->saved_texts.DeleteSavedText(saved.id, saved.revision, kSystem).ok());
    }
  }
  EXPECT_FALSE(FilesWith(folder_.path(), "Sancho Panza").empty());
  auto report = store_->erasures.ErasePerson(gone_, true, kSystem);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_EQ(report->attempts, 5u);
  BackupOptions backup;
  backup.data = folder_.path() / "data";
  backup.target = folder_.path() / "backup";
  ASSERT_TRUE(BackUp(backup).ok());
  for (const char* words : {"Sancho Panza", "quixote", "Quixote", "Aldonza", "Quijano"}) {
    EXPECT_EQ(FilesWith(folder_.path(), words), std::vector<std::string>{}) << words;
  }
  EXPECT_FALSE(fs::exists(folder_.path() / "data" / "REWRITE"));
  auto trail = *store_->audit.Audit(1000);
  auto tells = [&](const std::string& text) {
    return std::ranges::any_of(
        trail, [&](const AuditRow& row) { return row.after_json.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(tells("Rocinante39")) << "of others it is still told";
  EXPECT_TRUE(tells("{\"erased\":true}"));
}

TEST_F(ErasedWordsTest, ThoseThatOthersTypedAreListedWithTheirPlaces) {
  const Uuid other = AddPerson(*store_, "other", Role::kStudent);
  const Uuid attempt = Scored(other);
  Remark(attempt, "as ÁLONSO  Quijano does it", 0);
  Remark(attempt, "quixote's way", 0);
  Remark(attempt, "quixotesque", 0);
  Remark(Scored(gone_), "Alonso Quijano himself", 0);
  const Uuid cohort = *store_->cohorts.CreateCohort("Friends of (quixote)", kSystem);
  const auto report = store_->erasures.ErasePerson(gone_, true, kSystem);
  ASSERT_TRUE(report.ok()) << report.status().message();
  ASSERT_EQ(report->mentions.size(), 2u);
  EXPECT_EQ(report->mentions[0].kind, "attempt");
  EXPECT_EQ(report->mentions[0].count, 2u);
  EXPECT_EQ(report->mentions[0].places, (std::vector<std::string>{attempt.Text()}));
  EXPECT_EQ(report->mentions[1].kind, "cohort");
  EXPECT_EQ(report->mentions[1].places, (std::vector<std::string>{cohort.Text()}));
}

TEST_F(ErasedWordsTest, WhatACrashLeftInTheDatabaseIsGoneOnceTheNextServerRuns) {
  SayAll(Scored(gone_), gone_, "Sancho Panza");
  ASSERT_TRUE(store_->erasures.ErasePerson(gone_, true, kSystem).ok());
  // As if the power had failed between deletion and rewrite.
  std::ofstream(folder_.path() / "data" / "REWRITE").close();
  store_.reset();
  StoreOptions server;
  server.folder = folder_.path() / "data";
  server.hold_lock = true;
  auto next = OpenSqliteStore(server);
  ASSERT_TRUE(next.ok()) << next.status().message();
  ASSERT_TRUE((*next)->erasures.FinishErasures().ok());
  EXPECT_FALSE(fs::exists(folder_.path() / "data" / "REWRITE"));
}

}  // namespace
}  // namespace enamel::server
