#include "server/storage/verify/verify.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "server/results/result_document.h"
#include "server/storage/keys/folder_keyring.h"
#include "tests/server/storage/verified_school.h"

// Every kind of disagreement is found and named; without one there is nothing to find.
namespace enamel::server {
namespace {

using namespace testing;

TEST_F(VerifyTest, WholeDataHasNoFindings) {
  VerifyReport report = Look();
  for (const Finding& finding : report.findings)
    ADD_FAILURE() << finding.kind << ": " << finding.found;
  EXPECT_EQ(report.attempts, 2u);
  EXPECT_EQ(report.sealed, 1u);
  EXPECT_EQ(report.chunks, 5u);
  EXPECT_EQ(report.ticks, 5u * World::kTicksPerChunk);
  EXPECT_EQ(report.keys, 1u);
  EXPECT_EQ(report.unnamed_blobs, 0u);
}

TEST_F(VerifyTest, ChangedBlobIsFound) {
  Sha256 series = school_.store->results.ResultOf(scored_)->series;
  ASSERT_TRUE(WriteFileDurably(Blob(series), AsBytes("other")).ok());
  ExpectOnly("blob", series.Hex());
}

TEST_F(VerifyTest, MissingBlobIsFound) {
  Sha256 deviation = school_.store->results.ResultOf(scored_)->deviation;
  fs::remove(Blob(deviation));
  ExpectOnly("blob", deviation.Hex());
}

TEST_F(VerifyTest, UnnamedBlobIsToldAndNoFault) {
  ASSERT_TRUE(school_.store->blobs.PutBlob(AsBytes("left by a crash")).ok());
  VerifyReport report = Look();
  EXPECT_TRUE(report.findings.empty());
  EXPECT_EQ(report.unnamed_blobs, 1u);
}

TEST_F(VerifyTest, StrayFileAmongBlobsIsToldAndNoFault) {
  ASSERT_TRUE(WriteFileDurably(Data() / "blobs" / "notes.txt", AsBytes("x")).ok());
  VerifyReport report = Look();
  EXPECT_TRUE(report.findings.empty());
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_NE(report.notes[0].find("notes.txt"), std::string::npos);
}

TEST_F(VerifyTest, LostChunkIsFound) {
  Sql("DELETE FROM trace_chunks WHERE attempt = " + Id(open_) + " AND seq = 1");
  ExpectOnly("chain", open_.Text());
}

TEST_F(VerifyTest, ChunkOfAnotherPlaceIsFound) {
  Sql("UPDATE trace_chunks SET bytes = (SELECT bytes FROM trace_chunks WHERE attempt = " +
      Id(open_) + " AND seq = 1) WHERE attempt = " + Id(open_) + " AND seq = 0");
  ExpectOnly("chain", open_.Text());
}

TEST_F(VerifyTest, CountsThatDoNotFitAreFound) {
  const std::pair<const char*, const char*> changes[] = {
      {"ticks = ticks + 1", "ticks = ticks - 1"},
      {"chunks = chunks + 1", "chunks = chunks - 1"},
      {"head_state_hash = head_state_hash + 1", "head_state_hash = head_state_hash - 1"},
      {"trace_bytes = trace_bytes - 1", "trace_bytes = trace_bytes + 1"},
      {"gap_ticks = gap_ticks + 7", "gap_ticks = gap_ticks - 7"}};
  for (const auto& [change, back] : changes) {
    SCOPED_TRACE(change);
    const std::string where = " WHERE id = " + Id(scored_);
    Sql(std::string("UPDATE attempts SET ") + change + where);
    ExpectFound("chain", scored_.Text());
    Sql(std::string("UPDATE attempts SET ") + back + where);
    EXPECT_TRUE(Look().findings.empty());
  }
}

TEST_F(VerifyTest, ScoredAttemptWithoutItsTraceIsFound) {
  Sql("UPDATE attempts SET trace_blob = NULL WHERE id = " + Id(scored_));
  ExpectOnly("seal", scored_.Text());
}

TEST_F(VerifyTest, SignatureOfAnotherStationIsFound) {
  Sql("UPDATE stations SET public_key = zeroblob(32)");
  VerifyReport report = Look();
  EXPECT_EQ(report.findings.size(), 3u) << "one for each attempt, and the station's row";
  EXPECT_EQ(std::ranges::count(report.findings, "signature", &Finding::kind), 2);
}

TEST_F(VerifyTest, TicketOfAnotherServerIsFound) {
  auto other = trace::NewKeyPair();
  ASSERT_TRUE(WriteFileDurably(Data() / "ticket.key", other.secret_key, 0600).ok());
  VerifyReport report = Look();
  EXPECT_EQ(report.findings.size(), 4u) << "two tickets, one result, the audit trail as a whole";
  for (const char* kind : {"ticket", "result", "audit"})
    EXPECT_GE(std::ranges::count(report.findings, kind, &Finding::kind), 1) << kind;
  fs::remove(Data() / "ticket.key");
  EXPECT_TRUE(Look().findings.empty());
  EXPECT_EQ(Look().notes.size(), 1u) << "says that it could not look";
}

TEST_F(VerifyTest, AttemptMovedToAnotherPersonIsFound) {
  Uuid other = AddPerson(*school_.store, "other", Role::kStudent);
  Sql("UPDATE attempts SET person = " + Id(other) + " WHERE id = " + Id(scored_));
  ExpectFound("ticket", scored_.Text());
  ExpectFound("decision", scored_.Text());
}

// What somebody could want to change about an attempt that is scored, one by one. Each is found, by
// its kind, and names the attempt; put back, everything agrees again.
class EditsTest : public VerifyTest {
 protected:
  EditsTest() {
    graded_ = school_.Record(2);
    EXPECT_TRUE(school_.store->judging
                    .FlagAttempt(graded_, kResumed, "the station continued", Actor{{}, "test"}, {})
                    .ok());
    school_.Score(graded_, scored_);
    ExerciseRow other = school_.world.Exercise("other", "v1 of another");
    other_exercise_ = *school_.store->exercises.PublishExercise(other, Uuid{}, kSystem);
    EXPECT_TRUE(Look().findings.empty()) << "before anything is changed";
  }
  void ExpectFound(const std::string& edit, const std::string& kind) {
    SCOPED_TRACE(edit);
    const char* const kTables[] = {"attempts", "attempt_results", "exercises", "trace_chunks"};
    std::string keep;
    for (const std::string table : kTables) {
      keep += "CREATE TABLE kept_" + table + " AS SELECT * FROM " + table + "; ";
    }
    Sql(keep + edit);
    VerifyReport report = Look();
    EXPECT_FALSE(report.findings.empty());
    EXPECT_TRUE(std::ranges::any_of(report.findings, [&](const Finding& finding) {
      return finding.kind == kind && finding.object == graded_.Text();
    }));
    for (const std::string table : kTables) {
      Sql("DELETE FROM " + table + "; INSERT INTO " + table + " SELECT * FROM kept_" + table +
          "; DROP TABLE kept_" + table);
    }
    EXPECT_TRUE(Look().findings.empty()) << "put back";
  }
  std::string Of(const char* table) const {
    return std::string(" WHERE ") + (std::string(table) == "attempts" ? "id" : "attempt") + " = " +
           Id(graded_);
  }
  static std::string Hex(ByteView bytes) { return "x'" + ToHex(bytes) + "'"; }
  Bytes Document() const { return school_.store->results.ResultOf(graded_)->document; }

