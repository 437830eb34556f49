#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "server/storage/engine/query.h"
#include "server/storage/recordings/trace_parts.h"
#include "server/storage/store_engine.h"
#include "tests/server/storage/backends.h"

// Traces: commits, refusals, survival of a restart.
namespace enamel::server {
namespace {

using namespace testing;

class IngestTest : public StoreSuite {
 protected:
  World world_{*store_};
};

INSTANTIATE_TEST_SUITE_P(Backends, IngestTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(IngestTest, HeaderIsOpenedOnceAndAgainOnlyWithTheSameBytes) {
  Uuid attempt = world_.OpenedAttempt();
  EXPECT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok());
  EXPECT_EQ(store_->tickets.OpenAttempt(attempt, AsBytes("another")).code(), Code::kConflict);
  EXPECT_EQ(store_->tickets.OpenAttempt(Uuid::New(), AsBytes("header")).code(), Code::kNotFound);
}

TEST_P(IngestTest, KeepsTheFactsThatWereSaidLast) {
  Uuid attempt = world_.OpenedAttempt();
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->facts, "{}");
  ASSERT_TRUE(store_->tickets.KeepFacts(attempt, "{\"resumed\":1}").ok());
  ASSERT_TRUE(store_->tickets.KeepFacts(attempt, "{\"resumed\":2}").ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->facts, "{\"resumed\":2}");
  EXPECT_EQ(store_->tickets.KeepFacts(Uuid::New(), "{}").code(), Code::kNotFound);
}

TEST_P(IngestTest, ChunksAreCountedOnceHoweverOftenTheyCome) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 3);
  for (const auto& chunk : chunks) EXPECT_TRUE(store_->ingest.AppendChunk(chunk).ok());
  AttemptRow row = *store_->attempts.AttemptById(attempt);
  EXPECT_EQ(row.chunks, 3u);
  EXPECT_EQ(row.ticks, 3u * World::kTicksPerChunk);
  EXPECT_EQ(row.state, AttemptState::kRecording);
}

TEST_P(IngestTest, ChunkOutOfOrderNamesTheExpectedOne) {
  Uuid attempt = world_.OpenedAttempt();
  Status status = store_->ingest.AppendChunk(world_.Chunk(attempt, 2, World::HeaderHash()));
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_EQ(status.field(), "seq");
  EXPECT_NE(status.message().find("expected chunk 0"), std::string::npos) << status.message();
}

TEST_P(IngestTest, ChunkOfAnotherChainIsRefused) {
  Uuid attempt = world_.OpenedAttempt();
  Status status =
      store_->ingest.AppendChunk(world_.Chunk(attempt, 0, HashSha256(AsBytes("elsewhere"))));
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_EQ(status.field(), "previous");
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->chunks, 0u);
}

TEST_P(IngestTest, ContradictingChunkQuarantinesTheAttemptAndKeepsBoth) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 1);
  EXPECT_EQ(store_->ingest.AppendChunk(world_.Chunk(attempt, 0, World::HeaderHash(), 9)).code(),
            Code::kConflict);
  AttemptRow row = *store_->attempts.AttemptById(attempt);
  EXPECT_EQ(row.state, AttemptState::kQuarantined);
  EXPECT_FALSE(row.problem.empty());
  EXPECT_EQ(AllChunks(store_->recordings, attempt)->front(), chunks[0].bytes);
  EXPECT_EQ(store_->seals.SealAttempt(World::SealOf(chunks), 1).code(), Code::kConflict);
}

TEST_P(IngestTest, SealedTraceReadsBackTheSameBytes) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 4);
  trace::Seal seal = World::SealOf(chunks);
  ASSERT_TRUE(store_->seals.SealAttempt(seal, 200).ok());
  EXPECT_TRUE(store_->seals.SealAttempt(seal, 300).ok()) << "again: nothing to do";
  auto stored = AllChunks(store_->recordings, attempt);
  ASSERT_EQ(stored->size(), chunks.size());
  for (size_t i = 0; i < chunks.size(); ++i) EXPECT_EQ((*stored)[i], chunks[i].bytes);
  EXPECT_EQ(*store_->recordings.AttemptHeader(attempt), Bytes({'h', 'e', 'a', 'd', 'e', 'r'}));
  EXPECT_EQ(store_->recordings.AttemptSeal(attempt)->state_hash, seal.state_hash);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->sealed_ms, 200);
  EXPECT_EQ(store_->jobs.Jobs("queued")->size(), 1u);
}

