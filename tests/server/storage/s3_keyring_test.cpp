#include "server/storage/keys/s3_keyring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <boost/json.hpp>
#include <mutex>
#include <thread>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "server/storage/engine/database.h"
#include "tests/server/storage/bare_rows.h"
#include "tests/server/storage/store_world.h"
#include "tests/support/s3_stand_in.h"

// The key ring in a bucket that fails on command, with two servers beside each other.
namespace enamel::server {
namespace {

using namespace enamel::server::testing;
using Fault = test::S3StandIn::Fault;

boost::json::object Golden() {
  auto text = ReadFile(ENAMEL_SOURCE_DIR "/schemas/golden/wrapped_key.json");
  EXPECT_TRUE(text.ok()) << text.status().message();
  return boost::json::parse(AsText(*text)).as_object();
}
Bytes BytesOf(const boost::json::object& golden, const char* name) {
  return *FromHex(std::string_view(golden.at(name).as_string()));
}

// The golden key was wrapped with libsodium and Python's hashlib, from the text alone.
TEST(MasterKeyTest, WrappedKeyIsTheOneOfTheFormatsDescription) {
  const auto golden = Golden();
  const MasterKey master(DataKey(BytesOf(golden, "master_key")));
  const Uuid person = *Uuid::Parse(std::string_view(golden.at("person").as_string()));
  const Bytes wrapped = BytesOf(golden, "wrapped");
  const auto key = master.Unwrap(person, wrapped);
  ASSERT_TRUE(key.ok()) << key.status().message();
  EXPECT_TRUE(std::ranges::equal(key->view(), BytesOf(golden, "key")));
  EXPECT_EQ(master.Fingerprint().Hex(), std::string_view(golden.at("fingerprint").as_string()));
  const Bytes mine = master.Wrap(person, *key);
  EXPECT_EQ(mine.size(), wrapped.size());
  EXPECT_NE(mine, wrapped) << "another nonce";
  EXPECT_TRUE(std::ranges::equal(master.Unwrap(person, mine)->view(), key->view()));
  EXPECT_FALSE(master.Unwrap(Uuid::New(), wrapped).ok());
  EXPECT_FALSE(MasterKey(DataKey::New()).Unwrap(person, wrapped).ok());
}

TEST(MasterKeyTest, EveryChangedBitAndLengthIsNoticed) {
  const auto golden = Golden();
  const MasterKey master(DataKey(BytesOf(golden, "master_key")));
  const Uuid person = *Uuid::Parse(std::string_view(golden.at("person").as_string()));
  const Bytes wrapped = BytesOf(golden, "wrapped");
  for (size_t i = 0; i < 8 * wrapped.size(); ++i) {
    Bytes changed = wrapped;
    changed[i / 8] ^= static_cast<uint8_t>(1 << i % 8);
    EXPECT_FALSE(master.Unwrap(person, changed).ok()) << "bit " << i;
  }
  for (size_t size = 0; size < wrapped.size(); ++size) {
    EXPECT_FALSE(master.Unwrap(person, ByteView(wrapped).first(size)).ok()) << size;
  }
  Bytes longer = wrapped;
  longer.push_back(0);
  EXPECT_FALSE(master.Unwrap(person, longer).ok());
}

TEST(MasterKeyTest, FileIsMadeOnceAndMayNotBeReadByOthers) {
  const TempFolder folder;
  const auto path = folder.path() / "master.key";
  EXPECT_EQ(ReadMasterKey(path).status().code(), Code::kNotFound);
  const auto made = EnsureMasterKey(path, SystemDisk());
  ASSERT_TRUE(made.ok()) << made.status().message();
  EXPECT_EQ(ReadMasterKey(path)->Fingerprint(), made->Fingerprint());
  EXPECT_EQ(EnsureMasterKey(path, SystemDisk())->Fingerprint(), made->Fingerprint());
  std::filesystem::permissions(path, std::filesystem::perms(0640));
  EXPECT_EQ(ReadMasterKey(path).status().code(), Code::kForbidden);
  for (const std::string& text : {std::string(), std::string(63, 'a'), std::string(65, 'a'),
                                  std::string(64, 'x'), std::string(1025, 'a')}) {
    ASSERT_TRUE(WriteFileDurably(path, AsBytes(text), 0600).ok());
    const Status refused = ReadMasterKey(path).status();
    EXPECT_FALSE(refused.ok()) << text;
    EXPECT_EQ(refused.message().find("aaaa"), std::string::npos) << "part of a key is in a message";
  }
}

class S3KeyringTest : public ::testing::Test {
 protected:
  // One of the servers: a key ring over a connection of its own.
  struct Server {
    Server(const test::S3StandIn& s3, const std::filesystem::path& folder, const MasterKey& master)
        : db(OpenMigrated(folder / "enamel.db")),
          rows(ConnectionsTo(folder / "enamel.db", before_write), 2) {
      s3::S3Options options = s3.options();
      options.limits.tries = 1;
      auto client = s3::S3Client::Make(options);
      EXPECT_TRUE(client.ok()) << client.status().message();
      ring = std::make_unique<S3Keyring>(std::move(client).value(), "k/", master, rows);
    }
    S3Keyring* operator->() { return ring.get(); }

