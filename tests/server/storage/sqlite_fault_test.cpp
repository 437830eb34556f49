#include <gtest/gtest.h>

#include "tests/server/storage/store_world.h"

// Fails the Nth write for every N until a whole attempt goes through: what was acknowledged is
// there afterwards, what was refused can simply be sent again.
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
    std::vector<Store::ChunkPut> chunks;
    uint32_t acknowledged = 0;
    bool sealed = false;
    Sha256 previous = World::HeaderHash();
    for (uint32_t seq = 0; seq < kChunks; ++seq) {
      chunks.push_back(world.Chunk(attempt, seq, previous));
      previous = chunks.back().hash;
      if (!store->AppendChunk(chunks.back()).ok()) break;
      ++acknowledged;
    }
    if (acknowledged == kChunks) sealed = store->SealAttempt(World::SealOf(chunks), 1).ok();
    bool fired = faults.fired;
    faults.until_failure = -1;

    store.reset();
    store = OpenStore(folder.path());
    EXPECT_GE(store->AttemptChunks(attempt)->size(), acknowledged);
    if (sealed) {
      EXPECT_EQ(store->AttemptById(attempt)->state, AttemptState::kSealed);
    }

    previous = World::HeaderHash();
    std::vector<Store::ChunkPut> all;
    for (uint32_t seq = 0; seq < kChunks; ++seq) {
      all.push_back(world.Chunk(attempt, seq, previous));
      previous = all.back().hash;
      EXPECT_TRUE(store->AppendChunk(all.back()).ok());
    }
    EXPECT_TRUE(store->SealAttempt(World::SealOf(all), 1).ok());
    EXPECT_EQ(store->AttemptById(attempt)->ticks, uint64_t{kChunks} * World::kTicksPerChunk);
    EXPECT_EQ(store->Jobs("queued")->size(), 1u);
    if (!fired) return;
  }
  FAIL() << "the attempt never went through without a failure";
}

}  // namespace
}  // namespace enamel::server
