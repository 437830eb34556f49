#include "station/spool/spool.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "common/base/file.h"
#include "station/spool/recorder.h"
#include "station/spool/salvage.h"
#include "station/spool/spool_file.h"
#include "station/spool/verify.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

class SpoolTest : public testing::Test {
 protected:
  SpoolTest() {
    keys_ = trace::NewKeyPair();
    header_.ticket.attempt = Uuid::New();
    header_.params.kc_mn_per_mm = 2500;
    header_.params.resolution_nm = {10'000, 10'000, 10'000};
    header_.params.peak_force_mn = 7900;
    header_.params.bur_radius_nm = 500'000;
    header_.station_software = "test";
    header_.hand.kind = HandKind::kProgram;
  }

  std::unique_ptr<Spool> Open() {
    auto spool = Spool::Open(folder_);
    EXPECT_TRUE(spool.ok()) << spool.status().message();
    return spool.ok() ? std::move(*spool) : nullptr;
  }
  Uuid id() const { return header_.ticket.attempt; }
  Sha256 header_hash() const { return HashSha256(trace::EncodeHeader(header_)); }

  // Records `ticks` invented ticks through a Recorder; sealed when `finish`.
  void Record(Spool& spool, int ticks, bool finish) {
    SampleRing ring(static_cast<size_t>(ticks));
    Recorder recorder(spool, ring, id(), header_hash(), keys_.secret_key);
    for (int i = 0; i < ticks; ++i) {
      Sample s;
      s.tick.input.counts = {i, -i, i / 3};
      s.state_hash = static_cast<uint64_t>(i) * 77;
      ASSERT_TRUE(ring.Push(s));
    }
    if (finish) {
      auto seal = recorder.Finish();
      ASSERT_TRUE(seal.ok()) << seal.status().message();
      EXPECT_EQ(seal->ticks, static_cast<uint64_t>(ticks));
      return;
    }
    while (true) {
      auto moved = recorder.Pump();
      ASSERT_TRUE(moved.ok()) << moved.status().message();
      if (!*moved) break;
    }
  }

  // Changes the file without the program's knowledge.
  void Tamper(const std::string& sql) {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open((folder_ / "spool.sqlite").c_str(), &db), SQLITE_OK);
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    sqlite3_close(db);
  }
  // Every row of a table, each column with its name, in the order of their keys.
  static std::vector<std::string> AllOf(const fs::path& file, const std::string& table) {
    sqlite3* db = nullptr;
    EXPECT_EQ(sqlite3_open(file.c_str(), &db), SQLITE_OK);
    std::vector<std::string> out;
    const std::string sql = "SELECT * FROM " + table + " ORDER BY 1, 2";
    sqlite3_stmt* rows = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(db, sql.c_str(), -1, &rows, nullptr), SQLITE_OK);
    while (sqlite3_step(rows) == SQLITE_ROW) {
      for (int i = 0; i < sqlite3_column_count(rows); ++i) {
        const auto* value = static_cast<const char*>(sqlite3_column_blob(rows, i));
        out.push_back(std::string(sqlite3_column_name(rows, i)) + " = " +
                      (value ? std::string(value, sqlite3_column_bytes(rows, i)) : "NULL"));
      }
    }
    sqlite3_finalize(rows);
    sqlite3_close(db);
    return out;
  }
  // A spool with one sealed attempt of 1100 ticks.
  void MakeOne() {
    auto spool = Open();
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 1100, true);
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  trace::KeyPair keys_;
  trace::Header header_;
};

TEST_F(SpoolTest, RecordingComesBackAsItWentIn) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "class-1", "phantom_desktop").ok());
  Record(*spool, 1234, true);
  auto file = spool->Export(id());
  ASSERT_TRUE(file.ok());
  ASSERT_EQ(file->chunks.size(), 3u);
  int tick = 0;
  for (const Bytes& bytes : file->chunks) {
    auto chunk = trace::DecodeChunk(bytes);
    ASSERT_TRUE(chunk.ok());
    for (const trace::Tick& t : chunk->ticks) EXPECT_EQ(t.input.counts[0], tick++);
  }
  EXPECT_EQ(tick, 1234);
  ASSERT_TRUE(file->seal.has_value());
  EXPECT_EQ(file->seal->state_hash, 1233u * 77);
}

