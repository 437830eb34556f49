#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/base/file.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/ticket_key.h"
#include "server/storage/master_key.h"
#include "server/storage/sql/query.h"
#include "server/storage/sql/sqlite_impl.h"
#include "tests/server/storage/store_world.h"
#include "tests/support/postgres_proxy.h"
#include "tests/support/s3_stand_in.h"

// Several servers with their rows in one PostgreSQL database: what they write at the same time, and
// what is left when one's connection breaks anywhere, is kept once.
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
    auto db = sqlite::OpenPgDatabase(server_, {}, /*read_only=*/false, {});
    EXPECT_TRUE(db.ok() && (*db)->Exec(("DROP SCHEMA \"" + schema_ + "\" CASCADE").c_str()).ok());
  }
  // Each its own folder: a server of its own. They share the ticket key.
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
  int64_t Count(const std::string& sql) {
    auto db = sqlite::OpenPgDatabase(server_, schema_, /*read_only=*/true, {});
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

// Every message to PostgreSQL of an attempt's whole life is where the connection breaks, once for each
// way it can: with ENAMEL_FULL=1; every ninth otherwise.
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
      met |= with_cuts([&] { return store->CreateAttempt(row, AsBytes("ticket"), kSystem); }, cut,
                       skip);
      met |= with_cuts([&] { return store->OpenAttempt(row.id, AsBytes("header")); }, cut, skip);
      const auto chunk = world.Chunk(row.id, 0, World::HeaderHash());
      met |= with_cuts([&] { return store->AppendChunk(chunk); }, cut, skip);
      met |= with_cuts([&] { return store->SealAttempt(World::SealOf({chunk}), 200); }, cut, skip);
      std::optional<JobRow> job;
      met |= with_cuts(
          [&] {
            auto taken = store->LeaseJob(1, 1000);
            if (taken.ok()) job = *taken;
            return taken.status();
          },
          cut, skip);
      ASSERT_TRUE(job.has_value());
      EXPECT_EQ(job->attempt, row.id);
      met |= with_cuts([&] { return store->SetProgress(job->lease, 0.5); }, cut, skip);
      Store::AttemptResult result;
      result.score = 50;
      result.score_json = PutText(*store, "score");
      met |= with_cuts([&] { return store->FinishAttempt(row.id, result, job->lease); }, cut, skip);
      met |= with_cuts([&] { return store->FinishJob(job->lease, true, ""); }, cut, skip);
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
  for (const char* action : {"attempt.ticket", "attempt.seal", "attempt.score"}) {
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
  std::filesystem::copy(folder.path() / "ticket.key", other.path() / "ticket.key");
  std::filesystem::copy(folder.path() / "keyring", other.path() / "keyring",
                        std::filesystem::copy_options::recursive);
  stores[1] = Open(other, server_);
  constexpr uint32_t kChunks = 40;
  const Uuid attempt = world.OpenedAttempt();
  std::vector<Store::ChunkPut> chunks;
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
          Status status = store->AppendChunk(chunk);
          while (status.code() == Code::kConflict && status.field() == "seq")
            status = store->AppendChunk(chunk);
          ASSERT_TRUE(status.ok()) << status.message() << " / " << status.field();
        }
      });
    }
  }
  const AttemptRow row = *stores[1]->AttemptById(attempt);
  EXPECT_EQ(row.chunks, kChunks);
  EXPECT_EQ(row.flags & kContradicted, 0u);
  EXPECT_EQ(row.ticks, uint64_t{kChunks} * World::kTicksPerChunk);
  EXPECT_TRUE(stores[1]->SealAttempt(World::SealOf(chunks), 300).ok());
  EXPECT_TRUE(stores[0]->SealAttempt(World::SealOf(chunks), 300).ok()) << "said twice";
  EXPECT_EQ(Count("SELECT count(*) FROM jobs"), 1);
}

