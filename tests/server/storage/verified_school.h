#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "server/storage/verify/verify.h"
#include "tests/server/storage/recorded_attempt.h"

// A data folder that `verify` finds whole, and ways to edit it behind the store's back.
namespace enamel::server::testing {

namespace fs = std::filesystem;

class VerifyTest : public ::testing::Test {
 protected:
  VerifyTest() {
    scored_ = school_.Record(3);
    school_.Score(scored_);
    open_ = school_.Record(2);
  }

  fs::path Data() const { return folder_.path() / "data"; }
  VerifyReport Look() {
    auto report = Verify({Data(), {}, {}});
    EXPECT_TRUE(report.ok()) << report.status().message();
    return report.ok() ? *report : VerifyReport();
  }
  // The one finding there is, which must be of this kind and name this object.
  void ExpectOnly(const std::string& kind, const std::string& object) {
    VerifyReport report = Look();
    ASSERT_FALSE(report.findings.empty());
    for (const Finding& finding : report.findings) {
      EXPECT_EQ(finding.kind, kind) << finding.expected << " / " << finding.found;
      EXPECT_EQ(finding.object, object) << finding.expected << " / " << finding.found;
      EXPECT_FALSE(finding.remedy.empty());
    }
  }
  // Among others.
  void ExpectFound(const std::string& kind, const std::string& object) {
    const VerifyReport report = Look();
    EXPECT_TRUE(std::ranges::any_of(
        report.findings,
        [&](const Finding& finding) { return finding.kind == kind && finding.object == object; }))
        << kind << " " << object;
  }
  void Sql(const std::string& sql) {
    sqlite3* handle = nullptr;
    ASSERT_EQ(sqlite3_open((Data() / "enamel.db").c_str(), &handle), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(handle);
    EXPECT_GT(sqlite3_total_changes(handle), 0) << sql;
    sqlite3_close(handle);
  }
  static std::string Told(const VerifyReport& report) {
    std::string out = "found:";
    for (const Finding& finding : report.findings)
      out += "\n" + finding.kind + " " + finding.object + ": " + finding.expected;
    return out;
  }
  fs::path Blob(const Sha256& hash) const {
    return Data() / "blobs" / hash.Hex().substr(0, 2) / hash.Hex();
  }
  static std::string Id(const Uuid& id) {
    std::string hex = id.Text();
    std::erase(hex, '-');
    return "x'" + hex + "'";
  }

  TempFolder folder_;
  RecordedSchool school_{folder_.path() / "data"};
  Uuid scored_, open_;
};

}  // namespace enamel::server::testing