TEST_P(IngestTest, SealThatDoesNotMatchTheChunksIsRefused) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 2);
  trace::Seal seal = World::SealOf(chunks);
  ++seal.chunks;
  EXPECT_EQ(store_->seals.SealAttempt(seal, 200).code(), Code::kConflict);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kRecording);
}

TEST_P(IngestTest, SealedAttemptTakesRepeatsButNothingNew) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 2);
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  EXPECT_TRUE(store_->ingest.AppendChunk(chunks[1]).ok());
  EXPECT_EQ(store_->ingest.AppendChunk(world_.Chunk(attempt, 1, chunks[0].hash, 5)).code(),
            Code::kConflict);
  EXPECT_EQ(store_->ingest.AppendChunk(world_.Chunk(attempt, 2, chunks[1].hash)).code(),
            Code::kConflict);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kSealed);
}

TEST_P(IngestTest, ContradictionIsToldOnceAndShownHoweverOftenItComes) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 1);
  for (int salt = 1; salt <= 40; ++salt) {
    EXPECT_FALSE(
        store_->ingest.AppendChunk(world_.Chunk(attempt, 0, World::HeaderHash(), salt)).ok());
  }
  AuditFilter about;
  about.object = attempt.Text();
  about.action = "attempt.quarantine";
  EXPECT_EQ(store_->audit.FindAudit(about)->size(), 1u);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags & kContradicted, kContradicted);
  auto evidence = *store_->recordings.ContradictionsOf(attempt);
  ASSERT_FALSE(evidence.empty());
  EXPECT_LE(evidence.size(), 16u);
  EXPECT_EQ(evidence[0].seq, 0u);
  EXPECT_NE(evidence[0].hash, chunks[0].hash);
  EXPECT_EQ(evidence[0].received_ms, 100);
}

TEST_P(IngestTest, ContradictionAfterTheSealIsFlaggedOnceAndChangesNothing) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 2);
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  for (int salt = 1; salt <= 3; ++salt) {
    EXPECT_FALSE(store_->ingest.AppendChunk(world_.Chunk(attempt, 1, chunks[0].hash, salt)).ok());
  }
  AttemptRow row = *store_->attempts.AttemptById(attempt);
  EXPECT_EQ(row.state, AttemptState::kSealed);
  EXPECT_EQ(row.flags & kContradicted, kContradicted);
  AuditFilter about;
  about.object = attempt.Text();
  about.action = "attempt.flag";
  EXPECT_EQ(store_->audit.FindAudit(about)->size(), 1u);
  EXPECT_EQ(store_->recordings.ContradictionsOf(attempt)->size(), 3u);
  EXPECT_EQ(AllChunks(store_->recordings, attempt)->at(1), chunks[1].bytes);
}

