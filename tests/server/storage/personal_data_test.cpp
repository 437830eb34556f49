#include <algorithm>

#include "tests/server/storage/backends.h"

// Erasing people, and what every backend keeps and does not keep of them.
namespace enamel::server {
namespace {

using namespace testing;

class PersonalDataTest : public StoreSuite {
 protected:
  World world_{*store_};
};
INSTANTIATE_TEST_SUITE_P(Backends, PersonalDataTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(PersonalDataTest, BlobOfAnAttemptReadsBackAndIsNotWhatWasPut) {
  Uuid attempt = world_.OpenedAttempt();
  Bytes data(1000, 7);
  Sha256 name = *store_->blobs.PutAttemptBlob(attempt, data);
  EXPECT_NE(name, HashSha256(data)) << "kept as it is";
  EXPECT_EQ(*store_->blobs.PutAttemptBlob(attempt, data), name) << "again: the same blob";
  EXPECT_EQ(*store_->blobs.GetBlob(name), data);
  EXPECT_NE(*store_->blobs.PutAttemptBlob(world_.OpenedAttempt(), data), name)
      << "of another attempt: another blob";
  EXPECT_EQ(store_->blobs.PutAttemptBlob(Uuid::New(), data).status().code(), Code::kNotFound);
}

TEST_P(PersonalDataTest, ErasedPersonLeavesNothingThatCanBeRead) {
  Uuid scored = world_.ScoredAttempt(), open = world_.OpenedAttempt();
  world_.Append(open, 2);
  Sha256 deviation = *store_->blobs.PutAttemptBlob(scored, AsBytes("deviation"));
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, world_.student, kSystem).ok());
  Sha256 token = HashSha256(AsBytes("token"));
  ASSERT_TRUE(store_->sessions.CreateSession({token, world_.student, 1, 1, 1000, "page"}).ok());

  auto report = store_->erasures.ErasePerson(world_.student, false, kSystem);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_EQ(report->attempts, 2u);
  for (int look = 0; look < 2; ++look) {
    EXPECT_EQ(store_->people.PersonById(world_.student).status().code(), Code::kNotFound);
    EXPECT_EQ(store_->people.PersonByLogin("student").status().code(), Code::kNotFound);
    EXPECT_EQ(store_->attempts.AttemptById(scored).status().code(), Code::kNotFound);
    EXPECT_EQ(store_->attempts.AttemptById(open).status().code(), Code::kNotFound);
    EXPECT_FALSE(store_->blobs.GetBlob(deviation).ok());
    EXPECT_FALSE(store_->sessions.FindSession(token).ok());
    EXPECT_TRUE(store_->cohorts.CohortMembers(cohort)->empty());
    EXPECT_TRUE(store_->jobs.Jobs("").value().empty());
    Reopen();
  }
  EXPECT_EQ(store_->erasures.ErasePerson(world_.student, false, kSystem).status().code(),
            Code::kNotFound);
}

TEST_P(PersonalDataTest, ErasureOfOneLeavesTheOthersAlone) {
  Uuid other = AddPerson(*store_, "other", Role::kStudent);
  Uuid attempt = world_.NewAttemptOf(other).id;
  ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  auto chunks = world_.Append(attempt, 2);
  world_.ScoredAttempt();
  ASSERT_TRUE(store_->erasures.ErasePerson(world_.student, false, kSystem).ok());
  EXPECT_EQ(AllChunks(store_->recordings, attempt)->at(1), chunks[1].bytes);
  EXPECT_EQ(store_->attempts.Attempts({})->size(), 1u);
}

TEST_P(PersonalDataTest, WhoMadeAReferenceIsErasedOnlyWithIt) {
  Uuid dentist = AddPerson(*store_, "dentist", Role::kInstructor);
  Uuid cut = world_.NewAttemptOf(dentist).id;
  ASSERT_TRUE(store_->tickets.OpenAttempt(cut, AsBytes("header")).ok());
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world_.Append(cut, 1)), 200).ok());
  AttemptResult done;
  done.score = 100;
  ASSERT_TRUE(store_->results.FinishAttempt(cut, done, {}).ok());
  ASSERT_TRUE(store_->references.AddReference(cut, "Dr. Example", true, kSystem).ok());
  Uuid compared = world_.ScoredAttempt();
  AttemptResult result;
  result.score_json = PutText(*store_, "score");
  result.reference = cut;
  ASSERT_TRUE(store_->results.FinishAttempt(compared, result, {}).ok());

  auto refused = store_->erasures.ErasePerson(dentist, false, kSystem);
  EXPECT_EQ(refused.status().code(), Code::kConflict);
  EXPECT_NE(refused.status().message().find(cut.Text()), std::string::npos);
  EXPECT_TRUE(AllChunks(store_->recordings, cut).ok()) << "a refusal destroys no key";

  auto erased = store_->erasures.ErasePerson(dentist, true, kSystem);
  ASSERT_TRUE(erased.ok()) << erased.status().message();
  EXPECT_EQ(erased->references, 1u);
  EXPECT_FALSE(store_->references.ReferenceFor(world_.exercise.id)->has_value());
  EXPECT_TRUE(store_->results.ResultOf(compared).ok()) << "the score stays";
  EXPECT_FALSE(store_->results.ResultOf(compared)->reference.has_value());
}

TEST_P(PersonalDataTest, ErasureIsAuditedWithoutNamingThePerson) {
  world_.ScoredAttempt();
  ASSERT_TRUE(store_->erasures.ErasePerson(world_.student, false, kSystem).ok());
  auto rows = store_->audit.Audit(100);
  auto row = std::ranges::find(*rows, "person.erase", &AuditRow::action);
  ASSERT_NE(row, rows->end());
  EXPECT_EQ(row->object, HashSha256(world_.student.view()).Hex());
  EXPECT_EQ(row->object.find(world_.student.Text()), std::string::npos);
}

TEST_P(PersonalDataTest, AuditAboutAPersonHasWhatTheyDidAndWhatWasDoneToThem) {
  Uuid scored = world_.ScoredAttempt();
  Uuid other = AddPerson(*store_, "other", Role::kStudent);
  ASSERT_TRUE(store_->judging.ReleaseAttempt(scored, Actor{other, "page"}).ok());
  auto about = store_->audit.AuditAbout(world_.student);
  ASSERT_TRUE(about.ok()) << about.status().message();
  auto has = [&](const char* action) {
    return std::ranges::find(*about, action, &AuditRow::action) != about->end();
  };
  EXPECT_TRUE(has("person.create"));
  EXPECT_TRUE(has("attempt.seal"));
  EXPECT_TRUE(has("attempt.release")) << "done by somebody else to an attempt of theirs";
  EXPECT_TRUE(std::ranges::none_of(*about, [&](const AuditRow& row) {
    return row.object == other.Text();
  })) << "and nothing about others";
  EXPECT_EQ(about->front().action, "person.create") << "oldest first";
}

}  // namespace
}  // namespace enamel::server
