#include <gtest/gtest.h>

#include <algorithm>

#include "server/stations/session.h"
#include "tests/server/stations/link_world.h"

// A second person signs an exam attempt at the chair.
namespace enamel::server::stations {
namespace {

using namespace testing;

class SignOffTest : public StudentAtStation {
 protected:
  SignOffTest() {
    Require(true);
    world_.GivePin(world_.instructor);
  }

  void Require(bool sign_off) {
    auto row = world_.store->assignments.AssignmentsFor(world_.student)->front().assignment;
    row.exam = true;
    row.sign_off = sign_off;
    row.hands = HandsAllowed::kAny;
    auto changed = world_.store->assignments.ReplaceAssignment(row, kSystem);
    ASSERT_TRUE(changed.ok()) << changed.status().message();
  }
  Uuid AddInstructor(const std::string& login, bool of_cohort) {
    const Uuid id = AddPerson(*world_.store, login, Role::kInstructor, world_.verifier);
    if (of_cohort) EXPECT_TRUE(world_.store->cohorts.AddToCohort(world_.cohort, id, kSystem).ok());
    world_.GivePin(id);
    return id;
  }
  Recording Begin() {
    auto reply = station_.RequestTicket(world_.exercise.content, profile_);
    EXPECT_TRUE(reply.has_ticket_issued()) << reply.error().message();
    ticket_ = reply.ticket_issued();
    return Recording(world_, TicketOf(reply), station_.keys, 1);
  }
  wire::Reply Sign(const Recording& recording, const std::string& at,
                   const std::string& login = "instructor", const std::string& pin = kPin) {
    return station_.SignOff(recording.seal.attempt, at, login, pin);
  }
  std::vector<SignOffRow> SignaturesOf(const Recording& recording) {
    return *world_.store->sign_offs.SignOffsOf(recording.seal.attempt);
  }
  void Send(const Recording& recording) {
    auto opened = station_.Open(recording.header);
    ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
    ASSERT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
  }
  std::string CodeOf(const wire::Reply& reply) {
    return reply.has_error() ? reply.error().code() : "ok";
  }

  wire::TicketIssued ticket_;
};

TEST_F(SignOffTest, StartAndEndAreSignedAndKeptWithWhoAndWhen) {
  Recording recording = Begin();
  EXPECT_TRUE(ticket_.sign_off());
  const UnixMs began = world_.now;
  auto signed_off = Sign(recording, "start");
  ASSERT_TRUE(signed_off.has_signed_off()) << signed_off.error().message();
  EXPECT_EQ(signed_off.signed_off().display_name(), "Name of instructor");
  Send(recording);
  world_.now += 5000;
  ASSERT_TRUE(Sign(recording, "end").has_signed_off());
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());

  const auto rows = SignaturesOf(recording);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at, SignedAt::kStart);
  EXPECT_EQ(rows[0].signer, world_.instructor);
  EXPECT_EQ(rows[0].signed_ms, began);
  EXPECT_EQ(rows[1].at, SignedAt::kEnd);
  EXPECT_EQ(rows[1].signed_ms, began + 5000);
  AuditFilter filter;
  filter.action = "attempt.sign_off";
  filter.object = recording.seal.attempt.Text();
  const auto audit = *world_.store->audit.FindAudit(filter);
  ASSERT_EQ(audit.size(), 2u);
  EXPECT_EQ(audit[0].via, "station scripted");
  EXPECT_NE(audit[0].actor.find(world_.instructor.Text()), std::string::npos);
}

TEST_F(SignOffTest, AttemptWhoseStartIsNotSignedIsRefused) {
  Recording recording = Begin();
  auto opened = station_.Open(recording.header);
  EXPECT_EQ(opened.error().code(), "forbidden");
  EXPECT_EQ(opened.error().field(), "sign_off");
  EXPECT_EQ(CodeOf(Sign(recording, "end")), "conflict") << "an end before the start";
  EXPECT_EQ(CodeOf(station_.Open(recording.header)), "forbidden");
  ASSERT_EQ(CodeOf(Sign(recording, "start")), "ok");
  EXPECT_EQ(CodeOf(station_.Open(recording.header)), "ok");
}

