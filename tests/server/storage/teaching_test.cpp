#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "server/training/revision.h"
#include "server/training/ticket_rules.h"
#include "tests/server/storage/backends.h"

// What every backend of Store must do about teaching: drafts and versions, assignments and their
// limits, time, results, overrides, annotations, appeals, references, cancelled jobs.
namespace enamel::server {
namespace {

using namespace testing;

class TeachingTest : public StoreSuite {
 protected:
  Uuid Cohort(const std::string& name, const Uuid& member) {
    Uuid cohort = *store_->cohorts.CreateCohort(name, kSystem);
    EXPECT_TRUE(store_->cohorts.AddToCohort(cohort, member, kSystem).ok());
    return cohort;
  }
  AssignmentRow Assigned(const Uuid& cohort, uint32_t limit = 0, bool exam = false) {
    AssignmentRow row;
    row.exercise = "exercise";
    row.cohort = cohort;
    row.attempt_limit = limit;
    row.exam = exam;
    auto added = store_->assignments.AddAssignment(row, kSystem);
    EXPECT_TRUE(added.ok()) << added.status().message();
    return *added;
  }
  // Ticketed under the assignment; `change` may spoil the row.
  Result<Uuid> Begin(World& world, const AssignmentRow& assignment,
                     const std::function<void(AttemptRow&)>& change = {}) {
    AttemptRow row;
    row.id = Uuid::New();
    row.person = world.student;
    row.station = world.station;
    row.exercise = world.exercise.id;
    row.profile_content = world.profile;
    row.ticketed_ms = 5;
    row.assignment = assignment.id;
    row.exam = assignment.exam;
    row.due_ms = assignment.due_ms;
    if (change) change(row);
    Status status = store_->tickets.CreateAttempt(row, AsBytes("ticket"), kSystem);
    if (!status.ok()) return status;
    return row.id;
  }
  // Scored, and nothing waits.
  Uuid Settled(World& world, double score = 80) {
    Uuid attempt = world.ScoredAttempt(score);
    EXPECT_TRUE(
        store_->jobs.FinishJob(store_->jobs.LeaseJob(1, 1000)->value().lease, true, "").ok());
    EXPECT_TRUE(
        store_->results.FinishAttempt(attempt, *store_->results.ResultOf(attempt), {}).ok());
    return attempt;
  }
  // Scored, released, and another run of it queued.
  Uuid Rescored(World& world, double score) {
    Uuid attempt = Settled(world, score);
    EXPECT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
    EXPECT_TRUE(store_->judging.Rescore(attempt, "rescore", kSystem).ok());
    return attempt;
  }
  std::vector<std::string> Actions() {
    std::vector<std::string> out;
    auto rows = store_->audit.Audit(1000);
    for (const AuditRow& row : *rows) out.push_back(row.action);
    return out;
  }
};
INSTANTIATE_TEST_SUITE_P(Backends, TeachingTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(TeachingTest, DraftIsSeenByNobodyUntilPublishedAndThenNeverChanges) {
  World world(*store_);
  auto draft = store_->exercises.PutDraft(world.Exercise("exercise", "draft"), kSystem);
  ASSERT_TRUE(draft.ok()) << draft.status().message();
  EXPECT_EQ(draft->version, 0);
  EXPECT_EQ(store_->exercises.ExercisesFor(world.student)->front().content, world.exercise.content);
  EXPECT_EQ(store_->exercises.ExerciseByContent(draft->content).status().code(), Code::kNotFound);
  EXPECT_EQ(
      store_->exercises.PutDraft(world.Exercise("exercise", "other"), kSystem).status().code(),
      Code::kConflict);

  ExerciseRow better = world.Exercise("exercise", "better draft");
  better.id = draft->id;
  better.revision = draft->revision;
  auto replaced = store_->exercises.ReplaceDraft(better, kSystem);
  ASSERT_TRUE(replaced.ok()) << replaced.status().message();
  EXPECT_EQ(store_->exercises.ReplaceDraft(better, kSystem).status().field(), kStale);
  Reopen();

  auto published = store_->exercises.PublishDraft(draft->id, replaced->revision, kSystem);
  ASSERT_TRUE(published.ok()) << published.status().message();
  EXPECT_EQ(published->version, 2);
  EXPECT_EQ(published->content, better.content);
  EXPECT_EQ(store_->exercises.ExercisesFor(world.student)->front().id, world.exercise.id)
      << "what is assigned stays";
  EXPECT_EQ(store_->exercises.AllExercises()->front().id, draft->id);
  better.revision = published->revision;
  Status refused = store_->exercises.ReplaceDraft(better, kSystem).status();
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.field(), kStale);
  EXPECT_EQ(store_->exercises.DeleteDraft(draft->id, published->revision, kSystem).code(),
            Code::kConflict);
  ASSERT_EQ(store_->exercises.ExerciseVersions("exercise")->size(), 2u);
  EXPECT_EQ(store_->exercises.ExerciseVersions("exercise")->back().content, world.exercise.content);
}

TEST_P(TeachingTest, DraftThatSaysNothingNewIsNotPublishedAndCanBeDiscarded) {
  World world(*store_);
  auto draft = store_->exercises.PutDraft(world.Exercise("exercise", "v1"), kSystem);
  EXPECT_EQ(store_->exercises.PublishDraft(draft->id, 1, kSystem).status().code(), Code::kConflict);
  EXPECT_EQ(store_->exercises.DeleteDraft(draft->id, 7, kSystem).field(), kStale);
  ASSERT_TRUE(store_->exercises.DeleteDraft(draft->id, 1, kSystem).ok());
  EXPECT_TRUE(store_->exercises.ExercisesIn(ExerciseState::kDraft)->empty());
  ExerciseRow nowhere = world.Exercise("elsewhere", "e");
  nowhere.scene = HashSha256(AsBytes("no such scene"));
  EXPECT_EQ(store_->exercises.PutDraft(nowhere, kSystem).status().field(), "scene_sha256");
}

TEST_P(TeachingTest, RetiredExerciseIsOfferedToNobodyUntilItIsPublishedAgain) {
  World world(*store_);
  ASSERT_TRUE(
      store_->exercises.PublishExercise(world.Exercise("exercise", "v2"), Uuid{}, kSystem).ok());
  const auto assigned = *store_->assignments.Assignments({});
  for (const AssignmentRow& row : assigned) {
    ASSERT_TRUE(store_->assignments.DeleteAssignment(row.id, row.revision, kSystem).ok());
  }
  ASSERT_TRUE(store_->exercises.RetireExercise(world.exercise.id, kSystem).ok());
  EXPECT_TRUE(store_->exercises.ExercisesFor(world.student)->empty())
      << "not the older version either";
  EXPECT_TRUE(store_->exercises.AllExercises()->empty());
  EXPECT_EQ(store_->exercises.ExercisesIn(ExerciseState::kRetired)->front().version, 2);
  EXPECT_EQ(store_->exercises.RetireExercise(world.exercise.id, kSystem).code(), Code::kConflict);
  ASSERT_TRUE(
      store_->exercises.PublishExercise(world.Exercise("exercise", "v2"), Uuid{}, kSystem).ok());
  EXPECT_EQ(store_->exercises.AllExercises()->front().version, 2);
}

TEST_P(TeachingTest, RetiringLocksNobodyOutOfWhatIsAssigned) {
  World world(*store_);
  const auto assigned = *store_->assignments.Assignments({});
  for (const AssignmentRow& row : assigned) {
    ASSERT_TRUE(store_->assignments.DeleteAssignment(row.id, row.revision, kSystem).ok());
  }
  AssignmentRow row = Assigned(Cohort("year 1", world.student));
  ASSERT_TRUE(store_->exercises.RetireExercise(world.exercise.id, kSystem, "a newer one").ok());
  EXPECT_EQ(store_->exercises.ExercisesFor(world.student)->size(), 1u);
  ASSERT_EQ(store_->assignments.AssignmentsFor(world.student)->size(), 1u);
  EXPECT_TRUE(store_->assignments.AssignmentsFor(world.student)->front().assignment.retired);
  EXPECT_TRUE(Begin(world, row).ok());
  row.due_ms = 5000;
  row.opens_ms = 0;
  ASSERT_TRUE(store_->assignments.ReplaceAssignment(row, kSystem).ok());
  EXPECT_TRUE(store_->exercises.ExercisesFor(world.student)->empty()) << "over";
  ASSERT_TRUE(store_->exercises.OfferExerciseAgain(world.exercise.id, kSystem).ok());
  EXPECT_EQ(store_->exercises.AllExercises()->size(), 1u);
  EXPECT_EQ(store_->exercises.OfferExerciseAgain(world.exercise.id, kSystem).code(),
            Code::kConflict);
  EXPECT_TRUE(store_->exercises.RetireExercise(world.exercise.id, kSystem).ok());
}

TEST_P(TeachingTest, NameOfAnExerciseIsOfWhoFirstUsedItUntilNothingOfItIsLeft) {
  World world(*store_);
  EXPECT_TRUE(world.exercise.owner.IsZero() && world.exercise.shared) << "the command line's";
  const Actor ada{AddPerson(*store_, "ada", Role::kInstructor), "page"};
  const Actor ben{AddPerson(*store_, "ben", Role::kInstructor), "page"};
  const Actor root{AddPerson(*store_, "root", Role::kAdmin), "page"};
  ExerciseRow hers = *store_->exercises.PutDraft(world.Exercise("hers", "h1"), ada);
  EXPECT_EQ(hers.owner, ada.person);
  EXPECT_EQ(hers.owner_name, "Name of ada");
  EXPECT_FALSE(hers.shared);
  EXPECT_TRUE(store_->exercises.PutDraft(world.Exercise("schools", "s1"), root)->owner.IsZero());
  hers = *store_->exercises.PublishDraft(hers.id, hers.revision, ada);
  EXPECT_EQ(store_->exercises.PutDraft(world.Exercise("hers", "h2"), root)->owner, ada.person)
      << "another version by an admin takes nothing away";

  ExerciseRow draft = *store_->exercises.PutDraft(world.Exercise("first", "f1"), ben);
  ExerciseRow renamed = world.Exercise("second", "f1");
  renamed.id = draft.id;
  renamed.revision = draft.revision;
  draft = *store_->exercises.ReplaceDraft(renamed, ben);
  EXPECT_EQ(draft.owner, ben.person);
  EXPECT_EQ(store_->exercises.PutDraft(world.Exercise("first", "a1"), ada)->owner, ada.person);
  ASSERT_TRUE(store_->exercises.DeleteDraft(draft.id, draft.revision, ben).ok());
  EXPECT_EQ(store_->exercises.PutDraft(world.Exercise("second", "a2"), ada)->owner, ada.person);
}

TEST_P(TeachingTest, ExerciseIsSharedAndHandedOverWithAnAuditRow) {
  World world(*store_);
  const Actor ada{AddPerson(*store_, "ada", Role::kInstructor), "page"};
  const Uuid ben = AddPerson(*store_, "ben", Role::kInstructor);
  const ExerciseRow hers = *store_->exercises.PutDraft(world.Exercise("hers", "h1"), ada);
  EXPECT_TRUE(store_->exercises.ShareExercise(hers.id, {true, {}}, ada)->shared);
  EXPECT_EQ(Actions().front(), "exercise.share");
  const size_t rows = Actions().size();
  EXPECT_TRUE(store_->exercises.ShareExercise(hers.id, {true, ada.person}, ada)->shared);
  EXPECT_EQ(Actions().size(), rows) << "nothing changed";
  for (const Uuid& nobody : {world.student, Uuid::New()}) {
    EXPECT_EQ(store_->exercises.ShareExercise(hers.id, {{}, nobody}, ada).status().field(),
              "owner_id");
  }
  EXPECT_EQ(store_->exercises.ShareExercise(hers.id, {false, ben}, ada)->owner, ben);
  EXPECT_FALSE(store_->exercises.ExerciseById(hers.id)->shared);
  ASSERT_TRUE(store_->people.SetDisabled(ben, true, kSystem).ok());
  EXPECT_EQ(store_->exercises.ShareExercise(hers.id, {true, {}}, kSystem)->owner, ben)
      << "stays with who is disabled until it is handed on";
  EXPECT_TRUE(store_->exercises.ShareExercise(hers.id, {{}, Uuid{}}, kSystem)->owner.IsZero());
  EXPECT_EQ(store_->exercises.ShareExercise(hers.id, {{}, ben}, kSystem).status().field(),
            "owner_id");
  EXPECT_EQ(store_->exercises.ShareExercise(Uuid::New(), {true, {}}, ada).status().code(),
            Code::kNotFound);
}

TEST_P(TeachingTest, ExerciseOfSomebodyErasedIsTheSchools) {
  World world(*store_);
  const Actor ada{AddPerson(*store_, "ada", Role::kInstructor), "page"};
  AddPerson(*store_, "root", Role::kAdmin);
  const Uuid hers = store_->exercises.PutDraft(world.Exercise("hers", "h1"), ada)->id;
  ASSERT_TRUE(store_->erasures.ErasePerson(ada.person, false, kSystem).ok());
  EXPECT_TRUE(store_->exercises.ExerciseById(hers)->owner.IsZero());
  EXPECT_FALSE(store_->exercises.ExerciseById(hers)->shared);
}

TEST_P(TeachingTest, AssignmentsAreThoseOfOwnCohortsAndOfEverybody) {
  World world(*store_);
  Uuid other = AddPerson(*store_, "other", Role::kStudent);
  Uuid mine = Cohort("mine", world.student), theirs = Cohort("theirs", other);
  AssignmentRow exam = Assigned(mine, 3, true);
  Assigned(theirs);
  auto rows = store_->assignments.AssignmentsFor(world.student);
  ASSERT_EQ(rows->size(), 2u) << "own cohort's and everybody's";
  EXPECT_EQ(rows->front().assignment.id, exam.id) << "exams first";
  EXPECT_EQ(rows->front().assignment.cohort_name, "mine");
  EXPECT_EQ(rows->front().exercise.id, world.exercise.id);
  EXPECT_EQ(store_->assignments.Assignments({})->size(), 3u);
  EXPECT_EQ(store_->assignments.Assignments({.cohort = theirs})->size(), 1u);
  EXPECT_EQ(store_->assignments.Assignments({.of_instructor = other})->size(), 2u);
}

TEST_P(TeachingTest, AssignmentOfWhatDoesNotExistIsRefusedWithTheField) {
  World world(*store_);
  AssignmentRow row;
  row.exercise = "no such";
  EXPECT_EQ(store_->assignments.AddAssignment(row, kSystem).status().field(), "exercise");
  row.exercise = "exercise";
  row.cohort = Uuid::New();
  EXPECT_EQ(store_->assignments.AddAssignment(row, kSystem).status().field(), "cohort_id");
  row.cohort = {};
  row.stations = {Uuid::New()};
  EXPECT_EQ(store_->assignments.AddAssignment(row, kSystem).status().field(), "station_ids");
  ASSERT_TRUE(store_->stations.RevokeStation(world.station, kSystem).ok());
  row.stations = {world.station};
  EXPECT_EQ(store_->assignments.AddAssignment(row, kSystem).status().field(), "station_ids")
      << "revoked";
  EXPECT_EQ(store_->assignments.Assignments({})->size(), 1u)
      << "nothing is left of what was refused";
}

TEST_P(TeachingTest, EditOfAnAssignmentSomebodyElseChangedIsRefused) {
  World world(*store_);
  AssignmentRow row = Assigned(Cohort("mine", world.student), 1, true);
  row.stations = {world.station};
  row.due_ms = 5000;
  auto edited = store_->assignments.ReplaceAssignment(row, kSystem);
  ASSERT_TRUE(edited.ok()) << edited.status().message();
  EXPECT_EQ(edited->stations, row.stations);
  EXPECT_EQ(edited->due_ms, 5000);
  EXPECT_EQ(store_->assignments.ReplaceAssignment(row, kSystem).status().field(), kStale);
  EXPECT_EQ(store_->assignments.DeleteAssignment(row.id, row.revision, kSystem).field(), kStale);
  ASSERT_TRUE(store_->assignments.DeleteAssignment(row.id, edited->revision, kSystem).ok());
  EXPECT_EQ(store_->assignments.AssignmentById(row.id).status().code(), Code::kNotFound);
}

TEST_P(TeachingTest, LimitHoldsAlsoForTicketsAtTheSameMoment) {
  World world(*store_);
  AssignmentRow row = Assigned(Cohort("mine", world.student), 3);
  std::atomic<int> issued = 0, refused = 0;
  std::vector<std::thread> stations;
  for (int i = 0; i < 8; ++i) {
    stations.emplace_back([&] {
      auto attempt = Begin(world, row);
      if (attempt.ok()) {
        ++issued;
      } else {
        EXPECT_EQ(attempt.status().field(), "attempt_limit");
        ++refused;
      }
    });
  }
  for (std::thread& station : stations) station.join();
  EXPECT_EQ(issued, 3);
  EXPECT_EQ(refused, 5);
  auto rows = store_->assignments.AssignmentsFor(world.student);
  auto mine = std::ranges::find_if(
      *rows, [&](const AssignedRow& assigned) { return assigned.assignment.id == row.id; });
  ASSERT_NE(mine, rows->end());
  EXPECT_EQ(mine->attempts_used, 3u);

  Uuid first = store_->attempts.Attempts({.assignment = row.id})->back().id;
  ASSERT_TRUE(store_->judging.FlagAttempt(first, kExcused, "power cut", kSystem).ok());
  EXPECT_TRUE(Begin(world, row).ok()) << "an excused attempt does not count";
}

TEST_P(TeachingTest, SecondExamAttemptWaitsForTheFirstToEnd) {
  World world(*store_);
  AssignmentRow exam = Assigned(Cohort("mine", world.student), 0, true);
  Uuid first = *Begin(world, exam);
  EXPECT_EQ(Begin(world, exam).status().field(), "exam");
  ASSERT_TRUE(store_->tickets.OpenAttempt(first, AsBytes("header")).ok());
  EXPECT_EQ(Begin(world, exam).status().field(), "exam");
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(first, 1)), 200).ok());
  Uuid second = *Begin(world, exam);
  EXPECT_FALSE(Begin(world, exam).ok());
  ASSERT_TRUE(store_->judging.FlagAttempt(second, kExcused, "station broke", kSystem).ok());
  EXPECT_TRUE(Begin(world, exam).ok());
  auto readmitted = [](AttemptRow& row) { row.flags = kReadmitted; };
  EXPECT_TRUE(Begin(world, exam, readmitted).ok()) << "what was made already is not refused";
}

