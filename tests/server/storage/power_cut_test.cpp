#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <set>

#include "tests/server/storage/simulated_disk.h"
#include "tests/server/storage/store_world.h"

// The power fails after every single operation on the disk. Everything acknowledged before
// survives, and everything else can be sent again.
namespace enamel::server {
namespace {

using namespace testing;

// What had been acknowledged when so many operations had been done.
struct Promise {
  size_t operations = 0;
  std::map<Uuid, uint32_t> chunks;
  std::set<Uuid> sealed, scored, erased;
  std::set<Sha256> blobs;
};

// A small school's day on a simulated disk: recordings, seals, scores, an erasure, a restart.
class Day {
 public:
  explicit Day(const std::filesystem::path& folder) : disk_(folder), folder_(folder) { Open(); }

  void Run() {
    world_.emplace(*store_);
    Uuid second = AddPerson(*store_, "second", Role::kStudent);
    first_ = Begin(world_->student);
    Record(first_, 5);
    Uuid other = Begin(second);
    Record(other, 2);
    Seal(first_);
    Score(first_);
    unfinished_ = Begin(world_->student);
    Record(unfinished_, 3);
    store_.reset();
    Open();
    Record(unfinished_, 3);
    Seal(other);
    Erase(second, other);
    Record(unfinished_, 2);
    store_.reset();
    Acknowledge();
  }

  const Promise& PromiseAfter(size_t operations) const {
    const Promise* last = &promises_.front();
    for (const Promise& promise : promises_) {
      if (promise.operations <= operations) last = &promise;
    }
    return *last;
  }
  const std::vector<ChunkPut>& SentOf(const Uuid& attempt) const { return sent_.at(attempt); }
  SimulatedDisk& disk() { return disk_; }
  size_t first_promise() const { return promises_.at(1).operations; }

 private:
  void Open() {
    StoreOptions options;
    options.folder = folder_;
    options.hold_lock = true;
    options.vfs = disk_.vfs();
    options.disk = &disk_;
    auto opened = OpenSqliteStore(options);
    ASSERT_TRUE(opened.ok()) << opened.status().message();
    store_ = std::move(opened).value();
  }

  void Acknowledge() {
    now_.operations = disk_.operations();
    promises_.push_back(now_);
  }

  Uuid Begin(const Uuid& person) {
    AttemptRow row;
    row.id = Uuid::New();
    row.person = person;
    row.station = world_->station;
    row.exercise = world_->exercise.id;
    row.profile_content = world_->profile;
    row.ticketed_ms = 5;
    EXPECT_TRUE(store_->tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
    EXPECT_TRUE(store_->tickets.OpenAttempt(row.id, AsBytes("header")).ok());
    now_.chunks[row.id] = 0;
    Acknowledge();
    return row.id;
  }

  void Record(const Uuid& attempt, uint32_t count) {
    auto& sent = sent_[attempt];
    for (uint32_t i = 0; i < count; ++i) {
      Sha256 previous = sent.empty() ? World::HeaderHash() : sent.back().hash;
      sent.push_back(world_->Chunk(attempt, static_cast<uint32_t>(sent.size()), previous));
      Status status = store_->ingest.AppendChunk(sent.back());
      EXPECT_TRUE(status.ok()) << status.message();
      ++now_.chunks[attempt];
      Acknowledge();
    }
  }

  void Seal(const Uuid& attempt) {
    EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(sent_[attempt]), 200).ok());
    now_.sealed.insert(attempt);
    Acknowledge();
  }

  void Score(const Uuid& attempt) {
    AttemptResult result;
    result.score_json = *store_->blobs.PutAttemptBlob(attempt, AsBytes("{\"score\": 80}"));
    now_.blobs.insert(result.score_json);
    Acknowledge();
    EXPECT_TRUE(store_->results.FinishAttempt(attempt, result, {}).ok());
    now_.scored.insert(attempt);
    Acknowledge();
  }

  void Erase(const Uuid& person, const Uuid& attempt) {
    now_.chunks.erase(attempt);  // from the first step on, it may be there or not
    now_.sealed.erase(attempt);
    Acknowledge();
    auto erased = store_->erasures.ErasePerson(person, false, kSystem);
    EXPECT_TRUE(erased.ok()) << erased.status().message();
    now_.erased.insert(person);
    Acknowledge();
  }

