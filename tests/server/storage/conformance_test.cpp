#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include "server/storage/store_engine.h"
#include "server/training/names.h"
#include "tests/server/storage/backends.h"

// What every backend of Store must do: people, stations, content, results, references, jobs, audit.
namespace enamel::server {
namespace {

using namespace testing;

class StoreTest : public StoreSuite {};
INSTANTIATE_TEST_SUITE_P(Backends, StoreTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(StoreTest, PersonIsFoundByIdAndLoginAfterReopening) {
  Uuid id = AddPerson(*store_, "ada", Role::kInstructor, "verifier");
  Reopen();
  EXPECT_EQ(store_->people.PersonById(id)->login, "ada");
  EXPECT_EQ(store_->people.PersonByLogin("ada")->role, Role::kInstructor);
  EXPECT_EQ(*store_->people.PasswordVerifier(id), "verifier");
  EXPECT_EQ(store_->people.PersonByLogin("nobody").status().code(), Code::kNotFound);
}

TEST_P(StoreTest, SecondPersonWithTheSameLoginIsAConflict) {
  AddPerson(*store_, "ada", Role::kStudent);
  Person again;
  again.login = "ada";
  auto refused = store_->people.CreatePerson(again, "x", {}, kSystem);
  EXPECT_EQ(refused.status().code(), Code::kConflict);
  EXPECT_NE(refused.status().message().find("ada"), std::string::npos);
}

TEST_P(StoreTest, DisablingAPersonEndsItsSessions) {
  Uuid id = AddPerson(*store_, "ada", Role::kStudent);
  Sha256 token = HashSha256(AsBytes("token"));
  ASSERT_TRUE(store_->sessions.CreateSession({token, id, 1, 1, 1000, "page"}).ok());
  ASSERT_TRUE(store_->sessions.FindSession(token).ok());
  ASSERT_TRUE(store_->people.SetDisabled(id, true, kSystem).ok());
  EXPECT_EQ(store_->sessions.FindSession(token).status().code(), Code::kNotFound);
}

TEST_P(StoreTest, PersonIsAddedWithTheCohortsOrNotAtAll) {
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  Person ada;
  ada.login = "ada";
  ada.display_name = "Ada";
  auto refused = store_->people.CreatePerson(ada, "x", {cohort, Uuid::New()}, kSystem);
  EXPECT_EQ(refused.status().code(), Code::kNotFound);
  EXPECT_EQ(refused.status().field(), "cohorts");
  EXPECT_EQ(store_->people.PersonByLogin("ada").status().code(), Code::kNotFound);
  EXPECT_TRUE(store_->cohorts.CohortMembers(cohort)->empty());
  auto id = store_->people.CreatePerson(ada, "x", {cohort, cohort}, kSystem);
  ASSERT_TRUE(id.ok()) << id.status().message();
  EXPECT_EQ(store_->cohorts.CohortsOf(*id)->size(), 1u);
}

TEST_P(StoreTest, NewPasswordEndsSessionsMadeWithTheOldOne) {
  Uuid id = AddPerson(*store_, "ada", Role::kStudent);
  Sha256 token = HashSha256(AsBytes("token"));
  ASSERT_TRUE(store_->sessions.CreateSession({token, id, 1, 1, 1000, "page"}).ok());
  ASSERT_TRUE(store_->people.SetPassword(id, "new", false, kSystem).ok());
  EXPECT_FALSE(store_->sessions.FindSession(token).ok());
}

TEST_P(StoreTest, MembersAreAddedOnceAndToKnownCohorts) {
  Uuid a = AddPerson(*store_, "a", Role::kStudent), b = AddPerson(*store_, "b", Role::kInstructor);
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, a, kSystem).ok());
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, b, kSystem).ok());
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, b, kSystem).ok())
      << "adding twice changes nothing";
  EXPECT_EQ(store_->cohorts.CohortMembers(cohort)->size(), 2u);
  EXPECT_EQ(store_->cohorts.AddToCohort(Uuid::New(), a, kSystem).code(), Code::kNotFound);
}

