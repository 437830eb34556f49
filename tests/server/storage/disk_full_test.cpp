#include <gtest/gtest.h>

#include "tests/server/storage/simulated_disk.h"
#include "tests/server/storage/store_world.h"

// A full disk: the store acknowledges only what it has written, reports the full disk, and resumes
// by itself when there is room again.
namespace enamel::server {
namespace {

using namespace testing;

class DiskFullTest : public ::testing::Test {
 protected:
  std::unique_ptr<Store> Open(uint64_t min_free_bytes) {
    StoreOptions options;
    options.folder = folder_.path();
    options.vfs = disk_.vfs();
    options.disk = &disk_;
    options.min_free_bytes = min_free_bytes;
    options.free_space_check = std::chrono::milliseconds(0);
    auto store = OpenSqliteStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }
  TempFolder folder_;
  SimulatedDisk disk_{folder_.path()};
};

constexpr uint64_t kMib = 1 << 20;

TEST_F(DiskFullTest, RecordingsAreRefusedBeforeTheLastBlockAndTakenAgain) {
  auto store = Open(10 * kMib);
  World world(*store);
  Uuid attempt = world.OpenedAttempt();
  auto first = world.Chunk(attempt, 0, World::HeaderHash());
  EXPECT_TRUE(store->health.Health().takes_recordings);

  disk_.SetFree(9 * kMib);
  Status refused = store->ingest.AppendChunk(first);
  EXPECT_EQ(refused.code(), Code::kUnavailable) << "stations come back after this one";
  EXPECT_NE(refused.message().find("9 MiB"), std::string::npos) << refused.message();
  EXPECT_EQ(store->blobs.PutBlob(AsBytes("x")).status().code(), Code::kUnavailable);
  StoreHealth health = store->health.Health();
  EXPECT_FALSE(health.takes_recordings);
  EXPECT_FALSE(health.problem.empty());
  EXPECT_EQ(health.free_bytes, 9 * kMib);
  EXPECT_TRUE(store->people.SetDisabled(world.student, true, kSystem).ok())
      << "what makes room, or has to be done anyhow, still works";

  disk_.SetFree(11 * kMib);
  EXPECT_TRUE(store->health.Health().takes_recordings);
  EXPECT_TRUE(store->ingest.AppendChunk(first).ok());
}

TEST_F(DiskFullTest, WriteThatFindsNoRoomIsNotAcknowledgedAndNothingBeforeItIsLost) {
  auto store = Open(0);
  World world(*store);
  Uuid attempt = world.OpenedAttempt();
  disk_.SetFree(100'000);
  std::vector<ChunkPut> sent;
  Status status;
  while (status.ok()) {
    ASSERT_LT(sent.size(), 1000u) << "the disk never got full";
    Sha256 previous = sent.empty() ? World::HeaderHash() : sent.back().hash;
    sent.push_back(world.Chunk(attempt, static_cast<uint32_t>(sent.size()), previous));
    status = store->ingest.AppendChunk(sent.back());
  }
  EXPECT_EQ(status.code(), Code::kStorage);
  EXPECT_NE(status.message().find("disk space"), std::string::npos) << status.message();
  EXPECT_FALSE(store->health.Health().takes_recordings);
  EXPECT_EQ(AllChunks(store->recordings, attempt)->size(), sent.size() - 1);
  EXPECT_EQ(store->ingest.AppendChunk(sent.back()).code(), Code::kStorage) << "and again";

  disk_.SetFree(std::nullopt);
  EXPECT_TRUE(store->ingest.AppendChunk(sent.back()).ok());
  EXPECT_TRUE(store->health.Health().takes_recordings);
  trace::Seal seal = World::SealOf(sent);
  EXPECT_TRUE(store->seals.SealAttempt(seal, 200).ok());
  store.reset();
  store = Open(0);
  EXPECT_EQ(AllChunks(store->recordings, attempt)->size(), sent.size());
}

TEST_F(DiskFullTest, SealThatFindsNoRoomForTheBlobIsSimplyTriedAgain) {
  auto store = Open(0);
  World world(*store);
  Uuid attempt = world.OpenedAttempt();
  auto chunks = world.Append(attempt, 3);
  disk_.SetFree(50);
  EXPECT_EQ(store->seals.SealAttempt(World::SealOf(chunks), 200).code(), Code::kStorage);
  EXPECT_EQ(store->attempts.AttemptById(attempt)->state, AttemptState::kRecording);
  EXPECT_EQ(AllChunks(store->recordings, attempt)->size(), 3u);
  disk_.SetFree(std::nullopt);
  EXPECT_TRUE(store->seals.SealAttempt(World::SealOf(chunks), 200).ok());
}

// Where the room ends must not matter: whatever was acknowledged survives a power cut at that
// moment.
TEST_F(DiskFullTest, FullDiskAndThenAPowerCutLoseNothingAcknowledged) {
  for (uint64_t room : {3'000u, 9'000u, 20'000u, 47'000u, 90'000u}) {
    TempFolder folder, left;
    SimulatedDisk disk(folder.path());
    StoreOptions options;
    options.folder = folder.path();
    options.vfs = disk.vfs();
    options.disk = &disk;
    auto store = std::move(OpenSqliteStore(options)).value();
    World world(*store);
    Uuid attempt = world.OpenedAttempt();
    disk.SetFree(room);
    uint32_t acknowledged = 0;
    Sha256 previous = World::HeaderHash();
    for (;; ++acknowledged) {
      auto put = world.Chunk(attempt, acknowledged, previous);
      previous = put.hash;
      if (!store->ingest.AppendChunk(put).ok()) break;
    }
    disk.CutAfter(disk.operations(), SimulatedDisk::Unsynced::kLost, 0, left.path());
    auto after = OpenStore(left.path());
    ASSERT_TRUE(AllChunks(after->recordings, attempt).ok());
    EXPECT_EQ(AllChunks(after->recordings, attempt)->size(), acknowledged)
        << room << " bytes of room";
  }
}

}  // namespace
}  // namespace enamel::server
