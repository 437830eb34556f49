#include <gtest/gtest.h>

#include <algorithm>

#include "common/trace/trace.h"
#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

class ChainTest : public testing::Test {
 protected:
  ChainTest() : recording_(sample::Record(sample::CutInputs(500), 100)) {}

  ChainVerifier Fresh() const {
    return ChainVerifier(recording_.header.ticket.attempt,
                         HashSha256(EncodeHeader(recording_.header)));
  }
  Chunk At(size_t i) const { return *DecodeChunkHead(recording_.chunks[i]); }
  ChainVerifier After(size_t n) const {
    ChainVerifier chain = Fresh();
    for (size_t i = 0; i < n; ++i) EXPECT_TRUE(chain.Accept(At(i)).ok());
    return chain;
  }

  sample::Recording recording_;
};

TEST_F(ChainTest, AcceptsAWholeRecordingAndItsSeal) {
  ChainVerifier chain = After(5);
  EXPECT_EQ(chain.next_seq(), 5u);
  EXPECT_EQ(chain.next_tick(), 500u);
  EXPECT_EQ(chain.state_hash(), recording_.seal.state_hash);
  EXPECT_TRUE(chain.AcceptSeal(recording_.seal).ok());
}

TEST_F(ChainTest, AcceptsNoOrderButTheRecordedOne) {
  std::vector<size_t> order = {0, 1, 2, 3, 4};
  int accepted = 0;
  do {
    ChainVerifier chain = Fresh();
    accepted +=
        std::all_of(order.begin(), order.end(), [&](size_t i) { return chain.Accept(At(i)).ok(); });
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(accepted, 1);
}

TEST_F(ChainTest, RefusesAReplayedChunkAndStaysWhereItWas) {
  ChainVerifier chain = After(3);
  Status status = chain.Accept(At(2));
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_EQ(status.field(), "seq");
  EXPECT_TRUE(chain.Accept(At(3)).ok());
}

TEST_F(ChainTest, RefusesAChunkLeftOut) {
  ChainVerifier chain = After(1);
  Status status = chain.Accept(At(2));
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_NE(status.message().find("expected seq 1, found 2"), std::string::npos)
      << status.message();
}

TEST_F(ChainTest, RefusesAChunkOfAnotherAttempt) {
  Chunk chunk = At(0);
  chunk.head.attempt.bytes.fill(0x55);
  EXPECT_EQ(Fresh().Accept(chunk).field(), "attempt");
}

TEST_F(ChainTest, RefusesTheSamePlaceInAnotherHistory) {
  // Same attempt, same numbers, another hand: a chunk of the second cannot continue the first.
  auto inputs = sample::CutInputs(500);
  inputs[10].counts[0] += 1;
  auto other = sample::Record(inputs, 100);
  ChainVerifier chain = After(1);
  Status status = chain.Accept(*DecodeChunkHead(other.chunks[1]));
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_EQ(status.field(), "previous");
}

TEST_F(ChainTest, RefusesAHeaderExchangedUnderTheChunks) {
  Header header = recording_.header;
  header.params.peak_force_mn += 1;
  ChainVerifier chain(header.ticket.attempt, HashSha256(EncodeHeader(header)));
  EXPECT_EQ(chain.Accept(At(0)).field(), "previous");
}

TEST_F(ChainTest, RefusesAShiftedFirstTick) {
  Chunk chunk = At(1);
  chunk.head.first_tick += 1;
  EXPECT_EQ(After(1).Accept(chunk).field(), "first_tick");
}

TEST_F(ChainTest, GoesOnFromAStoredState) {
  ChainState stored = After(2).state();
  ChainVerifier chain(recording_.header.ticket.attempt, stored);
  for (size_t i = 2; i < 5; ++i) ASSERT_TRUE(chain.Accept(At(i)).ok());
  EXPECT_TRUE(chain.AcceptSeal(recording_.seal).ok());
}

TEST_F(ChainTest, RefusesASealThatDiffersInAnyField) {
  ChainVerifier chain = After(5);
  for (const char* field : {"attempt", "chunks", "ticks", "last_chunk", "state_hash"}) {
    Seal seal = recording_.seal;
    std::string name = field;
    if (name == "attempt") seal.attempt.bytes[0] ^= 1;
    if (name == "chunks") seal.chunks += 1;
    if (name == "ticks") seal.ticks -= 1;
    if (name == "last_chunk") seal.last_chunk.bytes[31] ^= 1;
    if (name == "state_hash") seal.state_hash ^= 1;
    EXPECT_EQ(chain.AcceptSeal(seal).field(), name);
  }
}

TEST_F(ChainTest, RefusesASealThatHidesTheLastChunk) {
  EXPECT_EQ(After(4).AcceptSeal(recording_.seal).code(), Code::kConflict);
}

}  // namespace
}  // namespace enamel::trace