TEST_P(StoreTest, EnrolmentCodeWorksOnceAndBeforeItExpires) {
  Sha256 code = HashSha256(AsBytes("a")), late = HashSha256(AsBytes("b"));
  ASSERT_TRUE(store_->stations.AddEnrolCode(code, 1000, kSystem).ok());
  ASSERT_TRUE(store_->stations.AddEnrolCode(late, 1000, kSystem).ok());
  StationRow row;
  row.name = "s";
  row.public_key.assign(32, 7);
  Sha256 credential = HashSha256(AsBytes("credential"));
  auto station = store_->stations.EnrolStation(code, row, credential, 1000);
  ASSERT_TRUE(station.ok()) << station.status().message();
  EXPECT_EQ(store_->stations.EnrolStation(code, row, credential, 1000).status().code(),
            Code::kUnauthenticated);
  EXPECT_EQ(store_->stations.EnrolStation(late, row, credential, 1001).status().code(),
            Code::kUnauthenticated);
  EXPECT_EQ(store_->stations.StationByCredential(station->id, credential)->public_key,
            row.public_key);
  EXPECT_EQ(store_->stations.StationByCredential(station->id, late).status().code(),
            Code::kNotFound);
}

TEST_P(StoreTest, BlobReadsBackAndAbsentOneIsNotFound) {
  Bytes data(100'000, 42);
  Sha256 hash = *store_->blobs.PutBlob(data);
  EXPECT_EQ(hash, HashSha256(data));
  EXPECT_EQ(*store_->blobs.PutBlob(data), hash);
  EXPECT_EQ(*store_->blobs.GetBlob(hash), data);
  EXPECT_EQ(store_->blobs.GetBlob(Sha256{}).status().code(), Code::kNotFound);
}

TEST_P(StoreTest, PublishingTheSameContentAgainKeepsTheVersion) {
  World world(*store_);
  auto same = store_->exercises.PublishExercise(world.Exercise("exercise", "v1"), Uuid{}, kSystem);
  EXPECT_EQ(same->id, world.exercise.id);
  auto next = store_->exercises.PublishExercise(world.Exercise("exercise", "v2"), Uuid{}, kSystem);
  EXPECT_EQ(next->version, 2);
  auto all = store_->exercises.AllExercises();
  ASSERT_EQ(all->size(), 1u);
  EXPECT_EQ(all->front().content, next->content);
  EXPECT_EQ(store_->exercises.ExerciseByContent(world.exercise.content)->version, 1);
}

TEST_P(StoreTest, ExerciseOfACohortIsOfferedToItsMembersOnly) {
  World world(*store_);
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  ASSERT_TRUE(
      store_->exercises.PublishExercise(world.Exercise("closed", "c1"), cohort, kSystem).ok());
  EXPECT_EQ(store_->exercises.ExercisesFor(world.student)->size(), 1u) << "the open one";
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, world.student, kSystem).ok());
  EXPECT_EQ(store_->exercises.ExercisesFor(world.student)->size(), 2u);
}

TEST_P(StoreTest, AttemptFiltersNarrowAndPage) {
  World world(*store_);
  Uuid other = AddPerson(*store_, "other", Role::kStudent);
  Uuid instructor = AddPerson(*store_, "instructor", Role::kInstructor);
  Uuid cohort = *store_->cohorts.CreateCohort("year 1", kSystem);
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, other, kSystem).ok());
  ASSERT_TRUE(store_->cohorts.AddToCohort(cohort, instructor, kSystem).ok());
  world.NewAttempt();
  world.NewAttemptOf(other);
  auto count = [&](AttemptFilter filter) { return store_->attempts.Attempts(filter)->size(); };
  EXPECT_EQ(count({}), 2u);
  EXPECT_EQ(count({.person = world.student}), 1u);
  EXPECT_EQ(count({.cohort = cohort}), 1u);
  EXPECT_EQ(store_->attempts.Attempts({.taught_by = instructor})->front().person, other);
  EXPECT_EQ(count({.taught_by = world.student}), 0u);
  EXPECT_EQ(count({.person = other, .cohort = cohort, .exercise = world.exercise.id}), 1u);
  AttemptRow newest = store_->attempts.Attempts({.limit = 1})->front();
  EXPECT_EQ(count({.before = newest.id}), 1u);
}