  Uuid graded_;
  ExerciseRow other_exercise_;
};

TEST_F(EditsTest, OfTheAttemptsRowAreFound) {
  const std::string at = Of("attempts");
  const std::pair<std::string, std::string> edits[] = {
      {"score = 99.5", "result"},
      {"score = 80.0000000001", "result"},
      {"score = NULL", "result"},
      {"critical_fail = 1", "result"},
      {"score_json = series", "result"},
      {"final_volume = deviation", "result"},
      {"deviation = series", "result"},
      {"series = deviation", "result"},
      {"reference = NULL", "result"},
      {"reference = " + Id(graded_), "result"},
      {"exercise = " + Id(other_exercise_.id), "result"},
      {"profile_content = " + Hex(other_exercise_.content.view()), "result"},
      {"flags = 0", "result"},
      {"head_hash = zeroblob(32)", "chain"},
      {"hand_kind = 1", "hand"},
      {"hand_device = 'omega.3'", "hand"},
      {"person = " + Id(AddPerson(*school_.store, "other", Role::kStudent)), "ticket"},
  };
  for (const auto& [edit, kind] : edits) ExpectFound("UPDATE attempts SET " + edit + at, kind);
}

TEST_F(EditsTest, OfTheRunAreFound) {
  const std::string at = Of("attempt_results");
  for (const std::string edit :
       {"score = 99.5", "critical_fail = 1", "score_json = zeroblob(32)", "scored_ms = 7",
        "reference = NULL", "document = x''", "document = zeroblob(616)", "document = x'00'"}) {
    ExpectFound("UPDATE attempt_results SET " + edit + at, "result");
  }
  ExpectFound("DELETE FROM attempt_results" + at, "result");
  ExpectFound(
      "UPDATE attempt_results SET document = (SELECT o.document FROM attempt_results o "
      "WHERE o.attempt = " +
          Id(scored_) + ")" + at,
      "result");
}

TEST_F(EditsTest, OfRowAndRunTogetherAreFound) {
  ExpectFound("UPDATE attempts SET score = 99.5" + Of("attempts") +
                  "; UPDATE attempt_results SET score = 99.5" + Of("attempt_results"),
              "result");
  ExpectFound("UPDATE attempts SET score = 99.5" + Of("attempts") +
                  "; UPDATE attempt_results SET score = 99.5, document = x''" +
                  Of("attempt_results"),
              "result");
}

TEST_F(EditsTest, SignedByAnybodyElseIsFound) {
  ResultDocument document = *DecodeResult(Document());
  document.points = 99.5;
  ExpectFound("UPDATE attempt_results SET document = " + Hex(EncodeResult(document)) +
                  Of("attempt_results"),
              "result");
  SignResult(document, trace::NewKeyPair());
  ExpectFound("UPDATE attempts SET score = 99.5" + Of("attempts") +
                  "; UPDATE attempt_results SET score = 99.5, document = " +
                  Hex(EncodeResult(document)) + Of("attempt_results"),
              "result");
}

TEST_F(EditsTest, OfWhatItWasMadeFromAreFound) {
  ExpectFound("UPDATE exercises SET content = (SELECT o.content FROM exercises o WHERE o.id = " +
                  Id(other_exercise_.id) + ") WHERE id = " + Id(school_.world.exercise.id),
              "result");
  ExpectFound("UPDATE attempts SET head_hash = zeroblob(32) WHERE id = " + Id(scored_), "result");
  ExpectFound("UPDATE attempts SET final_volume = deviation WHERE id = " + Id(scored_), "result");
}

TEST_F(EditsTest, AnEarlierRunPutInThePlaceOfTheNewestIsFound) {
  school_.ScoreAgain(graded_, 60);
  EXPECT_TRUE(Look().findings.empty());
  EXPECT_EQ(Look().results, 3u);
  ExpectFound("DELETE FROM attempt_results" + Of("attempt_results") +
                  " AND run = 2; UPDATE attempts SET score = 80, score_json = (SELECT score_json "
                  "FROM attempt_results" +
                  Of("attempt_results") + ")" + Of("attempts"),
              "result");
}

// Each chunk, and in each some ticks: byte by byte across it.
TEST_F(EditsTest, OfARecordingsBytesAreFound) {
  for (int seq : {0, 1}) {
    const std::string where = " WHERE attempt = " + Id(open_) + " AND seq = " + std::to_string(seq);
    Bytes kept = AllChunks(school_.store->recordings, open_)->at(static_cast<size_t>(seq));
    for (size_t i = 0; i < kept.size(); i += 7) {
      Bytes changed = kept;
      changed[i] ^= 1;
      Sql("UPDATE trace_chunks SET bytes = " + Hex(changed) + where);
      EXPECT_FALSE(Look().findings.empty()) << "byte " << i << " of chunk " << seq;
    }
    // A tick moved by one count and the chunk signed again, by a key that is not the station's.
    trace::Chunk chunk = *trace::DecodeChunk(kept);
    for (size_t tick = 0; tick < chunk.ticks.size(); tick += 50) {
      trace::Chunk moved = chunk;
      ++moved.ticks[tick].input.counts[1];
      Bytes forged = trace::EncodeChunk(moved.head, moved.ticks, trace::NewKeyPair().secret_key);
      Sql("UPDATE trace_chunks SET bytes = " + Hex(forged) + where);
      EXPECT_FALSE(Look().findings.empty()) << "tick " << tick << " of chunk " << seq;
    }
    Sql("UPDATE trace_chunks SET bytes = " + Hex(kept) + where);
    EXPECT_TRUE(Look().findings.empty());
  }
}

TEST_F(VerifyTest, ResultWithoutADocumentIsFound) {
  const Uuid attempt = school_.Record(1);
  school_.Seal(attempt);
  AttemptResult result;
  result.score = 70;
  result.score_json = PutText(*school_.store, "score that nobody signed");
  ASSERT_TRUE(school_.store->results.FinishAttempt(attempt, result, {}).ok());
  ExpectOnly("result", attempt.Text());
}

TEST_F(VerifyTest, APlaybackOfAnotherAttemptIsFound) {
  std::array<Uuid, 2> attempts;
  for (Uuid& attempt : attempts) {
    attempt = school_.Record(1);
    school_.Score(attempt, scored_);
    const Sha256 made =
        *school_.store->blobs.PutAttemptBlob(attempt, AsBytes("what it looked like"));
    ASSERT_TRUE(school_.store->timelines.PutTimeline(attempt, made).ok());
  }
  EXPECT_TRUE(Look().findings.empty());
  Sql("UPDATE timelines SET content = (SELECT content FROM timelines WHERE attempt = x'" +
      ToHex(attempts[0].view()) + "') WHERE attempt = x'" + ToHex(attempts[1].view()) + "'");
  const VerifyReport report = Look();
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].kind, "timeline");
  EXPECT_EQ(report.findings[0].object, attempts[1].Text());
}

