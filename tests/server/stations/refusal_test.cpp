#include <gtest/gtest.h>
#include <sodium.h>
#include <zstd.h>

#include "tests/server/stations/link_world.h"

// Chunks as no honest station sends them: each refused with a reason, none counted, and the next
// honest one taken.
namespace enamel::server::stations {
namespace {

using namespace testing;

class ChunkRefusalTest : public ::testing::Test {
 protected:
  ChunkRefusalTest() {
    EXPECT_TRUE(station_.Enrol().has_enrolled());
    session_.emplace(world_.services, "127.0.0.1");
    EXPECT_TRUE(station_.Hello().has_welcome());
    EXPECT_TRUE(station_.SignIn("student").has_signed_in());
    recording_.emplace(NewRecording());
    EXPECT_TRUE(station_.Open(recording_->header).has_attempt_opened());
  }

  wire::Reply Carry(const wire::Request& request) {
    return CarryTo(*session_, request).reply.value_or(wire::Reply());
  }

  Recording NewRecording() {
    auto reply = station_.RequestTicket(world_.exercise.content, world_.Profile("omega3"));
    return Recording(world_, TicketOf(reply), station_.keys, 3);
  }

  uint32_t Stored() { return world_.store->attempts.AttemptById(recording_->seal.attempt)->chunks; }

  void ExpectRefused(const Bytes& chunk, const std::string& code) {
    uint32_t before = Stored();
    wire::Reply reply = station_.Put(chunk);
    EXPECT_EQ(reply.error().code(), code) << reply.error().message();
    EXPECT_FALSE(reply.error().message().empty());
    EXPECT_EQ(Stored(), before);
  }

  void ExpectTaken(const Bytes& chunk) {
    wire::Reply reply = station_.Put(chunk);
    EXPECT_TRUE(reply.chunk_ack().committed()) << reply.error().message();
  }

  // The chunk with another payload than it was signed with, signed again: only the station itself
  // could send it.
  Bytes WithPayload(const Bytes& packed, uint32_t unpacked_size) {
    const Bytes& honest = recording_->chunks[0];
    ByteWriter out;
    out.Raw(ByteView(honest).first(82));
    out.U32(unpacked_size);
    out.U32(static_cast<uint32_t>(packed.size()));
    out.Raw(packed);
    return Signed(out.Take());
  }

  Bytes Signed(Bytes bytes) {
    // schemas/trace_format.md, "Chunk".
    Bytes message(kDomain.begin(), kDomain.end());
    Sha256 hash = HashSha256(bytes);
    message.insert(message.end(), hash.bytes.begin(), hash.bytes.end());
    trace::Signature signature;
    crypto_sign_detached(signature.data(), nullptr, message.data(), message.size(),
                         station_.keys.secret_key.data());
    bytes.insert(bytes.end(), signature.begin(), signature.end());
    return bytes;
  }

  static constexpr std::string_view kDomain = "enamel.trace-chunk.v1";
  LinkWorld world_;
  std::optional<Session> session_{std::in_place, world_.services, "127.0.0.1"};
  ScriptedStation station_{[this](const wire::Request& request) { return Carry(request); }};
  std::optional<Recording> recording_;
};

TEST_F(ChunkRefusalTest, TruncatedAnywhere) {
  const Bytes& chunk = recording_->chunks[0];
  for (size_t size = 0; size < chunk.size(); size += 7) {
    Bytes cut(chunk.begin(), chunk.begin() + static_cast<long>(size));
    ExpectRefused(cut, "invalid_input");
  }
  ExpectTaken(chunk);
}

TEST_F(ChunkRefusalTest, BeforeItsTurn) {
  ExpectRefused(recording_->chunks[1], "conflict");
  ExpectTaken(recording_->chunks[0]);
  ExpectTaken(recording_->chunks[1]);
}

TEST_F(ChunkRefusalTest, ReplayedChunkCountsOnce) {
  ExpectTaken(recording_->chunks[0]);
  ExpectTaken(recording_->chunks[0]);
  EXPECT_EQ(Stored(), 1u);
}

TEST_F(ChunkRefusalTest, OfAnotherAttempt) {
  Recording other = NewRecording();
  ASSERT_TRUE(station_.Open(other.header).has_attempt_opened());
  // The other attempt's chunk, said to be of this one: its chain begins elsewhere.
  Bytes chunk(other.chunks[0].begin(), other.chunks[0].end() - 64);
  std::ranges::copy(recording_->seal.attempt.bytes, chunk.begin() + 6);
  ExpectRefused(Signed(chunk), "conflict");
  ExpectTaken(recording_->chunks[0]);
}

TEST_F(ChunkRefusalTest, OfAnAttemptThatIsNotOpen) {
  Recording other = NewRecording();
  ExpectRefused(other.chunks[0], "not_found");
}

TEST_F(ChunkRefusalTest, SignedBySomebodyElse) {
  Bytes forged = recording_->Chunk(0, HashSha256(recording_->header), trace::NewKeyPair());
  ExpectRefused(forged, "forbidden");
  ExpectTaken(recording_->chunks[0]);
}

TEST_F(ChunkRefusalTest, UnsignedChunkIsNeverUnpacked) {
  // A payload that cannot be unpacked, unsigned: the answer is about the signature.
  Bytes bomb = WithPayload(Bytes(16, 0xff), 100);
  bomb.back() ^= 1;
  ExpectRefused(bomb, "forbidden");
}

TEST_F(ChunkRefusalTest, PayloadThatUnpacksToMoreThanItSaysOrMay) {
  Bytes zeros(8 << 20);
  Bytes packed(ZSTD_compressBound(zeros.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), zeros.data(), zeros.size(), 19));
  ASSERT_LT(packed.size(), 1000u);
  // 100 ticks may take 24 (1 + 10 · 100) bytes (schemas/trace_format.md, "Limits").
  constexpr uint32_t kMost = 24 * (1 + 10 * Recording::kTicks);
  ExpectRefused(WithPayload(packed, kMost), "invalid_input");
  ExpectRefused(WithPayload(packed, kMost + 1), "too_large");
  ExpectRefused(WithPayload(packed, 0xffffffff), "too_large");
  ExpectTaken(recording_->chunks[0]);
}

TEST_F(ChunkRefusalTest, LargerThanAnyChunk) {
  ExpectRefused(Bytes(trace::kMaxChunkBytes + 1), "too_large");
}

TEST_F(ChunkRefusalTest, CommittedTicksAreShownToWhoeverWatches) {
  const Uuid& attempt = recording_->seal.attempt;
  ExpectTaken(recording_->chunks[0]);
  EXPECT_FALSE(world_.live.Latest(attempt).has_value()) << "made for nobody";
  auto watch = world_.live.Watch(attempt, Uuid{});
  ExpectTaken(recording_->chunks[1]);
  auto event = watch->Next();
  ASSERT_NE(event, nullptr);
  EXPECT_TRUE(event->starts_with("{\"tick\":199,")) << *event;
  // 100 ticks at about 60 rows a second.
  EXPECT_EQ(std::ranges::count(*event, '['), 1 + 7);
}

}  // namespace
}  // namespace enamel::server::stations
