#include "server/storage/blobs/s3_blobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <thread>

#include "common/base/unix_time.h"
#include "server/storage/blobs/blob_rows.h"
#include "server/storage/engine/database.h"
#include "tests/server/storage/bare_rows.h"
#include "tests/server/storage/store_world.h"
#include "tests/support/s3_stand_in.h"

// Blobs in an S3 store that fails on command, with two servers beside each other.
namespace enamel::server {
namespace {

using namespace enamel::server::testing;
using Fault = test::S3StandIn::Fault;

constexpr int64_t kMinuteMs = 60'000, kHourMs = 60 * kMinuteMs;

// One of the servers: blobs over a connection of its own.
class Server {
 public:
  Server(const test::S3StandIn& s3, const std::filesystem::path& folder, const int64_t& now_ms)
      : db_(OpenMigrated(folder / "enamel.db")),
        rows_(ConnectionsTo(folder / "enamel.db", before_write), 2) {
    s3::S3Options options = s3.options();
    options.time.pause = [](auto) {};
    auto client = s3::S3Client::Make(options);
    EXPECT_TRUE(client.ok()) << client.status().message();
    blobs_ = std::make_unique<S3Blobs>(std::move(client).value(), "p/", rows_,
                                       [&now_ms] { return now_ms; });
  }
  Status Write(const std::function<Status(sql::Db&)>& work) { return rows_.Write(work); }
  // As an attempt's trace; without, its name is taken away.
  void Name(const Sha256& hash, bool there = true) {
    const std::string content = "X'" + hash.Hex() + "'";
    const Status done =
        db_->Exec((there ? "INSERT INTO start_teeth (tenant, volume, content) VALUES (1, " +
                               content + ", " + content + ")"
                         : "DELETE FROM start_teeth WHERE content = " + content)
                      .c_str());
    ASSERT_TRUE(done.ok()) << done.message();
  }
  // What an erasure does.
  size_t Free(const Sha256& hash) {
    std::vector<Blobs::Freed> freed;
    const Status done = Write([&](sql::Db& db) -> Status {
      auto out = blobs_->Free(db, {hash});
      if (out.ok()) freed = *out;
      return out.status();
    });
    EXPECT_TRUE(done.ok()) << done.message();
    return *blobs_->Remove(freed);
  }
  S3Blobs* operator->() { return blobs_.get(); }
  sql::Db& db() { return *db_; }
  std::function<void()> before_write;  // once

 private:
  std::unique_ptr<SqliteDb> db_;
  Transactions rows_;
  std::unique_ptr<S3Blobs> blobs_;
};

class S3BlobsTest : public ::testing::Test {
 protected:
  void TearDown() override { EXPECT_EQ(s3_.complaints(), std::vector<std::string>{}); }
  std::vector<std::string> Keys() const {
    std::vector<std::string> out;
    for (const auto& [key, body] : s3_.objects()) out.push_back(key);
    return out;
  }

