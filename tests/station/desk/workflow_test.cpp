#include "station/desk/workflow.h"

#include <gtest/gtest.h>

#include "common/base/password.h"
#include "station/desk/first_password.h"
#include "tests/station/session/kept_attempt.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::desk {
namespace {

namespace fs = std::filesystem;
using Clock = Workflow::Clock;

constexpr char kPin[] = "804217";

// A separate workplace with a server on loopback; frames are calls of Tick.
class WorkflowTest : public testing::Test {
 protected:
  WorkflowTest() {
    server_.emplace(folder_);
    EXPECT_TRUE(SaveCredentials(folder_ / "data", server_->NewStation()).ok());
    WorkplaceOptions options;
    options.data = folder_ / "data";
    workplace_ = std::move(*Workplace::Open(options));
    flow_.emplace(*workplace_, WorkflowOptions{});
  }
  ~WorkflowTest() override {
    flow_.reset();
    workplace_.reset();
  }

  template <typename Until>
  void TickUntil(Until&& until) {
    while (!until()) {
      flow_->Tick(Clock::now(), true);
      std::this_thread::yield();
    }
  }
  void Settle() {
    TickUntil([&] { return !flow_->busy(); });
  }
  void SignIn() {
    flow_->SignIn("ada", "secret");
    Settle();
    ASSERT_EQ(flow_->place(), Place::kExercises) << flow_->problem();
  }
  void ServerComesBackAsAnother() {
    uint16_t port = server_->endpoint().port;
    const Uuid person = server_->person;
    server_.reset();
    server_.emplace(folder_, port);
    server_->person = person;
  }