// A copy of a station's folder uses a reserved ticket once more. Whatever the second recording is,
// its upload is found, the first recording is unchanged, and an instructor sees why.
TEST_P(IngestTest, TicketThatWasClonedIsFoundHoweverLongTheSecondRecordingIs) {
  for (bool sealed : {true, false}) {
    for (uint32_t others : {1u, 2u, 3u, 4u}) {
      SCOPED_TRACE(std::to_string(others) + (sealed ? " after the seal" : " before the seal"));
      Uuid attempt = world_.OpenedAttempt();
      auto first = world_.Append(attempt, 3);
      if (sealed) ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(first), 200).ok());
      // The station of the copy sends the requested chunks: those after the committed ones.
      ASSERT_TRUE(store_->tickets.OpenAttempt(attempt, AsBytes("header")).ok())
          << "the same ticket";
      std::vector<ChunkPut> second;
      Sha256 previous = World::HeaderHash();
      for (uint32_t seq = 0; seq < others; ++seq) {
        second.push_back(world_.Chunk(attempt, seq, previous, 7));
        previous = second.back().hash;
      }
      for (uint32_t seq = 3; seq < others; ++seq) {
        EXPECT_EQ(store_->ingest.AppendChunk(second[seq]).code(), Code::kConflict);
      }
      EXPECT_EQ(store_->seals.SealAttempt(World::SealOf(second), 300).code(), Code::kConflict);

      AttemptRow row = *store_->attempts.AttemptById(attempt);
      EXPECT_EQ(row.flags & kContradicted, kContradicted);
      EXPECT_EQ(row.chunks, 3u) << "what was there stays";
      EXPECT_EQ(AllChunks(store_->recordings, attempt)->back(), first.back().bytes);
      AuditFilter about;
      about.object = attempt.Text();
      about.action = "attempt.flag";
      auto told = *store_->audit.FindAudit(about);
      ASSERT_EQ(told.size(), 1u) << "once";
      EXPECT_NE(told[0].after_json.find("two recordings"), std::string::npos);
      if (!sealed) EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(first), 400).ok());
    }
  }
}

TEST_P(IngestTest, TicketThatWasClonedIsFoundByAnotherHeader) {
  Uuid attempt = world_.OpenedAttempt();
  EXPECT_EQ(store_->tickets.OpenAttempt(attempt, AsBytes("other header")).code(), Code::kConflict);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags & kContradicted, kContradicted);
  EXPECT_EQ(AsText(*store_->recordings.AttemptHeader(attempt)), "header");
}

TEST_P(IngestTest, StationThatComesBackAfterABreakIsNoContradiction) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 2);
  ChunkPut third = world_.Chunk(attempt, 2, chunks[1].hash);
  auto all = chunks;
  all.push_back(third);
  EXPECT_FALSE(store_->seals.SealAttempt(World::SealOf(all), 200).ok())
      << "its chunk is still missing";
  EXPECT_FALSE(store_->ingest.AppendChunk(world_.Chunk(attempt, 3, third.hash)).ok())
      << "out of order";
  for (const auto& chunk : all) EXPECT_TRUE(store_->ingest.AppendChunk(chunk).ok());
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(all), 300).ok());
  for (const auto& chunk : all) EXPECT_TRUE(store_->ingest.AppendChunk(chunk).ok());
  EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(all), 400).ok());
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->flags, 0u);
}

TEST_P(IngestTest, WhatIsCommittedOfAContradictedAttemptCanBeAccepted) {
  Uuid attempt = world_.OpenedAttempt();
  auto chunks = world_.Append(attempt, 2);
  EXPECT_FALSE(store_->ingest.AppendChunk(world_.Chunk(attempt, 0, World::HeaderHash(), 9)).ok());
  ASSERT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kQuarantined);
  Status accepted = store_->judging.Rescore(attempt, "rescore", kSystem);
  ASSERT_TRUE(accepted.ok()) << accepted.message();
  AttemptRow row = *store_->attempts.AttemptById(attempt);
  EXPECT_EQ(row.state, AttemptState::kSealed);
  EXPECT_GT(row.sealed_ms, 0);
  EXPECT_EQ(row.flags & kContradicted, kContradicted) << "it stays known";
  EXPECT_EQ(store_->recordings.AttemptSeal(attempt)->last_chunk, chunks[1].hash);
  EXPECT_EQ(AllChunks(store_->recordings, attempt)->size(), 2u);
  EXPECT_EQ(store_->jobs.Jobs("queued")->size(), 1u);
  AuditFilter about;
  about.object = attempt.Text();
  about.action = "attempt.accept";
  EXPECT_EQ(store_->audit.FindAudit(about)->size(), 1u);
  Reopen();
  EXPECT_EQ(AllChunks(store_->recordings, attempt)->at(1), chunks[1].bytes);
  EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 300).ok())
      << "the station's own seal";
}

