#include "common/protocol/release.h"

#include <gtest/gtest.h>

namespace enamel::protocol {
namespace {

TEST(ReleaseTest, OneMinorVersionApartMeet) {
  for (const char* station : {"0.9.0", "0.10.0", "0.10.99", "0.11.3", ""})
    EXPECT_TRUE(MayMeet("0.10.1", station).ok()) << station;
  EXPECT_TRUE(MayMeet("1.0.0", "1.1.0").ok());
}

TEST(ReleaseTest, FurtherApartTheErrorSaysWhichIsWhichAndWhatToInstallWhere) {
  const Status old = MayMeet("0.11.2", "0.9.4");
  EXPECT_EQ(old.code(), Code::kVersion);
  EXPECT_EQ(old.field(), "release");
  EXPECT_EQ(old.message(),
            "this server is Enamel 0.11.2, the station 0.9.4; they may be one minor version apart: "
            "install Enamel 0.11.2 at the station, which keeps its recordings and sends them then");
  EXPECT_EQ(MayMeet("0.9.4", "0.11.2").message(),
            "this server is Enamel 0.9.4, the station 0.11.2; they may be one minor version apart: "
            "install Enamel 0.9.4 at the station, or update the server first");
}

TEST(ReleaseTest, AnotherMajorVersionIsFurtherApart) {
  EXPECT_EQ(MayMeet("1.0.0", "0.9.0").code(), Code::kVersion);
  EXPECT_EQ(MayMeet("1.1.0", "2.1.0").code(), Code::kVersion);
}

TEST(ReleaseTest, WhatIsNoReleaseIsRefused) {
  for (const char* station :
       {"0.9", "0.9.0 ", "v0.9.0", "0.9.-1", "0..0", "0.9.0.0", "0.99999999999999.0"})
    EXPECT_EQ(MayMeet("0.9.0", station).code(), Code::kInvalidInput) << station;
}

TEST(ReleaseTest, ThisProgramsReleaseMeetsItself) {
  EXPECT_TRUE(MayMeet(ThisRelease(), ThisRelease()).ok());
  EXPECT_FALSE(ThisRelease().empty());
}

}  // namespace
}  // namespace enamel::protocol