// Two jobs of each attempt wait, and eight workers on two servers take them.
TEST_F(PgServersTest, EveryJobIsTakenByOneWorkerAndAnAttemptHasOneRunAtATime) {
  const TempFolder folder;
  std::array<std::unique_ptr<Store>, 2> stores;
  stores[0] = Open(folder, server_);
  World world(*stores[0]);
  const TempFolder other;
  std::filesystem::copy(folder.path() / "ticket.key", other.path() / "ticket.key");
  stores[1] = Open(other, server_);
  constexpr int kAttempts = 20;
  for (int i = 0; i < kAttempts; ++i) {
    const Uuid attempt = world.OpenedAttempt();
    ASSERT_TRUE(stores[0]->SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
    // As when an instructor has it scored again before it was scored.
    ASSERT_TRUE(sqlite::QueueScoreJob(**sqlite::OpenPgDatabase(server_, schema_, false, {}),
                                      attempt, "rescore")
                    .ok());
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
          auto job = store.LeaseJob(1000, 1000);
          ASSERT_TRUE(job.ok()) << job.status().message();
          if (!*job) continue;
          {
            std::lock_guard lock(mutex);
            EXPECT_EQ(++running[(*job)->attempt], 1) << "two runs of one attempt";
            taken.insert((*job)->id);
          }
          EXPECT_TRUE(store.SetProgress((*job)->lease, 0.5).ok());
          {
            std::lock_guard lock(mutex);
            --running[(*job)->attempt];
          }
          EXPECT_TRUE(store.FinishJob((*job)->lease, true, "").ok());
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
    ASSERT_TRUE(first->SealAttempt(World::SealOf(world.Append(attempt, 1)), 200).ok());
  }
  const JobRow job = **first->LeaseJob(1000, 1'000'000);
  const TempFolder other;
  std::filesystem::copy(folder.path() / "ticket.key", other.path() / "ticket.key");
  {
    auto second = Open(other, server_);
    const JobRow theirs = **second->LeaseJob(2000, 1'000'000);
    EXPECT_NE(theirs.id, job.id);
    EXPECT_FALSE(second->LeaseJob(2000, 1'000'000)->has_value());
    EXPECT_TRUE(first->SetProgress(job.lease, 0.5).ok());
  }
  auto second = Open(other, server_);
  auto again = second->LeaseJob(3000, 1'000'000);
  ASSERT_TRUE(again->has_value()) << "its own of before are over";
  EXPECT_NE((*again)->id, job.id);
  EXPECT_TRUE(first->SetProgress(job.lease, 0.6).ok());
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
  place.store.endpoint = bucket.endpoint();
  place.store.region = test::S3StandIn::kRegion;
  place.store.bucket = test::S3StandIn::kBucket;
  place.store.credentials = bucket.credentials();
  options.folder.s3_keys->master_key = keys.path() / "master.key";
  EXPECT_EQ(OpenPostgresStore(options).status().code(), Code::kNotFound) << "no master key";
  EXPECT_FALSE(*HasServers(options));
  ASSERT_TRUE(EnsureMasterKey(keys.path() / "master.key", SystemDisk()).ok());
  auto first = OpenPostgresStore(options);
  ASSERT_TRUE(first.ok()) << first.status().message();
  EXPECT_TRUE(*HasServers(options));
  const Sha256 certificate = HashSha256(AsBytes("certificate"));
  EXPECT_TRUE((*first)->MatchIdentity(ServerPart::kStationCertificate, {}).ok()) << "nobody's yet";
  EXPECT_TRUE((*first)->MatchIdentity(ServerPart::kStationCertificate, certificate).ok());
  EXPECT_TRUE((*first)->MatchIdentity(ServerPart::kStationCertificate, certificate).ok());

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
  const Status other_certificate = (*second)->MatchIdentity(
      ServerPart::kStationCertificate, HashSha256(AsBytes("another certificate")));
  EXPECT_EQ(other_certificate.code(), Code::kConflict);
  EXPECT_NE(other_certificate.message().find("station.crt"), std::string::npos);
  EXPECT_EQ((*second)->MatchIdentity(ServerPart::kStationCertificate, {}).code(), Code::kNotFound);

  // What one takes in, the other reads; whom one erases is erased for both.
  World world(**first);
  const Uuid attempt = world.OpenedAttempt();
  const auto chunks = world.Append(attempt, 2);
  EXPECT_EQ((*second)->AttemptChunks(attempt)->size(), 2u);
  ASSERT_TRUE((*second)->SealAttempt(World::SealOf(chunks), 200).ok());
  ASSERT_TRUE((*first)->ErasePerson(world.student, false, kSystem).ok());
  EXPECT_EQ((*second)->AttemptById(attempt).status().code(), Code::kNotFound);
  Person again;
  again.id = world.student;
  again.login = "again";
  EXPECT_EQ((*second)->CreatePerson(again, "v", {}, kSystem).status().code(), Code::kConflict);
  EXPECT_EQ(bucket.complaints(), std::vector<std::string>{});
}

}  // namespace
}  // namespace enamel::server