  test::S3StandIn s3_;
  TempFolder folder_;
  int64_t now_ms_ = enamel::UnixMs();
  Server one_{s3_, folder_.path(), now_ms_}, two_{s3_, folder_.path(), now_ms_};
  const Bytes body_ = {1, 2, 3};
  const Sha256 hash_ = HashSha256(body_);
};

TEST_F(S3BlobsTest, WhatOneServerPutsAnotherGets) {
  EXPECT_FALSE(one_->Has(hash_));
  EXPECT_EQ(one_->Get(hash_).status().code(), Code::kNotFound);
  EXPECT_EQ(*one_->Put(body_), hash_);
  EXPECT_TRUE(two_->Has(hash_));
  EXPECT_EQ(*two_->Get(hash_), body_);
  ASSERT_EQ(Keys().size(), 1u);
  EXPECT_TRUE(Keys()[0].starts_with("p/" + hash_.Hex() + "-")) << Keys()[0];
}

TEST_F(S3BlobsTest, TheSameTwiceIsUploadedOnce) {
  ASSERT_TRUE(one_->Put(body_).ok() && two_->Put(body_).ok());
  EXPECT_EQ(s3_.requests("PUT"), 1);
  EXPECT_EQ(Keys().size(), 1u);
}

TEST_F(S3BlobsTest, OfTwoWhoUploadAtOnceOneIsKeptAndTheOthersGoes) {
  one_.before_write = [&] { EXPECT_TRUE(two_->Put(body_).ok()); };
  ASSERT_TRUE(one_->Put(body_).ok());
  EXPECT_EQ(s3_.requests("PUT"), 2);
  EXPECT_EQ(Keys().size(), 1u);
  EXPECT_EQ(*one_->Get(hash_), body_);
  EXPECT_EQ(*two_->Get(hash_), body_);
}

TEST_F(S3BlobsTest, WhatNobodyNamesAnyMoreGoesAtOnceAndWhatIsNamedStays) {
  ASSERT_TRUE(one_->Put(body_).ok());
  one_.Name(hash_);
  EXPECT_EQ(two_.Free(hash_), 0u);
  EXPECT_TRUE(one_->Has(hash_));
  one_.Name(hash_, false);
  EXPECT_EQ(two_.Free(hash_), 1u);
  EXPECT_FALSE(one_->Has(hash_));
  EXPECT_TRUE(Keys().empty());
}

// The other server frees between Put and the transaction that names.
TEST_F(S3BlobsTest, WhatWasFreedBeforeItWasNamedIsNotNamedAndIsPutAgain) {
  ASSERT_TRUE(one_->Put(body_).ok());
  const std::string first = Keys().at(0);
  EXPECT_EQ(two_.Free(hash_), 1u);
  const Status held = one_.Write([&](sql::Db& db) { return one_->Hold(db, {hash_}); });
  EXPECT_EQ(held.code(), Code::kUnavailable) << held.message();
  ASSERT_TRUE(one_->Put(body_).ok());
  EXPECT_TRUE(one_.Write([&](sql::Db& db) { return one_->Hold(db, {hash_, Sha256{}}); }).ok());
  ASSERT_EQ(Keys().size(), 1u);
  EXPECT_NE(Keys()[0], first) << "another generation";
}

// The other server has deleted the row and not yet the object.
TEST_F(S3BlobsTest, DeletingAnEarlierGenerationLeavesALaterOneAlone) {
  ASSERT_TRUE(one_->Put(body_).ok());
  std::vector<Blobs::Freed> freed;
  ASSERT_TRUE(two_.Write([&](sql::Db& db) -> Status {
                    freed = *two_->Free(db, {hash_});
                    return Status::Ok();
                  })
                  .ok());
  ASSERT_EQ(freed.size(), 1u);
  ASSERT_TRUE(one_->Put(body_).ok());
  EXPECT_EQ(*two_->Remove(freed), 1u);
  EXPECT_EQ(*two_->Get(hash_), body_);
}

TEST_F(S3BlobsTest, ReaderWhoseRowIsOldFindsTheLaterGeneration) {
  ASSERT_TRUE(one_->Put(body_).ok());
  s3_.RemoveObject(Keys().at(0));
  EXPECT_EQ(one_->Get(hash_).status().code(), Code::kStorage) << "lost, and said so";
  EXPECT_NE(one_->Problem().message().find("lost"), std::string::npos);
  ASSERT_TRUE(two_->Put(body_).ok()) << "who puts it again mends it";
  EXPECT_EQ(*one_->Get(hash_), body_);
  EXPECT_TRUE(one_->Problem().ok());
  EXPECT_EQ(Keys().size(), 1u);
}

TEST_F(S3BlobsTest, SweepTakesWhatWasNotNamedWithinADay) {
  const Bytes named = {4}, young = {5};
  ASSERT_TRUE(one_->Put(body_).ok() && one_->Put(named).ok());
  one_.Name(HashSha256(named));
  EXPECT_EQ(*two_->Sweep(std::chrono::hours(24)), 0u);
  now_ms_ += 23 * kHourMs;
  ASSERT_TRUE(one_->Put(young).ok());
  EXPECT_EQ(*two_->Sweep(std::chrono::hours(24)), 0u);
  now_ms_ += 2 * kHourMs;
  EXPECT_EQ(*two_->Sweep(std::chrono::hours(24)), 1u);
  EXPECT_FALSE(one_->Has(hash_));
  EXPECT_TRUE(one_->Has(HashSha256(named)) && one_->Has(HashSha256(young)));
  EXPECT_EQ(Keys().size(), 2u);
}

TEST_F(S3BlobsTest, SweepLeavesWhatWasPutAgainSince) {
  ASSERT_TRUE(one_->Put(body_).ok());
  now_ms_ += 25 * kHourMs;
  two_.before_write = [&] { EXPECT_TRUE(one_->Put(body_).ok()); };
  EXPECT_EQ(*two_->Sweep(std::chrono::hours(24)), 0u);
  EXPECT_EQ(*two_->Get(hash_), body_);
}

TEST_F(S3BlobsTest, ObjectWithoutARowGoesADayLaterAndOthersThingsStay) {
  ASSERT_TRUE(one_->Put(body_).ok());
  one_.Name(hash_);
  const std::string orphan = one_->KeyOf(hash_, 7), young = one_->KeyOf(hash_, 8);
  s3_.SetPageSize(2);
  for (const std::string& key :
       {orphan, young, std::string("p/readme"), std::string("q/x"), one_->KeyOf(hash_, 9) + "0"}) {
    s3_.SetObject(key, body_);
  }
  for (const std::string& key : Keys()) {
    if (key != young)
      s3_.SetModified(key, std::chrono::system_clock::now() - std::chrono::hours(25));
  }
  EXPECT_EQ(*two_->Sweep(std::chrono::hours(24)), 1u);
  EXPECT_EQ(Keys().size(), 5u);
  EXPECT_FALSE(std::ranges::count(Keys(), orphan));
  EXPECT_EQ(*one_->Get(hash_), body_);
  const int lists = s3_.requests("GET");
  EXPECT_EQ(*two_->Sweep(std::chrono::hours(24)), 0u);
  EXPECT_EQ(s3_.requests("GET"), lists) << "the store is listed once a day";
}

TEST_F(S3BlobsTest, UploadThatTookAnHourIsNotCountedAnyMore) {
  one_.before_write = [&] { now_ms_ += kHourMs; };
  EXPECT_EQ(one_->Put(body_).status().code(), Code::kUnavailable);
  EXPECT_FALSE(one_->Has(hash_)) << "a sweep may be about to take the object";
}

TEST_F(S3BlobsTest, EveryFaultLeavesEitherTheWholeBlobOrNone) {
  struct Case {
    Fault fault;
    Code code;
  };
  for (const Case& c :
       {Case{Fault::kForbidden, Code::kStorage}, Case{Fault::kInternal, Code::kUnavailable},
        Case{Fault::kSlowDown, Code::kUnavailable}, Case{Fault::kFull, Code::kStorage},
        Case{Fault::kQuota, Code::kStorage}, Case{Fault::kResetInBody, Code::kUnavailable},
        Case{Fault::kResetAfterwards, Code::kUnavailable}}) {
    const Bytes body = {9, static_cast<uint8_t>(c.fault)};
    s3_.FailNext(c.fault, -1);
    const Status put = one_->Put(body).status();
    EXPECT_EQ(put.code(), c.code) << put.message();
    for (const char* inner : {"127.0.0.1", "blobs,", "bucket"}) {
      EXPECT_EQ(put.message().find(inner), std::string::npos) << put.message();
    }
    EXPECT_FALSE(one_->Has(HashSha256(body)));
    EXPECT_FALSE(one_->Problem().ok());
    s3_.FailNext(Fault::kNone, 0);
    ASSERT_TRUE(one_->Put(body).ok());
    EXPECT_TRUE(one_->Problem().ok());
    s3_.FailNext(c.fault, -1);
    EXPECT_EQ(two_->Get(HashSha256(body)).status().code(), c.code);
    s3_.FailNext(Fault::kNone, 0);
    EXPECT_EQ(*two_->Get(HashSha256(body)), body);
  }
}

TEST_F(S3BlobsTest, WrongBytesAreNeverHandedOut) {
  ASSERT_TRUE(one_->Put(body_).ok());
  s3_.FailNext(Fault::kWrongBytes, -1, "GET");
  EXPECT_EQ(one_->Get(hash_).status().code(), Code::kStorage);
  s3_.FailNext(Fault::kWrongBytes, 1, "GET");
  EXPECT_EQ(*one_->Get(hash_), body_);
}

TEST_F(S3BlobsTest, ObjectThatGrewIsNotTaken) {
  ASSERT_TRUE(one_->Put(body_).ok());
  const std::string key = s3_.objects().begin()->first;
  s3_.SetObject(key, Bytes(1 << 20));
  EXPECT_EQ(two_->Get(hash_).status().code(), Code::kStorage);
  EXPECT_NE(two_->Problem().message().find("at most " + std::to_string(body_.size()) + " bytes"),
            std::string::npos)
      << two_->Problem().message();
}

TEST_F(S3BlobsTest, ErasureIsNotKeptUpByAStoreThatIsAway) {
  ASSERT_TRUE(one_->Put(body_).ok());
  s3_.Stop();
  EXPECT_EQ(two_.Free(hash_), 0u);
  EXPECT_FALSE(one_->Has(hash_)) << "its row is gone";
  s3_.Start();
  EXPECT_EQ(Keys().size(), 1u);
  s3_.SetModified(Keys()[0], std::chrono::system_clock::now() - std::chrono::hours(25));
  EXPECT_EQ(*two_->Sweep(std::chrono::hours(24)), 1u);
  EXPECT_TRUE(Keys().empty());
}

// Minutes without the store: arriving chunks are kept, ended attempts wait at their station.
TEST(S3OutageTest, RecordingsGoOnAndSealsComeAgain) {
  test::S3StandIn s3;
  TempFolder folder;
  StoreOptions options;
  options.folder = folder.path();
  options.s3_blobs.emplace();
  options.s3_blobs->store = s3.options();
  options.s3_blobs->store.time.pause = [](auto) {};
  auto store = std::move(OpenSqliteStore(options)).value();
  World world(*store);
  const Uuid attempt = world.OpenedAttempt();
  s3.Stop();
  std::vector<ChunkPut> chunks;
  Sha256 previous = World::HeaderHash();
  for (uint32_t seq = 0; seq < 3; ++seq) {
    chunks.push_back(world.Chunk(attempt, seq, previous));
    previous = chunks.back().hash;
    EXPECT_TRUE(store->ingest.AppendChunk(chunks.back()).ok());
  }
  EXPECT_EQ(store->seals.SealAttempt(World::SealOf(chunks), 1).code(), Code::kUnavailable);
  EXPECT_EQ(store->attempts.AttemptById(attempt)->state, AttemptState::kRecording);
  EXPECT_TRUE(store->health.Health().takes_recordings);
  EXPECT_NE(store->health.Health().waiting.find("store of blobs"), std::string::npos);
  s3.Start();
  EXPECT_TRUE(store->seals.SealAttempt(World::SealOf(chunks), 1).ok());
  EXPECT_EQ(store->attempts.AttemptById(attempt)->state, AttemptState::kSealed);
  EXPECT_EQ(AllChunks(store->recordings, attempt)->size(), 3u);
  EXPECT_TRUE(store->health.Health().waiting.empty()) << store->health.Health().waiting;
}

}  // namespace
}  // namespace enamel::server
