#include "station/desk/opening.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "station/desk/workflow.h"
#include "station/spool/salvage.h"
#include "tests/station/desk/english.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::desk {
namespace {

namespace fs = std::filesystem;

class OpeningTest : public testing::Test {
 protected:
  OpeningTest() { server_.emplace(folder_); }

  fs::path data() const { return folder_ / "data"; }
  fs::path file() const { return data() / "spool.sqlite"; }
  void Enrol() { ASSERT_TRUE(SaveCredentials(data(), server_->NewStation()).ok()); }
  // A spool with a person's attempt, whose file is then partly destroyed.
  void Damage() {
    const trace::Header header = HeaderOf(server_->person);
    {
      auto spool = Spool::Open(data());
      ASSERT_TRUE((*spool)->BeginAttempt(header, "class-1", "pointer").ok());
    }
    for (const char* end : {"-wal", "-shm"}) fs::remove(file().string() + end);
    std::fstream out(file(), std::ios::binary | std::ios::in | std::ios::out);
    out << std::string(100, '\x5a');
  }
  static void Settle(Opening& opening) {
    while (opening.busy()) {
      opening.Tick();
      std::this_thread::yield();
    }
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  std::optional<FakeServer> server_;
};

TEST_F(OpeningTest, WhatIsWholeIsOpenAtOnce) {
  Enrol();
  Opening opening({.data = data()});
  EXPECT_TRUE(opening.problem().ok()) << opening.problem().message();
  EXPECT_NE(opening.workplace(), nullptr);
}

TEST_F(OpeningTest, ADamagedSpoolIsExplainedAndOpensOnceItWasSalvaged) {
  Enrol();
  Damage();
  Opening opening({.data = data()});
  ASSERT_EQ(opening.workplace(), nullptr);
  const OpeningProblem shown = opening.explained(kEnglish);
  EXPECT_NE(shown.what.find("is damaged"), std::string::npos) << shown.what;
  EXPECT_NE(shown.safe.find("the server has are safe"), std::string::npos) << shown.safe;
  EXPECT_NE(shown.todo.find("another station"), std::string::npos) << shown.todo;
  EXPECT_NE(shown.operators.find("spool salvage --out"), std::string::npos);
  EXPECT_NE(shown.operators.find(data().string()), std::string::npos);
  EXPECT_GE(opening.Lines().size(), 2u);
  opening.TryAgain();
  Settle(opening);
  EXPECT_EQ(opening.workplace(), nullptr) << "nobody has mended it yet";
  EXPECT_EQ(opening.problem().field(), kDamagedSpool);

  ASSERT_TRUE(SalvageSpool(data(), folder_ / "saved").ok());
  fs::rename(file(), folder_ / "damaged.sqlite");
  for (const char* end : {"-wal", "-shm"}) fs::remove(file().string() + end);
  fs::rename(folder_ / "saved" / "spool.sqlite", file());
  opening.TryAgain();
  Settle(opening);
  ASSERT_NE(opening.workplace(), nullptr) << opening.problem().message();
  EXPECT_TRUE(opening.problem().ok());
  Workflow flow(*opening.workplace(), {});
  flow.SignIn("ada", "secret");
  while (flow.busy()) flow.Tick(Workflow::Clock::now(), true);
  EXPECT_EQ(flow.place(), Place::kExercises) << flow.problem();
}

TEST_F(OpeningTest, EveryTroubleSaysWhatIsWrongWhatIsSafeAndWhatToDo) {
  for (const Status& problem :
       {Status(Code::kNotFound, "not enrolled"), Status(Code::kStorage, "full"),
        Status(Code::kStorage, "broken", kDamagedSpool), Status(Code::kVersion, "newer"),
        Status(Code::kForbidden, "others may read it", kEnrolment),
        Status(Code::kVersion, "of another version", kEnrolment),
        Status(Code::kInvalidInput, "no port", kServerOption),
        Status(Code::kStorage, "0 bytes", kLostSpool), Status(Code::kStorage, "no room")}) {
    const OpeningProblem shown = OpeningProblemOf(kEnglish, problem, data());
    EXPECT_FALSE(shown.what.empty());
    EXPECT_FALSE(shown.safe.empty());
    EXPECT_FALSE(shown.todo.empty());
    EXPECT_EQ(shown.operators.find(problem.message()), 0u) << "in the program's own words";
    EXPECT_EQ(shown.what.find("spool"), std::string::npos) << "students know no spool";
  }
}

TEST_F(OpeningTest, ASecondWindowIsRefusedWhileOneIsOpenAndCommandsAreNot) {
  Enrol();
  auto first = std::make_unique<Opening>(WorkplaceOptions{.data = data()});
  ASSERT_NE(first->workplace(), nullptr) << first->problem().message();
  Opening second({.data = data()});
  EXPECT_EQ(second.workplace(), nullptr);
  EXPECT_EQ(second.problem().field(), kWindowOpen);
  const OpeningProblem shown = second.explained(kEnglish);
  EXPECT_EQ(shown.what, "Another window of this station is open.");
  EXPECT_NE(shown.operators.find("process " + std::to_string(::getpid()) + " has the window of"),
            std::string::npos)
      << shown.operators;
  second.TryAgain();
  Settle(second);
  EXPECT_EQ(second.workplace(), nullptr);
  // As 'upload', 'run' and 'spool list' open it.
  EXPECT_TRUE(Workplace::Open({.data = data()}).ok());
  EXPECT_TRUE(Spool::OpenToRead(data()).ok());
  first.reset();
  second.TryAgain();
  Settle(second);
  EXPECT_NE(second.workplace(), nullptr) << second.problem().message();
  Opening third({.data = data()});
  EXPECT_EQ(third.problem().field(), kWindowOpen) << "which is the one now";
}

TEST_F(OpeningTest, AnEmptySpoolIsNotOfferedToBeSalvaged) {
  Enrol();
  { ASSERT_TRUE(Spool::Open(data()).ok()); }
  for (const char* end : {"-wal", "-shm"}) fs::remove(file().string() + end);
  fs::resize_file(file(), 0);
  const OpeningProblem shown = Opening({.data = data()}).explained(kEnglish);
  EXPECT_NE(shown.what.find("empty or missing"), std::string::npos) << shown.what;
  EXPECT_EQ(shown.safe.find("can usually be saved"), std::string::npos) << shown.safe;
  EXPECT_EQ(shown.operators.find("salvage"), std::string::npos) << shown.operators;
  EXPECT_NE(shown.operators.find("Put its copy back as " + file().string()), std::string::npos)
      << shown.operators;
}

TEST_F(OpeningTest, WithoutItsEnrolmentItsRecordingsAreNotSaidToBeNone) {
  Enrol();
  { ASSERT_TRUE(Spool::Open(data()).ok()); }
  fs::rename(data() / "station.json", folder_ / "kept.json");
  Opening opening({.data = data()});
  const OpeningProblem shown = opening.explained(kEnglish);
  EXPECT_EQ(shown.safe.find("Nothing has been recorded"), std::string::npos) << shown.safe;
  EXPECT_NE(shown.safe.find("still here"), std::string::npos) << shown.safe;
  EXPECT_NE(shown.operators.find("station.json: restore a copy of that file"), std::string::npos)
      << shown.operators;
  EXPECT_NE(shown.operators.find("spool export"), std::string::npos) << shown.operators;
  fs::rename(folder_ / "kept.json", data() / "station.json");
  opening.TryAgain();
  Settle(opening);
  EXPECT_NE(opening.workplace(), nullptr) << opening.problem().message();
}

TEST_F(OpeningTest, WhatIsWrongWithTheEnrolmentIsNotSaidOfTheRecordings) {
  Enrol();
  EXPECT_NE(Opening({.data = data(), .server = "no port"}).explained(kEnglish).what.find("address"),
            std::string::npos);
  const fs::path enrolment = data() / "station.json";
  fs::permissions(enrolment, fs::perms(0644));
  EXPECT_NE(Opening({.data = data()}).explained(kEnglish).what.find("enrolment data"),
            std::string::npos);
  std::ofstream(enrolment) << "{\"enamel_station\": 99}";
  fs::permissions(enrolment, fs::perms(0600));
  EXPECT_NE(Opening({.data = data()}).explained(kEnglish).what.find("enrolled by another version"),
            std::string::npos);
}

TEST_F(OpeningTest, AStationThatIsEnrolledMeanwhileOpens) {
  Opening opening({.data = data()});
  EXPECT_NE(opening.explained(kEnglish).what.find("not enrolled"), std::string::npos);
  Enrol();
  opening.TryAgain();
  Settle(opening);
  EXPECT_NE(opening.workplace(), nullptr) << opening.problem().message();
}

}  // namespace
}  // namespace enamel::station::desk