TEST_F(VerifyTest, ReferenceErasedWithItsPersonIsNoFault) {
  Uuid other = AddPerson(*school_.store, "other", Role::kStudent);
  Uuid compared = school_.RecordOf(other, 1);
  school_.Score(compared, scored_);
  ASSERT_TRUE(
      school_.store->erasures.ErasePerson(school_.world.student, true, Actor{{}, "test"}).ok());
  VerifyReport report = Look();
  for (const Finding& finding : report.findings)
    ADD_FAILURE() << finding.kind << ": " << finding.expected << " / " << finding.found;
  EXPECT_EQ(report.results, 1u);
}

TEST_F(VerifyTest, ResultWhoseRecordingARuleRemovedIsNoFault) {
  ASSERT_TRUE(school_.store->judging.ReleaseAttempt(scored_, Actor{{}, "test"}, {}).ok());
  ASSERT_TRUE(school_.store->retention.SetRetention({"recordings", 1}, Actor{{}, "test"}).ok());
  ASSERT_TRUE(
      school_.store->retention.ApplyRetention(int64_t{10} * 86'400'000, false, Actor{{}, "test"})
          .ok());
  ASSERT_NE(school_.store->attempts.AttemptById(scored_)->expired_ms, 0);
  VerifyReport report = Look();
  for (const Finding& finding : report.findings)
    ADD_FAILURE() << finding.kind << ": " << finding.expected << " / " << finding.found;
}