TEST_F(SignOffTest, AttemptWhoseEndIsNotSignedIsKept) {
  Recording recording = Begin();
  ASSERT_EQ(CodeOf(Sign(recording, "start")), "ok");
  Send(recording);
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  EXPECT_EQ(SignaturesOf(recording).size(), 1u);
  EXPECT_EQ(CodeOf(Sign(recording, "end")), "conflict") << "what is handed in is not signed later";
  EXPECT_EQ(SignaturesOf(recording).size(), 1u);
}

TEST_F(SignOffTest, WrongPinNoPinAndUnknownLoginGetTheSameAnswer) {
  AddPerson(*world_.store, "colleague", Role::kInstructor, world_.verifier);
  Recording recording = Begin();
  const auto wrong = Sign(recording, "start", "instructor", "804218").error();
  EXPECT_EQ(wrong.code(), "unauthenticated");
  for (const auto& [login, pin] : {std::pair{"colleague", ""},
                                   {"colleague", kPin},
                                   {"nobody", kPin},
                                   {"instructor", kPassword}}) {
    const auto error = Sign(recording, "start", login, pin).error();
    EXPECT_EQ(error.code(), wrong.code()) << login;
    EXPECT_EQ(error.message(), wrong.message()) << login;
  }
  EXPECT_TRUE(SignaturesOf(recording).empty());
  EXPECT_EQ(station_.SignIn("instructor", kPin).error().code(), "unauthenticated")
      << "a PIN signs and does nothing else";
}

TEST_F(SignOffTest, WrongPinsSlowDownAsWrongPasswordsDoAndAreAudited) {
  Recording recording = Begin();
  int checked = 0;
  while (CodeOf(Sign(recording, "start", "instructor", "804218")) == "unauthenticated") ++checked;
  EXPECT_EQ(checked, 6) << "five are free (throttle.h)";
  const auto waits = Sign(recording, "start").error();
  EXPECT_EQ(waits.code(), "unavailable") << "not even the right one";
  EXPECT_EQ(waits.field(), "throttled");
  world_.authenticator.refusals().Settle();
  AuditFilter filter;
  filter.action = "session.refused";
  filter.object = world_.instructor.Text();
  const auto audit = *world_.store->audit.FindAudit(filter);
  EXPECT_TRUE(std::ranges::any_of(audit, [](const AuditRow& row) {
    return row.after_json.find(R"("reason":"pin")") != std::string::npos;
  }));
}

TEST_F(SignOffTest, LockedPinSignsNothingAndTheChairSaysWhatToDo) {
  Recording recording = Begin();
  for (int i = 0; i < 10; ++i) (void)world_.store->people.TryPin(world_.instructor);
  const auto locked = Sign(recording, "start").error();
  EXPECT_EQ(locked.code(), "forbidden");
  EXPECT_EQ(locked.field(), "pin_locked");
  EXPECT_TRUE(SignaturesOf(recording).empty());
  AddInstructor("colleague", true);
  EXPECT_EQ(CodeOf(Sign(recording, "start", "colleague")), "ok") << "the exam can go on";
}

TEST_F(SignOffTest, OnlyStaffOfTheCohortSignAndNeverTheStudent) {
  // The student is in that instructor's cohort too, which the exam was not assigned to.
  const Uuid elsewhere = AddInstructor("elsewhere", false);
  const Uuid other = *world_.store->cohorts.CreateCohort("year 2", kSystem);
  for (const Uuid& person : {elsewhere, world_.student}) {
    ASSERT_TRUE(world_.store->cohorts.AddToCohort(other, person, kSystem).ok());
  }
  world_.GivePin(world_.student);
  Recording recording = Begin();
  for (const char* login : {"elsewhere", "student"}) {
    const auto error = Sign(recording, "start", login).error();
    EXPECT_EQ(error.code(), "forbidden") << login;
    EXPECT_EQ(error.field(), "signer") << login;
  }
  const Uuid admin = AddPerson(*world_.store, "admin", Role::kAdmin, world_.verifier);
  world_.GivePin(admin);
  EXPECT_EQ(CodeOf(Sign(recording, "start", "admin")), "ok");
}