TEST_F(SpoolTest, VerifyAcceptsWhatWasRecorded) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  Record(*spool, 1100, true);
  auto verdicts = VerifyRecordings(*spool, keys_.public_key);
  ASSERT_TRUE(verdicts.ok());
  ASSERT_EQ(verdicts->size(), 1u);
  EXPECT_TRUE((*verdicts)[0].status.ok()) << (*verdicts)[0].status.message();
  EXPECT_FALSE((*VerifyRecordings(*spool, trace::NewKeyPair().public_key))[0].status.ok());
}

TEST_F(SpoolTest, VerifyFindsAChunkThatWasChanged) {
  {
    auto spool = Open();
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 1100, true);
  }
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "spool.sqlite").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, "DELETE FROM chunks WHERE seq = 1", nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(db);
  EXPECT_EQ((*VerifyRecordings(*Open(), keys_.public_key))[0].status.code(), Code::kConflict);
}

// Cases that must not pass as whole.
TEST_F(SpoolTest, VerifyComparesWhatIsThereWithWhatIsCounted) {
  for (const char* sql :
       {"DELETE FROM chunks WHERE seq = 2; UPDATE attempts SET seal_chunks = NULL",
        "DELETE FROM chunks; UPDATE attempts SET seal_chunks = NULL",
        "UPDATE attempts SET ticks = 5", "UPDATE attempts SET gap_ticks = 77",
        "UPDATE attempts SET committed = chunks + 1", "UPDATE attempts SET bytes = 1",
        "UPDATE attempts SET chunks = 4", "UPDATE attempts SET header_sha256 = zeroblob(32)"}) {
    MakeOne();
    ASSERT_TRUE((*VerifyRecordings(*Open(), keys_.public_key))[0].status.ok());
    Tamper(sql);
    EXPECT_EQ((*VerifyRecordings(*Open(), keys_.public_key))[0].status.code(), Code::kConflict)
        << sql;
    for (const char* end : {"", "-wal", "-shm"}) {
      fs::remove((folder_ / "spool.sqlite").string() + end);
    }
  }
}

TEST_F(SpoolTest, EmptyFileIsNotANewSpool) {
  MakeOne();
  for (const char* end : {"-wal", "-shm"}) fs::remove((folder_ / "spool.sqlite").string() + end);
  fs::resize_file(folder_ / "spool.sqlite", 0);
  auto opened = Spool::Open(folder_);
  ASSERT_EQ(opened.status().code(), Code::kStorage);
  EXPECT_NE(opened.status().message().find("0 bytes"), std::string::npos);
  EXPECT_EQ(opened.status().field(), kLostSpool) << "nothing in it can be salvaged";
  EXPECT_EQ(Spool::OpenToRead(folder_).status().code(), Code::kStorage);
  EXPECT_EQ(fs::file_size(folder_ / "spool.sqlite"), 0u);
}

// SQLite would discard the log, and with it the last recordings.
TEST_F(SpoolTest, LogWithoutItsFileIsNotThrownAway) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  fs::copy_file(folder_ / "spool.sqlite-wal", folder_ / "saved");
  spool.reset();
  fs::remove(folder_ / "spool.sqlite");
  fs::rename(folder_ / "saved", folder_ / "spool.sqlite-wal");
  EXPECT_EQ(Spool::Open(folder_).status().code(), Code::kStorage);
  EXPECT_GT(fs::file_size(folder_ / "spool.sqlite-wal"), 0u);
}

TEST_F(SpoolTest, ReadingCreatesNothing) {
  auto opened = Spool::OpenToRead(folder_ / "mistyped");
  ASSERT_EQ(opened.status().code(), Code::kNotFound);
  EXPECT_NE(opened.status().message().find("--data"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "mistyped"));
}

TEST_F(SpoolTest, ReadingSeesWhatARecordingProcessHasWrittenAndMayNotWrite) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  Record(*spool, 1100, false);
  auto reader = Spool::OpenToRead(folder_);
  ASSERT_TRUE(reader.ok()) << reader.status().message();
  EXPECT_EQ((*reader)->Get(id())->chunks, 2u);
  EXPECT_TRUE((*VerifyRecordings(**reader, keys_.public_key))[0].status.ok());
  EXPECT_EQ((*reader)->MarkRefused(id(), "no").code(), Code::kStorage);
  Record(*spool, 1600, false);
  EXPECT_EQ((*reader)->Get(id())->chunks, 3u);
}

