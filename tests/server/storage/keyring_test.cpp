#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "server/storage/keys/folder_keyring.h"
#include "tests/server/storage/store_world.h"

// Keys of people, and data encrypted under them.
namespace enamel::server {
namespace {

using namespace testing;

class KeyringTest : public ::testing::Test {
 protected:
  std::filesystem::path Ring(const char* name) const { return folder_.path() / name; }
  TempFolder folder_;
  FolderKeyring ring_{Ring("a"), SystemDisk()};
  Uuid person_ = Uuid::New(), attempt_ = Uuid::New();
};

// The golden envelope was computed with libsodium and Python's hashlib, from the text alone.
TEST_F(KeyringTest, EnvelopeIsTheOneOfTheFormatsDescription) {
  auto text = ReadFile(ENAMEL_SOURCE_DIR "/schemas/golden/personal_data.json");
  ASSERT_TRUE(text.ok()) << text.status().message();
  auto golden = boost::json::parse(AsText(*text)).as_object();
  auto bytes = [&](const char* name) {
    return *FromHex(std::string_view(golden.at(name).as_string()));
  };
  Uuid person = *Uuid::Parse(std::string_view(golden.at("person").as_string()));
  Uuid attempt = *Uuid::Parse(std::string_view(golden.at("attempt").as_string()));
  DataKey key{ByteView(bytes("key"))};
  EXPECT_EQ(SealPersonal(person, key, attempt, bytes("plain")), bytes("envelope"));
  EXPECT_EQ(TombstoneOf(person).Hex(), std::string_view(golden.at("tombstone").as_string()));
  ASSERT_TRUE(SystemDisk().MakeFolder(ring_.folder()).ok());
  ASSERT_TRUE(WriteFileDurably(ring_.folder() / (person.Text() + ".key"), bytes("key")).ok());
  EXPECT_EQ(*OpenPersonal(ring_, bytes("envelope")), bytes("plain"));
}

TEST_F(KeyringTest, KeyIsMadeOnceAndFoundByAnotherProcess) {
  EXPECT_EQ(ring_.Find(person_).status().code(), Code::kNotFound);
  auto made = ring_.FindOrMake(person_);
  ASSERT_TRUE(made.ok()) << made.status().message();
  FolderKeyring elsewhere(Ring("a"), SystemDisk());
  EXPECT_TRUE(std::ranges::equal(elsewhere.FindOrMake(person_)->view(), made->view()));
  EXPECT_FALSE(std::ranges::equal(ring_.FindOrMake(Uuid::New())->view(), made->view()));
}

TEST_F(KeyringTest, DestroyedKeyOpensNothingAndIsNotMadeAgain) {
  Bytes sealed = SealPersonal(person_, *ring_.FindOrMake(person_), attempt_, AsBytes("data"));
  FolderKeyring elsewhere(Ring("a"), SystemDisk());
  ASSERT_TRUE(elsewhere.Destroy(person_, 5).ok());
  EXPECT_EQ(OpenPersonal(ring_, sealed).status().code(), Code::kNotFound)
      << "although this one had it in memory";
  EXPECT_EQ(ring_.FindOrMake(person_).status().code(), Code::kConflict);
  EXPECT_TRUE(ring_.People()->empty());
  ASSERT_EQ(ring_.Gone()->size(), 1u);
  EXPECT_EQ(ring_.Gone()->front().erased_ms, 5);
}

TEST_F(KeyringTest, EveryChangedBitIsNoticed) {
  const Bytes sealed = SealPersonal(person_, *ring_.FindOrMake(person_), attempt_, AsBytes("data"));
  for (size_t i = 24; i < sealed.size(); ++i) {
    Bytes changed = sealed;
    changed[i] ^= 1;
    EXPECT_EQ(OpenPersonal(ring_, changed).status().code(), Code::kStorage) << "byte " << i;
  }
  Bytes version = sealed;
  version[4] = 2;
  EXPECT_EQ(OpenPersonal(ring_, version).status().code(), Code::kVersion);
  Bytes reserved = sealed;
  reserved[6] = 1;
  EXPECT_EQ(OpenPersonal(ring_, reserved).status().code(), Code::kStorage);
}

TEST_F(KeyringTest, TextIsPackedAndComesBack) {
  std::string curve = "{\"force_n\":[";
  for (int i = 0; i < 2000; ++i) curve += std::to_string(i % 700) + ",";
  const DataKey key = *ring_.FindOrMake(person_);
  const Bytes sealed = SealPacked(person_, key, attempt_, AsBytes(curve));
  EXPECT_LT(sealed.size(), curve.size() / 3);
  EXPECT_EQ(AsText(*OpenPersonal(ring_, sealed)), curve);
  EXPECT_EQ(SealPacked(person_, key, attempt_, AsBytes(curve)), sealed);
  EXPECT_TRUE(*IsOfAttempt(ring_, sealed, attempt_));
  EXPECT_FALSE(*IsOfAttempt(ring_, sealed, Uuid::New()));
  Bytes flags = sealed;
  flags[6] = 2;
  EXPECT_EQ(OpenPersonal(ring_, flags).status().code(), Code::kVersion);
  flags[6] = 0;
  EXPECT_EQ(OpenPersonal(ring_, flags).status().code(), Code::kStorage) << "not read as text";
}

TEST_F(KeyringTest, WhatIsNoEnvelopeIsReadAsItIs) {
  for (const char* text : {"", "ENEV", "{\"score\": 1}", "ENTV and more of it, a whole document"}) {
    Bytes bytes(AsBytes(text).begin(), AsBytes(text).end());
    EXPECT_EQ(*OpenPersonal(ring_, bytes), bytes);
  }
}

TEST_F(KeyringTest, FileThatDoesNotBelongIsNamed) {
  ASSERT_TRUE(ring_.FindOrMake(person_).ok());
  ASSERT_TRUE(WriteFileDurably(ring_.folder() / "notes.txt", AsBytes("hello")).ok());
  EXPECT_EQ(ring_.People().status().code(), Code::kInvalidInput);
  EXPECT_NE(ring_.People().status().message().find("notes.txt"), std::string::npos);
}

TEST_F(KeyringTest, ShortKeyFileIsRefused) {
  ASSERT_TRUE(SystemDisk().MakeFolder(ring_.folder()).ok());
  ASSERT_TRUE(WriteFileDurably(ring_.folder() / (person_.Text() + ".key"), AsBytes("x")).ok());
  EXPECT_EQ(ring_.Find(person_).status().code(), Code::kStorage);
}

TEST_F(KeyringTest, MirrorHasTheSameKeysAndAllErasures) {
  Uuid other = Uuid::New(), gone = Uuid::New();
  Bytes sealed = SealPersonal(person_, *ring_.FindOrMake(person_), attempt_, AsBytes("data"));
  FolderKeyring mirror(Ring("b"), SystemDisk());
  ASSERT_TRUE(mirror.FindOrMake(other).ok()) << "a key that the source does not have";
  ASSERT_TRUE(mirror.FindOrMake(gone).ok());
  ASSERT_TRUE(ring_.Destroy(gone, 5).ok());
  ASSERT_TRUE(mirror.MirrorFrom(ring_).ok());
  EXPECT_EQ(*mirror.People(), std::vector{person_});
  EXPECT_TRUE(mirror.IsGone(gone));
  EXPECT_EQ(AsText(*OpenPersonal(mirror, sealed)), "data");
}

TEST_F(KeyringTest, JoinedRingKeepsItsErasuresAgainstOlderKeys) {
  ASSERT_TRUE(ring_.FindOrMake(person_).ok());
  FolderKeyring older(Ring("b"), SystemDisk());
  ASSERT_TRUE(older.MirrorFrom(ring_).ok());
  ASSERT_TRUE(ring_.Destroy(person_, 5).ok());
  ASSERT_TRUE(Join(ring_, older).ok());
  EXPECT_TRUE(ring_.People()->empty());
  ASSERT_TRUE(Join(older, ring_).ok());
  EXPECT_TRUE(older.People()->empty());
}

}  // namespace
}  // namespace enamel::server
