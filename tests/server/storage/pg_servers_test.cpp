#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <semaphore>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/engine/lease.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/server_identity.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/judging/result_rows.h"
#include "server/storage/keys/master_key.h"
#include "server/storage/open_store.h"
#include "server/storage/people/sign_in_rows.h"
#include "server/storage/recordings/ingest_rows.h"
#include "server/storage/store.h"
#include "server/storage/upkeep/store_health.h"
#include "tests/server/storage/store_world.h"
#include "tests/support/becomes.h"
#include "tests/support/missing_standbys.h"
#include "tests/support/postgres_proxy.h"
#include "tests/support/s3_stand_in.h"

// Several servers with their rows in one PostgreSQL database: simultaneous writes, and those whose
// connection breaks anywhere, are kept once.
namespace enamel::server {
namespace {

using namespace testing;
using test::PostgresProxy;

class PgServersTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* server = std::getenv("ENAMEL_POSTGRES");
    if (server == nullptr) GTEST_SKIP() << "ENAMEL_POSTGRES names no server";
    server_ = server;
  }
  void TearDown() override {
    if (server_.empty()) return;
    auto db = OpenPgDatabase(server_, {}, /*read_only=*/false, {});
    EXPECT_TRUE(db.ok() && (*db)->Exec(("DROP SCHEMA \"" + schema_ + "\" CASCADE").c_str()).ok());
  }
  // Each its own folder: a server of its own.
  std::unique_ptr<Store> Open(const TempFolder& folder, const std::string& server) {
    PostgresOptions options;
    options.server = server;
    options.schema = schema_;
    options.folder.folder = folder.path();
    options.folder.hold_lock = true;
    auto store = OpenPostgresStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }
  // One more, with the ticket key of the server in `first`.
  std::unique_ptr<Store> OpenAnother(const TempFolder& folder, const TempFolder& first) {
    std::filesystem::copy_file(first.path() / "ticket.key", folder.path() / "ticket.key");
    return Open(folder, server_);
  }
  int64_t Count(const std::string& sql) {
    auto db = OpenPgDatabase(server_, schema_, /*read_only=*/true, {});
    sql::Query q(**db, sql);
    EXPECT_TRUE(q.Next()) << q.status().message();
    return q.Int(0);
  }

  std::string server_;
  const std::string schema_ = "s" + Uuid::New().Text();
};

// As a station or a worker does: what failed for now is sent again.
Status Again(const std::function<Status()>& send) {
  Status status = send();
  for (int tries = 1; status.code() == Code::kUnavailable && tries < 4; ++tries) status = send();
  return status;
}

