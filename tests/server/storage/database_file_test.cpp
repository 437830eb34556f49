#include "server/storage/folder/database_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/file.h"
#include "server/storage/open_store.h"
#include "tests/support/s3_stand_in.h"
#include "tests/support/temp_folder.h"

// database.json (schemas/database.md).
namespace enamel::server {
namespace {

const std::filesystem::path kGolden = ENAMEL_SOURCE_DIR "/schemas/golden";
const std::string kBegin = R"({"format":"enamel-database","version":1,)";

class DatabaseFileTest : public ::testing::Test {
 protected:
  void Write(const std::string& text, const char* name = kDatabaseFile, int mode = 0600) {
    ASSERT_TRUE(WriteFileDurably(folder_.path() / name, AsBytes(text), mode).ok());
  }
  void CopyGolden(const char* golden, const char* name) {
    Write(std::string(AsText(*ReadFile(kGolden / golden))), name);
  }
  Status Refusal(const std::string& text) {
    Write(text);
    return ReadDatabaseFile(folder_.path()).status();
  }
  test::TempFolder folder_;
};

TEST_F(DatabaseFileTest, GoldenFileIsReadAndWrittenAgain) {
  EXPECT_FALSE(ReadDatabaseFile(folder_.path())->has_value());
  CopyGolden("database.json", kDatabaseFile);
  const auto all = ReadDatabaseFile(folder_.path());
  ASSERT_TRUE(all.ok()) << all.status().message();
  EXPECT_EQ((*all)->server, "postgresql://enamel@db1,db2/school?sslmode=verify-full");
  EXPECT_EQ((*all)->schema, "enamel");
  const PlaceInS3 blobs{"https://s3.example.org:9000", "eu-central-1", "enamel-blobs", "school/",
                        "/etc/enamel/s3.crt",          "s3.json"};
  EXPECT_EQ((*all)->blobs, blobs);
  const KeysInS3 keys{{"https://s3.example.org:9000", "eu-central-1", "enamel-keys", "school/",
                       "/etc/enamel/s3.crt", "s3_keys.json"},
                      "/etc/enamel/master.key"};
  EXPECT_EQ((*all)->keys, keys);
  DatabaseFile rows = **all, rows_and_blobs = **all;
  rows.blobs.reset();
  rows.keys.reset();
  rows_and_blobs.keys.reset();
  for (const DatabaseFile& file : {rows, rows_and_blobs, **all}) {
    const test::TempFolder other;
    ASSERT_TRUE(WriteDatabaseFile(other.path(), file, SystemDisk()).ok());
    EXPECT_EQ(**ReadDatabaseFile(other.path()), file);
  }
}

TEST_F(DatabaseFileTest, APasswordThatOthersMayReadIsRefused) {
  const auto with = [](const std::string& server) {
    return kBegin + R"("server":")" + server + R"(","schema":"enamel"})";
  };
  for (const char* server :
       {"host=localhost password=secret", "postgresql://a:secret@localhost/b"}) {
    Write(with(server), kDatabaseFile, 0644);
    const Status open = ReadDatabaseFile(folder_.path()).status();
    EXPECT_EQ(open.code(), Code::kForbidden) << open.message();
    EXPECT_EQ(open.message().find("secret"), std::string::npos);
    std::filesystem::permissions(folder_.path() / kDatabaseFile, std::filesystem::perms(0600));
    EXPECT_TRUE(ReadDatabaseFile(folder_.path()).ok());
  }
  Write(with("postgresql://a@localhost/b"), kDatabaseFile, 0644);
  EXPECT_TRUE(ReadDatabaseFile(folder_.path()).ok()) << "nothing to hide";
}

TEST_F(DatabaseFileTest, KeysBesideTheBlobsOrWithoutAMasterKeyAreRefused) {
  const std::string begin =
      kBegin +
      R"("server":"host=a","schema":"s","blobs":{"endpoint":"https://a","bucket":"b"},"keys":)";
  EXPECT_TRUE(
      Refusal(begin + R"({"endpoint":"https://a","bucket":"c","master_key_file":"m"}})").ok());
  for (const char* keys : {R"({"endpoint":"https://a","bucket":"b","master_key_file":"m"}})",
                           R"({"endpoint":"https://a","bucket":"c"}})", "1}"}) {
    EXPECT_EQ(Refusal(begin + keys).code(), Code::kInvalidInput) << keys;
  }
}

TEST_F(DatabaseFileTest, BlobsInS3WithRowsInSqliteAreRefused) {
  const Status status =
      Refusal(kBegin + R"("blobs":{"endpoint":"https://s3.example.org","bucket":"b"}})");
  EXPECT_EQ(status.code(), Code::kInvalidInput);
  EXPECT_NE(status.message().find("enamel.db are one machine's"), std::string::npos)
      << status.message();
  StoreOptions options;
  options.folder = folder_.path();
  EXPECT_EQ(OpenStore(options).status().code(), Code::kInvalidInput);
}

TEST_F(DatabaseFileTest, WhatAnotherServerWouldPassOverIsRefused) {
  const std::string rows = R"("server":"host=a","schema":"s")";
  EXPECT_TRUE(Refusal(kBegin + rows + "}").ok());
  EXPECT_EQ(Refusal(R"({"format":"enamel-database","version":2,)" + rows + "}").code(),
            Code::kVersion);
  for (const char* begin : {"{", R"({"version":1,)", R"({"format":"enamel-database",)",
                            R"({"format":"another","version":1,)"}) {
    EXPECT_EQ(Refusal(begin + rows + "}").code(), Code::kInvalidInput) << begin;
  }
  for (const std::string& blobs : {std::string("1"), std::string("{}"),
                                   std::string(R"({"endpoint":"https://s3.example.org"})"),
                                   std::string(R"({"endpoint":1,"bucket":"b"})"),
                                   std::string(R"({"endpoint":"","bucket":"b"})")}) {
    EXPECT_EQ(Refusal(kBegin + rows + R"(,"blobs":)" + blobs + "}").code(), Code::kInvalidInput)
        << blobs;
  }
}

TEST_F(DatabaseFileTest, CredentialsAreReadFromAFileThatOthersMayNotRead) {
  PlaceInS3 blobs{"https://s3.example.org", "", "b", "", "ca.pem", "s3.json"};
  EXPECT_EQ(ReadS3Place(folder_.path(), blobs).status().code(), Code::kNotFound);
  CopyGolden("database_credentials.json", "s3.json");
  const auto place = ReadS3Place(folder_.path(), blobs);
  ASSERT_TRUE(place.ok()) << place.status().message();
  EXPECT_EQ(place->store.credentials.access_key, "AKIAIOSFODNN7EXAMPLE");
  EXPECT_EQ(place->store.credentials.secret_key, "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY");
  EXPECT_EQ(place->store.region, "us-east-1");
  EXPECT_EQ(place->store.ca_file, folder_.path() / "ca.pem");
  std::filesystem::permissions(folder_.path() / "s3.json", std::filesystem::perms(0640));
  const Status open = ReadS3Place(folder_.path(), blobs).status();
  EXPECT_EQ(open.code(), Code::kForbidden);
  EXPECT_NE(open.message().find("chmod 600"), std::string::npos);
  EXPECT_EQ(open.message().find("wJalr"), std::string::npos);
}

TEST_F(DatabaseFileTest, CredentialsMayBeOfTheEnvironment) {
  const PlaceInS3 blobs{"https://s3.example.org", "", "b", "", "", ""};
  ::unsetenv("AWS_ACCESS_KEY_ID");
  EXPECT_EQ(ReadS3Place(folder_.path(), blobs).status().field(), "credentials");
  ::setenv("AWS_ACCESS_KEY_ID", "key", 1);
  ::setenv("AWS_SECRET_ACCESS_KEY", "secret", 1);
  EXPECT_EQ(ReadS3Place(folder_.path(), blobs)->store.credentials.secret_key, "secret");
  ::unsetenv("AWS_ACCESS_KEY_ID");
  ::unsetenv("AWS_SECRET_ACCESS_KEY");
}

TEST_F(DatabaseFileTest, PrefixOfOtherSignsIsRefused) {
  CopyGolden("database_credentials.json", "s3.json");
  for (const std::string& prefix : {std::string("/a"), std::string("a b"), std::string(201, 'a')}) {
    EXPECT_EQ(
        ReadS3Place(folder_.path(), {"https://a", "", "b", prefix, "", "s3.json"}).status().field(),
        "prefix");
  }
}

TEST_F(DatabaseFileTest, FolderStaysWithItsStoreOfBlobs) {
  DatabaseFile file{"host=a", "s"};
  ASSERT_TRUE(WriteDatabaseFile(folder_.path(), file, SystemDisk()).ok());
  file.blobs = PlaceInS3{"https://s3.example.org", "", "b", "", "", ""};
  EXPECT_EQ(MayKeepRowsIn(folder_.path(), file).code(), Code::kConflict);
}

TEST_F(DatabaseFileTest, StoreIsTriedWithAnObjectThatGoesAgain) {
  test::S3StandIn s3;
  S3Place place;
  place.store = s3.options();
  place.prefix = "p/";
  const Status tried = TryS3Place(place);
  EXPECT_TRUE(tried.ok()) << tried.message();
  EXPECT_TRUE(s3.objects().empty());
  s3.FailNext(test::S3StandIn::Fault::kForbidden, -1, "DELETE");
  EXPECT_EQ(TryS3Place(place).code(), Code::kStorage) << "a key that may not delete";
}

}  // namespace
}  // namespace enamel::server