// As in a folder that may not be written: there can be no shared memory beside the file.
TEST_F(SpoolTest, WithoutTheRightToWriteBesideItItIsReadInACopyWithItsLog) {
  {
    auto spool = Open();
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 1100, true);
    fs::create_directories(folder_ / "ro");
    for (const char* end : {"", "-wal"}) {
      fs::copy_file((folder_ / "spool.sqlite").string() + end,
                    (folder_ / "ro" / "spool.sqlite").string() + end);
    }
  }
  fs::create_directories(folder_ / "ro" / "spool.sqlite-shm");
  auto reader = Spool::OpenToRead(folder_ / "ro");
  ASSERT_TRUE(reader.ok()) << reader.status().message();
  EXPECT_EQ((*reader)->Export(id())->chunks.size(), 3u);
  EXPECT_TRUE((*VerifyRecordings(**reader, keys_.public_key))[0].status.ok());
}

// As a process leaves it that was killed before it had made the tables.
TEST_F(SpoolTest, ASpoolWithoutTablesIsReadWithoutBeingChanged) {
  Tamper("PRAGMA journal_mode = WAL; VACUUM");
  auto reader = Spool::OpenToRead(folder_);
  ASSERT_TRUE(reader.ok()) << reader.status().message();
  EXPECT_TRUE((*reader)->List()->empty());
  EXPECT_TRUE(AllOf(folder_ / "spool.sqlite", "sqlite_schema").empty());
}

