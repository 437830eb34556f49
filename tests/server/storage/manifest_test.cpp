#include "server/storage/verify/manifest.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

namespace enamel::server {
namespace {

namespace json = boost::json;

const std::string kHash(64, 'a');

json::object Good() {
  return {{"format", "enamel-server-backup"},
          {"version", 1},
          {"created_ms", 1'700'000'000'000},
          {"software", "enamel-server 0.1.0"},
          {"schema", 2},
          {"keyring", "inside"},
          {"counts", {{"people", 1}, {"attempts", 2}, {"ticks", 3}}},
          {"trail", json::array()},
          {"files", json::array{{{"path", "blobs/aa/" + kHash}, {"bytes", 7}, {"sha256", kHash}},
                                {{"path", "enamel.db"}, {"bytes", 8}, {"sha256", kHash}}}}};
}

Status Refusal(const json::object& manifest) {
  return ManifestFromJson(json::serialize(manifest)).status();
}

TEST(ManifestTest, ReadsWhatItWrites) {
  auto read = ManifestFromJson(json::serialize(Good()));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->files.size(), 2u);
  EXPECT_EQ(read->ticks, 3u);
  auto again = ManifestFromJson(ToJson(*read));
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_EQ(ToJson(*again), ToJson(*read));
}

TEST(ManifestTest, IgnoresUnknownMembersAndRefusesUnknownVersions) {
  json::object more = Good();
  more["more"] = 1;
  EXPECT_TRUE(Refusal(more).ok());
  more["version"] = 2;
  EXPECT_EQ(Refusal(more).code(), Code::kVersion);
}

TEST(ManifestTest, PathsLeadNowhereButIntoADataFolder) {
  for (const char* path : {"../enamel.db", "/etc/passwd", "blobs/../x", "blobs/ab/cd", "LOCK",
                           "keyring/../x.key", "", "enamel.db/", "keyring/gone/..",
                           "blobs/aa/aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
                           "aaaaaaaaaaaaaa/",
                           "RESTORE-UNFINISHED"}) {
    json::object bad = Good();
    bad["files"] = json::array{{{"path", path}, {"bytes", 1}, {"sha256", kHash}}};
    EXPECT_EQ(Refusal(bad).code(), Code::kInvalidInput) << path;
  }
}

TEST(ManifestTest, WhatIsNoManifestIsRefusedWithTheMember) {
  for (const char* member : {"format", "version", "created_ms", "software", "schema", "keyring",
                             "counts", "trail", "files"}) {
    json::object without = Good(), other = Good();
    without.erase(member);
    other[member] = nullptr;
    EXPECT_NE(Refusal(without).message().find(member), std::string::npos) << member;
    EXPECT_FALSE(Refusal(other).ok()) << member;
  }
  for (const char* text : {"", "[]", "{", "null", "{} {}"}) {
    EXPECT_FALSE(ManifestFromJson(text).ok()) << text;
  }
}

TEST(ManifestTest, FilesStandInOrderAndOnce) {
  json::object bad = Good();
  json::array& files = bad["files"].as_array();
  std::swap(files[0], files[1]);
  EXPECT_FALSE(Refusal(bad).ok());
  files[1] = files[0];
  EXPECT_FALSE(Refusal(bad).ok());
}

}  // namespace
}  // namespace enamel::server