// 250 ticks a chunk at 100 Hz: 2.5 s each.
TEST_P(TeachingTest, MoreTicksThanTimeAreFlaggedAndInAnExamQuarantined) {
  World world(*store_);
  AssignmentRow exam = Assigned(Cohort("mine", world.student), 0, true);
  auto timed = [](AttemptRow& row) { row.rate_hz = 100; };
  Uuid attempt = *Begin(world, exam, timed);
  ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  // All received 95 ms after the ticket: one chunk is 2.5 s of work, more than 2.1 s.
  auto chunks = world.Append(attempt, 1);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags, uint32_t{kFasterThanTime});
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kQuarantined);
  EXPECT_FALSE(store_->jobs.LeaseJob(1, 1000)->has_value()) << "nothing is scored";
  EXPECT_EQ(AllChunks(store_->recordings, attempt)->size(), 1u) << "and nothing is lost";
  EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 300).ok())
      << "sent again, because the answer was lost";
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kQuarantined);

  ASSERT_TRUE(store_->judging.Rescore(attempt, "rescore", kSystem).ok())
      << "an instructor accepts it";
  EXPECT_EQ(store_->jobs.LeaseJob(1, 1000)->value().attempt, attempt);

  AssignmentRow practice = Assigned(Cohort("practice", world.student));
  Uuid quick = *Begin(world, practice, timed);
  ASSERT_TRUE(store_->tickets.OpenAttempt(quick, AsBytes("header")).ok());
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(quick, 2)), 200).ok());
  EXPECT_EQ(store_->attempts.AttemptById(quick)->flags, uint32_t{kFasterThanTime});
  EXPECT_EQ(store_->attempts.AttemptById(quick)->state, AttemptState::kSealed);
}