TEST_F(VerifyTest, LostKeyIsFound) {
  fs::remove(Data() / "keyring" / (school_.world.student.Text() + ".key"));
  VerifyReport report = Look();
  ASSERT_FALSE(report.findings.empty());
  for (const Finding& finding : report.findings) EXPECT_EQ(finding.kind, "key");
}

TEST_F(VerifyTest, UnfinishedErasureIsFoundAndFinishedByTheNextStart) {
  FolderKeyring ring(Data() / "keyring", SystemDisk());
  ASSERT_TRUE(ring.Destroy(school_.world.student, 5).ok());
  VerifyReport report = Look();
  EXPECT_TRUE(
      std::ranges::any_of(report.findings, [](const Finding& f) { return f.kind == "erasure"; }));
  school_.store.reset();
  StoreOptions server;
  server.folder = Data();
  server.hold_lock = true;
  ASSERT_TRUE(OpenSqliteStore(server).ok());
  EXPECT_TRUE(Look().findings.empty());
  EXPECT_EQ(Look().people, 0u);
}

TEST_F(VerifyTest, APersonWhoIsErasedMeanwhileIsNoDamage) {
  bool erased = false;
  VerifyOptions options{Data(), {}, [&](const std::string& what, uint64_t done, uint64_t) {
                          if (erased || what != "database" || done == 0) return;
                          erased = true;
                          auto gone = school_.store->erasures.ErasePerson(school_.world.student,
                                                                          true, Actor{{}, "test"});
                          EXPECT_TRUE(gone.ok()) << gone.status().message();
                        }};
  auto report = Verify(options);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(erased);
  for (const Finding& finding : report->findings)
    ADD_FAILURE() << finding.kind << ": " << finding.found;
  EXPECT_EQ(report->erased, 1u);
  EXPECT_EQ(report->attempts, 0u);
}

TEST_F(VerifyTest, RowThatNamesNothingIsFound) {
  Sql("PRAGMA foreign_keys = 0; DELETE FROM stations");
  VerifyReport report = Look();
  EXPECT_TRUE(
      std::ranges::any_of(report.findings, [](const Finding& f) { return f.kind == "database"; }));
}

TEST_F(VerifyTest, CorruptPageIsFoundNotFollowed) {
  school_.store.reset();
  Bytes content = *ReadFile(Data() / "enamel.db");
  for (size_t page = 4; page * 4096 + 200 < content.size(); page += 5) {
    std::fill_n(content.begin() + static_cast<std::ptrdiff_t>(page * 4096), 200, 0xff);
  }
  ASSERT_TRUE(WriteFileDurably(Data() / "enamel.db", content).ok());
  VerifyReport report = Look();
  EXPECT_TRUE(
      std::ranges::any_of(report.findings, [](const Finding& f) { return f.kind == "database"; }));
}

TEST_F(VerifyTest, FolderWithoutADatabaseIsRefused) {
  EXPECT_EQ(Verify({folder_.path() / "nowhere", {}, {}}).status().code(), Code::kNotFound);
}

}  // namespace
}  // namespace enamel::server
