#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <fstream>
#include <random>
#include <string>

#include "server/storage/engine/query.h"
#include "server/storage/recordings/trace_rows.h"
#include "server/storage/store_engine.h"
#include "server/storage/verify/verify.h"
#include "tests/server/storage/recorded_attempt.h"

// A recording of any length is sealed and read with the memory of a few parts. The bound is the
// system's: an allocation beyond it fails.
namespace enamel::server {
namespace {

using namespace testing;

// In proportion to 300 MB within 64 MiB, which takes twice the time.
constexpr uint64_t kRecordingBytes = 150'000'000;
constexpr uint64_t kMaxMemory = uint64_t{32} << 20;  // above what an idle store has

// The private writable memory of this process, which RLIMIT_DATA counts.
uint64_t DataBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmData:")) return std::stoull(line.substr(7)) * 1024;
  }
  return 0;
}

class MemoryLimit {
 public:
  explicit MemoryLimit(uint64_t above) {
    EXPECT_EQ(::getrlimit(RLIMIT_DATA, &before_), 0);
    ::malloc_trim(0);
    rlimit limit = before_;
    limit.rlim_cur = DataBytes() + above;
    EXPECT_EQ(::setrlimit(RLIMIT_DATA, &limit), 0);
  }
  ~MemoryLimit() { EXPECT_EQ(::setrlimit(RLIMIT_DATA, &before_), 0); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
};

// Chunks of one noise that nothing packs; signed and chained, so that `verify` has nothing to say.
class Noise {
 public:
  Noise(const Uuid& attempt, const trace::KeyPair& keys, const Sha256& header) : keys_(keys) {
    std::mt19937_64 random(61);
    std::vector<trace::Tick> ticks(trace::kMaxTicksPerChunk);
    for (trace::Tick& tick : ticks) {
      for (int32_t& count : tick.input.counts) count = static_cast<int32_t>(random());
      for (int32_t& at : tick.witness.anchor_100nm) at = static_cast<int32_t>(random());
      for (int32_t& force : tick.witness.force_sent_mn) force = static_cast<int32_t>(random());
      for (int32_t& force : tick.witness.force_computed_mn) force = static_cast<int32_t>(random());
    }
    trace::ChunkHead head;
    head.attempt = attempt;
    head.state_hash = 7;
    bytes_ = trace::EncodeChunk(head, ticks, keys.secret_key);
    put_ = {attempt, head, header, {}, 100};
    put_.head.count = trace::kMaxTicksPerChunk;
    put_.head.seq = UINT32_MAX;
  }

  const ChunkPut& Next() {
    // schemas/trace_format.md, "Chunk".
    constexpr size_t kSeq = 22, kFirstTick = 26, kPrevious = 50, kSignature = 64;
    ++put_.head.seq;
    put_.head.first_tick = uint64_t{put_.head.seq} * trace::kMaxTicksPerChunk;
    ByteWriter numbers;
    numbers.U32(put_.head.seq);
    numbers.U64(put_.head.first_tick);
    std::ranges::copy(ByteView(numbers.bytes()).first(4), bytes_.begin() + kSeq);
    std::ranges::copy(ByteView(numbers.bytes()).subspan(4), bytes_.begin() + kFirstTick);
    std::ranges::copy(put_.hash.view(), bytes_.begin() + kPrevious);
    put_.hash = HashSha256(ByteView(bytes_).first(bytes_.size() - kSignature));
    std::ranges::copy(trace::SignText("enamel.trace-chunk.v1", put_.hash.view(), keys_.secret_key),
                      bytes_.end() - kSignature);
    put_.bytes = bytes_;
    return put_;
  }
  size_t chunk_bytes() const { return bytes_.size(); }

 private:
  const trace::KeyPair& keys_;
  Bytes bytes_;
  ChunkPut put_;
};

// Puts the rows of a recording, without a sync for each chunk. Returns its seal.
trace::Seal Record(RecordedSchool& school, const Uuid& attempt, uint64_t bytes) {
  StoreEngine& engine = *school.store->engine;
  const Bytes header = *school.store->recordings.AttemptHeader(attempt);
  const DataKey key = *engine.keyring->FindOrMake(school.world.student);
  Noise noise(attempt, school.world.keys, HashSha256(header));
  ChunkPut last;
  const auto chunks = static_cast<uint32_t>(bytes / noise.chunk_bytes() + 1);
  for (uint32_t done = 0; done < chunks;) {
    const uint32_t some = std::min<uint32_t>(chunks - done, 64);
    const Status kept = engine.rows.Write([&](sql::Db& db) -> Status {
      for (uint32_t i = 0; i < some; ++i) {
        last = noise.Next();
        const Bytes sealed = SealPersonal(school.world.student, key, attempt, last.bytes);
        ENAMEL_RETURN_IF_ERROR(InsertChunk(db, last, sealed));
      }
      return Status::Ok();
    });
    EXPECT_TRUE(kept.ok()) << kept.message();
    done += some;
  }
  const trace::Seal seal{attempt, chunks, uint64_t{chunks} * trace::kMaxTicksPerChunk, last.hash,
                         last.head.state_hash};
  const Status counted = engine.rows.Write([&](sql::Db& db) {
    Query q(db,
            "UPDATE attempts SET chunks = ?3, ticks = ?4, head_hash = ?5, head_state_hash = ?6, "
            "trace_bytes = ?7, last_chunk_ms = 100 WHERE tenant = ?1 AND id = ?2");
    q.Bind(attempt).Bind(int64_t{seal.chunks}).Bind(static_cast<int64_t>(seal.ticks));
    q.Bind(seal.last_chunk).Bind(std::bit_cast<int64_t>(seal.state_hash));
    return q.Bind(static_cast<int64_t>(header.size() + chunks * noise.chunk_bytes())).Run();
  });
  EXPECT_TRUE(counted.ok()) << counted.message();
  return seal;
}

TEST(RecordingMemoryTest, OfAHundredAndFiftyMegabytesIsThatOfAFewParts) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory is beyond any bound";
#endif
  TempFolder folder;
  RecordedSchool school(folder.path() / "data");
  // An idle store has its threads, connections and caches.
  const Uuid small = school.Record(3);
  school.Seal(small);
  ASSERT_TRUE(*school.store->recordings.IsWhole(small));
  const Uuid attempt = school.Record(0);
  school.store.reset();
  {
    StoreOptions options;
    options.folder = school.data;
    school.store = std::move(OpenSqliteStore(options)).value();
  }
  const MemoryLimit limit(kMaxMemory);
  const trace::Seal seal = Record(school, attempt, kRecordingBytes);
  const Status sealed = school.store->seals.SealAttempt(seal, 200);
  ASSERT_TRUE(sealed.ok()) << sealed.message();
  EXPECT_TRUE(*school.store->recordings.IsWhole(attempt));
  const auto recording = *school.store->recordings.Open(attempt, seal.chunks - 1);
  const auto last = recording.next();
  ASSERT_TRUE(last.ok() && *last) << last.status().message();
  EXPECT_EQ(trace::DecodeChunkHead(**last)->hash, seal.last_chunk);
  const auto report = Verify({school.data, {}, {}});
  ASSERT_TRUE(report.ok()) << report.status().message();
  for (const Finding& finding : report->findings) {
    ADD_FAILURE() << finding.kind << " " << finding.object << ": expected " << finding.expected
                  << ", found " << finding.found;
  }
}

}  // namespace
}  // namespace enamel::server
