#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "tests/server/storage/store_world.h"

// Fails the Nth write for every N until a whole attempt succeeds: everything acknowledged survives,
// and everything refused can simply be sent again.
namespace enamel::server {
namespace {

using namespace testing;

constexpr uint32_t kChunks = 3;

struct Faults {
  int until_failure = -1;  // -1: off
  bool fired = false;
  bool operator()() {
    if (until_failure < 0 || until_failure-- > 0) return false;
    fired = true;
    return true;
  }
};

TEST(SqliteFaultTest, NothingAcknowledgedIsLostWhicheverWriteFails) {
  for (int n = 0; n < 200; ++n) {
    SCOPED_TRACE("write " + std::to_string(n) + " fails");
    TempFolder folder;
    Faults faults;
    auto store = OpenStore(folder.path(), [&] { return faults(); });
    World world(*store);
    Uuid attempt = world.OpenedAttempt();

    faults.until_failure = n;
    std::vector<ChunkPut> chunks;
    uint32_t acknowledged = 0;
    bool sealed = false;
    Sha256 previous = World::HeaderHash();
    for (uint32_t seq = 0; seq < kChunks; ++seq) {
      chunks.push_back(world.Chunk(attempt, seq, previous));
      previous = chunks.back().hash;
      if (!store->ingest.AppendChunk(chunks.back()).ok()) break;
      ++acknowledged;
    }
    if (acknowledged == kChunks) sealed = store->seals.SealAttempt(World::SealOf(chunks), 1).ok();
    bool fired = faults.fired;
    faults.until_failure = -1;

    store.reset();
    store = OpenStore(folder.path());
    EXPECT_GE(AllChunks(store->recordings, attempt)->size(), acknowledged);
    if (sealed) {
      EXPECT_EQ(store->attempts.AttemptById(attempt)->state, AttemptState::kSealed);
    }

    previous = World::HeaderHash();
    std::vector<ChunkPut> all;
    for (uint32_t seq = 0; seq < kChunks; ++seq) {
      all.push_back(world.Chunk(attempt, seq, previous));
      previous = all.back().hash;
      EXPECT_TRUE(store->ingest.AppendChunk(all.back()).ok());
    }
    EXPECT_TRUE(store->seals.SealAttempt(World::SealOf(all), 1).ok());
    EXPECT_EQ(store->attempts.AttemptById(attempt)->ticks,
              uint64_t{kChunks} * World::kTicksPerChunk);
    EXPECT_EQ(store->jobs.Jobs("queued")->size(), 1u);
    if (!fired) return;
  }
  FAIL() << "the attempt never went through without a failure";
}

// Runs `act` with write n failing, for every n until none does. `look` gets whether `act` reported
// success, and a store opened again as a server opens it.
void WhicheverWriteFails(const std::function<void(World&)>& prepare,
                         const std::function<bool(Store&, const World&)>& act,
                         const std::function<void(Store&, const World&, bool done)>& look) {
  for (int n = 0; n < 200; ++n) {
    SCOPED_TRACE("write " + std::to_string(n) + " fails");
    TempFolder folder;
    Faults faults;
    auto store = OpenStore(folder.path(), [&] { return faults(); });
    World world(*store);
    prepare(world);
    faults.until_failure = n;
    bool done = act(*store, world);
    bool fired = faults.fired;
    faults.until_failure = -1;
    EXPECT_TRUE(done || fired);
    store.reset();
    StoreOptions server;
    server.folder = folder.path();
    server.hold_lock = true;
    auto opened = OpenSqliteStore(server);
    ASSERT_TRUE(opened.ok()) << opened.status().message();
    look(**opened, world, done);
    if (!fired) return;
  }
  FAIL() << "it never went through without a failure";
}

size_t AuditRows(Store& store, const std::string& action) {
  auto rows = *store.audit.Audit(1000);
  return static_cast<size_t>(std::ranges::count(rows, action, &AuditRow::action));
}

TEST(SqliteFaultTest, APersonIsErasedWhollyOrNotAtAllWhicheverWriteFails) {
  Uuid attempt;
  WhicheverWriteFails([&](World& world) { attempt = world.ScoredAttempt(); },
                      [](Store& store, const World& world) {
                        return store.erasures.ErasePerson(world.student, true, kSystem).ok();
                      },
                      [&](Store& store, const World& world, bool done) {
                        bool there = store.people.PersonById(world.student).ok();
                        EXPECT_FALSE(done && there);
                        EXPECT_EQ(store.attempts.AttemptById(attempt).ok(), there);
                        EXPECT_EQ(AllChunks(store.recordings, attempt).ok(), there);
                        EXPECT_EQ(AuditRows(store, "person.erase"), there ? 0u : 1u);
                        if (!there) return;
                        EXPECT_TRUE(store.erasures.ErasePerson(world.student, true, kSystem).ok());
                        EXPECT_FALSE(store.attempts.AttemptById(attempt).ok());
                      });
}

TEST(SqliteFaultTest, ARetentionRuleIsAppliedWhollyOrNotAtAllWhicheverWriteFails) {
  constexpr UnixMs kLater = UnixMs{30} * 86'400'000;
  Uuid attempt;
  WhicheverWriteFails(
      [&](World& world) {
        attempt = world.OpenedAttempt();
        world.Append(attempt, 2);
        ASSERT_TRUE(world.store.retention.SetRetention({"unfinished", 14}, kSystem).ok());
      },
      [](Store& store, const World&) {
        return store.retention.ApplyRetention(kLater, false, kSystem).ok();
      },
      [&](Store& store, const World&, bool done) {
        auto chunks = AllChunks(store.recordings, attempt);
        EXPECT_FALSE(done && chunks.ok());
        if (!chunks.ok()) return;
        EXPECT_EQ(chunks->size(), 2u);
        EXPECT_TRUE(store.retention.ApplyRetention(kLater, false, kSystem).ok());
        EXPECT_FALSE(store.attempts.AttemptById(attempt).ok());
      });
}

TEST(SqliteFaultTest, APersonIsAddedWithAllMembershipsOrNotAtAllWhicheverWriteFails) {
  std::vector<Uuid> cohorts;
  WhicheverWriteFails(
      [&](World& world) {
        cohorts = {*world.store.cohorts.CreateCohort("a", kSystem),
                   *world.store.cohorts.CreateCohort("b", kSystem)};
      },
      [&](Store& store, const World&) {
        Person person;
        person.login = "ada";
        person.display_name = "Ada";
        return store.people.CreatePerson(person, "verifier", cohorts, kSystem).ok();
      },
      [&](Store& store, const World&, bool done) {
        auto ada = store.people.PersonByLogin("ada");
        EXPECT_EQ(ada.ok(), done);
        size_t in = 0;
        for (const Uuid& cohort : cohorts) in += store.cohorts.CohortMembers(cohort)->size();
        EXPECT_EQ(in, ada.ok() ? 2u : 0u);
        EXPECT_EQ(AuditRows(store, "person.create"), ada.ok() ? 2u : 1u);
        EXPECT_EQ(AuditRows(store, "cohort.add"), in);
      });
}

TEST(SqliteFaultTest, EveryChangeOfPeopleIsDoneWithItsAuditOrNotAtAllWhicheverWriteFails) {
  WhicheverWriteFails(
      [](World&) {},
      [](Store& store, const World& world) {
        Person person;
        person.login = "ada";
        person.display_name = "Ada";
        auto ada = store.people.CreatePerson(person, "verifier", {}, kSystem);
        if (!ada.ok()) return false;
        auto cohort = store.cohorts.CreateCohort("year 3", kSystem);
        if (!cohort.ok()) return false;
        return store.cohorts.AddToCohort(*cohort, *ada, kSystem).ok() &&
               store.people.SetPassword(*ada, "other", false, kSystem).ok() &&
               store.people.SetDisabled(world.student, true, kSystem).ok();
      },
      [](Store& store, const World& world, bool done) {
        auto ada = store.people.PersonByLogin("ada");
        auto cohorts = *store.cohorts.Cohorts();
        bool member = !cohorts.empty() && !store.cohorts.CohortMembers(cohorts[0].id)->empty();
        bool changed = ada.ok() && *store.people.PasswordVerifier(ada->id) == "other";
        bool disabled = store.people.PersonById(world.student)->disabled;
        EXPECT_EQ(AuditRows(store, "person.create"), ada.ok() ? 2u : 1u);
        EXPECT_EQ(AuditRows(store, "cohort.create"), cohorts.size());
        EXPECT_EQ(AuditRows(store, "cohort.add"), member ? 1u : 0u);
        EXPECT_EQ(AuditRows(store, "person.password"), changed ? 1u : 0u);
        EXPECT_EQ(AuditRows(store, "person.disable"), disabled ? 1u : 0u);
        EXPECT_EQ(done, disabled);
      });
}

TEST(SqliteFaultTest, FailureThatHasPassedIsForgottenWithoutAnybodyWriting) {
  TempFolder folder;
  Faults faults;
  auto store = OpenStore(folder.path(), [&] { return faults(); });
  World world(*store);
  faults.until_failure = 0;
  ASSERT_FALSE(store->cohorts.CreateCohort("first", kSystem).ok());
  EXPECT_FALSE(store->health.Health().takes_recordings);
  faults.until_failure = 0;
  EXPECT_FALSE(store->health.TryWrite().ok()) << "it fails still";
  EXPECT_FALSE(store->health.Health().takes_recordings);
  faults.until_failure = -1;
  EXPECT_TRUE(store->health.TryWrite().ok());
  EXPECT_TRUE(store->health.Health().takes_recordings);
  const uint64_t writes = store->health.Health().writes;
  EXPECT_TRUE(store->health.TryWrite().ok());
  EXPECT_EQ(store->health.Health().writes, writes) << "nothing failed: nothing to try";
}

}  // namespace
}  // namespace enamel::server