// Every message to PostgreSQL of an attempt's whole life is where the connection breaks, once for
// each way it can: with ENAMEL_FULL=1; every ninth otherwise.
TEST_F(PgServersTest, AnAttemptIsThereOnceWhereverTheConnectionBreaks) {
  const TempFolder folder;
  PostgresProxy proxy(server_);
  auto store = Open(folder, proxy.server());
  World world(*store);
  const bool full = std::getenv("ENAMEL_FULL") != nullptr;
  const int step = full ? 1 : 9;
  int64_t attempts = 0, cuts = 0;
  int first = 0;
  auto with_cuts = [&](const std::function<Status()>& step, PostgresProxy::Cut cut, int skip) {
    proxy.CutAt(skip, cut);
    const Status status = Again(step);
    EXPECT_TRUE(status.ok()) << status.message() << " with message " << skip;
    return proxy.Disarm();
  };
  for (const auto cut : {PostgresProxy::Cut::kBefore, PostgresProxy::Cut::kAfter,
                         PostgresProxy::Cut::kAnswer, PostgresProxy::Cut::kLate}) {
    // All steps of one attempt with the connection broken at the same place of each, until no step
    // has so many messages.
    bool met = true;
    for (int skip = full ? 0 : first++; met; skip += step) {
      ASSERT_LT(skip, 300);
      met = false;
      AttemptRow row;
      row.id = Uuid::New();
      row.person = world.student;
      row.station = world.station;
      row.exercise = world.exercise.id;
      row.profile_content = world.profile;
      row.ticketed_ms = 5;
      row.sign_off = true;
      const Actor signer{world.student, "station"};
      met |= with_cuts(
          [&] { return store->tickets.CreateAttempt(row, AsBytes("ticket"), kSystem); }, cut, skip);
      met |= with_cuts([&] { return store->sign_offs.Sign(row.id, SignedAt::kStart, 6, signer); },
                       cut, skip);
      met |= with_cuts([&] { return store->tickets.OpenAttempt(row.id, AsBytes("header")); }, cut,
                       skip);
      const auto chunk = world.Chunk(row.id, 0, World::HeaderHash());
      met |= with_cuts([&] { return store->ingest.AppendChunk(chunk); }, cut, skip);
      met |= with_cuts([&] { return store->seals.SealAttempt(World::SealOf({chunk}), 200); }, cut,
                       skip);
      std::optional<JobRow> job;
      met |= with_cuts(
          [&] {
            auto taken = store->jobs.LeaseJob(1, 1000);
            if (taken.ok()) job = *taken;
            return taken.status();
          },
          cut, skip);
      ASSERT_TRUE(job.has_value());
      EXPECT_EQ(job->attempt, row.id);
      met |= with_cuts([&] { return store->results.SetProgress(job->lease, 0.5); }, cut, skip);
      AttemptResult result;
      result.score = 50;
      result.score_json = PutText(*store, "score");
      met |= with_cuts([&] { return store->results.FinishAttempt(row.id, result, job->lease); },
                       cut, skip);
      met |= with_cuts([&] { return store->jobs.FinishJob(job->lease, true, ""); }, cut, skip);
      cuts += met ? 1 : 0;
      ++attempts;
    }
  }
  EXPECT_GT(cuts, full ? 150 : 15);
  EXPECT_EQ(Count("SELECT count(*) FROM attempts WHERE state = 5 AND chunks = 1"), attempts);
  EXPECT_EQ(Count("SELECT count(*) FROM attempts"), attempts);
  EXPECT_EQ(Count("SELECT count(*) FROM jobs WHERE state = 'done' AND tries = 1"), attempts);
  EXPECT_EQ(Count("SELECT count(*) FROM jobs"), attempts);
  EXPECT_EQ(Count("SELECT count(*) FROM attempt_results"), attempts);
  EXPECT_EQ(Count("SELECT count(*) FROM sign_offs WHERE signed_ms = 6"), attempts);
  for (const char* action :
       {"attempt.ticket", "attempt.sign_off", "attempt.seal", "attempt.score"}) {
    EXPECT_EQ(Count(std::string("SELECT count(*) FROM audit WHERE action = '") + action + "'"),
              attempts)
        << action;
  }
}

// A station that changed servers while its last chunks were still under way.
TEST_F(PgServersTest, ChunksThatComeToTwoServersAtOnceAreKeptOnce) {
  const TempFolder folder;
  std::array<std::unique_ptr<Store>, 2> stores;
  stores[0] = Open(folder, server_);
  World world(*stores[0]);
  (void)world.Append(world.OpenedAttempt(), 1);  // makes the person's key
  const TempFolder other;
  std::filesystem::copy(folder.path() / "keyring", other.path() / "keyring",
                        std::filesystem::copy_options::recursive);
  stores[1] = OpenAnother(other, folder);
  constexpr uint32_t kChunks = 40;
  const Uuid attempt = world.OpenedAttempt();
  std::vector<ChunkPut> chunks;
  Sha256 previous = World::HeaderHash();
  for (uint32_t seq = 0; seq < kChunks; ++seq) {
    chunks.push_back(world.Chunk(attempt, seq, previous));
    previous = chunks.back().hash;
  }
  {
    std::vector<std::jthread> links;
    for (auto& store : stores) {
      links.emplace_back([&] {
        for (const auto& chunk : chunks) {
          // Refused where the other server has not committed the one before it yet.
          Status status = store->ingest.AppendChunk(chunk);
          while (status.code() == Code::kConflict && status.field() == "seq")
            status = store->ingest.AppendChunk(chunk);
          ASSERT_TRUE(status.ok()) << status.message() << " / " << status.field();
        }
      });
    }
  }
  const AttemptRow row = *stores[1]->attempts.AttemptById(attempt);
  EXPECT_EQ(row.chunks, kChunks);
  EXPECT_EQ(row.flags & kContradicted, 0u);
  EXPECT_EQ(row.ticks, uint64_t{kChunks} * World::kTicksPerChunk);
  EXPECT_TRUE(stores[1]->seals.SealAttempt(World::SealOf(chunks), 300).ok());
  const Status twice = stores[0]->seals.SealAttempt(World::SealOf(chunks), 300);
  EXPECT_TRUE(twice.ok()) << "said twice: " << twice.message();
  EXPECT_EQ(Count("SELECT count(*) FROM jobs"), 1);
}