TEST_P(TeachingTest, WorkInRealTimeIsNotFlagged) {
  World world(*store_);
  AssignmentRow practice = Assigned(Cohort("mine", world.student));
  Uuid attempt = *Begin(world, practice, [](AttemptRow& row) { row.rate_hz = 100; });
  ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  Sha256 previous = World::HeaderHash();
  for (uint32_t seq = 0; seq < 20; ++seq) {
    ChunkPut chunk = world.Chunk(attempt, seq, previous);
    chunk.received_ms = 5 + (seq + 1) * 2500;
    previous = chunk.hash;
    ASSERT_TRUE(store_->ingest.AppendChunk(chunk).ok());
  }
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags, 0u);
}

TEST_P(TeachingTest, LongerThanTheTimeLimitIsFlagged) {
  World world(*store_);
  AssignmentRow practice = Assigned(Cohort("mine", world.student));
  Uuid attempt = *Begin(world, practice, [](AttemptRow& row) { row.limit_ticks = 250; });
  ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  ChunkPut first = world.Chunk(attempt, 0, World::HeaderHash());
  ASSERT_TRUE(store_->ingest.AppendChunk(first).ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags, 0u) << "to the tick";
  ASSERT_TRUE(store_->ingest.AppendChunk(world.Chunk(attempt, 1, first.hash)).ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags, uint32_t{kOverTime});
}

// Ticket at 5 ms, one chunk of 2.5 s at 100 Hz.
TEST_P(TeachingTest, LateWorkAndALateUploadAreToldApart) {
  World world(*store_);
  AssignmentRow practice = Assigned(Cohort("mine", world.student));
  auto sealed = [&](UnixMs due_ms, UnixMs received_ms) {
    Uuid attempt = *Begin(world, practice, [&](AttemptRow& row) {
      row.rate_hz = 100;
      row.due_ms = due_ms;
    });
    EXPECT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
    ChunkPut chunk = world.Chunk(attempt, 0, World::HeaderHash());
    chunk.received_ms = received_ms;
    EXPECT_TRUE(store_->ingest.AppendChunk(chunk).ok());
    EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf({chunk}), received_ms + 1).ok());
    return store_->attempts.AttemptById(attempt)->flags;
  };
  EXPECT_EQ(sealed(0, 1'000'000), 0u) << "never due";
  EXPECT_EQ(sealed(3000, 2600), 0u);
  EXPECT_EQ(sealed(3000, 1'000'000), uint32_t{kLateUpload}) << "may have been made in time";
  EXPECT_EQ(sealed(2000, 1'000'000), uint32_t{kLate}) << "2.5 s of work cannot end 2 s after";
}

TEST_P(TeachingTest, ReleaseOfAnAssignmentReleasesWhatIsScoredAndCanBeTakenBack) {
  World world(*store_);
  AssignmentRow row = Assigned(Cohort("mine", world.student));
  auto scored = [&] {
    Uuid attempt = *Begin(world, row);
    EXPECT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
    EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
    AttemptResult result;
    result.score_json = PutText(*store_, "score");
    EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
    return attempt;
  };
  Uuid a = scored(), b = scored(), open = *Begin(world, row), other = world.ScoredAttempt();
  EXPECT_EQ(*store_->judging.ReleaseAssignment(row.id, kSystem), 2u);
  EXPECT_EQ(*store_->judging.ReleaseAssignment(row.id, kSystem), 0u);
  EXPECT_TRUE(store_->attempts.AttemptById(a)->released &&
              store_->attempts.AttemptById(b)->released);
  EXPECT_FALSE(store_->attempts.AttemptById(open)->released ||
               store_->attempts.AttemptById(other)->released);
  ASSERT_TRUE(store_->judging.WithdrawRelease(a, kSystem).ok());
  EXPECT_FALSE(store_->attempts.AttemptById(a)->released);
  EXPECT_EQ(std::ranges::count(Actions(), "attempt.unrelease"), 1);
  EXPECT_EQ(store_->judging.ReleaseAssignment(Uuid::New(), kSystem).status().code(),
            Code::kNotFound);
}

TEST_P(TeachingTest, ABorderlineScoreOfGradedWorkIsReleasedWhenAPersonHasSetIt) {
  World world(*store_);
  const AssignmentRow row = Assigned(Cohort("mine", world.student));
  const Uuid attempt = *Begin(world, row);
  ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  AttemptResult result;
  result.score = 80;
  result.borderline = true;
  result.score_json = PutText(*store_, "score");
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  auto now = [&] { return *store_->attempts.AttemptById(attempt); };
  EXPECT_NE(now().flags & kBorderlineScore, 0U);
  EXPECT_EQ(store_->judging.ReleaseAttempt(attempt, kSystem).field(), "borderline");
  EXPECT_EQ(store_->judging.ReleaseAssignment(row.id, kSystem).status().field(), "borderline");
  EXPECT_FALSE(now().released);
  const ScoreOverride same{80, "looked at under the lens", {}, 0};
  ASSERT_TRUE(store_->judging.OverrideScore(attempt, same, kSystem).ok());
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
  ASSERT_TRUE(store_->judging.OverrideScore(attempt, std::nullopt, kSystem).ok());
  EXPECT_FALSE(now().released) << "nobody decides any more";
  result.borderline = false;
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
}