// Students of cohort A, of both cohorts, and of none, each with work under A's, B's and everybody's assignment, and with
// practice.
TEST_P(StoreTest, AssignmentsCohortSaysWhoTeachesAnAttemptInListsAndAlone) {
  World world(*store_);
  const Uuid a = *store_->cohorts.CreateCohort("A", kSystem);
  const Uuid b = *store_->cohorts.CreateCohort("B", kSystem);
  auto person = [&](const char* login, Role role, const std::vector<Uuid>& cohorts) {
    const Uuid id = AddPerson(*store_, login, role);
    for (const Uuid& in : cohorts) EXPECT_TRUE(store_->cohorts.AddToCohort(in, id, kSystem).ok());
    return id;
  };
  const Uuid ada = person("ada", Role::kInstructor, {a}),
             ben = person("ben", Role::kInstructor, {b});
  const Uuid sam = person("sam", Role::kStudent, {a}), sue = person("sue", Role::kStudent, {a, b});
  const Uuid left = person("left", Role::kStudent, {});
  auto assigned = [&](const Uuid& cohort) {
    AssignmentRow row;
    row.exercise = world.exercise.name;
    row.cohort = cohort;
    return store_->assignments.AddAssignment(row, kSystem)->id;
  };
  const struct {
    const char* what;
    std::optional<Uuid> assignment;
    bool ada_of_sam, ben_of_sam, ada_of_sue, ben_of_sue, ada_of_left, ben_of_left;
  } cases[] = {{"A's", assigned(a), true, false, true, false, true, false},
               {"B's", assigned(b), false, true, false, true, false, true},
               {"everybody's", assigned({}), true, false, true, true, false, false},
               {"practice", {}, true, false, true, true, false, false}};
  // Instructors of an archived cohort still see its work.
  ASSERT_TRUE(store_->cohorts.EditCohort(a, {{}, true}, 1, kSystem).ok());
  std::map<Uuid, std::set<Uuid>> alone, listed;
  for (const auto& c : cases) {
    auto expect = [&](const Uuid& student, bool adas, bool bens) {
      AttemptRow row = world.AttemptOf(student);
      row.assignment = c.assignment;
      ASSERT_TRUE(store_->tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
      EXPECT_EQ(*store_->attempts.Teaches(ada, row.id), adas) << c.what;
      EXPECT_EQ(*store_->attempts.Teaches(ben, row.id), bens) << c.what;
      if (adas) alone[ada].insert(row.id);
      if (bens) alone[ben].insert(row.id);
    };
    expect(sam, c.ada_of_sam, c.ben_of_sam);
    expect(sue, c.ada_of_sue, c.ben_of_sue);
    expect(left, c.ada_of_left, c.ben_of_left);
  }
  for (const Uuid& instructor : {ada, ben}) {
    const auto rows = store_->attempts.Attempts({.taught_by = instructor});
    for (const AttemptRow& row : *rows) listed[instructor].insert(row.id);
  }
  EXPECT_EQ(listed, alone);
}

TEST_P(StoreTest, AttemptsAreFoundByNameAndComeInOrderPageByPage) {
  World world(*store_);
  std::vector<Uuid> people;
  for (const char* name : {"Émile", "Dora", "emil", "Álvaro"}) {
    people.push_back(AddPerson(*store_, "p" + std::to_string(people.size()), Role::kStudent));
    ASSERT_TRUE(store_->people.EditPerson(people.back(), {.display_name = name}, 1, kSystem).ok());
    world.NewAttemptOf(people.back());
  }
  world.NewAttemptOf(people[0]);
  const Uuid low = world.ScoredAttempt(20), high = world.ScoredAttempt(90);
  const auto walked = [&](AttemptFilter filter) {
    std::vector<AttemptRow> out;
    filter.limit = 2;
    for (size_t page = 0; page < 10; ++page) {
      const auto rows = store_->attempts.Attempts(filter);
      EXPECT_TRUE(rows.ok()) << rows.status().message();
      out.insert(out.end(), rows->begin(), rows->end());
      if (rows->size() < filter.limit) break;
      filter.before = rows->back().id;
    }
    return out;
  };
  std::string names;
  for (const AttemptRow& row : walked({.name = "P", .order = AttemptFilter::Order::kName})) {
    names += row.person_name + " ";
  }
  EXPECT_EQ(names, "Álvaro Dora emil Émile Émile ");
  EXPECT_EQ(walked({.name = "EMIL"}).size(), 3u);
  EXPECT_EQ(walked({.name = "emile p0"}).size(), 2u);
  const auto scored = walked({.order = AttemptFilter::Order::kLowestScore});
  ASSERT_EQ(scored.size(), 7u);
  EXPECT_EQ(scored[0].id, low);
  EXPECT_EQ(scored[1].id, high);
  EXPECT_FALSE(scored[2].score.has_value());
}

// An index gives the pages of a large set; the store sorts a small set. Both must be parts of the same list.
TEST_P(StoreTest, PagesInEveryOrderAreTheWholeListSorted) {
  World world(*store_);
  using Order = AttemptFilter::Order;
  std::vector<Uuid> students;
  for (const char* name : {"Bo", "Ann", "ann", "Ada"}) {
    students.push_back(AddPerson(*store_, "s" + std::to_string(students.size()), Role::kStudent));
    ASSERT_TRUE(
        store_->people.EditPerson(students.back(), {.display_name = name}, 1, kSystem).ok());
  }
  const Uuid outside = students.back();
  const Uuid large = *store_->cohorts.CreateCohort("large", kSystem),
             small = *store_->cohorts.CreateCohort("small", kSystem);
  const Uuid of_many = AddPerson(*store_, "many", Role::kInstructor),
             of_few = AddPerson(*store_, "few", Role::kInstructor);
  ASSERT_TRUE(
      store_->cohorts
          .ChangeMembers(large, {students[0], students[1], students[2], of_many}, {}, kSystem)
          .ok());
  ASSERT_TRUE(store_->cohorts.ChangeMembers(small, {outside, of_few}, {}, kSystem).ok());
  AssignmentRow terms;
  terms.exercise = world.exercise.name;
  terms.cohort = large;
  const Uuid assignment = store_->assignments.AddAssignment(terms, kSystem)->id;
  const auto add = [&](Db& db, int i) {
    const bool outsider = i % 11 == 0;
    Query q(db,
            "INSERT INTO attempts (tenant, id, person, station, exercise, profile_content, state, "
            "ticketed_ms, ticket, assignment, score, override_score) VALUES (?1, ?2, ?3, ?4, ?5, "
            "?6, 5, 1, ?2, ?7, ?8, ?9)");
    q.Bind(Uuid::New()).Bind(outsider ? outside : students[static_cast<size_t>(i % 3)]);
    q.Bind(world.station).Bind(world.exercise.id).Bind(world.profile);
    q.Bind(outsider || i % 20 == 1 ? std::nullopt : std::optional(assignment));
    i % 7 == 0 ? q.BindNull(sql::Type::kReal) : q.Bind(0.1 * (i * 37 % 40));
    i % 13 == 0 ? q.Bind(1.5) : q.BindNull(sql::Type::kReal);
    return q.Run();
  };
  ASSERT_TRUE(store_->engine->rows
                  .Write([&](Db& db) {
                    Status added;
                    for (int i = 0; i < 660 && added.ok(); ++i) added = add(db, i);
                    return added;
                  })
                  .ok());
  const auto all = *store_->attempts.Attempts({.limit = AttemptFilter::kMaxAtOnce});
  ASSERT_EQ(all.size(), 660u);
  const auto score = [](const AttemptRow& row) {
    return row.overridden ? row.overridden->score : row.score.value_or(1000);
  };
  const auto before = [&](Order order, const AttemptRow& a, const AttemptRow& b) {
    if (order == Order::kName) {
      return std::tuple(SearchName(a.person_name), a.person, b.id) <
             std::tuple(SearchName(b.person_name), b.person, a.id);
    }
    if (order == Order::kLowestScore) {
      return std::tuple(score(a), b.id) < std::tuple(score(b), a.id);
    }
    return b.id < a.id;
  };
  const auto is_outside = [&](const AttemptRow& row) { return row.person == outside; };
  const struct {
    const char* what;
    AttemptFilter filter;
    std::function<bool(const AttemptRow&)> has;
  } lists[] = {
      {"all", {}, [](const AttemptRow&) { return true; }},
      {"a student's",
       {.person = students[1]},
       [&](const auto& a) { return a.person == students[1]; }},
      {"a large cohort's", {.cohort = large}, [&](const auto& a) { return !is_outside(a); }},
      {"a small cohort's", {.cohort = small}, is_outside},
      {"taught by one of many",
       {.taught_by = of_many},
       [&](const auto& a) { return !is_outside(a); }},
      {"taught by one of few", {.taught_by = of_few}, is_outside},
      {"an assignment's",
       {.assignment = assignment},
       [&](const auto& a) { return a.assignment == assignment; }},
      {"an exercise's", {.exercise = world.exercise.id}, [](const AttemptRow&) { return true; }},
      {"a small cohort's of an exercise",
       {.cohort = small, .exercise = world.exercise.id},
       is_outside},
      {"taught by one of few, of a large assignment",
       {.taught_by = of_few, .assignment = assignment},
       [](const AttemptRow&) { return false; }},
  };
  for (const auto& [what, filter, has] : lists) {
    for (const Order order : {Order::kNewest, Order::kName, Order::kLowestScore}) {
      std::vector<AttemptRow> expected;
      std::ranges::copy_if(all, std::back_inserter(expected), has);
      std::ranges::sort(expected,
                        [&](const auto& a, const auto& b) { return before(order, a, b); });
      AttemptFilter page = filter;
      page.order = order;
      page.limit = 90;
      std::vector<Uuid> found;
      for (size_t pages = 0; pages < 10; ++pages) {
        const auto rows = store_->attempts.Attempts(page);
        ASSERT_TRUE(rows.ok()) << rows.status().message();
        for (const AttemptRow& row : *rows) found.push_back(row.id);
        if (rows->size() < page.limit) break;
        page.before = rows->back().id;
      }
      std::vector<Uuid> ids;
      for (const AttemptRow& row : expected) ids.push_back(row.id);
      EXPECT_EQ(found, ids) << what << ", order " << static_cast<int>(order);
    }
  }
  // Nobody decided anything about these, as verification would find.
  ASSERT_TRUE(
      store_->engine->rows
          .Write([](Db& db) {
            return Query(db, "DELETE FROM attempts WHERE tenant = ?1 AND ticketed_ms = 1").Run();
          })
          .ok());
}

TEST_P(StoreTest, OnlyAScoredAttemptIsReleased) {
  World world(*store_);
  Uuid open = world.OpenedAttempt();
  EXPECT_EQ(store_->judging.ReleaseAttempt(open, kSystem).code(), Code::kConflict);
  Uuid scored = world.ScoredAttempt();
  ASSERT_TRUE(store_->judging.ReleaseAttempt(scored, kSystem).ok());
  EXPECT_TRUE(store_->attempts.AttemptById(scored)->released);
}

TEST_P(StoreTest, ReferenceQueuesAttemptsThatWereScoredWithoutOne) {
  World world(*store_);
  Uuid scored = world.ScoredAttempt();
  auto job = store_->jobs.LeaseJob(1, 1000);
  ASSERT_TRUE(job.ok() && job->has_value());
  ASSERT_TRUE(store_->jobs.FinishJob((*job)->lease, true, "").ok());
  AttemptResult done;
  done.score = 100;
  ASSERT_TRUE(store_->results.FinishAttempt(scored, done, {}).ok());
  EXPECT_FALSE(store_->jobs.LeaseJob(1, 1000)->has_value());

  auto reference = store_->references.AddReference(scored, "Dr. Example", true, kSystem);
  ASSERT_TRUE(reference.ok()) << reference.status().message();
  EXPECT_EQ(store_->references.ReferenceFor(world.exercise.id)->value().attempt, scored);
  auto again = store_->jobs.LeaseJob(1, 1000);
  ASSERT_TRUE(again->has_value());
  EXPECT_EQ((*again)->attempt, scored);

  AttemptResult result;
  result.reference = scored;
  ASSERT_TRUE(store_->results.FinishAttempt(scored, result, {}).ok());
  EXPECT_EQ(store_->results.ResultOf(scored).status().code(), Code::kOk);
  EXPECT_EQ(store_->results.ResultOf(scored)->reference, scored);
}

TEST_P(StoreTest, FirstReferenceQueuesAttemptsThatTheTargetJudged) {
  World world(*store_);
  const Uuid by_target = world.ScoredAttempt(), by_another = world.ScoredAttempt();
  const Uuid failed = world.OpenedAttempt(), reference = world.ScoredAttempt();
  AttemptResult compared = *store_->results.ResultOf(by_another);
  compared.reference = by_target;
  ASSERT_TRUE(store_->results.FinishAttempt(by_another, compared, {}).ok());
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(failed, 1)), 200).ok());
  ASSERT_TRUE(
      store_->results.FailAttempt(failed, Status(Code::kConflict, "replay differs"), {}).ok());
  auto end_jobs = [&] {
    while (const auto job = *store_->jobs.LeaseJob(1, 1000)) {
      if (const auto before = store_->results.ResultOf(job->attempt); before.ok()) {
        ASSERT_TRUE(store_->results.FinishAttempt(job->attempt, *before, job->lease).ok());
      } else {
        ASSERT_TRUE(
            store_->results
                .FailAttempt(job->attempt, Status(Code::kConflict, "replay differs"), job->lease)
                .ok());
      }
      ASSERT_TRUE(store_->jobs.FinishJob(job->lease, true, "").ok());
    }
  };
  auto queued_by = [&](const Uuid& cut) {
    EXPECT_TRUE(store_->references.AddReference(cut, "Dr. Example", true, kSystem).ok());
    std::set<Uuid> out;
    for (const JobRow& job : *store_->jobs.Jobs("queued")) out.insert(job.attempt);
    return out;
  };
  end_jobs();
  EXPECT_EQ(queued_by(reference), (std::set<Uuid>{by_target, reference}));
  end_jobs();
  const Uuid second = world.ScoredAttempt();
  end_jobs();
  for (const Uuid& judged : {by_target, reference, second}) {
    const AttemptResult again = *store_->results.ResultOf(judged);
    ASSERT_TRUE(store_->results.FinishAttempt(judged, again, {}).ok());
  }
  EXPECT_EQ(queued_by(second), std::set<Uuid>{second})
      << "a second reference changes no score before somebody asks";
}