  // An attempt of this person, complete or interrupted.
  Uuid Recorded(const Uuid& person, bool ended) {
    trace::Header header = HeaderOf(person);
    EXPECT_TRUE(workplace_->spool().BeginAttempt(header, "class-1", "pointer").ok());
    trace::Seal seal;
    seal.attempt = header.ticket.attempt;
    if (ended) EXPECT_TRUE(workplace_->spool().PutSeal(seal).ok());
    return header.ticket.attempt;
  }
  // A practice exercise that somebody's list has had, with the server away since.
  void ServerLeavesPractice() {
    const KeptDocuments kept = KeepDocuments(folder_ / "data", "pointer", false);
    server_->assignments = {Uuid::New()};
    server_->describe = [&](size_t, wire::ExerciseRef& ref) {
      ref.set_name(kept.exercise.name);
      ref.set_exercise(protocol::ToField(kept.exercise_hash.view()));
    };
    server_->profiles = {{"pointer", kept.profile_hash}};
    EXPECT_FALSE(flow_->may_practise());
    SignIn();
    flow_->SignOut();
    EXPECT_TRUE(flow_->may_practise());
    server_.reset();
  }
  Uuid Kept() {
    trace::Ticket ticket;
    ticket.attempt = Uuid::New();
    ticket.expires_unix_ms = int64_t{1} << 60;
    EXPECT_TRUE(TicketSafe(workplace_->spool()).Put(ticket, {}, kPin).ok());
    return ticket.attempt;
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  std::optional<FakeServer> server_;
  std::unique_ptr<Workplace> workplace_;
  std::optional<Workflow> flow_;
};

TEST_F(WorkflowTest, TheHandThatSomebodyChoseIsTheirsUntilTheySignOut) {
  SignIn();
  EXPECT_FALSE(flow_->left_handed());
  flow_->HoldInLeft(true);
  flow_->ToExercises();
  Settle();
  EXPECT_TRUE(flow_->left_handed());
  flow_->SignOut();
  EXPECT_FALSE(flow_->left_handed());
  flow_.reset();
  flow_.emplace(*workplace_, WorkflowOptions{.left_handed = true});
  EXPECT_TRUE(flow_->left_handed()) << "the chair's";
  SignIn();
  flow_->HoldInLeft(false);
  flow_->SignOut();
  EXPECT_TRUE(flow_->left_handed());
}

TEST_F(WorkflowTest, WhatWasNotWrittenIsAskedForWithoutTheServer) {
  flow_->SignIn("", "secret");
  EXPECT_FALSE(flow_->busy());
  EXPECT_EQ(flow_->problem(), "Enter your login first.");
  flow_->SignIn("ada", "");
  EXPECT_EQ(flow_->problem(), "Enter your password too.");
  EXPECT_EQ(flow_->place(), Place::kSignIn);
}

TEST_F(WorkflowTest, WhoSignsInSeesOwnAttemptsOnly) {
  const Uuid cut_off = Recorded(server_->person, false), ended = Recorded(server_->person, true);
  Recorded(Uuid::New(), false);
  Recorded(Uuid::New(), true);
  SignIn();
  ASSERT_EQ(flow_->cut_off().size(), 1u);
  EXPECT_EQ(flow_->cut_off()[0].id, cut_off);
  ASSERT_EQ(flow_->handed_in().size(), 1u);
  EXPECT_EQ(flow_->handed_in()[0].id, ended);
  flow_->SignOut();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_TRUE(flow_->cut_off().empty());
  EXPECT_TRUE(flow_->handed_in().empty());
}

TEST_F(WorkflowTest, WithoutTheServerThePersonIsToldAndMayTryAgain) {
  uint16_t port = server_->endpoint().port;
  const Uuid person = server_->person;
  server_.reset();
  flow_->SignIn("ada", "secret");
  Settle();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_NE(flow_->problem().find("The server is away"), std::string::npos) << flow_->problem();
  server_.emplace(folder_, port);
  server_->person = person;
  SignIn();
}

TEST_F(WorkflowTest, WithoutTheServerAnybodyMayPractise) {
  ServerLeavesPractice();
  flow_->ToPractice();
  Settle();
  ASSERT_EQ(flow_->place(), Place::kPracticeList);
  ASSERT_EQ(flow_->exercises().size(), 1u) << flow_->problem();
  flow_->ChooseExercise(0);
  EXPECT_EQ(flow_->way(), Way::kPractice);
  Settle();
  ASSERT_EQ(flow_->place(), Place::kExercise);
  EXPECT_TRUE(flow_->problem().empty()) << flow_->problem();
  ASSERT_NE(flow_->preview(), nullptr);
  EXPECT_TRUE(flow_->preview()->attempt().IsZero()) << "it needs no ticket";
  ASSERT_LT(flow_->offer_index(), flow_->offers().size());
  EXPECT_EQ(flow_->offers()[flow_->offer_index()].profile, "pointer");
  EXPECT_FALSE(flow_->instructor()) << "nobody is signed in";
  flow_->Back();
  EXPECT_EQ(flow_->place(), Place::kPracticeList);
  flow_->Back();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_EQ(flow_->way(), Way::kTicket);
  EXPECT_TRUE(flow_->exercises().empty());
  EXPECT_TRUE(workplace_->spool().List()->empty());
}

TEST_F(WorkflowTest, PracticeThatNobodyIsAtEnds) {
  ServerLeavesPractice();
  flow_->ToPractice();
  Settle();
  const auto now = Clock::now();
  flow_->Tick(now, true);
  flow_->Tick(now + std::chrono::seconds(601), false);
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_EQ(flow_->notice(), "Practice has ended, because nobody was active.");
}

TEST_F(WorkflowTest, SigningOutDoesNotWaitForAServerThatHangs) {
  SignIn();
  server_->silent = true;
  flow_->Refresh();
  while (server_->unanswered == 0) std::this_thread::yield();
  flow_->SignOut();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_TRUE(flow_->busy()) << "it waited for the background task";
  Settle();
  EXPECT_TRUE(flow_->problem().empty()) << "nobody asked for: " << flow_->problem();
  server_->silent = false;
  SignIn();
}

TEST_F(WorkflowTest, ClosingDoesNotWaitForAServerThatHangs) {
  SignIn();
  server_->silent = true;
  flow_->Refresh();
  while (server_->unanswered == 0) std::this_thread::yield();
  auto before = Clock::now();
  flow_.reset();
  EXPECT_LT(Clock::now() - before, ServerLink::kTimeout / 2);
}

TEST_F(WorkflowTest, AResultThatIsShownIsLeftWithoutWaitingForAServerThatHangs) {
  Recorded(server_->person, true);
  SignIn();
  server_->silent = true;
  flow_->OpenHandedIn(0);
  ASSERT_EQ(flow_->place(), Place::kResult);
  TickUntil([&] { return server_->unanswered > 0; });
  flow_->ToExercises();
  EXPECT_EQ(flow_->place(), Place::kExercises);
  EXPECT_TRUE(flow_->busy()) << "it waited for the background task";
}

TEST_F(WorkflowTest, AResultIsSeenAfterTheConnectionWasLost) {
  const Uuid attempt = Recorded(server_->person, true);
  server_->seen.insert(attempt);
  SignIn();
  flow_->OpenHandedIn(0);
  ASSERT_EQ(flow_->place(), Place::kResult);
  TickUntil([&] { return flow_->progress().has_value(); });
  ServerComesBackAsAnother();
  server_->seen.insert(attempt);
  TickUntil([&] { return flow_->place() == Place::kSignIn; });
  EXPECT_NE(flow_->notice().find("Sign in again to see the result"), std::string::npos)
      << flow_->notice();
  flow_->SignIn("ada", "secret");
  Settle();
  EXPECT_EQ(flow_->place(), Place::kResult) << flow_->problem();
  TickUntil([&] { return flow_->progress().has_value(); });
  EXPECT_EQ(flow_->progress()->state, "ticketed");
  flow_->ToExercises();
  Settle();
  EXPECT_EQ(flow_->handed_in().size(), 1u) << "and it stays in the list";
}

TEST_F(WorkflowTest, SomebodyElseDoesNotComeToTheResultOfWhoLostTheConnection) {
  const Uuid attempt = Recorded(server_->person, true);
  server_->seen.insert(attempt);
  SignIn();
  flow_->OpenHandedIn(0);
  TickUntil([&] { return flow_->progress().has_value(); });
  ServerComesBackAsAnother();
  server_->person = Uuid::New();
  TickUntil([&] { return flow_->place() == Place::kSignIn; });
  SignIn();
  EXPECT_TRUE(flow_->handed_in().empty());
  flow_->SignOut();
  server_->person = Uuid::New();
  SignIn();
}

TEST_F(WorkflowTest, AttemptThatWasCutOffIsHandedInOrLeft) {
  Recorded(server_->person, false);
  SignIn();
  flow_->OpenCutOff(0);
  EXPECT_EQ(flow_->dialog(), Dialog::kCutOff);
  flow_->Back();
  EXPECT_EQ(flow_->dialog(), Dialog::kNone);
  EXPECT_EQ(flow_->place(), Place::kExercises);
  flow_->OpenCutOff(0);
  flow_->EndCutOff();
  Settle();
  EXPECT_EQ(flow_->dialog(), Dialog::kCutOff) << "nothing was recorded: it can only go on";
  EXPECT_FALSE(flow_->problem().empty());
  flow_->CloseDialog();
  EXPECT_EQ(flow_->cut_off().size(), 1u) << "and is still there";
}

TEST_F(WorkflowTest, TicketKeptForLaterIsGivenBackWithItsPinAlone) {
  Kept();
  flow_->SignOut();  // looks again
  ASSERT_EQ(flow_->reserved().size(), 1u);
  flow_->ToReserved();
  EXPECT_EQ(flow_->place(), Place::kReserved);
  flow_->AskPin(0);
  EXPECT_EQ(flow_->dialog(), Dialog::kPin);
  flow_->GiveBack("804218");
  Settle();
  EXPECT_EQ(flow_->dialog(), Dialog::kPin);
  EXPECT_FALSE(flow_->problem().empty()) << "a wrong PIN is told";
  flow_->GiveBack(kPin);
  Settle();
  EXPECT_EQ(flow_->dialog(), Dialog::kNone) << flow_->problem();
  EXPECT_TRUE(flow_->reserved().empty());
  EXPECT_NE(flow_->notice().find("does not count"), std::string::npos) << flow_->notice();
  flow_->Back();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
}

TEST_F(WorkflowTest, FirstPasswordIsChosenAtTheChair) {
  constexpr char kOneTime[] = "k7mq-2xhd", kNew[] = "kettle orbit plum fence";
  server_->must_change_password = true;
  server_->assignments = {Uuid::New()};
  flow_->SignIn("ada", kOneTime);
  Settle();
  ASSERT_EQ(flow_->place(), Place::kFirstPassword) << flow_->problem();
  EXPECT_TRUE(flow_->problem().empty()) << flow_->problem();
  EXPECT_FALSE(workplace_->person().has_value()) << "nobody is signed in with it";

  flow_->ChoosePassword(kNew, "kettle orbit plum fench");
  EXPECT_FALSE(flow_->busy()) << "nothing is sent of two that differ";
  EXPECT_EQ(flow_->problem(), "The two passwords do not match. Enter the new password again.");
  server_->refuse_passwords = Status(Code::kInvalidInput, "among the first", kNewPassword);
  flow_->ChoosePassword("password1", "password1");
  Settle();
  EXPECT_EQ(flow_->place(), Place::kFirstPassword);
  EXPECT_NE(flow_->problem().find("easy to guess"), std::string::npos) << flow_->problem();

  server_->refuse_passwords.reset();
  flow_->ChoosePassword(kNew, kNew);
  Settle();
  EXPECT_EQ(flow_->place(), Place::kExercises) << flow_->problem();
  EXPECT_EQ(flow_->exercises().size(), 1u);
  EXPECT_EQ(server_->password_choice().session(), "once");
  EXPECT_EQ(server_->password_choice().old_password(), kOneTime);
  EXPECT_EQ(server_->password_choice().new_password(), kNew);
  EXPECT_EQ(workplace_->person()->session, "own");
}

TEST_F(WorkflowTest, WhoLeavesTheFirstPasswordSignsInWithTheOldOneAgain) {
  server_->must_change_password = true;
  flow_->SignIn("ada", "k7mq-2xhd");
  Settle();
  flow_->Back();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_TRUE(server_->password_choice().new_password().empty());
  flow_->SignIn("ada", "k7mq-2xhd");
  Settle();
  EXPECT_EQ(flow_->place(), Place::kFirstPassword);
  server_->refuse_passwords = Status(Code::kUnauthenticated, "it has expired", "one_time_password");
  flow_->ChoosePassword("kettle orbit plum fence", "kettle orbit plum fence");
  Settle();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_EQ(flow_->problem().find("This one-time password no longer works"), 0u)
      << flow_->problem();
}

TEST(ProblemOfPasswordTest, SaysWhatThePageSays) {
  const language::Words words(language::Language::kEnglish);
  const auto problem = [&](const std::string& chosen, const std::string& again) {
    return ProblemOfPassword(words, "k7mq-2xhd", chosen, again);
  };
  EXPECT_EQ(problem("sechsü", "sechsü"), "Use at least 8 characters. This password has 6.");
  EXPECT_EQ(problem("k7mq-2xhd", "k7mq-2xhd"), "That is already your password. Choose another.");
  const std::string longest(kMaxPasswordLength, 'x');
  EXPECT_EQ(problem(longest, longest), "");
  EXPECT_EQ(problem(longest + "x", longest + "x"),
            "This password is too long. Choose a shorter one.");
  EXPECT_EQ(problem("achtzehn", "achtzehn"), "");
}

// The server says the same of a wrong password, an unknown login and a one-time password that is used
// up.
TEST_F(WorkflowTest, WhoseOneTimePasswordIsUsedUpIsToldWhatToUse) {
  server_->refuse_sign_ins = Status(Code::kUnauthenticated, "login or password is wrong");
  flow_->SignIn("ada", "used up");
  Settle();
  EXPECT_NE(flow_->problem().find("one-time password works until you have chosen your own"),
            std::string::npos)
      << flow_->problem();
}

TEST_F(WorkflowTest, CommonProblemsAreSaidInThePersonsLanguage) {
  flow_->Speak(language::Language::kGerman);
  server_->refuse_sign_ins = Status(Code::kUnauthenticated, "login or password is wrong");
  flow_->SignIn("ada", "wrong");
  Settle();
  EXPECT_NE(flow_->problem().find("Passwort ist falsch"), std::string::npos) << flow_->problem();
  server_->refuse_sign_ins.reset();
  Kept();
  flow_->SignOut();
  EXPECT_EQ(flow_->words().language(), language::Language::kEnglish) << "as the station is set";
  flow_->Speak(language::Language::kGerman);
  flow_->ToReserved();
  flow_->AskPin(0);
  flow_->GiveBack("804218");
  Settle();
  EXPECT_NE(flow_->problem().find("Falsche PIN"), std::string::npos) << flow_->problem();
}

TEST_F(WorkflowTest, NobodyStaysSignedInWhereNothingHappens) {
  SignIn();
  auto now = Clock::now();
  flow_->Tick(now, true);
  flow_->Tick(now + std::chrono::seconds(599), false);
  EXPECT_EQ(flow_->place(), Place::kExercises);
  flow_->Tick(now + std::chrono::seconds(601), false);
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  EXPECT_FALSE(flow_->notice().empty());
  EXPECT_FALSE(workplace_->person().has_value());
}

TEST_F(WorkflowTest, EveryPlaceWithoutAnAttemptHasAWayBack) {
  Recorded(server_->person, true);
  server_->assignments = {Uuid::New()};
  SignIn();
  flow_->OpenHandedIn(0);
  flow_->Back();
  EXPECT_EQ(flow_->place(), Place::kExercises);
  Settle();
  flow_->ChooseExercise(0);
  ASSERT_EQ(flow_->place(), Place::kExercise);
  flow_->Back();
  EXPECT_EQ(flow_->place(), Place::kExercises);
  flow_->Back();
  EXPECT_EQ(flow_->place(), Place::kSignIn);
  Settle();
}

}  // namespace
}  // namespace enamel::station::desk