TEST_P(TeachingTest, OverrideCountsAndTheComputedScoreIsKept) {
  World world(*store_);
  Uuid attempt = world.ScoredAttempt(62), unscored = world.OpenedAttempt();
  ScoreOverride better{75, "the crown was cracked before", {}, 0};
  Actor instructor{world.student, "page"};
  ASSERT_TRUE(store_->judging.OverrideScore(attempt, better, instructor).ok());
  Reopen();
  AttemptRow row = *store_->attempts.AttemptById(attempt);
  EXPECT_EQ(row.score, 62);
  EXPECT_EQ(row.overridden->score, 75);
  EXPECT_EQ(row.overridden->reason, better.reason);
  EXPECT_EQ(row.overridden->by, world.student);
  ASSERT_TRUE(store_->judging.OverrideScore(attempt, std::nullopt, instructor).ok());
  EXPECT_FALSE(store_->attempts.AttemptById(attempt)->overridden.has_value());
  auto audit = store_->audit.Audit(1)->front();
  EXPECT_EQ(audit.action, "attempt.override");
  EXPECT_NE(audit.before_json.find("cracked"), std::string::npos) << "what it was stays on record";
  EXPECT_EQ(store_->judging.OverrideScore(unscored, better, kSystem).code(), Code::kConflict);
}

TEST_P(TeachingTest, ScoringAgainKeepsTheEarlierResult) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  auto run = [&](double score, const std::string& text) {
    Uuid lease = store_->jobs.LeaseJob(1, 1000)->value().lease;
    AttemptResult result;
    result.score = score;
    result.score_json = PutText(*store_, text);
    EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, lease).ok());
    EXPECT_TRUE(store_->jobs.FinishJob(lease, true, "").ok());
  };
  run(50, "first");
  ASSERT_TRUE(store_->judging.Rescore(attempt, "rescore", kSystem).ok());
  EXPECT_EQ(store_->judging.Rescore(attempt, "rescore", kSystem).code(), Code::kConflict)
      << "one waits";
  run(70, "second");
  auto results = store_->results.ResultsOf(attempt);
  ASSERT_EQ(results->size(), 2u);
  EXPECT_EQ(results->at(0).score, 70);
  EXPECT_EQ(results->at(0).cause, "rescore");
  EXPECT_EQ(results->at(1).score, 50);
  EXPECT_EQ(results->at(1).cause, "seal");
  EXPECT_EQ(AsText(*store_->blobs.GetBlob(results->at(1).score_json)), "first");
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->score, 70);
  EXPECT_EQ(store_->judging.Rescore(world.OpenedAttempt(), "rescore", kSystem).code(),
            Code::kConflict);
}

TEST_P(TeachingTest, AnnotationsStandByTickAndAreEditedByRevision) {
  World world(*store_);
  Uuid attempt = world.ScoredAttempt();
  AnnotationRow remark;
  remark.attempt = attempt;
  remark.tick = 700;
  remark.text = "too steep";
  Actor author{world.student, "page"};
  AnnotationRow late = *store_->remarks.AddAnnotation(remark, author);
  remark.tick = 10;
  remark.point_um = {{100, -200, 300}};
  AnnotationRow early = *store_->remarks.AddAnnotation(remark, author);
  Reopen();
  auto rows = store_->remarks.AnnotationsOf(attempt);
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ(rows->front().id, early.id);
  EXPECT_EQ(rows->front().point_um, remark.point_um);
  EXPECT_FALSE(rows->back().point_um.has_value());
  EXPECT_EQ(rows->front().author_name, "Name of student");
  late.text = "steep, and well done";
  AnnotationRow edited = *store_->remarks.ReplaceAnnotation(late, author);
  EXPECT_EQ(edited.text, late.text);
  EXPECT_GT(edited.edited_ms, 0);
  EXPECT_EQ(store_->remarks.ReplaceAnnotation(late, author).status().field(), kStale);
  ASSERT_TRUE(store_->remarks.DeleteAnnotation(late.id, edited.revision, author).ok());
  EXPECT_EQ(store_->remarks.AnnotationsOf(attempt)->size(), 1u);
  EXPECT_EQ(store_->remarks.AddAnnotation({.attempt = Uuid::New()}, author).status().code(),
            Code::kNotFound);
}

TEST_P(TeachingTest, AppealIsFiledOnceAfterTheReleaseAndAnsweredOnce) {
  World world(*store_);
  Uuid attempt = world.ScoredAttempt();
  // The run that sealing queued is over.
  ASSERT_TRUE(store_->jobs.FinishJob(store_->jobs.LeaseJob(1, 1000)->value().lease, true, "").ok());
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, {}, {}).ok());
  Actor student{world.student, "page"};
  EXPECT_EQ(store_->appeals.FileAppeal(attempt, "please", student).code(), Code::kConflict);
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
  ASSERT_TRUE(store_->appeals.FileAppeal(attempt, "the mesial wall was given", student).ok());
  EXPECT_EQ(store_->appeals.FileAppeal(attempt, "again", student).code(), Code::kConflict);
  EXPECT_EQ(store_->attempts.Attempts({.open_appeal = true})->size(), 1u);
  ASSERT_TRUE(store_->appeals.AnswerAppeal(attempt, true, "we look again", kSystem).ok());
  EXPECT_EQ(store_->appeals.AnswerAppeal(attempt, false, "no", kSystem).code(), Code::kConflict);
  AppealRow appeal = store_->appeals.AppealOf(attempt)->value();
  EXPECT_EQ(appeal.state, "regraded");
  EXPECT_EQ(appeal.answer, "we look again");
  EXPECT_TRUE(store_->attempts.Attempts({.open_appeal = true})->empty());
  auto job = store_->jobs.LeaseJob(1, 1000);
  ASSERT_TRUE(job->has_value());
  EXPECT_EQ((*job)->cause, "appeal");
}

TEST_P(TeachingTest, AppealThatCannotBeRegradedStaysOpen) {
  World world(*store_);
  Uuid attempt = world.ScoredAttempt();  // its first run is still in the queue
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
  ASSERT_TRUE(store_->appeals.FileAppeal(attempt, "please", kSystem).ok());
  EXPECT_EQ(store_->appeals.AnswerAppeal(attempt, true, "yes", kSystem).code(), Code::kConflict);
  EXPECT_EQ(store_->appeals.AppealOf(attempt)->value().state, "open")
      << "answer and run go together";
  EXPECT_TRUE(store_->appeals.AnswerAppeal(attempt, false, "no", kSystem).ok());
}

TEST_P(TeachingTest, CutThatDoesNotDoTheTaskCannotBecomeAReference) {
  World world(*store_);
  Status nothing =
      store_->references.AddReference(world.ScoredAttempt(0), "Dr. Idle", true, kSystem).status();
  EXPECT_EQ(nothing.code(), Code::kConflict);
  EXPECT_EQ(nothing.field(), "score");
}

TEST_P(TeachingTest, CutThatIsMarkedAgainCountsOnceUnderItsNewName) {
  World world(*store_);
  const Uuid cut = world.ScoredAttempt(94);
  ASSERT_TRUE(store_->references.AddReference(cut, "Dr. One", true, kSystem).ok());
  ASSERT_TRUE(store_->references.AddReference(cut, "Dr. Two", true, kSystem).ok());
  const auto all = store_->references.References(world.exercise.id);
  ASSERT_EQ(all->size(), 2u);
  EXPECT_EQ(all->front().dentist, "Dr. Two");
  EXPECT_EQ(all->front().withdrawn_ms, 0);
  EXPECT_GT(all->back().withdrawn_ms, 0);
}

TEST_P(TeachingTest, WithdrawnReferenceGivesWayToTheOneBefore) {
  World world(*store_);
  Uuid old_cut = world.ScoredAttempt(), new_cut = world.ScoredAttempt();
  ASSERT_TRUE(store_->references.AddReference(old_cut, "Dr. One", true, kSystem).ok());
  ReferenceRow newer = *store_->references.AddReference(new_cut, "Dr. Two", false, kSystem);
  EXPECT_FALSE(newer.consent);
  EXPECT_EQ(store_->references.ReferenceFor(world.exercise.id)->value().attempt, new_cut);
  ASSERT_TRUE(store_->references.WithdrawReference(newer.id, kSystem).ok());
  EXPECT_EQ(store_->references.ReferenceFor(world.exercise.id)->value().attempt, old_cut);
  auto all = store_->references.References(world.exercise.id);
  ASSERT_EQ(all->size(), 2u);
  EXPECT_GT(all->front().withdrawn_ms, 0);
  EXPECT_TRUE(all->back().consent);
  EXPECT_EQ(store_->references.AddReference(new_cut, "Dr. Two", true, kSystem)->version, 3);
}