// Two jobs of each attempt wait, and eight workers on two servers take them.
TEST_F(PgServersTest, EveryJobIsTakenByOneWorkerAndAnAttemptHasOneRunAtATime) {
  const TempFolder folder;
  std::array<std::unique_ptr<Store>, 2> stores;
  stores[0] = Open(folder, server_);
  World world(*stores[0]);
  const TempFolder other;
  stores[1] = OpenAnother(other, folder);
  constexpr int kAttempts = 20;
  for (int i = 0; i < kAttempts; ++i) {
    const Uuid attempt = world.OpenedAttempt();
    ASSERT_TRUE(stores[0]->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
    // As when an instructor has it scored again before it was scored.
    ASSERT_TRUE(
        QueueScoreJob(**OpenPgDatabase(server_, schema_, false, {}), attempt, "rescore").ok());
  }
  ASSERT_EQ(Count("SELECT count(*) FROM jobs WHERE state = 'queued'"), 2 * kAttempts);
  std::mutex mutex;
  std::map<Uuid, int> running;
  std::multiset<Uuid> taken;
  std::atomic<int> done{0};
  {
    std::vector<std::jthread> workers;
    for (int i = 0; i < 8; ++i) {
      workers.emplace_back([&, i] {
        Store& store = *stores[static_cast<size_t>(i % 2)];
        while (done < 2 * kAttempts) {
          auto job = store.jobs.LeaseJob(1000, 1000);
          ASSERT_TRUE(job.ok()) << job.status().message();
          if (!*job) continue;
          {
            std::lock_guard lock(mutex);
            EXPECT_EQ(++running[(*job)->attempt], 1) << "two runs of one attempt";
            taken.insert((*job)->id);
          }
          EXPECT_TRUE(store.results.SetProgress((*job)->lease, 0.5).ok());
          {
            std::lock_guard lock(mutex);
            --running[(*job)->attempt];
          }
          EXPECT_TRUE(store.jobs.FinishJob((*job)->lease, true, "").ok());
          ++done;
        }
      });
    }
  }
  EXPECT_EQ(taken.size(), size_t{2 * kAttempts});
  EXPECT_EQ(std::set<Uuid>(taken.begin(), taken.end()).size(), taken.size()) << "taken twice";
}

// The second one's start must not end what the first is at.
TEST_F(PgServersTest, AServerThatStartsEndsItsOwnLeasesAndNoOthers) {
  const TempFolder folder;
  auto first = Open(folder, server_);
  World world(*first);
  for (int i = 0; i < 2; ++i) {
    const Uuid attempt = world.OpenedAttempt();
    ASSERT_TRUE(first->seals.SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  }
  const JobRow job = **first->jobs.LeaseJob(1000, 1'000'000);
  const TempFolder other;
  {
    auto second = OpenAnother(other, folder);
    const JobRow theirs = **second->jobs.LeaseJob(2000, 1'000'000);
    EXPECT_NE(theirs.id, job.id);
    EXPECT_FALSE(second->jobs.LeaseJob(2000, 1'000'000)->has_value());
    EXPECT_TRUE(first->results.SetProgress(job.lease, 0.5).ok());
  }
  auto second = Open(other, server_);
  auto again = second->jobs.LeaseJob(3000, 1'000'000);
  ASSERT_TRUE(again->has_value()) << "its own of before are over";
  EXPECT_NE((*again)->id, job.id);
  EXPECT_TRUE(first->results.SetProgress(job.lease, 0.6).ok());
}

TEST_F(PgServersTest, FailuresToSignInAreCountedOnceEachByAllServers) {
  const TempFolder first_folder, second_folder;
  auto first = Open(first_folder, server_);
  auto second = OpenAnother(second_folder, first_folder);
  EXPECT_TRUE(first->shared);
  const std::vector<Sha256> keys{HashSha256(AsBytes("ada")), HashSha256(AsBytes("here"))};
  const UnixMs later = enamel::UnixMs() + 3'600'000;
  constexpr int kEach = 60;
  std::vector<std::thread> threads;
  std::atomic<int> failed{0};
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      for (int n = 0; n < kEach; ++n) {
        // Named in either order, and between them somebody gets in.
        const std::vector<Sha256> mine{keys[i % 2], keys[1 - i % 2]};
        Store& store = i < 4 ? *first : *second;
        const Status counted = store.sign_ins.Change(mine, [&](std::vector<SignInCounter>& all) {
          for (SignInCounter& counter : all) {
            ++counter.failures;
            counter.until_ms = later;
          }
        });
        failed += counted.ok() ? 0 : 1;
        const std::vector<Sha256> own{HashSha256(AsBytes("seat " + std::to_string(n % 3)))};
        for (const bool in : {false, true}) {
          failed +=
              store.sign_ins
                      .Change(own,
                              [&](std::vector<SignInCounter>& all) {
                                all[0] = in ? SignInCounter{} : SignInCounter{1, 0, 1, 0, later};
                              })
                      .ok()
                  ? 0
                  : 1;
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failed, 0);
  ASSERT_TRUE(first->sign_ins
                  .Change(keys,
                          [&](std::vector<SignInCounter>& all) {
                            for (const SignInCounter& counter : all)
                              EXPECT_EQ(counter.failures, 8u * kEach);
                          })
                  .ok());
}

TEST_F(PgServersTest, UpkeepIsOneServersAtATimeAndFinishedByAnother) {
  const TempFolder first_folder, second_folder;
  auto first = Open(first_folder, server_);
  auto second = OpenAnother(second_folder, first_folder);
  World world(*first);
  const auto open = [&] {
    return std::move(OpenPgDatabase(server_, schema_, /*read_only=*/false, {})).value();
  };
  {
    auto held = Lease::Take(open(), "upkeep");
    ASSERT_TRUE(held.ok()) << held.status().message();
    EXPECT_EQ(Lease::Take(open(), "upkeep").status().field(), kLeaseHeld);
    const Status refused = second->erasures.ErasePerson(world.student, false, kSystem).status();
    EXPECT_EQ(refused.code(), Code::kUnavailable);
    EXPECT_EQ(refused.field(), kLeaseHeld);
    EXPECT_TRUE(first->people.PersonById(world.student).ok()) << "nothing of it was begun";
    EXPECT_EQ(first->retention.ApplyRetention(enamel::UnixMs(), false, kSystem).status().field(),
              kLeaseHeld);
  }
  EXPECT_EQ(Count("SELECT count(*) FROM leases"), 0) << "given back";
  // A server that died had taken it, and had begun to erase.
  ASSERT_TRUE(
      open()
          ->Exec("INSERT INTO leases VALUES (1, 'upkeep', decode(repeat('ab', 16), 'hex'), 1); "
                 "INSERT INTO rewrite_due VALUES (1, 1, decode(repeat('cd', 16), 'hex'))")
          .ok());
  ASSERT_TRUE(second->erasures.FinishErasures().ok());
  EXPECT_EQ(Count("SELECT count(*) FROM rewrite_due"), 0);
  ASSERT_TRUE(second->erasures.ErasePerson(world.student, false, kSystem).ok());
  EXPECT_EQ(Count("SELECT count(*) FROM rewrite_due"), 0);
  EXPECT_EQ(Count("SELECT count(*) FROM leases"), 0);
}

TEST_F(PgServersTest, AnErasureWhileTheTablesAreWrittenAnewLeavesThemMarked) {
  const TempFolder folder;
  auto store = Open(folder, server_);
  const auto open = [&] {
    return std::move(OpenPgDatabase(server_, schema_, /*read_only=*/false, {})).value();
  };
  std::function<void()> before_write{};  // once
  const auto hook = [&] {
    if (before_write) std::exchange(before_write, {})();
    return false;
  };
  SpaceGuard space(folder.path(), SystemDisk(), 0, std::chrono::milliseconds(1000));
  Transactions rows(
      {OpenPgDatabase(server_, schema_, /*read_only=*/false, hook).value(), open, open}, 2),
      others({open(), open, open}, 2);
  Rewriter rewriter(folder.path(), space, rows), elsewhere(folder.path(), space, others);
  ASSERT_TRUE(rewriter.Mark().ok());
  // Before the mark is removed, another server has marked them for what it has erased meanwhile.
  before_write = [&] { EXPECT_TRUE(elsewhere.Mark().ok()); };
  ASSERT_TRUE(rewriter.RunIfMarked().ok());
  EXPECT_TRUE(*rewriter.IsMarked());
  ASSERT_TRUE(rewriter.RunIfMarked().ok());
  EXPECT_FALSE(*rewriter.IsMarked());
}

TEST_F(PgServersTest, ALeaseLastsAsLongAsItsHolder) {
  const TempFolder folder;
  auto store = Open(folder, server_);
  const auto open = [&] {
    return std::move(OpenPgDatabase(server_, schema_, /*read_only=*/false, {})).value();
  };
  int64_t until_renewed = 0;
  std::binary_semaphore until_read(0), renewed(0);
  int renewals = 0;
  const auto on_renewed = [&] {
    // The first may have been before `until` was read, the second is not.
    if (++renewals == 1) until_read.acquire();
    if (renewals != 2) return;
    until_renewed = Count("SELECT until_ms FROM leases");
    // Another takes it, as after an outage in which it could not be renewed: that one's is left
    // alone. Here, as a renewal at the same moment would refuse it.
    EXPECT_TRUE(open()->Exec("UPDATE leases SET lease = decode(repeat('ab', 16), 'hex')").ok());
    renewed.release();
  };
  using std::chrono::milliseconds;
  auto held = Lease::Take(open(), "upkeep", {milliseconds(2000), milliseconds(20), on_renewed});
  ASSERT_TRUE(held.ok());
  const int64_t until = Count("SELECT until_ms FROM leases");
  until_read.release();
  ASSERT_TRUE(renewed.try_acquire_for(std::chrono::seconds(60)));
  EXPECT_GT(until_renewed, until);
  held->reset();
  EXPECT_EQ(Count("SELECT count(*) FROM leases"), 1);
}

TEST_F(PgServersTest, StationsOfOneServerAreElsewhereForTheOthersUntilItIsGone) {
  const TempFolder one_folder, two_folder;
  auto one = Open(one_folder, server_), two = OpenAnother(two_folder, one_folder);
  World world(*one);
  const Uuid station = Uuid::New(), both = Uuid::New();
  const std::vector<StationLink> links{{station, true}, {both, false}};
  ASSERT_TRUE(one->live.KeepLinks(links, {}, true).ok());
  ASSERT_TRUE(two->live.KeepLinks({{both, true}}, {}, true).ok());
  auto elsewhere = *two->live.LinksElsewhere();
  std::ranges::sort(elsewhere, {}, &StationLink::shows_remarks);
  EXPECT_EQ(elsewhere, (std::vector<StationLink>{{both, false}, {station, true}}));
  EXPECT_EQ(*one->live.LinksElsewhere(), (std::vector<StationLink>{{both, true}}));
  // A remark at one server reaches the other, whose station reports how far it has come.
  const Uuid attempt = world.OpenedAttempt();
  AnnotationRow row;
  row.attempt = attempt;
  row.text = "stop";
  row.to_chair = true;
  ASSERT_TRUE(one->remarks.AddAnnotation(row, kSystem).ok());
  auto remarks = *two->live.ChairRemarks(0);
  ASSERT_EQ(remarks.size(), 1u);
  remarks[0].state = RemarkState::kShown;
  ASSERT_TRUE(two->live.MoveRemarks(remarks).ok());
  EXPECT_EQ(one->live.ChairRemarks(0)->at(0).state, RemarkState::kShown);

  // Not heard for a while.
  auto db = OpenPgDatabase(server_, schema_, /*read_only=*/false, {});
  ASSERT_TRUE((*db)->Exec("UPDATE running_servers SET heard_ms = heard_ms - 20001").ok());
  EXPECT_TRUE(two->live.LinksElsewhere()->empty());
  ASSERT_TRUE(two->live.KeepLinks({}, {}, false).ok()) << "nobody has deleted it yet";
  EXPECT_EQ(one->live.LinksElsewhere()->size(), 1u);
  const TempFolder third_folder;
  auto third = OpenAnother(third_folder, one_folder);
  ASSERT_TRUE(third->live.KeepLinks({}, {}, true).ok());
  EXPECT_EQ(Count("SELECT count(*) FROM running_servers"), 2);
  EXPECT_EQ(Count("SELECT count(*) FROM station_links"), 1);
  EXPECT_EQ(one->live.KeepLinks({}, {}, false).code(), Code::kNotFound);
  ASSERT_TRUE(one->live.KeepLinks(links, {}, true).ok());
  EXPECT_EQ(third->live.LinksElsewhere()->size(), 2u);
}

TEST_F(PgServersTest, AFullDiskStopsRecordingsOnlyWhereTheyGoToIt) {
  const test::S3StandIn bucket;
  for (const bool in_bucket : {false, true}) {
    const TempFolder folder;
    PostgresOptions options;
    options.server = server_;
    options.schema = schema_ + (in_bucket ? "" : " folder");
    options.folder.folder = folder.path();
    options.folder.min_free_bytes = uint64_t{1} << 62;
    if (in_bucket) options.folder.s3_blobs.emplace().store = bucket.options();
    auto store = OpenPostgresStore(options);
    ASSERT_TRUE(store.ok()) << store.status().message();
    EXPECT_EQ((*store)->health.Health().takes_recordings, in_bucket);
  }
  auto db = OpenPgDatabase(server_, {}, /*read_only=*/false, {});
  EXPECT_TRUE((*db)->Exec(("DROP SCHEMA \"" + schema_ + " folder\" CASCADE").c_str()).ok());
}

TEST_F(PgServersTest, TimesAreTheDatabases) {
  const TempFolder folder;
  auto store = Open(folder, server_);
  FollowClock(std::chrono::system_clock::now() + std::chrono::hours(5));
  ASSERT_TRUE(store->look.Look().ok());
  // The server is on this machine.
  const StoreHealth health = store->health.Health();
  EXPECT_LT(std::abs(health.clock_ahead_ms), 1000);
  EXPECT_EQ(health.clock_problem, "");
  EXPECT_LT(enamel::UnixMs(), enamel::UnixMs(std::chrono::system_clock::now()) + 3'600'000);
  FollowSystemClock();
}

TEST_F(PgServersTest, TheMajorityOfTheClocksCounts) {
  constexpr int64_t kHourMs = 3'600'000;
  const TempFolder folder;
  auto store = Open(folder, server_);
  ASSERT_TRUE(store->look.Beat().ok());
  EXPECT_EQ(store->look.clock_votes(), 2) << "its own and the database's";
  auto db = OpenPgDatabase(server_, schema_, /*read_only=*/false, {});
  ASSERT_TRUE(db.ok());
  // Other servers: a row each, an hour ahead of the database.
  const auto add = [&](int first, int last) {
    for (int i = first; i <= last; ++i) {
      sql::Query q(
          **db,
          "INSERT INTO write_probe SELECT 1, ?1, at_ms, ?2, 1, '127.0.0.1', 1 FROM write_probe "
          "LIMIT 1");
      const Bytes id(16, static_cast<uint8_t>(i));
      ASSERT_TRUE(q.BindBlob(id).BindInt(kHourMs).Run().ok());
    }
  };
  add(1, 2);
  ASSERT_TRUE(store->look.Beat().ok());
  EXPECT_EQ(store->look.median_ahead_ms(), 0) << "two against two: the database's counts";
  add(3, 3);
  ASSERT_TRUE(store->look.Beat().ok());
  EXPECT_EQ(store->look.median_ahead_ms(), kHourMs);
  const int64_t here_ms = enamel::UnixMs(std::chrono::system_clock::now());
  EXPECT_NEAR(static_cast<double>(enamel::UnixMs() - here_ms), kHourMs, 1000);
  const StoreHealth health = store->health.Health();
  EXPECT_TRUE(health.clock_is_off);
  EXPECT_NE(health.clock_problem.find("behind most servers"), std::string::npos);
  EXPECT_TRUE(health.takes_recordings);
  FollowSystemClock();
}

// As where two standbys were promoted at once: their timelines have the same number.
TEST_F(PgServersTest, ADatabaseThatLacksWhatThisServerCommittedTakesNoRecordings) {
  const TempFolder folder;
  auto store = Open(folder, server_);
  ASSERT_TRUE(store->look.Beat().ok());
  ASSERT_TRUE(store->look.Beat().ok());
  EXPECT_TRUE(store->health.Health().takes_recordings);
  auto db = OpenPgDatabase(server_, schema_, /*read_only=*/false, {});
  ASSERT_TRUE((*db)->Exec("UPDATE write_probe SET beats = beats - 1").ok());
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(store->look.Beat().ok());
    const StoreHealth health = store->health.Health();
    EXPECT_FALSE(health.takes_recordings) << "and stays so";
    EXPECT_FALSE(health.database_fails) << "no other server can help";
    EXPECT_NE(health.problem.find("second primary"), std::string::npos) << health.problem;
  }
}

TEST_F(PgServersTest, ADatabaseThatHangsIsNoticedAndOneThatRunsAgainToo) {
  const TempFolder folder;
  PostgresProxy proxy(server_);
  auto store = Open(folder, proxy.server());
  ASSERT_TRUE(store->look.Beat().ok());
  EXPECT_LT(store->look.silence(), std::chrono::seconds(1));
  // Refusing beside hanging: nobody waits for the check.
  proxy.Refuse();
  proxy.Hang();
  EXPECT_FALSE(store->look.Beat().ok());
  EXPECT_GT(store->look.silence(), std::chrono::seconds(1)) << "a second's patience";
  proxy.Refuse(false);
  proxy.Hang(false);
  ASSERT_TRUE(store->look.Beat().ok());
  EXPECT_LT(store->look.silence(), std::chrono::seconds(1));
}

// A request that only reads waits for nothing, and health says why changes wait.
TEST_F(PgServersTest, WhileEveryChangeWaitsForAStandbySessionsAreReadAndHealthSaysSo) {
  const TempFolder folder;
  auto store = Open(folder, server_);
  auto db = OpenPgDatabase(server_, {}, /*read_only=*/false, {});
  ASSERT_TRUE(db.ok());
  // After `missing`, whose end it may wait for.
  std::future<bool> touched;
  test::MissingStandbys missing(**db);
  missing.Name("nobody");
  ASSERT_TRUE(test::Becomes([&] {
    return store->look.Look().ok() && store->health.Health().standby == sql::Standby::kMissing;
  }));
  const StoreHealth health = store->health.Health();
  EXPECT_NE(health.waiting.find("standby"), std::string::npos) << health.waiting;
  EXPECT_TRUE(health.takes_recordings) << "what comes is not lost, and waits";
  touched = std::async(std::launch::async,
                       [&] { return store->sessions.TouchSession(Sha256{}, UnixMs()).ok(); });
  EXPECT_TRUE(touched.wait_for(std::chrono::seconds(10)) == std::future_status::ready &&
              touched.get());
}

// A rolling upgrade: the first server of the next version migrates while the others still run.
TEST_F(PgServersTest, ServersGoOnWhenANewerVersionMigratesAndNoneOfTheOldVersionStarts) {
  const TempFolder folder, other;
  auto store = Open(folder, server_);
  World world(*store);
  (void)world.ScoredAttempt();  // every statement of an attempt is prepared
  const Uuid attempt = world.OpenedAttempt();
  auto chunks = world.Append(attempt, 1);
  auto db = OpenPgDatabase(server_, schema_, /*read_only=*/false, {});
  ASSERT_TRUE(db.ok()) << db.status().message();
  std::vector<sql::Migration> later = PgMigrations();
  const int next = later.back().version + 1;
  // As the next version's may (server/README.md): it adds, and takes nothing away.
  later.push_back({next, "later.sql",
                   "ALTER TABLE attempts ADD COLUMN later BIGINT NOT NULL DEFAULT 0;"
                   "ALTER TABLE people ADD COLUMN later TEXT;"
                   "ALTER TABLE jobs ADD COLUMN later BYTEA;"
                   "CREATE INDEX later ON attempts (tenant, later);"
                   "CREATE TABLE laters (tenant BIGINT NOT NULL REFERENCES tenants (tenant))"});
  ASSERT_TRUE((*db)->Migrate(later).ok());

  chunks.push_back(world.Chunk(attempt, 1, chunks.back().hash));
  Status status = store->ingest.AppendChunk(chunks.back());
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_TRUE(store->seals.SealAttempt(World::SealOf(chunks), 300).ok());
  (void)world.ScoredAttempt();
  (void)AddPerson(*store, "later", Role::kStudent);
  EXPECT_EQ(Count("SELECT count(*) FROM attempts WHERE later = 0"), 3);

  std::filesystem::copy_file(folder.path() / "ticket.key", other.path() / "ticket.key");
  PostgresOptions options;
  options.server = server_;
  options.schema = schema_;
  options.folder.folder = other.path();
  status = OpenPostgresStore(options).status();
  EXPECT_EQ(status.code(), Code::kVersion);
  EXPECT_NE(status.message().find(std::to_string(next)), std::string::npos) << status.message();
  EXPECT_NE(status.message().find("Install that one again"), std::string::npos) << status.message();
}

TEST_F(PgServersTest, AServerThatIsKnownByAnotherThanTheOthersIsRefused) {
  const TempFolder folder, other, keys;
  const test::S3StandIn bucket;
  PostgresOptions options;
  options.server = server_;
  options.schema = schema_;
  options.folder.folder = folder.path();
  options.folder.s3_keys.emplace();
  S3Place& place = options.folder.s3_keys->place;
  place.store = bucket.options();
  options.folder.s3_keys->master_key = keys.path() / "master.key";
  EXPECT_EQ(OpenPostgresStore(options).status().code(), Code::kNotFound) << "no master key";
  EXPECT_FALSE(*HasServers(options));
  ASSERT_TRUE(EnsureMasterKey(keys.path() / "master.key", SystemDisk()).ok());
  auto first = OpenPostgresStore(options);
  ASSERT_TRUE(first.ok()) << first.status().message();
  EXPECT_TRUE(*HasServers(options));
  const Sha256 certificate = HashSha256(AsBytes("certificate"));
  EXPECT_TRUE((*first)->identity.MatchIdentity(ServerPart::kStationCertificate, {}).ok())
      << "nobody's yet";
  EXPECT_TRUE((*first)->identity.MatchIdentity(ServerPart::kStationCertificate, certificate).ok());
  EXPECT_TRUE((*first)->identity.MatchIdentity(ServerPart::kStationCertificate, certificate).ok());

  options.folder.folder = other.path();
  const Status without = OpenPostgresStore(options).status();
  EXPECT_EQ(without.code(), Code::kNotFound);
  EXPECT_NE(without.message().find("--identity"), std::string::npos) << without.message();
  EXPECT_FALSE(std::filesystem::exists(other.path() / "ticket.key"))
      << "a key of its own would be in the way of the others'";

  ASSERT_TRUE(EnsureTicketKey(other.path(), SystemDisk()).ok());
  const Status stranger = OpenPostgresStore(options).status();
  EXPECT_EQ(stranger.code(), Code::kConflict) << stranger.message();
  std::filesystem::copy_file(folder.path() / "ticket.key", other.path() / "ticket.key",
                             std::filesystem::copy_options::overwrite_existing);
  options.folder.s3_keys->master_key = other.path() / "master.key";
  ASSERT_TRUE(EnsureMasterKey(other.path() / "master.key", SystemDisk()).ok());
  const Status locked_out = OpenPostgresStore(options).status();
  EXPECT_EQ(locked_out.code(), Code::kConflict);
  EXPECT_NE(locked_out.message().find("master key"), std::string::npos) << locked_out.message();
  // Each would make a second key for a person.
  options.folder.s3_keys->master_key = keys.path() / "master.key";
  place.prefix = "another/";
  EXPECT_EQ(OpenPostgresStore(options).status().code(), Code::kConflict);
  place.prefix.clear();
  PostgresOptions in_folder = options;
  in_folder.folder.s3_keys.reset();
  EXPECT_EQ(OpenPostgresStore(in_folder).status().code(), Code::kConflict);
  std::filesystem::create_directories(other.path() / "keyring");
  const auto stray = other.path() / "keyring" / (Uuid::New().Text() + ".key");
  ASSERT_TRUE(WriteFileDurably(stray, Bytes(32), 0600).ok());
  EXPECT_EQ(OpenPostgresStore(options).status().code(), Code::kConflict);
  std::filesystem::remove(stray);

  auto second = OpenPostgresStore(options);
  ASSERT_TRUE(second.ok()) << second.status().message();
  const Status other_certificate = (*second)->identity.MatchIdentity(
      ServerPart::kStationCertificate, HashSha256(AsBytes("another certificate")));
  EXPECT_EQ(other_certificate.code(), Code::kConflict);
  EXPECT_NE(other_certificate.message().find("station.crt"), std::string::npos);
  EXPECT_EQ((*second)->identity.MatchIdentity(ServerPart::kStationCertificate, {}).code(),
            Code::kNotFound);

  // What one takes in, the other reads; whom one erases is erased for both.
  World world(**first);
  const Uuid attempt = world.OpenedAttempt();
  const auto chunks = world.Append(attempt, 2);
  EXPECT_EQ(AllChunks((*second)->recordings, attempt)->size(), 2u);
  ASSERT_TRUE((*second)->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  ASSERT_TRUE((*first)->erasures.ErasePerson(world.student, false, kSystem).ok());
  EXPECT_EQ((*second)->attempts.AttemptById(attempt).status().code(), Code::kNotFound);
  Person again;
  again.id = world.student;
  again.login = "again";
  EXPECT_EQ((*second)->people.CreatePerson(again, "v", {}, kSystem).status().code(),
            Code::kConflict);
  EXPECT_EQ(bucket.complaints(), std::vector<std::string>{});

  // All servers are stopped and the row is deleted: the first to start records the shared identity
  // again.
  first->reset();
  second->reset();
  auto db = OpenPgDatabase(server_, schema_, /*read_only=*/false, {});
  ASSERT_TRUE((*db)->Exec("DELETE FROM server_identity WHERE name = 'key_ring'").ok());
  place.prefix = "renewed/";
  EXPECT_TRUE(OpenPostgresStore(options).ok());
}

}  // namespace
}  // namespace enamel::server