// Half of the file is destroyed: the affected attempt is named, and the other is whole.
TEST_F(SpoolTest, VerifyOfADamagedSpoolNamesTheAttemptsThatAreHit) {
  MakeOne();
  trace::Header first = header_;
  header_.ticket.attempt = Uuid::New();
  {
    auto spool = Open();
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 50'000, true);
  }
  Tamper("PRAGMA wal_checkpoint(TRUNCATE)");
  fs::resize_file(folder_ / "spool.sqlite", fs::file_size(folder_ / "spool.sqlite") - 9'000);
  auto reader = Spool::OpenToRead(folder_);
  ASSERT_TRUE(reader.ok()) << reader.status().message();
  Status pages;
  auto verdicts = VerifyRecordings(**reader, keys_.public_key, &pages);
  ASSERT_TRUE(verdicts.ok()) << verdicts.status().message();
  EXPECT_EQ(pages.code(), Code::kStorage);
  ASSERT_EQ(verdicts->size(), 2u);
  for (const SpoolVerdict& v : *verdicts) {
    EXPECT_EQ(v.status.ok(), v.attempt.id == first.ticket.attempt) << v.status.message();
  }
}

// For any damage: saved data is whole as far as it goes, and the result says how far for each
// attempt.
TEST_F(SpoolTest, SalvageSavesWhatCanBeReadAndSaysWhatCouldNot) {
  MakeOne();
  const Uuid small = id();
  header_.ticket.attempt = Uuid::New();
  {
    auto spool = Open();
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 100'000, true);
  }
  Tamper("PRAGMA wal_checkpoint(TRUNCATE)");
  const fs::path file = folder_ / "spool.sqlite", kept = folder_ / "kept";
  fs::copy_file(file, kept);
  auto overwrite = [&](uint64_t from, size_t bytes) {
    std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp(static_cast<std::streamoff>(from));
    const std::string noise(bytes, '\x5a');
    out.write(noise.data(), static_cast<std::streamsize>(bytes));
  };
  const uint64_t size = fs::file_size(kept);
  int round = 0;
  for (const std::function<void()>& damage : std::vector<std::function<void()>>{
           [&] { fs::resize_file(file, size - 9'000); }, [&] { fs::resize_file(file, size / 2); },
           [&] { overwrite(20, 40); }, [&] { overwrite(0, 4096); },
           [&] { overwrite(size / 2, 300); }}) {
    fs::copy_file(kept, file, fs::copy_options::overwrite_existing);
    for (const char* end : {"-wal", "-shm"}) fs::remove(file.string() + end);
    damage();
    const fs::path to = folder_ / ("saved" + std::to_string(round++));
    auto saved = SalvageSpool(folder_, to);
    ASSERT_TRUE(saved.ok()) << round << ": " << saved.status().message();
    ASSERT_EQ(saved->attempts.size(), 2u) << round;
    auto verdicts = VerifyRecordings(**Spool::Open(to), keys_.public_key);
    ASSERT_TRUE(verdicts.ok());
    for (const SpoolVerdict& v : *verdicts) EXPECT_TRUE(v.status.ok()) << v.status.message();
    for (const SalvagedAttempt& a : saved->attempts) {
      const bool whole = a.id == small || round == 3 || round == 4;
      EXPECT_EQ(a.problem.ok(), whole) << round << ": " << a.problem.message();
      EXPECT_EQ(a.sealed, whole) << round;
      EXPECT_EQ(a.chunks == a.expected, whole) << round;
      EXPECT_GT(a.chunks, a.id == small ? 2u : 5u) << round;
    }
    EXPECT_EQ(SalvageSpool(folder_, to).status().code(), Code::kConflict);
  }
}

// Without damage nothing may be missing, including additions of a later version to a table.
TEST_F(SpoolTest, SalvageTakesEveryColumnOver) {
  MakeOne();
  {
    auto spool = Open();
    ASSERT_TRUE(spool->SetCommittedBelow(id(), 2).ok());
    ASSERT_TRUE(spool->loop_facts().Put(id(), {1, 2000, "{}"}).ok());
    LockedTicket ticket;
    ticket.attempt = Uuid::New();
    ticket.person = "Ada";
    ticket.locked = Bytes{1, 2, 3};
    ASSERT_TRUE(spool->tickets().Put(ticket).ok());
  }
  Tamper(
      "UPDATE attempts SET created_unix_ms = 1, committed_unix_ms = 2, resumed = 3, boot_id = 'b',"
      " boot_ms = 4, refused = 'no', refused_unix_ms = 5, waits_because = 'away',"
      " waits_since_unix_ms = 6, tried_unix_ms = 7, facts = x'c23e0178', sign_off = 1, outline = 1;"
      "UPDATE chunks SET spooled_unix_ms = 1000 + seq;"
      "UPDATE tickets SET wrong_pins = 3, wait_unix_ms = 8, outline = 1");
  ASSERT_TRUE(SalvageSpool(folder_, folder_ / "saved").ok());
  for (const char* table : {"attempts", "chunks", "tickets", "loop_facts"}) {
    const auto before = AllOf(folder_ / "spool.sqlite", table);
    ASSERT_FALSE(before.empty()) << table;
    EXPECT_EQ(AllOf(folder_ / "saved" / "spool.sqlite", table), before);
  }
}

// It would replace the spool that had recordings.
TEST_F(SpoolTest, SalvageOfWhatHasNothingLeftMakesNoSpool) {
  const fs::path file = folder_ / "spool.sqlite", to = folder_ / "saved";
  for (const std::string& content : {std::string(), std::string(40'960, '\x5a')}) {
    std::ofstream(file, std::ios::binary) << content;
    Status refused = SalvageSpool(folder_, to).status();
    EXPECT_EQ(refused.code(), Code::kStorage);
    EXPECT_NE(refused.message().find("(" + std::to_string(content.size()) + " bytes)"),
              std::string::npos)
        << refused.message();
    EXPECT_NE(refused.message().find("put a copy of it back"), std::string::npos);
    EXPECT_FALSE(fs::exists(to / "spool.sqlite"));
    EXPECT_FALSE(fs::exists(to / "spool.sqlite-wal"));
    EXPECT_EQ(fs::file_size(file), content.size());
  }
}

// The clock was set an hour back since the last chunk, which was 5 s ago.
TEST_F(SpoolTest, ClockThatWasSetBackMakesASilenceNoShorter) {
  MakeOne();
  auto before = Open()->SilenceOf(id());
  ASSERT_TRUE(before.ok());
  EXPECT_FALSE(before->clock_stepped);
  Tamper(
      "UPDATE chunks SET spooled_unix_ms = spooled_unix_ms + 3600000;"
      "UPDATE attempts SET boot_ms = boot_ms - 5000");
  auto silence = Open()->SilenceOf(id());
  ASSERT_TRUE(silence.ok());
  EXPECT_GE(silence->ms, 5'000 + before->ms);
  EXPECT_LT(silence->ms, 1'800'000);
  EXPECT_TRUE(silence->clock_stepped);
  // After a restart of the machine only the clock is left.
  Tamper("UPDATE attempts SET boot_id = 'another'");
  EXPECT_EQ(Open()->SilenceOf(id())->ms, 0);
  EXPECT_TRUE(Open()->SilenceOf(id())->clock_stepped);
}

TEST_F(SpoolTest, WritingTheSameTwiceIsNoError) {
  auto spool = Open();
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 600, true);
  }
  EXPECT_EQ(spool->Get(id())->chunks, 2u);
}

TEST_F(SpoolTest, AnotherChunkUnderTheSameNumberIsRefusedAndTheFirstKept) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  trace::ChunkHead head;
  head.attempt = id();
  head.previous = header_hash();
  std::vector<trace::Tick> ticks(3);
  Bytes first = trace::EncodeChunk(head, ticks, keys_.secret_key);
  ticks[1].input.counts[0] = 9;
  Bytes second = trace::EncodeChunk(head, ticks, keys_.secret_key);
  ASSERT_TRUE(spool->PutChunk(id(), first).ok());
  EXPECT_EQ(spool->PutChunk(id(), second).code(), Code::kConflict);
  EXPECT_EQ((*spool->ChunksFrom(id(), 0, 10))[0].bytes, first);
}

TEST_F(SpoolTest, ReopeningContinuesWhereItWas) {
  {
    auto spool = Open();
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 1000, false);
    ASSERT_TRUE(spool->MarkCommitted(id(), 0).ok());
  }
  auto spool = Open();
  auto attempt = spool->Get(id());
  EXPECT_EQ(attempt->chunks, 2u);
  EXPECT_EQ(attempt->committed, 1u);
  EXPECT_FALSE(attempt->seal.has_value());
}

TEST_F(SpoolTest, WhatWasPutSurvivesKillNine) {
  pid_t child = ::fork();
  if (child == 0) {
    auto spool = Spool::Open(folder_);
    bool ok = spool.ok() && (*spool)->BeginAttempt(header_, "e", "p").ok();
    SampleRing ring(2000);
    Recorder recorder(**spool, ring, id(), header_hash(), keys_.secret_key);
    for (int i = 0; i < 1500; ++i) ring.Push(Sample{});
    for (int i = 0; i < 3; ++i) ok = ok && recorder.Pump().ok();
    if (!ok) ::_exit(1);
    ::kill(::getpid(), SIGKILL);
  }
  int state = 0;
  ASSERT_EQ(::waitpid(child, &state, 0), child);
  ASSERT_TRUE(WIFSIGNALED(state));
  auto spool = Open();
  EXPECT_EQ(spool->Get(id())->chunks, 3u);
  EXPECT_TRUE((*VerifyRecordings(*spool, keys_.public_key))[0].status.ok());
}

TEST_F(SpoolTest, ServerThatForgotMakesChunksWaitAgain) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  Record(*spool, 2000, true);
  ASSERT_TRUE(spool->SetCommittedBelow(id(), 4).ok());
  EXPECT_EQ(spool->Get(id())->committed, 4u);
  ASSERT_TRUE(spool->SetCommittedBelow(id(), 1).ok());
  EXPECT_EQ(spool->Get(id())->committed, 1u);
}

TEST_F(SpoolTest, OnlyWhatTheServerHadForAWeekIsForgotten) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  Record(*spool, 600, true);
  auto later = std::chrono::system_clock::now() + std::chrono::hours(24 * 8);
  EXPECT_EQ(spool->Prune({}, later)->attempts, 0);
  ASSERT_TRUE(spool->SetCommittedBelow(id(), 2).ok());
  EXPECT_EQ(spool->Prune({}, later)->attempts, 0);
  ASSERT_TRUE(spool->MarkSealedAtServer(id()).ok());
  EXPECT_EQ(spool->Prune({})->attempts, 0);
  EXPECT_EQ(spool->Prune({}, later)->attempts, 1);
  EXPECT_EQ(spool->Get(id()).status().code(), Code::kNotFound);
}