TEST_P(TeachingTest, CancelledJobLeavesTheAttemptSealedAndItsRunCannotFinish) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  const JobRow taken = **store_->jobs.LeaseJob(1, 1000);
  const Uuid job = taken.id, run = taken.lease;
  ASSERT_TRUE(store_->results.SetProgress(run, 0.5).ok());
  EXPECT_EQ(store_->jobs.Jobs("running")->front().progress, 0.5);
  ASSERT_TRUE(store_->jobs.CancelJob(job, kSystem).ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kSealed);
  EXPECT_EQ(store_->results.SetProgress(run, 0.6).code(), Code::kUnavailable);
  EXPECT_EQ(store_->results.FinishAttempt(attempt, {}, run).code(), Code::kUnavailable);
  EXPECT_EQ(store_->results.FailAttempt(attempt, Status(Code::kConflict, "too late"), run).code(),
            Code::kUnavailable);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kSealed);
  ASSERT_TRUE(store_->jobs.FinishJob(run, false, "cancelled").ok());
  EXPECT_EQ(store_->jobs.Jobs("cancelled")->size(), 1u);
  EXPECT_FALSE(store_->jobs.LeaseJob(1, 1000)->has_value());
  EXPECT_EQ(store_->jobs.CancelJob(job, kSystem).code(), Code::kConflict);
  EXPECT_EQ(store_->jobs.CancelJob(Uuid::New(), kSystem).code(), Code::kNotFound);
  ASSERT_TRUE(store_->judging.Rescore(attempt, "rescore", kSystem).ok());
  Uuid next = store_->jobs.LeaseJob(1, 1000)->value().lease;
  EXPECT_EQ(store_->results.SetProgress(run, 0.9).code(), Code::kUnavailable)
      << "the old run goes on";
  AttemptResult result;
  result.score = 12;
  EXPECT_EQ(store_->results.FinishAttempt(attempt, result, run).code(), Code::kUnavailable);
  EXPECT_TRUE(store_->results.SetProgress(next, 0.1).ok());
  EXPECT_EQ(store_->jobs.Jobs("running")->front().progress, 0.1);
  result.score = 71;
  EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, next).ok());
  ASSERT_EQ(store_->results.ResultsOf(attempt)->size(), 1u);
  EXPECT_EQ(store_->results.ResultsOf(attempt)->front().cause, "rescore");
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->score, 71);
}

TEST_P(TeachingTest, RunWhoseLeaseWasTakenOverDoesNotQueueItsJobAgain) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  const JobRow slow = **store_->jobs.LeaseJob(1, 1000);
  const JobRow other = **store_->jobs.LeaseJob(5000, 1000);
  ASSERT_EQ(other.id, slow.id) << "taken over";
  EXPECT_EQ(store_->results.SetProgress(slow.lease, 0.5).field(), kLeaseOver)
      << "while the other one runs";
  EXPECT_EQ(store_->results.FinishAttempt(attempt, {}, slow.lease).code(), Code::kUnavailable);
  EXPECT_EQ(
      store_->results.FailAttempt(attempt, Status(Code::kConflict, "slow"), slow.lease).code(),
      Code::kUnavailable);
  ASSERT_TRUE(store_->jobs.FinishJob(slow.lease, true, "").ok());
  EXPECT_EQ(store_->jobs.Jobs("running")->size(), 1u);
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, {}, other.lease).ok());
  ASSERT_TRUE(store_->jobs.FinishJob(other.lease, true, "").ok());
  EXPECT_EQ(store_->results.FinishAttempt(attempt, {}, slow.lease).code(), Code::kUnavailable);
  ASSERT_TRUE(store_->jobs.FinishJob(slow.lease, false, "this scoring run is over").ok());
  EXPECT_TRUE(store_->jobs.Jobs("queued")->empty());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kScored);
}

TEST_P(TeachingTest, CancellingAnotherRunLeavesTheScoreThatWasThere) {
  World world(*store_);
  Uuid attempt = Rescored(world, 71);
  Uuid job = store_->jobs.LeaseJob(1, 1000)->value().id;
  ASSERT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kScoring);
  ASSERT_TRUE(store_->jobs.CancelJob(job, kSystem).ok());
  AttemptRow row = *store_->attempts.AttemptById(attempt);
  EXPECT_EQ(row.state, AttemptState::kScored);
  EXPECT_EQ(row.score, 71);
  EXPECT_EQ(row.progress, 1);
  EXPECT_TRUE(row.released);
  EXPECT_TRUE(store_->judging.Rescore(attempt, "rescore", kSystem).ok())
      << "and may be scored again";
}

TEST_P(TeachingTest, RunThatFailsLeavesTheScoreThatWasThereAndSaysWhy) {
  World world(*store_);
  Uuid attempt = Rescored(world, 71);
  for (int tries = 1; tries <= 3; ++tries) {
    auto job = store_->jobs.LeaseJob(1, 1000);
    ASSERT_TRUE(job->has_value());
    ASSERT_TRUE(store_->jobs.FinishJob((*job)->lease, false, "disk full").ok());
    AttemptRow row = *store_->attempts.AttemptById(attempt);
    EXPECT_EQ(row.state, AttemptState::kScored) << "after try " << tries;
    EXPECT_EQ(row.score, 71);
    EXPECT_EQ(row.progress, 1);
    EXPECT_TRUE(row.released);
    EXPECT_EQ(row.problem, "disk full");
  }
  EXPECT_FALSE(store_->jobs.LeaseJob(1, 1000)->has_value());
  ASSERT_TRUE(store_->judging.Rescore(attempt, "rescore", kSystem).ok());
  Uuid run = store_->jobs.LeaseJob(1, 1000)->value().lease;
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->problem, "");
  ASSERT_TRUE(
      store_->results.FailAttempt(attempt, Status(Code::kConflict, "the scene is gone"), {}).ok());
  ASSERT_TRUE(store_->jobs.FinishJob(run, true, "").ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kScored);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->problem, "the scene is gone");
  EXPECT_EQ(store_->results.ResultOf(attempt)->score, 71);
}

TEST_P(TeachingTest, ReleasedScoreThatTurnsOutOtherwiseIsReleasedAnew) {
  World world(*store_);
  Uuid attempt = Rescored(world, 71);
  AttemptResult result = *store_->results.ResultOf(attempt);
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_TRUE(store_->attempts.AttemptById(attempt)->released) << "the same score as before";
  result.score = 72;
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_FALSE(store_->attempts.AttemptById(attempt)->released);
  EXPECT_EQ(Actions()[1], "attempt.unrelease");
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
  EXPECT_TRUE(store_->attempts.AttemptById(attempt)->released);
}

TEST_P(TeachingTest, WhoJudgesAfterSomebodyElseIsToldInsteadOfOverwriting) {
  World world(*store_);
  Uuid attempt = world.ScoredAttempt();
  const int32_t seen = store_->attempts.AttemptById(attempt)->revision;
  ASSERT_TRUE(
      store_->judging.OverrideScore(attempt, ScoreOverride{90, "careful", {}, 0}, kSystem, seen)
          .ok());
  auto stale = [](const Status& status) {
    return status.code() == Code::kConflict && status.field() == kStale;
  };
  EXPECT_TRUE(stale(
      store_->judging.OverrideScore(attempt, ScoreOverride{40, "hasty", {}, 0}, kSystem, seen)));
  EXPECT_TRUE(stale(store_->judging.OverrideScore(attempt, std::nullopt, kSystem, seen)));
  EXPECT_TRUE(stale(store_->judging.ReleaseAttempt(attempt, kSystem, seen)));
  EXPECT_TRUE(stale(store_->judging.WithdrawRelease(attempt, kSystem, seen)));
  EXPECT_TRUE(stale(store_->judging.FlagAttempt(attempt, kExcused, "ill", kSystem, seen)));
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->overridden->score, 90);
  int32_t now = store_->attempts.AttemptById(attempt)->revision;
  auto moves_on = [&](const Status& status) {
    int32_t before = std::exchange(now, store_->attempts.AttemptById(attempt)->revision);
    return status.ok() && now > before;
  };
  EXPECT_TRUE(moves_on(store_->judging.ReleaseAttempt(attempt, kSystem, now)));
  EXPECT_TRUE(moves_on(store_->judging.WithdrawRelease(attempt, kSystem, now)));
  EXPECT_TRUE(moves_on(store_->judging.FlagAttempt(attempt, kExcused, "ill", kSystem, now)));
  AttemptResult result = *store_->results.ResultOf(attempt);
  EXPECT_FALSE(moves_on(store_->results.FinishAttempt(attempt, result, {}))) << "the same score";
  result.score = 12;
  EXPECT_TRUE(moves_on(store_->results.FinishAttempt(attempt, result, {}))) << "another score";
}

