#include "station/uplink/credentials.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "common/base/file.h"
#include "station/uplink/blob_cache.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

class CredentialsTest : public testing::Test {
 protected:
  CredentialsTest() {
    credentials_.server = {"::1", 7443};
    credentials_.fingerprint = HashSha256(AsBytes("certificate"));
    credentials_.station = Uuid::New();
    credentials_.credential.fill(7);
    credentials_.name = "chair \"4\"";
    credentials_.ticket_key.fill(9);
    credentials_.secret_key = trace::NewKeyPair().secret_key;
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  Credentials credentials_;
};

TEST_F(CredentialsTest, ComeBackAsTheyWereSaved) {
  ASSERT_TRUE(SaveCredentials(folder_, credentials_).ok());
  auto back = LoadCredentials(folder_);
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(back->server.Text(), credentials_.server.Text());
  EXPECT_EQ(back->fingerprint, credentials_.fingerprint);
  EXPECT_EQ(back->station, credentials_.station);
  EXPECT_EQ(back->credential, credentials_.credential);
  EXPECT_EQ(back->name, credentials_.name);
  EXPECT_EQ(back->ticket_key, credentials_.ticket_key);
  EXPECT_EQ(back->secret_key, credentials_.secret_key);
}

TEST_F(CredentialsTest, MovedServerKeepsItsPinnedIdentity) {
  ASSERT_TRUE(SaveCredentials(folder_, credentials_).ok());
  auto moved = LoadCredentialsFor(folder_, "127.0.0.1:9");
  ASSERT_TRUE(moved.ok());
  EXPECT_EQ(moved->server.Text(), "127.0.0.1:9");
  EXPECT_EQ(moved->fingerprint, credentials_.fingerprint);
  EXPECT_EQ(LoadCredentialsFor(folder_, "")->server.Text(), credentials_.server.Text());
  EXPECT_FALSE(LoadCredentialsFor(folder_, "nowhere").ok());
}

TEST_F(CredentialsTest, StationTakesTheCodeOfItsOwnName) {
  auto table = ReadFile(fs::path(ENAMEL_SOURCE_DIR) / "schemas/golden/enrolment_codes.csv");
  ASSERT_TRUE(table.ok()) << table.status().message();
  auto first = FindEnrolCode(AsText(*table), "Chair 1");
  auto second = FindEnrolCode(AsText(*table), "Room 2, left");
  ASSERT_TRUE(first.ok()) << first.status().message();
  ASSERT_TRUE(second.ok()) << second.status().message();
  EXPECT_EQ(first->code, "00112233445566778899aabbccddeeff");
  EXPECT_EQ(second->code, "ffeeddccbbaa99887766554433221100");
  EXPECT_EQ(second->fingerprint.Hex().substr(0, 8), "a94a8fe5");

  EXPECT_EQ(FindEnrolCode(AsText(*table), "Chair 3").status().code(), Code::kNotFound);
  EXPECT_EQ(FindEnrolCode(AsText(*table), "name").status().code(), Code::kInvalidInput);
  EXPECT_EQ(FindEnrolCode("code,name\r\n", "Chair 1").status().code(), Code::kInvalidInput);
}

TEST_F(CredentialsTest, PublicKeyIsTheSecretKeysOwn) {
  trace::KeyPair keys = trace::NewKeyPair();
  credentials_.secret_key = keys.secret_key;
  EXPECT_EQ(credentials_.public_key(), keys.public_key);
}

TEST_F(CredentialsTest, FileIsForItsOwnerOnlyAndRefusedOtherwise) {
  ASSERT_TRUE(SaveCredentials(folder_, credentials_).ok());
  struct stat info {};
  ASSERT_EQ(::stat((folder_ / "station.json").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  ::chmod((folder_ / "station.json").c_str(), 0644);
  EXPECT_EQ(LoadCredentials(folder_).status().code(), Code::kForbidden);
}

TEST_F(CredentialsTest, StationThatIsNotEnrolledIsToldHow) {
  Status status = LoadCredentials(folder_).status();
  EXPECT_EQ(status.code(), Code::kNotFound);
  EXPECT_NE(status.message().find("enamel-station enrol"), std::string::npos);
}

TEST_F(CredentialsTest, DamagedFileIsRefused) {
  for (const char* text : {"", "{", "[]", "{\"enamel_station\":1}", "{\"enamel_station\":2}"}) {
    ASSERT_TRUE(WriteFileDurably(folder_ / "station.json", AsBytes(text), 0600).ok());
    EXPECT_FALSE(LoadCredentials(folder_).ok()) << text;
  }
}

TEST_F(CredentialsTest, FileOfAnEarlierEnamelIsRefusedByName) {
  ASSERT_TRUE(WriteFileDurably(folder_ / "station.json", AsBytes("{\"format\":1}"), 0600).ok());
  const Status refused = LoadCredentials(folder_).status();
  EXPECT_EQ(refused.code(), Code::kVersion);
  EXPECT_EQ(refused.field(), kEnrolment);
  EXPECT_NE(refused.message().find("an earlier Enamel"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("enrol"), std::string::npos) << refused.message();
}

TEST(EnrolCodeTest, FingerprintMayBeWrittenWithColons) {
  Sha256 hash = HashSha256(AsBytes("x"));
  std::string colons;
  for (size_t i = 0; i < 64; i += 2) {
    if (i > 0) colons += ':';
    colons.append(hash.Hex(), i, 2);
  }
  for (const std::string& fingerprint : {hash.Hex(), colons}) {
    auto code = ParseEnrolCode("abc123@" + fingerprint);
    ASSERT_TRUE(code.ok());
    EXPECT_EQ(code->code, "abc123");
    EXPECT_EQ(code->fingerprint, hash);
  }
}

TEST(EnrolCodeTest, AnythingElseIsRefusedWithTheExpectedForm) {
  for (const char* text : {"", "abc", "@", "abc@", "abc@12",
                           "@"
                           "00"}) {
    Status status = ParseEnrolCode(text).status();
    EXPECT_EQ(status.code(), Code::kInvalidInput) << text;
    EXPECT_NE(status.message().find("CODE@FINGERPRINT"), std::string::npos);
  }
}

TEST_F(CredentialsTest, CacheGivesBackOnlyWhatMatchesItsName) {
  BlobCache cache(folder_ / "blobs");
  Bytes data = {1, 2, 3};
  Sha256 name = HashSha256(data);
  EXPECT_FALSE(cache.Find(name));
  ASSERT_TRUE(cache.Put(name, data).ok());
  EXPECT_EQ(cache.Find(name), data);
  ASSERT_TRUE(WriteFileDurably(folder_ / "blobs" / name.Hex(), AsBytes("other")).ok());
  EXPECT_FALSE(cache.Find(name));
}

}  // namespace
}  // namespace enamel::station
