#include "common/protocol/station_policy.h"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "common/base/file.h"

namespace enamel::protocol {
namespace {

TEST(StationPolicyTest, ValuesAreTakenOrRefusedWithWhatWasExpected) {
  for (const auto& [name, value] : {std::pair{"language", "de"},
                                    {"window", "1280x720"},
                                    {"keep-days", "7"},
                                    {"idle-minutes", "1440"},
                                    {"uplink-kbit", "0"},
                                    {"log-level", "debug"}}) {
    EXPECT_TRUE(CheckPolicySetting(name, value).ok()) << name << value;
  }
  for (const auto& [name, value, said] : {std::tuple{"language", "fr", "one of en, de, zh"},
                                          {"window", "wide", "1280x720"},
                                          {"keep-days", "6", "from 7 to 3650"},
                                          {"keep-days", "7.5", "an integer"},
                                          {"idle-minutes", "", "an integer"},
                                          {"uplink-kbit", "-1", "from 0"}}) {
    const Status refused = CheckPolicySetting(name, value);
    EXPECT_EQ(refused.field(), "value") << name << value;
    EXPECT_NE(refused.message().find(said), std::string::npos) << refused.message();
  }
}

TEST(StationPolicyTest, WhatAChairIsAndWhereItsServerIsAreNotForAPolicy) {
  for (const char* name : {"data", "server", "profile", "cpu", "config", "moon"}) {
    const Status refused = CheckPolicySetting(name, "1");
    EXPECT_EQ(refused.field(), "name") << name;
    EXPECT_NE(refused.message().find("keep-days"), std::string::npos) << refused.message();
  }
}

TEST(StationPolicyTest, AScopeIsANameOrItsBeginning) {
  EXPECT_TRUE(IsInScope("*", "lab2-07"));
  EXPECT_TRUE(IsInScope("lab2-*", "lab2-07"));
  EXPECT_TRUE(IsInScope("lab2-07", "lab2-07"));
  EXPECT_FALSE(IsInScope("lab2-0", "lab2-07"));
  EXPECT_FALSE(IsInScope("lab3-*", "lab2-07"));
}

TEST(StationPolicyTest, TheFileIsThatOfTheGoldenOneAndWhatItAddsIsIgnored) {
  const auto golden =
      ReadFile(std::string(ENAMEL_SOURCE_DIR) + "/schemas/golden/station_policy.json");
  ASSERT_TRUE(golden.ok());
  auto policy = PolicyFromJson(AsText(*golden));
  ASSERT_TRUE(policy.ok()) << policy.status().message();
  ASSERT_EQ(policy->settings_size(), 2);
  EXPECT_EQ(policy->settings(0).name(), "keep-days");
  EXPECT_EQ(policy->settings(0).value(), "30");
  EXPECT_TRUE(policy->settings(0).fixed());
  EXPECT_FALSE(policy->settings(1).fixed());
  const std::string again = PolicyJson(*policy);
  EXPECT_EQ(again, AsText(*golden));
  EXPECT_EQ(PolicyFromJson(R"({"later": [1], "settings": []})")->settings_size(), 0);
  EXPECT_EQ(PolicyFromJson("{").status().code(), Code::kInvalidInput);
}

}  // namespace
}  // namespace enamel::protocol