TEST_F(SpoolTest, FullQuotaForgetsWhatTheServerHasHadLongestAndNothingElse) {
  auto spool = Open();
  std::vector<Uuid> ids;
  for (int i = 0; i < 4; ++i) {
    header_.ticket.attempt = Uuid::New();
    ids.push_back(id());
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 1000, true);
    if (i == 0) continue;  // the server has the later three
    ASSERT_TRUE(spool->SetCommittedBelow(id(), 2).ok());
    ASSERT_TRUE(spool->MarkSealedAtServer(id()).ok());
    ::usleep(2'000);  // so that they were committed at different times
  }
  const uint64_t one = spool->Get(ids[0])->bytes;
  Retention retention;
  retention.bytes = 3 * one + one / 2;
  auto pruned = spool->Prune(retention);
  EXPECT_EQ(pruned->attempts, 1);
  EXPECT_EQ(pruned->early, 1);
  EXPECT_FALSE(spool->Get(ids[1]).ok());
  retention.bytes = 1;
  EXPECT_EQ(spool->Prune(retention)->attempts, 2);
  ASSERT_EQ(spool->List()->size(), 1u);
  EXPECT_EQ(spool->Get(ids[0])->chunks, 2u);
}

TEST_F(SpoolTest, WhyItWaitsIsKeptFromTheFirstTryThatFailedToOneThatDidNot) {
  MakeOne();
  const Uuid first = id();
  header_.ticket.attempt = Uuid::New();
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  Record(*spool, 600, true);
  ASSERT_TRUE(spool->MarkCommitted(id(), 1).ok());
  ASSERT_TRUE(spool->MarkSealedAtServer(id()).ok());
  ASSERT_TRUE(spool->MarkAllTried("the server is away").ok());
  auto waits = spool->Get(first);
  EXPECT_EQ(waits->waits_because, "the server is away");
  EXPECT_GT(waits->waits_since_unix_ms, 0);
  EXPECT_EQ(waits->tried_unix_ms, waits->waits_since_unix_ms);
  EXPECT_TRUE(spool->Get(id())->waits_because.empty()) << "the server has all of it";
  Tamper("UPDATE attempts SET waits_since_unix_ms = 1000 WHERE waits_because IS NOT NULL");
  ASSERT_TRUE(spool->MarkTried(first, "its storage is full").ok());
  auto again = spool->Get(first);
  EXPECT_EQ(again->waits_because, "its storage is full");
  EXPECT_EQ(again->waits_since_unix_ms, 1000);
  EXPECT_GE(again->tried_unix_ms, waits->tried_unix_ms);
  ASSERT_TRUE(spool->MarkTried(first, "").ok());
  EXPECT_TRUE(spool->Get(first)->waits_because.empty());
  EXPECT_EQ(spool->Get(first)->waits_since_unix_ms, 0);
  ASSERT_TRUE(spool->MarkTried(first, "away again").ok());
  ASSERT_TRUE(spool->MarkRefused(first, "its person is not known").ok());
  EXPECT_GT(spool->Get(first)->refused_unix_ms, 0);
  EXPECT_TRUE(spool->Get(first)->waits_because.empty());
  ASSERT_TRUE(spool->ClearRefusal(first).ok());
  EXPECT_EQ(spool->Get(first)->refused_unix_ms, 0);
}