TEST_P(TeachingTest, HowFastARunReplayedStandsBesideItsScore) {
  World world(*store_);
  Uuid attempt = Rescored(world, 71);
  AttemptResult result = *store_->results.ResultOf(attempt);
  result.replay_realtime_factor = 31.5;
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_TRUE(store_->attempts.AttemptById(attempt)->released) << "no other score";
  EXPECT_EQ(store_->results.ResultOf(attempt)->replay_realtime_factor, 31.5);
  EXPECT_EQ(store_->results.ResultsOf(attempt)->front().replay_realtime_factor, 31.5);
}

TEST_P(TeachingTest, ScoreWithTheSamePointsAndReasonsWithdrawsNoRelease) {
  World world(*store_);
  Uuid attempt = Rescored(world, 71);
  const int32_t revision = store_->attempts.AttemptById(attempt)->revision;
  AttemptResult result = *store_->results.ResultOf(attempt);
  const Sha256 before = result.score_json;
  result.score_json = PutText(*store_, "the same score with one metric more");
  result.same_judgement_as = before;
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_TRUE(store_->attempts.AttemptById(attempt)->released);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->revision, revision);
  EXPECT_EQ(store_->results.ResultOf(attempt)->score_json, result.score_json)
      << "the newest is kept";

  // The score that it was found equal to has been replaced.
  result.score_json = PutText(*store_, "another");
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_FALSE(store_->attempts.AttemptById(attempt)->released);
}

// The reference comes between a run's look for one and its end.
TEST_P(TeachingTest, ReferenceThatComesWhileARunLooksForOneHasItRunAgain) {
  World world(*store_);
  Uuid reference = world.ScoredAttempt();
  while (auto job = *store_->jobs.LeaseJob(1, 1000)) {
    ASSERT_TRUE(
        store_->results.FinishAttempt(reference, *store_->results.ResultOf(reference), job->lease)
            .ok());
    ASSERT_TRUE(store_->jobs.FinishJob(job->lease, true, "").ok());
  }
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  JobRow run = **store_->jobs.LeaseJob(1, 1000);
  ASSERT_EQ(run.attempt, attempt);
  ASSERT_FALSE(store_->references.ReferenceFor(world.exercise.id)->has_value());
  ASSERT_TRUE(store_->references.AddReference(reference, "Dr. Example", true, kSystem).ok());
  auto queued = [&] {
    auto jobs = *store_->jobs.Jobs("queued");
    return std::ranges::count(jobs, attempt, &JobRow::attempt);
  };
  EXPECT_EQ(queued(), 1);
  for (auto other = *store_->jobs.LeaseJob(2, 1000); other;
       other = *store_->jobs.LeaseJob(2, 1000)) {
    EXPECT_NE(other->attempt, attempt) << "one run of an attempt at a time";
    ASSERT_TRUE(
        store_->results.FinishAttempt(reference, *store_->results.ResultOf(reference), other->lease)
            .ok());
    ASSERT_TRUE(store_->jobs.FinishJob(other->lease, true, "").ok());
  }
  AttemptResult result = *store_->results.ResultOf(reference);
  ASSERT_FALSE(result.reference.has_value());
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, run.lease).ok());
  ASSERT_TRUE(store_->jobs.FinishJob(run.lease, true, "").ok());
  auto again = *store_->jobs.LeaseJob(3, 1000);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->attempt, attempt);
  result.reference = reference;
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, again->lease).ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kScored);
}

TEST_P(TeachingTest, ReleaseOfPracticeIsNotWithdrawnUnlessItIsAnExam) {
  World world(*store_);
  ExerciseRow practice = world.Exercise("practice", "p1");
  practice.graded = false;
  world.exercise = *store_->exercises.PublishExercise(practice, Uuid{}, kSystem);
  Uuid attempt = Rescored(world, 71);
  AttemptResult result = *store_->results.ResultOf(attempt);
  result.score = 72;
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_TRUE(store_->attempts.AttemptById(attempt)->released);
}

TEST_P(TeachingTest, ErasingAPersonTakesRemarksAppealsAndEarlierResultsWithIt) {
  World world(*store_);
  Uuid attempt = world.ScoredAttempt();
  Sha256 text = store_->results.ResultsOf(attempt)->front().score_json;
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
  ASSERT_TRUE(store_->appeals.FileAppeal(attempt, "please", Actor{world.student, "page"}).ok());
  AnnotationRow remark{.attempt = attempt, .text = "well done"};
  ASSERT_TRUE(store_->remarks.AddAnnotation(remark, kSystem).ok());
  auto report = store_->erasures.ErasePerson(world.student, false, kSystem);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(store_->remarks.AnnotationsOf(attempt)->empty());
  EXPECT_FALSE(store_->appeals.AppealOf(attempt)->has_value());
  EXPECT_TRUE(store_->results.ResultsOf(attempt)->empty());
  EXPECT_FALSE(store_->blobs.HasBlob(text));
}

TEST_P(TeachingTest, ErasingAPersonTakesTheWordsOutOfTheAuditTrailAndLeavesOthersTheirs) {
  World world(*store_);
  Uuid other = AddPerson(*store_, "other", Role::kStudent);
  Uuid theirs = world.NewAttemptOf(other).id, attempt = world.ScoredAttempt();
  ASSERT_TRUE(store_->judging.ReleaseAttempt(attempt, kSystem).ok());
  ASSERT_TRUE(
      store_->appeals.FileAppeal(attempt, "secret words", Actor{world.student, "page"}).ok());
  ASSERT_TRUE(store_->appeals.AnswerAppeal(attempt, false, "secret words", kSystem).ok());
  ASSERT_TRUE(
      store_->judging.OverrideScore(attempt, ScoreOverride{50, "secret words", {}, 0}, kSystem)
          .ok());
  ASSERT_TRUE(store_->judging.FlagAttempt(attempt, kExcused, "secret words", kSystem).ok());
  AnnotationRow remark;
  remark.attempt = attempt;
  remark.text = "secret words";
  remark = *store_->remarks.AddAnnotation(remark, kSystem);
  ASSERT_TRUE(store_->remarks.DeleteAnnotation(remark.id, remark.revision, kSystem).ok());
  ASSERT_TRUE(store_->judging.FlagAttempt(theirs, kExcused, "was ill", kSystem).ok());
  auto told = [&](const std::string& words) {
    auto rows = *store_->audit.Audit(1000);
    return std::ranges::count_if(rows, [&](const AuditRow& row) {
      return (row.before_json + row.after_json).find(words) != std::string::npos;
    });
  };
  auto rows_before = store_->audit.Audit(1000)->size();
  ASSERT_EQ(told("secret words"), 6);
  auto report = store_->erasures.ErasePerson(world.student, false, kSystem);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_EQ(told("secret words"), 0);
  EXPECT_EQ(told("was ill"), 1) << "of somebody who is there";
  EXPECT_EQ(store_->audit.Audit(1000)->size(), rows_before + 1) << "rows stay";
  auto actions = Actions();
  EXPECT_NE(std::ranges::find(actions, "appeal.file"), actions.end());
}

TEST_P(TeachingTest, PictureOfASceneIsKeptWithIt) {
  World world(*store_);
  EXPECT_TRUE(store_->scenes.Scenes()->front().surface.IsZero());
  Sha256 surface = PutText(*store_, "ENTM");
  ASSERT_TRUE(
      store_->scenes.PutSceneSurface(store_->scenes.Scenes()->front().volume, surface).ok());
  Reopen();
  EXPECT_EQ(store_->scenes.Scenes()->front().surface, surface);
}