TEST_F(SignOffTest, DisabledSignerAndOneWithAOneTimePasswordAreRefused) {
  Recording recording = Begin();
  ASSERT_TRUE(
      world_.store->people.SetPassword(world_.instructor, world_.verifier, true, kSystem).ok());
  EXPECT_EQ(CodeOf(Sign(recording, "start")), "unauthenticated");
  ASSERT_TRUE(
      world_.store->people.SetPassword(world_.instructor, world_.verifier, false, kSystem).ok());
  ASSERT_TRUE(world_.store->people.SetDisabled(world_.instructor, true, kSystem).ok());
  EXPECT_EQ(CodeOf(Sign(recording, "start")), "unauthenticated");
}

TEST_F(SignOffTest, SignerWhoseAnswerWasLostSignsAgainAndNobodyElseDoes) {
  AddInstructor("colleague", true);
  Recording recording = Begin();
  ASSERT_EQ(CodeOf(Sign(recording, "start")), "ok");
  world_.now += 1000;
  EXPECT_EQ(CodeOf(Sign(recording, "start")), "ok");
  EXPECT_EQ(CodeOf(Sign(recording, "start", "colleague")), "conflict");
  ASSERT_EQ(SignaturesOf(recording).size(), 1u);
  EXPECT_EQ(SignaturesOf(recording)[0].signed_ms, world_.now - 1000) << "the first one counts";
  Send(recording);
  EXPECT_EQ(CodeOf(Sign(recording, "end", "colleague")), "ok") << "another may sign the end";
}

TEST_F(SignOffTest, TermsAreThoseOfTheTicket) {
  Require(false);
  Recording unsigned_one = Begin();
  EXPECT_FALSE(ticket_.sign_off());
  EXPECT_EQ(CodeOf(Sign(unsigned_one, "start")), "conflict");
  Require(true);
  Send(unsigned_one);
}

TEST_F(SignOffTest, StartIsSignedWhileTheTicketIsValid) {
  Recording recording = Begin();
  world_.now += kExamTicketValidMs + 1;
  EXPECT_EQ(CodeOf(Sign(recording, "start")), "conflict");
  world_.now -= 1;
  EXPECT_EQ(CodeOf(Sign(recording, "start")), "ok");
}

TEST_F(SignOffTest, ReturnedTicketAndAnotherStationsAttemptAreNotSigned) {
  Recording recording = Begin();
  ASSERT_TRUE(station_.ReturnTicket(recording.seal.attempt).has_ticket_returned());
  EXPECT_EQ(CodeOf(Sign(recording, "start")), "conflict");
  EXPECT_EQ(CodeOf(station_.SignOff(Uuid::New(), "start", "instructor", kPin)), "not_found");
  EXPECT_EQ(CodeOf(Sign(recording, "middle")), "invalid_input");
}

TEST_F(SignOffTest, ErasureOfTheSignerTakesTheNameAndOfTheStudentTheSignature) {
  Recording recording = Begin();
  ASSERT_EQ(CodeOf(Sign(recording, "start")), "ok");
  ASSERT_TRUE(world_.store->erasures.ErasePerson(world_.instructor, false, kSystem).ok());
  ASSERT_EQ(SignaturesOf(recording).size(), 1u);
  EXPECT_EQ(SignaturesOf(recording)[0].signer_name, "");
  auto erased = world_.store->erasures.ErasePerson(world_.student, false, kSystem);
  ASSERT_TRUE(erased.ok()) << erased.status().message();
  EXPECT_TRUE(SignaturesOf(recording).empty());
}

// A restore has lost the signatures too; the recording may be the only copy of an exam.
TEST_F(SignOffTest, AttemptThatARestoreForgotIsTakenUnsigned) {
  Recording recording = Begin();
  recording.header_fields.ticket.attempt = Uuid::New();
  trace::SignTicket(recording.header_fields.ticket, world_.services.ticket_key.secret_key);
  auto opened = station_.Open(trace::EncodeHeader(recording.header_fields));
  ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
  const auto row = *world_.store->attempts.AttemptById(recording.header_fields.ticket.attempt);
  EXPECT_TRUE(row.sign_off);
  EXPECT_NE(row.flags & kReadmitted, 0u);
}

}  // namespace
}  // namespace enamel::server::stations