TEST_P(IngestTest, NothingCommittedIsNothingToAccept) {
  Uuid attempt = world_.OpenedAttempt();
  EXPECT_EQ(store_->judging.Rescore(attempt, "rescore", kSystem).code(), Code::kConflict);
  EXPECT_EQ(store_->attempts.AttemptById(attempt)->state, AttemptState::kRecording);
}

TEST_P(IngestTest, TicketOfSomethingThatIsNotHereNamesIt) {
  auto refused = [&](const std::function<void(AttemptRow&)>& spoil) {
    AttemptRow row;
    row.id = Uuid::New();
    row.person = world_.student;
    row.station = world_.station;
    row.exercise = world_.exercise.id;
    row.profile_content = world_.profile;
    spoil(row);
    return store_->tickets.CreateAttempt(row, AsBytes("ticket"), kSystem);
  };
  Status person = refused([](AttemptRow& row) { row.person = Uuid::New(); });
  EXPECT_EQ(person.code(), Code::kNotFound);
  EXPECT_EQ(person.field(), "person");
  EXPECT_EQ(refused([](AttemptRow& row) { row.station = Uuid::New(); }).field(), "station");
  EXPECT_EQ(refused([](AttemptRow& row) { row.exercise = Uuid::New(); }).field(), "exercise");
  Uuid erased = AddPerson(*store_, "erased", Role::kStudent);
  ASSERT_TRUE(store_->erasures.ErasePerson(erased, false, kSystem).ok());
  Status gone = refused([&](AttemptRow& row) { row.person = erased; });
  EXPECT_EQ(gone.code(), Code::kConflict) << "for good";
  Person again;
  again.id = erased;
  again.login = "erased";
  EXPECT_EQ(store_->people.CreatePerson(again, "none", {}, kSystem).status().code(),
            Code::kConflict);
}

TEST_P(IngestTest, ALongRecordingIsSealedInPartsAndReadFromAnyChunk) {
  const Uuid attempt = world_.OpenedAttempt();
  const auto chunks = world_.Append(attempt, 9);
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  const auto parts = *store_->engine->rows.Read([&](sql::Db& db) { return PartsOf(db, attempt); });
  ASSERT_GE(parts.size(), 2u);
  ASSERT_GT(parts[0].next_chunk, 1u) << "more than one chunk in a part";
  for (uint32_t from = 0; from <= chunks.size(); ++from) {
    const auto recording = *store_->recordings.Open(attempt, from);
    EXPECT_EQ(recording.chunks, chunks.size());
    EXPECT_TRUE(recording.sealed);
    for (uint32_t seq = from; seq < chunks.size(); ++seq) {
      ASSERT_EQ(recording.next()->value(), chunks[seq].bytes) << seq << " from " << from;
    }
    EXPECT_FALSE(recording.next()->has_value());
  }
  ASSERT_TRUE(store_->erasures.ErasePerson(world_.student, false, kSystem).ok());
  for (const TracePart& part : parts) EXPECT_FALSE(store_->blobs.HasBlob(part.content));
}

TEST_P(IngestTest, AReaderGoesOnWhenTheRecordingIsSealedMeanwhile) {
  const Uuid attempt = world_.OpenedAttempt();
  const auto chunks = world_.Append(attempt, 40);
  const auto recording = *store_->recordings.Open(attempt);
  EXPECT_EQ(recording.next()->value(), chunks[0].bytes);
  // Without a lock on the folder the rows go with the seal.
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  for (size_t i = 1; i < chunks.size(); ++i) {
    const auto next = recording.next();
    ASSERT_TRUE(next.ok()) << i << ": " << next.status().message();
    ASSERT_EQ(next->value(), chunks[i].bytes) << i;
  }
  EXPECT_FALSE(recording.next()->has_value());
}