UnixMs Now() {
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

TEST_P(TeachingTest, ExamKeepsItsVersionAndIsNeitherMovedNorRetiredUntilItIsOver) {
  World world(*store_);
  AssignmentRow exam = Assigned(Cohort("year 1", world.student), 0, true);
  ExerciseRow draft = *store_->exercises.PutDraft(world.Exercise("exercise", "d"), kSystem);
  draft = *store_->exercises.PublishDraft(draft.id, draft.revision, kSystem);
  EXPECT_EQ(store_->assignments.AssignmentById(exam.id)->version_id, world.exercise.id);
  auto refusals = [&] {
    return std::vector<Status>{
        store_->assignments.MoveAssignment(exam.id, draft.id, exam.revision, false, kSystem)
            .status(),
        store_->assignments.MoveAssignment(exam.id, draft.id, 0, true, kSystem).status(),
        store_->exercises.RetireExercise(world.exercise.id, kSystem)};
  };
  for (const Status& status : refusals()) {
    EXPECT_EQ(status.code(), Code::kConflict);
    EXPECT_EQ(status.field(), "assignment");
    EXPECT_NE(status.message().find(exam.id.Text()), std::string::npos) << status.message();
    EXPECT_NE(status.message().find("year 1"), std::string::npos) << status.message();
  }
  const AssignmentRow practice = Assigned(Cohort("year 2", world.student));
  EXPECT_TRUE(store_->assignments
                  .MoveAssignment(practice.id, world.exercise.id, practice.revision, false, kSystem)
                  .ok())
      << "another's exam is in nobody's way";
  Uuid taken = *Begin(world, exam, [](AttemptRow& row) { row.ticketed_ms = Now(); });
  ASSERT_TRUE(store_->tickets.OpenAttempt(taken, AsBytes("header")).ok());
  exam.due_ms = Now() - 1000;
  exam = *store_->assignments.ReplaceAssignment(exam, kSystem);
  for (const Status& status : refusals()) EXPECT_EQ(status.code(), Code::kConflict) << "running";
  ASSERT_TRUE(store_->judging.FlagAttempt(taken, kExcused, "ill", kSystem).ok());
  EXPECT_TRUE(
      store_->assignments.MoveAssignment(exam.id, draft.id, exam.revision, false, kSystem).ok());
  EXPECT_TRUE(store_->exercises.RetireExercise(draft.id, kSystem, "a newer one").ok());
}

TEST_P(TeachingTest, AssignmentStaysWithItsVersionUntilSomebodyMovesIt) {
  World world(*store_);
  AssignmentRow row = Assigned(Cohort("year 1", world.student));
  EXPECT_EQ(row.version_id, world.exercise.id);
  EXPECT_EQ(row.version, 1);
  const Uuid before = *Begin(world, row), begun = *Begin(world, row);
  ASSERT_TRUE(store_->tickets.OpenAttempt(begun, AsBytes("header")).ok());
  const ExerciseRow second =
      *store_->exercises.PublishExercise(world.Exercise("exercise", "v2"), Uuid{}, kSystem);
  const ExerciseRow other =
      *store_->exercises.PublishExercise(world.Exercise("other", "o"), {}, kSystem);
  row.due_ms = Now() + 3'600'000;
  row = *store_->assignments.ReplaceAssignment(row, kSystem);
  EXPECT_EQ(row.version_id, world.exercise.id) << "other terms are no other work";
  const std::vector<AssignmentRow> all = *store_->assignments.Assignments({});
  EXPECT_EQ(std::ranges::count(all, world.exercise.id, &AssignmentRow::version_id), 2)
      << "nor did the one for everybody follow";

  auto look = store_->assignments.MoveAssignment(row.id, second.id, 0, true, kSystem);
  ASSERT_TRUE(look.ok()) << look.status().message();
  EXPECT_EQ(look->before.version, 1);
  EXPECT_EQ(look->after.version, 2);
  EXPECT_EQ(look->attempts, 2u);
  EXPECT_EQ(look->tickets, 1u);
  EXPECT_EQ(store_->assignments.AssignmentById(row.id)->version, 1) << "only looked at";
  for (const Uuid& wrong : {other.id, Uuid::New()}) {
    EXPECT_EQ(store_->assignments.MoveAssignment(row.id, wrong, row.revision, false, kSystem)
                  .status()
                  .field(),
              "exercise_id");
  }
  EXPECT_EQ(store_->assignments.MoveAssignment(row.id, second.id, row.revision - 1, false, kSystem)
                .status()
                .field(),
            kStale);
  auto moved = store_->assignments.MoveAssignment(row.id, second.id, row.revision, false, kSystem);
  ASSERT_TRUE(moved.ok()) << moved.status().message();
  EXPECT_EQ(moved->after.revision, row.revision + 1);
  EXPECT_EQ(store_->assignments.AssignmentById(row.id)->version_id, second.id);
  EXPECT_EQ(store_->attempts.AttemptById(before)->exercise, world.exercise.id)
      << "tickets keep theirs";
  EXPECT_TRUE(store_->tickets.OpenAttempt(before, AsBytes("header")).ok());
  const AuditRow told = store_->audit.Audit(1)->front();
  EXPECT_EQ(told.action, "assignment.move");
  EXPECT_NE(told.before_json.find("\"version\":\"1\""), std::string::npos) << told.before_json;
  EXPECT_NE(told.after_json.find("\"version\":\"2\""), std::string::npos) << told.after_json;
}

TEST_P(TeachingTest, ExamTicketThatRanOutUnopenedIsNoExamUnderWay) {
  World world(*store_);
  AssignmentRow exam = Assigned(Cohort("year 1", world.student), 0, true);
  ASSERT_TRUE(Begin(world, exam).ok());
  auto at = [](UnixMs time_ms) { return [=](AttemptRow& row) { row.ticketed_ms = time_ms; }; };
  EXPECT_EQ(Begin(world, exam, at(5 + kExamTicketValidMs)).status().field(), "exam");
  auto next = Begin(world, exam, at(6 + kExamTicketValidMs));
  ASSERT_TRUE(next.ok()) << next.status().message();
  ASSERT_TRUE(store_->tickets.OpenAttempt(*next, AsBytes("header")).ok());
  EXPECT_EQ(Begin(world, exam, at(7 + 10 * kExamTicketValidMs)).status().field(), "exam")
      << "begun in time and not finished";
}

TEST_P(TeachingTest, TicketHandedBackUnusedCountsForNothingAndOpensNothing) {
  World world(*store_);
  AssignmentRow exam = Assigned(Cohort("year 1", world.student), 1, true);
  Uuid returned = *Begin(world, exam);
  EXPECT_EQ(Begin(world, exam).status().field(), "attempt_limit");
  EXPECT_EQ(store_->tickets.ReturnTicket(Uuid::New(), kSystem).code(), Code::kNotFound);
  auto rows_before = store_->audit.Audit(1000)->size();
  for (int again = 0; again < 2; ++again) {
    ASSERT_TRUE(store_->tickets.ReturnTicket(returned, Actor{{}, "station bench-1"}).ok());
    EXPECT_EQ(store_->audit.Audit(1000)->size(), rows_before + 1) << "told once";
    EXPECT_EQ(store_->attempts.AttemptById(returned)->flags, uint32_t{kReturned});
    EXPECT_EQ(store_->assignments.AssignmentsFor(world.student)->front().attempts_used, 0u);
  }
  AuditRow row = store_->audit.Audit(1)->front();
  EXPECT_EQ(row.action, "attempt.return");
  EXPECT_EQ(row.object, returned.Text());
  EXPECT_EQ(row.actor, "station bench-1");
  EXPECT_EQ(store_->tickets.OpenAttempt(returned, AsBytes("header")).code(), Code::kConflict);
  EXPECT_EQ(store_->attempts.AttemptById(returned)->state, AttemptState::kTicketed);
  EXPECT_TRUE(Begin(world, exam).ok()) << "neither the limit nor another exam is in the way";
}

TEST_P(TeachingTest, TicketThatWasOpenedIsNotTakenBack) {
  World world(*store_);
  AssignmentRow once = Assigned(Cohort("year 1", world.student), 1);
  Uuid attempt = *Begin(world, once);
  ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  auto refused = [&] {
    Status status = store_->tickets.ReturnTicket(attempt, kSystem);
    EXPECT_NE(status.message().find("excuse"), std::string::npos) << status.message();
    return status.code();
  };
  EXPECT_EQ(refused(), Code::kConflict) << "without a tick";
  auto chunks = world.Append(attempt, 1);
  EXPECT_EQ(refused(), Code::kConflict) << "with one";
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  EXPECT_EQ(refused(), Code::kConflict) << "sealed";
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags, 0u);
  EXPECT_EQ(Begin(world, once).status().field(), "attempt_limit");
}