    std::function<void()> before_write{};  // once
    std::unique_ptr<SqliteDb> db;          // past the key ring
    Transactions rows;
    std::unique_ptr<S3Keyring> ring;
  };

  void TearDown() override { EXPECT_EQ(s3_.complaints(), std::vector<std::string>{}); }
  std::vector<std::string> Keys() const {
    std::vector<std::string> out;
    for (const auto& [key, body] : s3_.objects()) out.push_back(key);
    return out;
  }
  static bool Same(const Result<DataKey>& a, const Result<DataKey>& b) {
    return a.ok() && b.ok() && std::ranges::equal(a->view(), b->view());
  }
  bool HasKeyOf(const Uuid& person) const {
    return std::ranges::any_of(
        Keys(), [&](const std::string& key) { return key.starts_with("k/" + person.Text()); });
  }
  void ExpectGone(const Uuid& person) {
    for (Server* server : {&one_, &two_}) {
      EXPECT_TRUE(*(*server)->IsGone(person));
      EXPECT_EQ((*server)->Find(person).status().code(), Code::kNotFound);
      EXPECT_EQ((*server)->FindOrMake(person).status().code(), Code::kConflict);
    }
  }

  test::S3StandIn s3_;
  TempFolder folder_;
  const MasterKey master_{DataKey::New()};
  Server one_{s3_, folder_.path(), master_}, two_{s3_, folder_.path(), master_};
  const Uuid person_ = Uuid::New();
};

TEST_F(S3KeyringTest, KeyThatOneServerMakesAnotherFinds) {
  EXPECT_EQ(one_->Find(person_).status().code(), Code::kNotFound);
  EXPECT_FALSE(*one_->IsGone(person_));
  const auto key = one_->FindOrMake(person_);
  ASSERT_TRUE(key.ok()) << key.status().message();
  EXPECT_TRUE(Same(key, two_->FindOrMake(person_)));
  EXPECT_TRUE(Same(key, one_->Find(person_)));
  ASSERT_EQ(Keys().size(), 1u);
  EXPECT_TRUE(Keys()[0].starts_with("k/" + person_.Text() + "-")) << Keys()[0];
  const auto objects = s3_.objects();
  const Bytes& kept = objects.begin()->second;
  // Not ranges::search, which clang 14 cannot read.
  EXPECT_EQ(std::search(kept.begin(), kept.end(), key->view().begin(), key->view().end()),
            kept.end())
      << "the bucket has the key as it is";
  EXPECT_FALSE(Same(key, one_->FindOrMake(Uuid::New())));
}

TEST_F(S3KeyringTest, KeyIsAskedOfTheBucketOnce) {
  ASSERT_TRUE(one_->FindOrMake(person_).ok());
  const int asked = s3_.requests();
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(one_->Find(person_).ok());
  EXPECT_EQ(s3_.requests(), asked);
  // A class that begins at once: all chunks of a moment want a key that the server has not read
  // yet.
  std::atomic<int> found{0};
  {
    std::vector<std::jthread> all;
    for (int i = 0; i < 16; ++i)
      all.emplace_back([&] { found += two_->Find(person_).ok() ? 1 : 0; });
  }
  EXPECT_EQ(found, 16);
  EXPECT_EQ(s3_.requests(), asked + 1);
}

TEST_F(S3KeyringTest, KeyThatIsPutIsReadBackFromTheBucket) {
  const DataKey key = DataKey::New();
  ASSERT_TRUE(one_->Put(person_, key).ok());
  const int asked = s3_.requests();
  EXPECT_TRUE(Same(key, one_->Find(person_)));
  EXPECT_EQ(s3_.requests(), asked + 1) << "not from memory";
  EXPECT_TRUE(one_->Put(person_, DataKey::New()).ok());
  EXPECT_TRUE(Same(key, one_->Find(person_))) << "the one that is there stays";
  EXPECT_EQ(*one_->People(), std::vector{person_});
}

TEST_F(S3KeyringTest, OfTwoServersThatMakeItAtOnceOneKeyCounts) {
  Result<DataKey> second = Status(Code::kInternal, "not made");
  one_.before_write = [&] { second = two_->FindOrMake(person_); };
  const auto first = one_->FindOrMake(person_);
  EXPECT_TRUE(Same(first, second)) << first.status().message();
  EXPECT_EQ(Keys().size(), 1u) << "the other's object is left";
}

TEST_F(S3KeyringTest, WhoIsErasedMeanwhileGetsNoKey) {
  one_.before_write = [&] { ASSERT_TRUE(two_->Destroy(person_, 5).ok()); };
  EXPECT_EQ(one_->FindOrMake(person_).status().code(), Code::kConflict);
  ASSERT_EQ(Keys().size(), 1u);
  EXPECT_TRUE(Keys()[0].starts_with("k/gone/")) << Keys()[0];
  ExpectGone(person_);
}

TEST_F(S3KeyringTest, DestroyedKeyIsGoneForEveryServerAtOnce) {
  const Uuid other = Uuid::New();
  ASSERT_TRUE(one_->FindOrMake(person_).ok() && two_->Find(person_).ok());
  const auto kept = one_->FindOrMake(other);
  ASSERT_TRUE(two_->Destroy(person_, 5).ok());
  ExpectGone(person_);
  EXPECT_EQ(Keys().size(), 2u) << "the other's key, and who was erased";
  EXPECT_TRUE(Same(kept, two_->Find(other)));
  const auto gone = one_->Gone();
  ASSERT_TRUE(gone.ok()) << gone.status().message();
  ASSERT_EQ(gone->size(), 1u);
  EXPECT_EQ(gone->front().person, TombstoneOf(person_));
  EXPECT_GT(gone->front().erased_ms, 0) << "by the store's clock";
  EXPECT_TRUE(two_->Destroy(person_, 6).ok()) << "again";
  EXPECT_EQ(Keys().size(), 2u);
}

// The erasure breaks off at each of its calls to the store: the person is erased nevertheless, and
// the next start finishes it.
TEST_F(S3KeyringTest, ErasureThatBreaksOffIsFinished) {
  for (const char* method : {"PUT", "GET", "DELETE"}) {
    SCOPED_TRACE(method);
    const Uuid person = Uuid::New();
    ASSERT_TRUE(one_->FindOrMake(person).ok());
    s3_.FailNext(Fault::kInternal, 1, method);
    EXPECT_EQ(one_->Destroy(person, 5).code(), Code::kUnavailable);
    ExpectGone(person);
    EXPECT_TRUE(HasKeyOf(person));
    ASSERT_TRUE(two_->Bury({{TombstoneOf(person), 5}}).ok());
    ExpectGone(person);
    EXPECT_FALSE(HasKeyOf(person));
    const auto gone = *two_->Gone();
    EXPECT_TRUE(std::ranges::any_of(
        gone, [&](const Tombstone& t) { return t.person == TombstoneOf(person); }));
  }
}

// Of an earlier generation, which no row names any more: older dumps have data under it.
TEST_F(S3KeyringTest, ErasureDestroysKeysThatNoRowNames) {
  ASSERT_TRUE(one_->FindOrMake(person_).ok());
  ASSERT_TRUE(one_.db->Exec("DELETE FROM person_keys").ok()) << "as after a restore";
  ASSERT_TRUE(one_->FindOrMake(person_).ok());
  ASSERT_EQ(Keys().size(), 2u);
  ASSERT_TRUE(two_->Destroy(person_, 5).ok());
  EXPECT_FALSE(HasKeyOf(person_));
}

TEST_F(S3KeyringTest, KeysOfTheErasedInARestoredBucketAreDestroyed) {
  const Uuid other = Uuid::New();
  ASSERT_TRUE(one_->FindOrMake(person_).ok() && one_->FindOrMake(other).ok());
  const auto before = s3_.objects();
  ASSERT_TRUE(one_->Destroy(person_, 5).ok());
  for (const auto& [key, body] : before) s3_.SetObject(key, body);
  ASSERT_TRUE(HasKeyOf(person_));
  ASSERT_TRUE(one_->Bury(*one_->Gone()).ok());
  EXPECT_FALSE(HasKeyOf(person_));
  EXPECT_TRUE(HasKeyOf(other));
}

TEST_F(S3KeyringTest, WhoWasErasedStaysSoWhenTheDatabaseIsRestored) {
  s3_.SetPageSize(1);
  const Uuid other = Uuid::New();
  for (const Uuid& person : {person_, other}) {
    ASSERT_TRUE(one_->FindOrMake(person).ok());
    ASSERT_TRUE(one_->Destroy(person, 5).ok());
  }
  ASSERT_TRUE(one_.db->Exec("DELETE FROM erasures").ok());
  EXPECT_FALSE(*one_->IsGone(person_)) << "as after a restore";
  const auto gone = one_->Gone();
  ASSERT_TRUE(gone.ok()) << gone.status().message();
  EXPECT_EQ(gone->size(), 2u);
  ASSERT_TRUE(one_->Bury(*gone).ok());
  ExpectGone(person_);
  ExpectGone(other);
  EXPECT_EQ(Keys().size(), 2u) << "each is listed once";
}

TEST_F(S3KeyringTest, WhatTheBucketForgotIsWrittenAgain) {
  ASSERT_TRUE(one_->Destroy(person_, 5).ok());
  s3_.RemoveObject(Keys()[0]);
  ASSERT_TRUE(one_->Bury({{TombstoneOf(person_), 5}}).ok());
  EXPECT_EQ(one_->Gone()->size(), 1u);
}

TEST_F(S3KeyringTest, LostAndForeignObjectsAreNamed) {
  ASSERT_TRUE(one_->FindOrMake(person_).ok());
  s3_.RemoveObject(Keys()[0]);
  EXPECT_TRUE(one_->Find(person_).ok()) << "it has the key in memory";
  EXPECT_EQ(two_->Find(person_).status().code(), Code::kStorage);
  EXPECT_EQ(two_->FindOrMake(person_).status().code(), Code::kStorage)
      << "another key would leave what is there unreadable";
  s3_.SetObject("k/gone/readme.txt", {});
  EXPECT_EQ(one_->Gone().status().code(), Code::kInvalidInput);
}

TEST_F(S3KeyringTest, WithAnotherMasterKeyNothingIsFoundAndNothingMade) {
  ASSERT_TRUE(one_->FindOrMake(person_).ok());
  Server stranger(s3_, folder_.path(), MasterKey(DataKey::New()));
  EXPECT_EQ(stranger->FindOrMake(person_).status().code(), Code::kStorage);
  EXPECT_EQ(Keys().size(), 1u);
}

TEST_F(S3KeyringTest, StoreThatIsAwayIsSaidAndCalledAgain) {
  s3_.FailNext(Fault::kSlowDown, 1);
  const Status away = one_->FindOrMake(person_).status();
  EXPECT_EQ(away.code(), Code::kUnavailable);
  EXPECT_EQ(away.message().find("127.0.0.1"), std::string::npos) << away.message();
  EXPECT_FALSE(one_->Problem().ok());
  ASSERT_TRUE(one_->FindOrMake(person_).ok());
  EXPECT_TRUE(one_->Problem().ok());
}

// The database is restored to before an erasure while the bucket is unreachable: the server starts,
// and the hourly upkeep erases again.
TEST(S3KeyringStoreTest, ErasureThatTheDatabaseForgotIsMadeAgainWhenTheBucketIsBack) {
  test::S3StandIn s3;
  const TempFolder folder, keys;
  StoreOptions options;
  options.folder = folder.path();
  options.hold_lock = true;
  options.s3_keys = {{s3.options(), "k/"}, keys.path() / "master.key"};
  options.s3_keys->place.store.time.pause = [](auto) {};
  ASSERT_TRUE(EnsureMasterKey(keys.path() / "master.key", SystemDisk()).ok());
  auto store = std::move(OpenSqliteStore(options)).value();
  World world(*store);
  world.Append(world.OpenedAttempt(), 1);
  store.reset();
  const auto before = folder.path() / "before.db";
  std::filesystem::copy_file(folder.path() / "enamel.db", before);
  store = std::move(OpenSqliteStore(options)).value();
  ASSERT_TRUE(store->erasures.ErasePerson(world.student, false, kSystem).ok());
  store.reset();
  std::filesystem::rename(before, folder.path() / "enamel.db");

  s3.Stop();
  auto restored = OpenSqliteStore(options);
  ASSERT_TRUE(restored.ok()) << restored.status().message();
  EXPECT_TRUE((*restored)->people.PersonById(world.student).ok())
      << "nobody could say that it is erased";
  s3.Start();
  ASSERT_TRUE((*restored)->erasures.FinishErasures().ok());
  EXPECT_EQ((*restored)->people.PersonById(world.student).status().code(), Code::kNotFound);
  EXPECT_EQ(s3.complaints(), std::vector<std::string>{});
}

}  // namespace
}  // namespace enamel::server
