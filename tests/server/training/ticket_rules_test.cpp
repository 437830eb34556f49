#include "server/training/ticket_rules.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

constexpr UnixMs kMinute = 60'000, kHour = 60 * kMinute;
// 2026-11-20 09:05 UTC: 20777 days after the epoch (date -u -d 2026-11-20 +%s).
constexpr UnixMs kNow = 20'777ll * 24 * kHour + 9 * kHour + 5 * kMinute;

Uuid Id(uint8_t n) {
  Uuid out;
  out.bytes[0] = n;
  return out;
}

AssignedRow Row() {
  AssignedRow out;
  out.assignment.id = Id(1);
  out.exercise.title = "Occlusal cavity";
  out.exercise.content = HashSha256(AsBytes("content"));
  return out;
}

Status Ask(const AssignedRow& row, std::optional<Uuid> station = Id(9)) {
  return MayBegin(row, kNow, station, "Bench 1, Bench 2");
}

TEST(TimeTextTest, IsReadBackToTheMinute) {
  EXPECT_EQ(TimeText(kNow), "2026-11-20 09:05 UTC");
  EXPECT_EQ(TimeText(1'709'164'740'000), "2024-02-28 23:59 UTC");
  for (const char* text : {"2026-11-20T09:05Z", "2026-11-20 09:05 UTC"}) {
    EXPECT_EQ(*TimeFromText(text), kNow) << text;
  }
  for (const char* text : {"", "tomorrow", "2026-11-20", "2026-02-30 10:00", "2026-11-20 24:00",
                           "2026-11-20 09:60", "2026-11-20 09:05 CET", "2026-11-20x09:05"}) {
    EXPECT_EQ(TimeFromText(text).status().code(), Code::kInvalidInput) << text;
  }
}

TEST(TimeTextTest, IsLocalUnlessItNamesItsZone) {
  ASSERT_EQ(setenv("TZ", "CET-1CEST,M3.5.0,M10.5.0/3", 1), 0);
  tzset();
  EXPECT_EQ(*TimeFromText("2026-11-20 10:05"), kNow) << "winter";
  EXPECT_EQ(*TimeFromText("2026-07-20 11:05"), *TimeFromText("2026-07-20 09:05Z")) << "summer";
  EXPECT_EQ(*TimeFromText("2026-11-20 10:05+01:00"), kNow);
  EXPECT_EQ(*TimeFromText("2026-11-20T14:35+05:30"), kNow);
  EXPECT_EQ(*TimeFromText("2026-11-20 04:05-05:00"), kNow);
  for (const char* text : {"2026-11-20 09:05+1", "2026-11-20 09:05+15:00",
                           "2026-11-20 09:05+01:00 CET", "2026-11-20 09:05 +01:00"}) {
    EXPECT_EQ(TimeFromText(text).status().code(), Code::kInvalidInput) << text;
  }
  ASSERT_EQ(setenv("TZ", "UTC", 1), 0);
  tzset();
}

TEST(TicketRulesTest, OpensAndIsDueToTheMillisecond) {
  AssignedRow row = Row();
  EXPECT_TRUE(Ask(row).ok());
  row.assignment.opens_ms = kNow;
  EXPECT_TRUE(Ask(row).ok());
  row.assignment.opens_ms = kNow + 1;
  EXPECT_EQ(Ask(row).field(), "opens");
  row.assignment.opens_ms = 0;
  row.assignment.due_ms = kNow;
  EXPECT_TRUE(Ask(row).ok());
  row.assignment.due_ms = kNow - 1;
  EXPECT_EQ(Ask(row).field(), "due");
  row.assignment.late_allowed = true;
  EXPECT_TRUE(Ask(row).ok());
  EXPECT_TRUE(IsLate(row.assignment, kNow));
}

TEST(TicketRulesTest, RefusalSaysWhatWhenAndWhatToDo) {
  AssignedRow row = Row();
  row.assignment.opens_ms = kNow + kHour;
  EXPECT_EQ(Ask(row).message(),
            "\"Occlusal cavity\" opens 2026-11-20 10:05 UTC, it is 2026-11-20 09:05 UTC; come back "
            "then");
  row = Row();
  row.assignment.attempt_limit = row.attempts_used = 2;
  EXPECT_EQ(Ask(row).field(), "attempt_limit");
  EXPECT_NE(Ask(row).message().find("allows 2 attempts, 2 are used"), std::string::npos);
  row.attempts_used = 1;
  EXPECT_TRUE(Ask(row).ok());
}

TEST(TicketRulesTest, GradedWorkAndExamsNeedAReferenceAndPracticeDoesNot) {
  ExerciseRow version;
  version.name = "class-1";
  version.version = 2;
  for (const bool exam : {false, true}) {
    for (const bool graded : {false, true}) {
      version.graded = graded;
      EXPECT_TRUE(CheckReference(exam, version, true).ok());
      Status without = CheckReference(exam, version, false);
      EXPECT_EQ(without.ok(), !exam && !graded);
      if (without.ok()) continue;
      EXPECT_EQ(without.code(), Code::kConflict);
      EXPECT_EQ(without.field(), "reference");
      EXPECT_NE(without.message().find("version 2 of \"class-1\""), std::string::npos);
    }
  }
}