TEST_F(SpoolTest, HowLoopsWentIsKeptRunByRunAndGoesWithItsAttempt) {
  MakeOne();
  auto spool = Open();
  ASSERT_TRUE(spool->loop_facts().Put(id(), {1, 2000, "{\"b\":1}"}).ok());
  ASSERT_TRUE(spool->loop_facts().Put(id(), {0, 1000, "{}"}).ok());
  ASSERT_TRUE(spool->loop_facts().Put(id(), {0, 1001, "{\"a\":1}"}).ok());
  EXPECT_EQ(spool->loop_facts().Put(Uuid::New(), {0, 1, "{}"}).code(), Code::kNotFound);
  auto kept = spool->loop_facts().Of(id());
  ASSERT_TRUE(kept.ok());
  ASSERT_EQ(kept->size(), 2u);
  EXPECT_EQ((*kept)[0].json, "{\"a\":1}");
  EXPECT_EQ((*kept)[0].ended_unix_ms, 1001);
  EXPECT_EQ((*kept)[1].run, 1u);
  ASSERT_TRUE(SalvageSpool(folder_, folder_ / "saved").ok());
  EXPECT_EQ((*Spool::Open(folder_ / "saved"))->loop_facts().Of(id())->size(), 2u);
  ASSERT_TRUE(spool->MarkCommitted(id(), 2).ok());
  ASSERT_TRUE(spool->MarkSealedAtServer(id()).ok());
  ASSERT_EQ(spool->Prune({std::chrono::hours(0), 1})->attempts, 1);
  EXPECT_TRUE(spool->loop_facts().Of(id())->empty());
}

TEST_F(SpoolTest, SeveralProcessesMayOpenASpoolThatIsNotThereYetAtOnce) {
  constexpr int kRounds = 20, kProcesses = 6;
  for (int round = 0; round < kRounds; ++round) {
    const fs::path folder = folder_ / std::to_string(round);
    int gate[2];
    ASSERT_EQ(::pipe(gate), 0);
    std::vector<pid_t> children;
    for (int i = 0; i < kProcesses; ++i) {
      children.push_back(::fork());
      if (children.back() != 0) continue;
      ::close(gate[1]);
      char go = 0;
      (void)!::read(gate[0], &go, 1);  // until all are there and the gate is closed
      auto spool = Spool::Open(folder);
      if (!spool.ok()) std::fprintf(stderr, "%s\n", spool.status().message().c_str());
      ::_exit(spool.ok() && (*spool)->List().ok() ? 0 : 1);
    }
    ::close(gate[0]);
    ::close(gate[1]);
    for (pid_t child : children) {
      int state = 0;
      ASSERT_EQ(::waitpid(child, &state, 0), child);
      EXPECT_EQ(state, 0) << round;
    }
  }
}