TEST_P(StoreTest, JobWhoseLeaseRanOutIsTakenAgainAndFailsAfterThreeTries) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  UnixMs now = 1000;
  for (uint32_t tries = 1; tries <= 3; ++tries) {
    auto job = store_->jobs.LeaseJob(now, 50);
    ASSERT_TRUE(job->has_value());
    EXPECT_EQ((*job)->tries, tries);
    EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kScoring);
    EXPECT_FALSE(store_->jobs.LeaseJob(now + 50, 50)->has_value()) << "leased";
    now += 100;
  }
  EXPECT_FALSE(store_->jobs.LeaseJob(now, 50)->has_value());
  EXPECT_EQ(store_->jobs.Jobs("failed")->size(), 1u);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kFailed);
}

TEST_P(StoreTest, LeaseThatIsKeptDoesNotRunOut) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  const Uuid run = store_->jobs.LeaseJob(1000, 50)->value().lease;
  ASSERT_TRUE(store_->jobs.KeepLease(run, 5000).ok());
  EXPECT_FALSE(store_->jobs.LeaseJob(4000, 50)->has_value());
  ASSERT_TRUE(store_->jobs.LeaseJob(6000, 50)->has_value());
  const Status late = store_->jobs.KeepLease(run, 9000);
  EXPECT_EQ(late.code(), Code::kUnavailable);
  EXPECT_EQ(late.field(), kLeaseOver);
  EXPECT_EQ(store_->jobs.KeepLease(Uuid::New(), 9000).field(), kLeaseOver);
}