TEST_P(IngestTest, OfAPartThatIsLostTheRecordingIsTakenOnceMore) {
  const Uuid attempt = world_.OpenedAttempt();
  const auto chunks = world_.Append(attempt, 9);
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  const auto parts = *store_->engine->rows.Read([&](sql::Db& db) { return PartsOf(db, attempt); });
  ASSERT_GE(parts.size(), 2u);
  for (const TracePart& part : {parts[0], parts[1]}) {
    ASSERT_TRUE(
        store_->engine->rows
            .Write([&](sql::Db& db) -> Status {
              Query rows(db, "DELETE FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2");
              ENAMEL_RETURN_IF_ERROR(rows.Bind(attempt).Run());
              Query q(db,
                      "UPDATE trace_parts SET content = ?3 WHERE tenant = ?1 AND attempt = ?2 AND "
                      "next_chunk = ?4");
              q.Bind(attempt).Bind(HashSha256(AsBytes("gone")));
              return q.Bind(int64_t{part.next_chunk}).Run();
            })
            .ok());
    ASSERT_FALSE(*store_->recordings.IsWhole(attempt));
    EXPECT_EQ(AllChunks(store_->recordings, attempt).status().code(), Code::kNotFound);
    for (const ChunkPut& chunk : chunks) ASSERT_TRUE(store_->ingest.AppendChunk(chunk).ok());
    ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 900).ok());
    EXPECT_TRUE(*store_->recordings.IsWhole(attempt));
    EXPECT_EQ(AllChunks(store_->recordings, attempt)->size(), chunks.size());
  }
}

TEST_P(IngestTest, ARecordingThatTheStoreHasLostIsTakenOnceMoreAndNothingElseChanges) {
  const Uuid attempt = world_.OpenedAttempt(), other = world_.OpenedAttempt();
  const auto chunks = world_.Append(attempt, 4), others = world_.Append(other, 2);
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(others), 200).ok());
  const AttemptRow before = *store_->attempts.AttemptById(attempt);
  const size_t jobs = store_->jobs.Jobs("queued")->size();
  EXPECT_TRUE(*store_->recordings.IsWhole(attempt));
  EXPECT_EQ(*store_->recordings.NextChunk(attempt), 4u);
  // Lost; another attempt's.
  for (const char* blob :
       {"?4", "(SELECT trace_blob FROM attempts WHERE tenant = ?1 AND id = ?3)"}) {
    ASSERT_TRUE(store_->engine->rows
                    .Write([&](sql::Db& db) -> Status {
                      {
                        Query rows(db,
                                   "DELETE FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2");
                        ENAMEL_RETURN_IF_ERROR(rows.Bind(attempt).Run());
                      }
                      Query q(db, std::string("UPDATE attempts SET trace_blob = ") + blob +
                                      " WHERE tenant = ?1 AND id = ?2 AND ?3 <> ?4");
                      return q.Bind(attempt).Bind(other).Bind(HashSha256(AsBytes("gone"))).Run();
                    })
                    .ok());
    ASSERT_FALSE(*store_->recordings.IsWhole(attempt)) << blob;
    EXPECT_EQ(*store_->recordings.NextChunk(attempt), 0u);
    EXPECT_EQ(store_->ingest.AppendChunk(chunks[1]).field(), "seq") << "in order";
    for (size_t i = 0; i < 3; ++i) ASSERT_TRUE(store_->ingest.AppendChunk(chunks[i]).ok()) << i;
    EXPECT_EQ(*store_->recordings.NextChunk(attempt), 3u);
    EXPECT_EQ(store_->seals.SealAttempt(World::SealOf(chunks), 900).field(), "seq");
    ASSERT_TRUE(store_->ingest.AppendChunk(chunks[3]).ok());
    ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 900).ok());
    EXPECT_TRUE(*store_->recordings.IsWhole(attempt)) << blob;
    EXPECT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 900).ok()) << "sent again";
    EXPECT_EQ(AllChunks(store_->recordings, attempt)->back(), chunks[3].bytes);
  }
  const AttemptRow after = *store_->attempts.AttemptById(attempt);
  EXPECT_EQ(after.state, before.state);
  EXPECT_EQ(after.flags, before.flags);
  EXPECT_EQ(after.sealed_ms, before.sealed_ms);
  EXPECT_EQ(store_->jobs.Jobs("queued")->size(), jobs) << "it is not scored anew";
}