TEST_F(SpoolTest, OneProcessRecordsAtATime) {
  auto spool = Open();
  {
    auto lock = spool->LockForRecording();
    ASSERT_TRUE(lock.ok());
    EXPECT_EQ(spool->LockForRecording().status().code(), Code::kConflict);
  }
  EXPECT_TRUE(spool->LockForRecording().ok());
}

TEST_F(SpoolTest, AttemptThatWasCutOffIsClosedAsFarAsItGoes) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  EXPECT_EQ(spool->CloseAttempt(id()).status().code(), Code::kInvalidInput);
  Record(*spool, 1700, false);  // 200 of them never became a chunk
  auto seal = spool->CloseAttempt(id());
  ASSERT_TRUE(seal.ok());
  EXPECT_EQ(seal->ticks, 1500u);
  EXPECT_EQ(seal->state_hash, 1499u * 77);
  EXPECT_TRUE((*VerifyRecordings(*spool, keys_.public_key))[0].status.ok());
  EXPECT_EQ(*spool->CloseAttempt(id()), *seal);
  EXPECT_EQ(spool->MarkResumed(id()).code(), Code::kConflict);
}

TEST_F(SpoolTest, RecorderGoesOnAfterTheChunksThatAreThere) {
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
  Record(*spool, 1000, false);
  auto last = trace::DecodeChunkHead((*spool->ChunksFrom(id(), 1, 1))[0].bytes);
  ASSERT_TRUE(last.ok());
  ASSERT_TRUE(spool->MarkResumed(id()).ok());
  SampleRing ring(1000);
  Recorder recorder(*spool, ring, id(), trace::ChainState{last->hash, 2, 1000, 999u * 77},
                    keys_.secret_key);
  Sample sample;
  sample.tick.input.gap_ticks = 5'000;
  for (int i = 0; i < 700; ++i) {
    ring.Push(sample);
    sample.tick.input.gap_ticks = 0;
  }
  ASSERT_TRUE(recorder.Finish().ok());
  auto attempt = spool->Get(id());
  EXPECT_EQ(attempt->chunks, 4u);
  EXPECT_EQ(attempt->ticks, 1700u);
  EXPECT_EQ(attempt->gap_ticks, 5'000u);
  EXPECT_EQ(attempt->facts.resumed(), 1u);
  EXPECT_TRUE((*VerifyRecordings(*spool, keys_.public_key))[0].status.ok());
}

// Field 1000 represents a fact of a later station.
TEST_F(SpoolTest, FactsComeBackAsTheyWereSaidAndResumedAsItIsCounted) {
  const auto facts = protocol::DecodeFacts(Bytes{0x08, 0x02, 0xc2, 0x3e, 0x01, 'x'});
  ASSERT_TRUE(facts.ok());
  auto spool = Open();
  ASSERT_TRUE(spool->BeginAttempt(header_, "class-1", "generic", *facts).ok());
  EXPECT_EQ(protocol::EncodeFacts(spool->Get(id())->facts), protocol::EncodeFacts(*facts));
  ASSERT_TRUE(spool->MarkResumed(id()).ok());
  EXPECT_EQ(spool->Get(id())->facts.resumed(), 3u);
}

TEST_F(SpoolTest, RemembersTheTermsOfTheTicket) {
  for (const ChairTerms& terms : {ChairTerms{true, false}, ChairTerms{false, true}}) {
    header_.ticket.attempt = Uuid::New();
    ASSERT_TRUE(Open()->BeginAttempt(header_, "e", "p", {}, terms).ok());
    auto spool = Open();
    EXPECT_EQ(spool->Get(id())->terms.sign_off, terms.sign_off);
    EXPECT_EQ(spool->Get(id())->terms.outline, terms.outline);
    LockedTicket ticket;
    ticket.attempt = id();
    ticket.outline = terms.outline;
    ASSERT_TRUE(spool->tickets().Put(ticket).ok());
    const auto kept = *spool->tickets().List();
    EXPECT_EQ(std::ranges::find(kept, id(), &LockedTicket::attempt)->outline, terms.outline);
  }
}

TEST_F(SpoolTest, AnAttemptWhoseFactsCannotBeReadSaysNone) {
  MakeOne();
  Tamper("UPDATE attempts SET facts = x'08', resumed = 2");
  auto attempt = Open()->Get(id());
  ASSERT_TRUE(attempt.ok());
  EXPECT_EQ(protocol::FactsText(attempt->facts), "resumed: 2");
}

TEST_F(SpoolTest, FileThatIsNoDatabaseIsRefusedWithItsName) {
  std::ofstream(folder_ / "spool.sqlite") << std::string(5000, 'x');
  auto spool = Spool::Open(folder_);
  EXPECT_EQ(spool.status().code(), Code::kStorage);
  EXPECT_NE(spool.status().message().find("spool.sqlite"), std::string::npos);
  EXPECT_NE(spool.status().message().find("damaged"), std::string::npos)
      << spool.status().message();
}

TEST_F(SpoolTest, NewerSpoolIsRefusedUnchanged) {
  Open();
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "spool.sqlite").c_str(), &db), SQLITE_OK);
  sqlite3_exec(db, "PRAGMA user_version = 99", nullptr, nullptr, nullptr);
  sqlite3_close(db);
  EXPECT_EQ(Spool::Open(folder_).status().code(), Code::kVersion);
}