TEST_P(StoreTest, ReturnedJobIsQueuedAgainWithoutCountingTheTry) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  for (int i = 0; i < 5; ++i) {
    auto job = store_->jobs.LeaseJob(1, 1000);
    ASSERT_TRUE(job->has_value());
    EXPECT_EQ((*job)->tries, 1u);
    ASSERT_TRUE(store_->jobs.ReturnJob((*job)->lease).ok());
    EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kSealed);
  }
}

TEST_P(StoreTest, FailedTryIsQueuedAgainWithItsError) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  Uuid run = store_->jobs.LeaseJob(1, 50)->value().lease;
  ASSERT_TRUE(store_->jobs.FinishJob(run, false, "disk full").ok());
  EXPECT_EQ(store_->jobs.Jobs("queued")->front().error, "disk full");
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kSealed);
}

TEST_P(StoreTest, AWorkerThatDiesAfterItsResultIsNotFollowedByAnother) {
  World world(*store_);
  Uuid attempt = world.OpenedAttempt();
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  const Uuid run = store_->jobs.LeaseJob(1, 50)->value().lease;
  AttemptResult result;
  result.score = 50;
  result.score_json = PutText(*store_, "score");
  ASSERT_TRUE(store_->results.FinishAttempt(attempt, result, run).ok());
  EXPECT_FALSE(store_->jobs.LeaseJob(1'000'000'000'000'000, 50)->has_value());
  EXPECT_EQ(store_->jobs.Jobs("done")->size(), 1u);
  EXPECT_EQ(store_->results.ResultsOf(attempt)->size(), 1u);
  // It was only slow.
  EXPECT_TRUE(store_->jobs.FinishJob(run, true, "").ok());
  EXPECT_TRUE(store_->jobs.FinishJob(run, false, "late").ok());
  EXPECT_EQ(store_->jobs.Jobs("done")->size(), 1u);
}

TEST_P(StoreTest, EveryChangeLeavesAnAuditRowWithItsActor) {
  World world(*store_);
  Uuid scored = world.ScoredAttempt();
  ASSERT_TRUE(store_->judging.ReleaseAttempt(scored, Actor{world.student, "page"}).ok());
  auto rows = store_->audit.Audit(100);
  auto released = std::find_if(rows->begin(), rows->end(),
                               [](const AuditRow& row) { return row.action == "attempt.release"; });
  ASSERT_NE(released, rows->end());
  EXPECT_EQ(released->object, scored.Text());
  EXPECT_EQ(released->actor, world.student.Text() + " (page)");
  EXPECT_NE(released->after_json, released->before_json);
}

}  // namespace
}  // namespace enamel::server