TEST_P(IngestTest, MoreThanARecordingMayHoldIsRefusedAndTheStoreStaysWell) {
  AttemptRow row = world_.AttemptOf(world_.student);
  row.rate_hz = 1000;
  ASSERT_TRUE(store_->tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
  ASSERT_TRUE(store_->tickets.OpenAttempt(row.id, AsBytes("header")).ok());
  const ChunkPut honest = world_.Chunk(row.id, 0, World::HeaderHash());
  ChunkPut gaps = honest;
  gaps.head.gap_ticks = UINT32_MAX;
  const Status refused = store_->ingest.AppendChunk(gaps);
  EXPECT_EQ(refused.code(), Code::kTooLarge) << refused.message();
  EXPECT_EQ(refused.field(), "ticks");
  EXPECT_EQ(store_->attempts.AttemptById(row.id)->chunks, 0u);
  EXPECT_TRUE(store_->health.Health().takes_recordings);
  ASSERT_TRUE(store_->ingest.AppendChunk(honest).ok());

  // An hour ahead of the clock, and not a tick more.
  ChunkPut ahead = world_.Chunk(row.id, 1, honest.hash);
  const auto room = 1000 * (ahead.received_ms - row.ticketed_ms + 3'600'000) / 1000;
  const auto counted = honest.head.count + ahead.head.count;
  ahead.head.gap_ticks = static_cast<uint32_t>(room - counted) + 1;
  EXPECT_EQ(store_->ingest.AppendChunk(ahead).field(), "ticks");
  --ahead.head.gap_ticks;
  EXPECT_TRUE(store_->ingest.AppendChunk(ahead).ok());

  const auto set = [&](const std::string& bytes) {
    return store_->engine->rows.Write([&](sql::Db& db) -> Status {
      Query q(db, "UPDATE attempts SET gap_ticks = 0, trace_bytes = " + bytes +
                      " WHERE tenant = ?1 AND id = ?2");
      return q.Bind(row.id).Run();
    });
  };
  const ChunkPut third = world_.Chunk(row.id, 2, ahead.hash);
  ASSERT_TRUE(set(std::to_string(16 * room)).ok());
  EXPECT_EQ(store_->ingest.AppendChunk(third).field(), "bytes");
  ASSERT_TRUE(set(std::to_string(16 * room - 10'000)).ok());
  EXPECT_TRUE(store_->ingest.AppendChunk(third).ok());
}

TEST_P(IngestTest, DataThatTheDatabaseRefusesIsNoFailureOfTheStore) {
  const auto write = [&](const char* sqlite, const char* postgres) {
    return store_->engine->rows.Write(
        [&](sql::Db& db) -> Status { return db.Exec(store_->shared ? postgres : sqlite); });
  };
  EXPECT_EQ(write("UPDATE server_attempts SET nothing = 1", "SELECT nothing FROM nowhere").code(),
            Code::kInternal);
  EXPECT_TRUE(store_->health.Health().takes_recordings) << "our own fault";
  EXPECT_EQ(write("CREATE TEMP TABLE a (id INTEGER PRIMARY KEY); INSERT INTO a VALUES ('no')",
                  "SELECT 9223372036854775807 + 1")
                .code(),
            Code::kInvalidInput);
  EXPECT_TRUE(store_->health.Health().takes_recordings);
}

TEST_P(IngestTest, ConcurrentAttemptsAllCommit) {
  constexpr int kAttempts = 4, kChunks = 8;
  std::vector<Uuid> attempts;
  for (int i = 0; i < kAttempts; ++i) attempts.push_back(world_.OpenedAttempt());
  std::vector<std::thread> threads;
  for (const Uuid& attempt : attempts) {
    threads.emplace_back([&, attempt] { world_.Append(attempt, kChunks); });
  }
  for (auto& thread : threads) thread.join();
  Reopen();
  for (const Uuid& attempt : attempts)
    EXPECT_EQ(AllChunks(store_->recordings, attempt)->size(), size_t{kChunks});
}

}  // namespace
}  // namespace enamel::server