TEST(TicketRulesTest, ExamIsTakenWhereItIsSaid) {
  AssignedRow row = Row();
  row.assignment.exam = true;
  EXPECT_TRUE(Ask(row).ok()) << "anywhere";
  row.assignment.stations = {Id(7), Id(8)};
  EXPECT_EQ(Ask(row).field(), "stations");
  EXPECT_NE(Ask(row).message().find("Bench 1, Bench 2"), std::string::npos);
  EXPECT_TRUE(Ask(row, Id(8)).ok());
  EXPECT_TRUE(Ask(row, std::nullopt).ok()) << "asked from the page";
}

TEST(TicketRulesTest, FirstThatAllowsAnAttemptIsPickedAndElseTheFirst) {
  AssignedRow exam = Row(), practice = Row();
  exam.assignment.exam = true;
  practice.assignment.id = Id(2);
  std::vector<AssignedRow> rows{exam, practice};
  auto picked = [&](std::optional<Uuid> wanted = {}) {
    return PickAssignment(rows, exam.exercise.content, wanted, kNow, Id(9));
  };
  EXPECT_EQ(picked(), &rows[0]) << "saying nothing does not dodge an exam";
  EXPECT_EQ(picked(Id(2)), &rows[1]);
  rows[0].assignment.opens_ms = kNow + 1;
  EXPECT_EQ(picked(), &rows[1]);
  EXPECT_EQ(picked(Id(1)), &rows[0]) << "to be refused with its reason";
  rows[1].assignment.opens_ms = kNow + 1;
  EXPECT_EQ(picked(), &rows[0]);
  EXPECT_EQ(picked(Id(3)), nullptr);
  EXPECT_EQ(PickAssignment(rows, Sha256{}, {}, kNow, {}), nullptr);
}

TEST(TicketRulesTest, TicketEndsAtTheDueTimeAndAnExamsWithinMinutes) {
  EXPECT_EQ(TicketEnd(std::nullopt, kNow), kNow + 12 * kHour);
  AssignedRow assigned;
  AssignmentRow& row = assigned.assignment;
  EXPECT_EQ(TicketEnd(assigned, kNow), kNow + 12 * kHour);
  row.due_ms = kNow + kHour;
  EXPECT_EQ(TicketEnd(assigned, kNow), row.due_ms);
  row.exam = true;
  EXPECT_EQ(TicketEnd(assigned, kNow), kNow + 10 * kMinute);
  row.exam = false;
  row.late_allowed = true;
  EXPECT_EQ(TicketEnd(assigned, kNow), kNow + 12 * kHour);
}

TEST(TicketRulesTest, OutlineIsShownInPracticeUnlessTheAssignmentSaysOtherwise) {
  ExerciseRow practice, graded;
  practice.graded = false;
  graded.graded = true;
  EXPECT_TRUE(ShowsOutline(std::nullopt, practice));
  EXPECT_FALSE(ShowsOutline(std::nullopt, graded));
  for (const ExerciseRow& exercise : {practice, graded}) {
    for (bool exam : {false, true}) {
      AssignedRow assigned = Row();
      assigned.exercise = exercise;
      assigned.assignment.exam = exam;
      EXPECT_EQ(ShowsOutline(assigned, exercise), !exam && !exercise.graded);
      assigned.assignment.outline = OutlineShown::kAlways;
      EXPECT_TRUE(ShowsOutline(assigned, exercise));
      assigned.assignment.outline = OutlineShown::kNever;
      EXPECT_FALSE(ShowsOutline(assigned, exercise));
    }
  }
  EXPECT_FALSE(OutlineShownFromName("exam"));
}

TEST(TicketRulesTest, TermsThatContradictThemselvesAreRefused) {
  AssignmentRow row;
  row.opens_ms = kNow;
  EXPECT_TRUE(CheckTerms(row).ok());
  row.due_ms = kNow;
  EXPECT_EQ(CheckTerms(row).field(), "due_ms");
  row.due_ms = kNow + 1;
  row.stations = {Id(1)};
  EXPECT_EQ(CheckTerms(row).field(), "station_ids");
  row.stations = {};
  row.sign_off = true;
  EXPECT_EQ(CheckTerms(row).field(), "sign_off");
  row.exam = true;
  row.stations = {Id(1)};
  EXPECT_TRUE(CheckTerms(row).ok());
}

TEST(TicketRulesTest, FlagNamesAreReadBack) {
  for (uint32_t bit = 1; bit <= kReturned; bit <<= 1) {
    ASSERT_EQ(AttemptFlagNames(bit).size(), 1u) << bit;
    EXPECT_EQ(AttemptFlagFromName(AttemptFlagNames(bit).front()), static_cast<AttemptFlag>(bit));
  }
  EXPECT_TRUE(AttemptFlagNames(0).empty());
  EXPECT_EQ(AttemptFlagFromName("early"), std::nullopt);
}

}  // namespace
}  // namespace enamel::server