  SimulatedDisk disk_;
  std::filesystem::path folder_;
  std::unique_ptr<Store> store_;
  std::optional<World> world_;  // its store is the first one
  Uuid first_, unfinished_;
  std::map<Uuid, std::vector<ChunkPut>> sent_;
  Promise now_;
  std::vector<Promise> promises_{Promise{}};
};

void ExpectKept(Store& store, const Day& day, const Promise& promise) {
  for (const auto& [attempt, count] : promise.chunks) {
    auto row = store.attempts.AttemptById(attempt);
    ASSERT_TRUE(row.ok()) << row.status().message();
    if (count == 0) continue;
    auto chunks = AllChunks(store.recordings, attempt);
    ASSERT_TRUE(chunks.ok()) << chunks.status().message();
    ASSERT_GE(chunks->size(), count);
    for (uint32_t i = 0; i < count; ++i)
      EXPECT_EQ((*chunks)[i], day.SentOf(attempt)[i].bytes) << "chunk " << i;
    if (promise.sealed.contains(attempt)) {
      EXPECT_TRUE(store.recordings.AttemptSeal(attempt).ok());
    }
    if (promise.scored.contains(attempt)) {
      EXPECT_TRUE(store.results.ResultOf(attempt).ok());
    }
  }
  for (const Sha256& blob : promise.blobs)
    EXPECT_TRUE(store.blobs.GetBlob(blob).ok()) << blob.Hex();
  for (const Uuid& person : promise.erased) {
    EXPECT_EQ(store.people.PersonById(person).status().code(), Code::kNotFound);
  }
}

// A station that comes back sends everything again; nothing is doubled.
void SendAgain(Store& store, const Day& day, const Promise& promise) {
  for (const auto& [attempt, count] : promise.chunks) {
    if (!store.recordings.AttemptHeader(attempt).ok()) continue;
    for (const ChunkPut& chunk : day.SentOf(attempt)) {
      Status status = store.ingest.AppendChunk(chunk);
      EXPECT_TRUE(status.ok()) << status.message();
    }
    EXPECT_EQ(store.attempts.AttemptById(attempt)->chunks, day.SentOf(attempt).size());
    EXPECT_EQ(AllChunks(store.recordings, attempt)->size(), day.SentOf(attempt).size());
  }
}

class PowerCutTest : public ::testing::TestWithParam<SimulatedDisk::Unsynced> {};

TEST_P(PowerCutTest, NothingAcknowledgedIsLostWhereverThePowerFails) {
  TempFolder folder;
  Day day(folder.path());
  ASSERT_NO_FATAL_FAILURE(day.Run());
  const bool full = std::getenv("ENAMEL_FULL") != nullptr;
  const size_t all = day.disk().operations();
  const size_t step = full ? 1 : std::max<size_t>(all / 60, 1);
  size_t cuts = 0;
  for (size_t after = 0; after <= all; after += step) {
    SCOPED_TRACE("power cut after operation " + std::to_string(after) + " of " +
                 std::to_string(all));
    TempFolder left;
    day.disk().CutAfter(after, GetParam(), static_cast<uint32_t>(after), left.path());
    auto store = OpenSqliteStore({left.path(), true});
    ASSERT_TRUE(store.ok()) << store.status().message();
    const Promise& promise = day.PromiseAfter(after);
    ASSERT_NO_FATAL_FAILURE(ExpectKept(**store, day, promise));
    SendAgain(**store, day, promise);
    ++cuts;
    if (HasFailure()) return;
  }
  RecordProperty("operations", static_cast<int>(all));
  std::printf("%zu operations, power cut after %zu of them\n", all, cuts);
}

INSTANTIATE_TEST_SUITE_P(UnsyncedWrites, PowerCutTest,
                         ::testing::Values(SimulatedDisk::Unsynced::kLost,
                                           SimulatedDisk::Unsynced::kTorn),
                         [](const auto& info) {
                           return info.param == SimulatedDisk::Unsynced::kLost ? "AreLost"
                                                                               : "AreTorn";
                         });

// Shows that the test can fail: a drive that only claims to sync loses acknowledged data.
TEST(SimulatedDiskTest, DriveThatLiesAboutSyncsLosesWhatWasAcknowledged) {
  TempFolder folder, left;
  Day day(folder.path());
  day.disk().SetLying();
  ASSERT_NO_FATAL_FAILURE(day.Run());
  const size_t last = day.disk().operations();
  day.disk().CutAfter(last, SimulatedDisk::Unsynced::kLost, 0, left.path());
  auto store = OpenSqliteStore({left.path(), true});
  size_t lost = 0;
  for (const auto& [attempt, count] : day.PromiseAfter(last).chunks) {
    auto chunks = store.ok() ? AllChunks((*store)->recordings, attempt) : store.status();
    lost += !chunks.ok() || chunks->size() < count ? 1 : 0;
  }
  EXPECT_GT(lost, 0u);
}

// The test's own foundation: a disk that forgets to sync is caught.
TEST(SimulatedDiskTest, WhatWasNotSyncedIsLost) {
  TempFolder folder;
  SimulatedDisk disk(folder.path());
  ASSERT_TRUE(disk.Replace(folder.path() / "a", AsBytes("one")).ok());
  size_t named = disk.operations();
  TempFolder before, after;
  disk.CutAfter(named - 1, SimulatedDisk::Unsynced::kLost, 0, before.path());
  disk.CutAfter(named, SimulatedDisk::Unsynced::kLost, 0, after.path());
  EXPECT_FALSE(std::filesystem::exists(before.path() / "a")) << "its folder was not synced yet";
  EXPECT_TRUE(std::filesystem::exists(after.path() / "a"));
}

}  // namespace
}  // namespace enamel::server