// Nothing marks the spools of earlier Enamels.
TEST_F(SpoolTest, ASpoolOfAnEarlierEnamelIsRefusedByNameAndLeftAsItIs) {
  MakeOne();
  Tamper("PRAGMA application_id = 0; PRAGMA user_version = 6; PRAGMA wal_checkpoint(TRUNCATE)");
  const fs::path file = folder_ / "spool.sqlite";
  const auto before = *ReadFile(file);
  for (const Status& refused : {Spool::Open(folder_).status(), Spool::OpenToRead(folder_).status(),
                                SalvageSpool(folder_, folder_ / "saved").status()}) {
    EXPECT_EQ(refused.code(), Code::kVersion);
    EXPECT_NE(refused.message().find(file.string() + " was made by an earlier Enamel"),
              std::string::npos)
        << refused.message();
    EXPECT_NE(refused.message().find("move the file away"), std::string::npos);
  }
  EXPECT_EQ(*ReadFile(file), before);
  EXPECT_FALSE(fs::exists(folder_ / "saved" / "spool.sqlite"));
}

TEST_F(SpoolTest, FolderThatCannotBeMadeIsRefusedWithWhatToDo) {
  std::ofstream(folder_ / "file") << "x";
  auto spool = Spool::Open(folder_ / "file" / "data");
  EXPECT_EQ(spool.status().code(), Code::kStorage);
  EXPECT_NE(spool.status().message().find("--data"), std::string::npos);
}

TEST_F(SpoolTest, FullDiskIsAClearErrorAndNothingSpooledIsLost) {
  {
    auto spool = Open();
    ASSERT_TRUE(spool->BeginAttempt(header_, "e", "p").ok());
    Record(*spool, 500, false);
  }
  pid_t child = ::fork();
  if (child == 0) {
    auto spool = Spool::Open(folder_);
    if (!spool.ok()) ::_exit(1);
    // No file may grow: the disk is full.
    ::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{60'000, 60'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    Status status;
    for (uint32_t i = 1; i < 200 && status.ok(); ++i) {
      trace::ChunkHead head;
      head.attempt = id();
      head.seq = i;
      std::vector<trace::Tick> ticks(500);
      for (size_t t = 0; t < 500; ++t)
        ticks[t].input.counts[0] = static_cast<int32_t>(t * t * i * 7919);
      status = (*spool)->PutChunk(id(), trace::EncodeChunk(head, ticks, keys_.secret_key));
    }
    ::_exit(status.code() == Code::kStorage ? 0 : 2);
  }
  int state = 0;
  ASSERT_EQ(::waitpid(child, &state, 0), child);
  ASSERT_TRUE(WIFEXITED(state));
  EXPECT_EQ(WEXITSTATUS(state), 0);
  auto spool = Open();
  EXPECT_GE(spool->Get(id())->chunks, 1u);
  EXPECT_TRUE(trace::DecodeChunk((*spool->ChunksFrom(id(), 0, 1))[0].bytes).ok());
}

TEST_F(SpoolTest, IsReadableByItsOwnerOnly) {
  Open();
  struct stat info {};
  ASSERT_EQ(::stat((folder_ / "spool.sqlite").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
}

}  // namespace
}  // namespace enamel::station