TEST_P(TeachingTest, AssignmentWithAttemptsStaysSoThatTheyCanBeReleasedTogether) {
  World world(*store_);
  AssignmentRow row = Assigned(Cohort("year 1", world.student));
  Uuid unused = *Begin(world, row), attempt = *Begin(world, row);
  ASSERT_TRUE(store_->tickets.ReturnTicket(unused, kSystem).ok());
  ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  Status refused = store_->assignments.DeleteAssignment(row.id, row.revision, kSystem);
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_EQ(refused.field(), "attempts");
  EXPECT_NE(refused.message().find("1 attempt was"), std::string::npos) << refused.message();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, {}, {}).ok());
  EXPECT_EQ(*store_->judging.ReleaseAssignment(row.id, kSystem), 1u);
}

TEST_P(TeachingTest, ArchivedCohortIsOfferedNothing) {
  World world(*store_);
  Uuid teacher = AddPerson(*store_, "teacher", Role::kInstructor);
  std::vector<AssignmentRow> everybodys = *store_->assignments.Assignments({});
  for (const AssignmentRow& row : everybodys) {
    ASSERT_TRUE(store_->assignments.DeleteAssignment(row.id, row.revision, kSystem).ok());
  }
  Uuid cohort = Cohort("year 1", teacher);
  Assigned(cohort);
  EXPECT_EQ(store_->exercises.ExercisesFor(teacher)->size(), 1u);
  CohortEdit archive;
  archive.archived = true;
  ASSERT_TRUE(store_->cohorts.EditCohort(cohort, archive, 1, kSystem).ok());
  EXPECT_TRUE(store_->exercises.ExercisesFor(teacher)->empty());
  EXPECT_TRUE(store_->assignments.AssignmentsFor(teacher)->empty());
}

TEST_P(TeachingTest, EveryChangeIsAudited) {
  World world(*store_);
  auto draft = store_->exercises.PutDraft(world.Exercise("exercise", "d"), kSystem);
  ASSERT_TRUE(store_->exercises.PublishDraft(draft->id, 1, kSystem).ok());
  AssignmentRow row = Assigned(Cohort("mine", world.student));
  ASSERT_TRUE(store_->assignments.ReplaceAssignment(row, kSystem).ok());
  Uuid attempt = *Begin(world, row);
  ASSERT_TRUE(store_->judging.FlagAttempt(attempt, kExcused, "ill", kSystem).ok());
  ASSERT_TRUE(store_->tickets.ReturnTicket(attempt, kSystem).ok());
  ASSERT_TRUE(store_->assignments.DeleteAssignment(row.id, 2, kSystem).ok());
  ASSERT_TRUE(store_->exercises.RetireExercise(draft->id, kSystem, "a newer one").ok());
  std::vector<std::string> actions = Actions();
  for (const char* action :
       {"exercise.draft", "exercise.publish", "exercise.retire", "assignment.add",
        "assignment.edit", "assignment.delete", "attempt.flag", "attempt.return"}) {
    EXPECT_NE(std::ranges::find(actions, action), actions.end()) << action;
  }
}

TEST_P(TeachingTest, NewestCorrectionOfARubricCountsAndEarlierOnesStay) {
  World world(*store_);
  const Uuid exercise = world.exercise.id;
  EXPECT_FALSE(store_->rubrics.RubricFor(exercise)->has_value());
  RubricRow row{exercise, 2, PutText(*store_, "rubric 2"), "walls counted twice", 0};
  ASSERT_TRUE(store_->rubrics.PublishRubric(row, kSystem).ok());
  RubricRow next{exercise, 3, PutText(*store_, "rubric 3"), "and floors", 0};
  ASSERT_TRUE(store_->rubrics.PublishRubric(next, kSystem).ok());
  Reopen();
  auto counting = store_->rubrics.RubricFor(exercise);
  ASSERT_TRUE(counting.ok() && counting->has_value());
  EXPECT_EQ((*counting)->version, 3);
  EXPECT_EQ((*counting)->content, next.content);
  EXPECT_EQ((*counting)->reason, "and floors");
  EXPECT_GT((*counting)->published_ms, 0);
  ASSERT_EQ(store_->rubrics.Rubrics(exercise)->size(), 2u);
  EXPECT_EQ(store_->rubrics.Rubrics(exercise)->back().content, row.content);
  EXPECT_TRUE(store_->blobs.HasBlob(row.content));
}

TEST_P(TeachingTest, ACorrectionOfAnotherRubricThanTheNewestIsStale) {
  World world(*store_);
  const Uuid exercise = world.exercise.id;
  auto publish = [&](int32_t version, const char* text) {
    return store_->rubrics
        .PublishRubric({exercise, version, PutText(*store_, text), "why", 0}, kSystem)
        .status();
  };
  ASSERT_TRUE(publish(5, "five").ok()) << "the exercise's own may have any version";
  EXPECT_EQ(publish(5, "another").field(), kStale);
  EXPECT_EQ(publish(8, "another").field(), kStale);
  EXPECT_EQ(publish(6, "five").code(), Code::kConflict) << "says nothing new";
  EXPECT_TRUE(publish(6, "six").ok());
  RubricRow nowhere{Uuid::New(), 2, PutText(*store_, "x"), "why", 0};
  EXPECT_EQ(store_->rubrics.PublishRubric(nowhere, kSystem).status().code(), Code::kNotFound);
  RubricRow unstored{exercise, 7, HashSha256(AsBytes("nobody put this")), "why", 0};
  EXPECT_EQ(store_->rubrics.PublishRubric(unstored, kSystem).status().code(), Code::kNotFound);
}

TEST_P(TeachingTest, ABatchScoresWhatItCanAndLeavesOutTheRest) {
  World world(*store_);
  const Uuid first = Settled(world), second = Settled(world);
  const Uuid open = world.OpenedAttempt();
  uint32_t left_out = 0;
  BatchRow wanted;
  wanted.title = "year 1";
  wanted.cause = "rubric";
  wanted.cohort = Cohort("year 1", world.student);
  auto batch = store_->batches.RescoreTogether(wanted, {first, open, second, Uuid::New()}, left_out,
                                               kSystem);
  ASSERT_TRUE(batch.ok()) << batch.status().message();
  EXPECT_EQ(left_out, 2u);
  EXPECT_EQ(batch->queued, 2u);
  EXPECT_EQ(batch->title, "year 1");
  EXPECT_EQ(batch->cohort, wanted.cohort);
  EXPECT_FALSE(batch->over());
  // Both are waiting now.
  EXPECT_EQ(
      store_->batches.RescoreTogether(wanted, {first, second}, left_out, kSystem).status().code(),
      Code::kConflict);
  EXPECT_EQ(store_->batches.Batches()->size(), 1u) << "what is refused leaves nothing";

  auto job = *store_->jobs.LeaseJob(1, 1000);
  ASSERT_TRUE(job);
  EXPECT_EQ(job->batch, batch->id);
  EXPECT_EQ(job->cause, "rubric");
  EXPECT_EQ(store_->batches.BatchById(batch->id)->running, 1u);
  ASSERT_TRUE(store_->results
                  .FinishAttempt(job->attempt, *store_->results.ResultOf(job->attempt), job->lease)
                  .ok());
  ASSERT_TRUE(store_->jobs.FinishJob(job->lease, true, "").ok());
  EXPECT_EQ(store_->batches.BatchById(batch->id)->done, 1u);
  ASSERT_TRUE(store_->batches.CancelBatch(batch->id, kSystem).ok());
  EXPECT_EQ(store_->batches.BatchById(batch->id)->cancelled, 1u);
  EXPECT_TRUE(store_->batches.BatchById(batch->id)->over());
  EXPECT_EQ(store_->batches.CancelBatch(batch->id, kSystem).code(), Code::kConflict);
  EXPECT_EQ(store_->batches.BatchById(Uuid::New()).status().code(), Code::kNotFound);
  JobFilter filter;
  filter.batch = batch->id;
  EXPECT_EQ(store_->jobs.FindJobs(filter)->size(), 2u);
}

TEST_P(TeachingTest, SomebodyWhoWaitsGoesBeforeABatch) {
  World world(*store_);
  const Uuid old = Settled(world);
  uint32_t left_out = 0;
  ASSERT_TRUE(store_->batches.RescoreTogether({}, {old}, left_out, kSystem).ok());
  const Uuid fresh = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(fresh, 1)), 200).ok());
  auto job = *store_->jobs.LeaseJob(1, 1000);
  ASSERT_TRUE(job);
  EXPECT_EQ(job->attempt, fresh);
  EXPECT_FALSE(job->batch);
}

}  // namespace
}  // namespace enamel::server
