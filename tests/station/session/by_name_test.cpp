#include "station/session/by_name.h"

#include <gtest/gtest.h>

namespace enamel::station {
namespace {

Catalogue::Exercise Assigned(const char* name, int64_t due_unix_ms, const char* refusal = "") {
  Catalogue::Exercise e;
  e.name = name;
  e.assignment = Uuid::New();
  e.due_unix_ms = due_unix_ms;
  if (*refusal != 0) e.refusal = Status(Code::kForbidden, refusal, "due");
  return e;
}

Hand Held(HandKind kind) { return MakeHand(kind, "", ""); }

TEST(ByNameTest, OfSeveralAssignmentsTheOneDueFirstThatAllowsAnAttemptIsChosen) {
  std::vector<Catalogue::Exercise> all = {Assigned("a", 0), Assigned("a", 300),
                                          Assigned("a", 100, "no attempts left"),
                                          Assigned("a", 200), Assigned("b", 1)};
  auto chosen = ChooseByName(all, {"a", {}, {}});
  ASSERT_TRUE(chosen.ok());
  EXPECT_EQ(chosen->assignment, all[3].assignment);
}

TEST(ByNameTest, WhatCannotBeBegunIsSaidBeforeItIsTried) {
  auto chosen = ChooseByName({Assigned("a", 0, "it opens on Monday")}, {"a", {}, {}});
  ASSERT_FALSE(chosen.ok());
  EXPECT_EQ(chosen.status().code(), Code::kForbidden);
  EXPECT_NE(chosen.status().message().find("it opens on Monday"), std::string::npos);
}

TEST(ByNameTest, OfSeveralAssignmentsOneThatAdmitsTheHandIsChosen) {
  std::vector<Catalogue::Exercise> all = {Assigned("a", 100), Assigned("a", 200),
                                          Assigned("a", 300)};
  all[0].hands = HandsAllowed::kListed;
  all[1].hands = HandsAllowed::kPointer;
  auto chosen = [&](HandKind kind) {
    auto found = ChooseByName(all, {"a", {}, Held(kind)});
    EXPECT_TRUE(found.ok()) << found.status().message();
    return found.ok() ? found->assignment : Uuid{};
  };
  EXPECT_EQ(chosen(HandKind::kProgram), all[2].assignment);
  EXPECT_EQ(chosen(HandKind::kPointer), all[1].assignment);
  EXPECT_EQ(chosen(HandKind::kHaptic), all[0].assignment) << "the server knows its list";
  EXPECT_EQ(chosen(HandKind::kNotTold), all[0].assignment);
}

TEST(ByNameTest, OpenExamIsNotDodgedByAHandThatItDoesNotAdmit) {
  std::vector<Catalogue::Exercise> all = {Assigned("a", 100), Assigned("a", 200)};
  all[1].exam = true;
  all[1].hands = HandsAllowed::kListed;
  auto chosen = ChooseByName(all, {"a", {}, Held(HandKind::kProgram)});
  ASSERT_EQ(chosen.status().code(), Code::kForbidden);
  EXPECT_EQ(chosen.status().field(), "hand");
  EXPECT_NE(chosen.status().message().find(all[0].assignment.Text()), std::string::npos)
      << chosen.status().message();
  EXPECT_TRUE(ChooseByName(all, {"a", all[0].assignment, Held(HandKind::kProgram)}).ok());
  all[1].refusal = Status(Code::kForbidden, "it was due on Monday", "due");
  EXPECT_EQ(ChooseByName(all, {"a", {}, Held(HandKind::kProgram)})->assignment, all[0].assignment);
}

TEST(ByNameTest, EachReasonWhyNoneCanBeBegunIsSaidOnce) {
  std::vector<Catalogue::Exercise> all = {Assigned("a", 0, "it was due on Monday"),
                                          Assigned("a", 0, "it was due on Monday"),
                                          Assigned("a", 0)};
  all[2].hands = HandsAllowed::kHaptic;
  auto chosen = ChooseByName(all, {"a", {}, Held(HandKind::kProgram)});
  ASSERT_EQ(chosen.status().code(), Code::kForbidden);
  const std::string& text = chosen.status().message();
  EXPECT_NE(text.find("a simulated hand"), std::string::npos) << text;
  const size_t monday = text.find("due on Monday");
  ASSERT_NE(monday, std::string::npos) << text;
  EXPECT_EQ(text.find("due on Monday", monday + 1), std::string::npos) << text;
}

TEST(ByNameTest, NamedAssignmentIsTheOneThatIsChosen) {
  std::vector<Catalogue::Exercise> all = {Assigned("a", 100), Assigned("a", 200)};
  EXPECT_EQ(ChooseByName(all, {"a", all[1].assignment, {}})->assignment, all[1].assignment);
  auto none = ChooseByName(all, {"a", Uuid::New(), {}});
  EXPECT_EQ(none.status().code(), Code::kNotFound);
  EXPECT_EQ(none.status().field(), "assignment");
  EXPECT_NE(none.status().message().find(all[1].assignment.Text()), std::string::npos);
}

TEST(ByNameTest, AnUnknownNameIsAnsweredWithEachKnownOneOnce) {
  auto chosen = ChooseByName({Assigned("a", 0), Assigned("a", 1), Assigned("b", 0)}, {"c", {}, {}});
  ASSERT_FALSE(chosen.ok());
  EXPECT_EQ(chosen.status().code(), Code::kNotFound);
  EXPECT_NE(chosen.status().message().find("there are a, b"), std::string::npos)
      << chosen.status().message();
}

}  // namespace
}  // namespace enamel::station
