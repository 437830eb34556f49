#include "station/session/by_name.h"

#include <gtest/gtest.h>

namespace enamel::station {
namespace {

Catalogue::Exercise Assigned(const char* name, int64_t due_unix_ms, const char* refusal = "") {
  Catalogue::Exercise e;
  e.name = name;
  e.assignment = Uuid::New();
  e.due_unix_ms = due_unix_ms;
  e.refusal = refusal;
  return e;
}

TEST(ByNameTest, OfSeveralAssignmentsTheOneDueFirstThatAllowsAnAttemptIsChosen) {
  std::vector<Catalogue::Exercise> all = {Assigned("a", 0), Assigned("a", 300),
                                          Assigned("a", 100, "no attempts left"),
                                          Assigned("a", 200), Assigned("b", 1)};
  auto chosen = ChooseByName(all, "a");
  ASSERT_TRUE(chosen.ok());
  EXPECT_EQ(chosen->assignment, all[3].assignment);
}

TEST(ByNameTest, WhatCannotBeBegunIsSaidBeforeItIsTried) {
  auto chosen = ChooseByName({Assigned("a", 0, "it opens on Monday")}, "a");
  ASSERT_FALSE(chosen.ok());
  EXPECT_EQ(chosen.status().code(), Code::kForbidden);
  EXPECT_NE(chosen.status().message().find("it opens on Monday"), std::string::npos);
}

TEST(ByNameTest, AnUnknownNameIsAnsweredWithEachKnownOneOnce) {
  auto chosen = ChooseByName({Assigned("a", 0), Assigned("a", 1), Assigned("b", 0)}, "c");
  ASSERT_FALSE(chosen.ok());
  EXPECT_EQ(chosen.status().code(), Code::kNotFound);
  EXPECT_NE(chosen.status().message().find("there are a, b"), std::string::npos)
      << chosen.status().message();
}

}  // namespace
}  // namespace enamel::station
