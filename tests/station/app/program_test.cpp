#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "station/uplink/credentials.h"

// enamel-station as people run it: exit codes and what is said.
namespace enamel::station {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int code = -1;
  std::string text;   // both streams
};

Outcome RunProgram(const std::string& arguments) {
  std::string line = std::string(ENAMEL_STATION_PROGRAM) + " " + arguments + " 2>&1 </dev/null";
  Outcome out;
  FILE* pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) return out;
  char buffer[4096];
  while (size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) out.text.append(buffer, n);
  int state = ::pclose(pipe);
  out.code = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
  return out;
}

class ProgramTest : public testing::Test {
 protected:
  ProgramTest() {
    std::string name = (fs::temp_directory_path() / "enamel_program_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    ::setenv("ENAMEL_PASSWORD", "secret", 1);
  }
  ~ProgramTest() override { fs::remove_all(folder_); }

  std::string data() const { return " --data " + (folder_ / "data").string(); }
  void Enrol(uint16_t port) {
    Credentials c;
    c.server = {"127.0.0.1", port};
    c.station = Uuid::New();
    c.secret_key = trace::NewKeyPair().secret_key;
    ASSERT_TRUE(SaveCredentials(folder_ / "data", c).ok());
  }

  fs::path folder_;
};

constexpr char kRun[] = "run --exercise e --profile p --user u --lockstep";

TEST_F(ProgramTest, HelpTeachesAFirstAttempt) {
  Outcome out = RunProgram("--help");
  EXPECT_EQ(out.code, 0);
  for (const char* word : {"enrol", "run", "upload", "spool", "replay", "import", "simulate",
                           "devices", "profiles", "CODE@FINGERPRINT", "Exit codes"}) {
    EXPECT_NE(out.text.find(word), std::string::npos) << word;
  }
}

TEST_F(ProgramTest, WrongCommandLineIsExitCodeTwo) {
  EXPECT_EQ(RunProgram("spool").code, 2);
  EXPECT_EQ(RunProgram("run").code, 2);
  EXPECT_EQ(RunProgram("no-such-thing").code, 2);
}

TEST_F(ProgramTest, StationThatIsNotEnrolledIsToldHow) {
  Outcome out = RunProgram(kRun + data());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("not enrolled"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, ServerThatIsNotThereIsNamedWithWhatToDo) {
  Enrol(1);
  Outcome out = RunProgram(kRun + data());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("127.0.0.1:1"), std::string::npos) << out.text;
  EXPECT_NE(out.text.find("enamel-station upload"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, PasswordIsNeverTakenFromTheCommandLine) {
  ::unsetenv("ENAMEL_PASSWORD");
  Outcome out = RunProgram(kRun + data());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("--password-stdin"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, UnknownOperatorIsAnsweredWithTheKnownOnes) {
  Outcome out = RunProgram(kRun + data() + " --operator nobody");
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("student-deep-mesial"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, EnrolRefusesACodeWithoutFingerprint) {
  Outcome out = RunProgram("enrol --server 127.0.0.1:1 --code abc" + data());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("CODE@FINGERPRINT"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, EnrolledStationIsNotEnrolledOverItsKey) {
  Enrol(1);
  Outcome out = RunProgram("enrol --server 127.0.0.1:1 --code c@" + std::string(64, 'a') + data());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("enrolled already"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, EmptySpoolIsListedVerifiedAndHasNothingToUpload) {
  EXPECT_EQ(RunProgram("spool list" + data()).code, 0);
  EXPECT_EQ(RunProgram("spool verify" + data()).code, 0);
  Enrol(1);
  Outcome out = RunProgram("upload" + data());
  EXPECT_EQ(out.code, 0);
  EXPECT_NE(out.text.find("nothing to upload"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, DataFolderIsForItsOwnerOnly) {
  EXPECT_EQ(RunProgram("spool list" + data() + "/below/").code, 0);
  EXPECT_EQ(fs::status(folder_ / "data" / "below").permissions(), fs::perms::owner_all);
}

TEST_F(ProgramTest, PlaceThatCannotBeWrittenIsRefusedBeforeTheWork) {
  std::string nowhere = (folder_ / "none" / "facts.json").string();
  std::string file = (folder_ / "file").string();
  std::fclose(std::fopen(file.c_str(), "w"));
  for (const std::string& arguments :
       {"simulate --json " + nowhere, "simulate --json " + folder_.string(),
        kRun + data() + " --json " + nowhere, kRun + data() + " --screenshot " + nowhere,
        "import nothing.stl --unit mm --out " + file + "/scene"}) {
    Outcome out = RunProgram(arguments);
    EXPECT_EQ(out.code, 1) << arguments;
    EXPECT_NE(out.text.find("name a place that this user may write"), std::string::npos)
        << arguments << ": " << out.text;
  }
}

TEST_F(ProgramTest, ReplayOfAFileThatIsNoTraceIsRefused) {
  Outcome out = RunProgram("replay " + std::string(ENAMEL_STATION_PROGRAM) + data());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("enamel-station: "), std::string::npos) << out.text;
}

TEST_F(ProgramTest, ProfilesShowWhereTheirNumbersAreFrom) {
  Outcome out = RunProgram("profiles");
  EXPECT_EQ(out.code, 0);
  for (const char* word : {"phantom_desktop", "omega3", "bhhd3", "paper"}) {
    EXPECT_NE(out.text.find(word), std::string::npos) << word;
  }
}

TEST_F(ProgramTest, DevicesListsWhatIsAlwaysThereWithoutAnyRights) {
  Outcome out = RunProgram("devices");
  EXPECT_EQ(out.code, 0);
  for (const char* word : {"pointer", "simulated", "dentist"}) {
    EXPECT_NE(out.text.find(word), std::string::npos) << out.text;
  }
}

TEST_F(ProgramTest, DoctorSaysWhatIsMissingAndFails) {
  std::string json = (folder_ / "doctor.json").string();
  Outcome out = RunProgram("doctor --no-graphics --json " + json + data());
  EXPECT_EQ(out.code, 1);
  for (const char* line : {"fail  enrolment", "enrol-code", "ok    spool", "disk", "real-time"}) {
    EXPECT_NE(out.text.find(line), std::string::npos) << line << ": " << out.text;
  }
  EXPECT_TRUE(fs::exists(json));
  EXPECT_FALSE(fs::exists(folder_ / "data"));  // it changes nothing
}

TEST_F(ProgramTest, DoctorFindsAServerThatIsNotThere) {
  Enrol(1);
  Outcome out = RunProgram("doctor --no-graphics" + data());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("ok    enrolment"), std::string::npos) << out.text;
  EXPECT_NE(out.text.find("fail  server"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, CalibratesASimulatedDeviceIntoAProfileThatCalibratesToItself) {
  std::string out_file = (folder_ / "mine.json").string();
  Outcome first = RunProgram("calibrate --device simulated:bhhd3 --name mine --out " + out_file);
  EXPECT_EQ(first.code, 0) << first.text;
  EXPECT_NE(first.text.find("proposed: Kc"), std::string::npos) << first.text;
  Outcome again = RunProgram("calibrate --sim-noise-um 12 --device simulated:" + out_file +
                             " --profile " + out_file);
  EXPECT_EQ(again.code, 0) << again.text;
}

TEST_F(ProgramTest, CalibrateRefusesWhatHasNoMotorsAndWhatIsNotThere) {
  Outcome mouse = RunProgram("calibrate --device spacemouse");
  EXPECT_EQ(mouse.code, 1);
  EXPECT_NE(mouse.text.find("only what has motors"), std::string::npos) << mouse.text;
  Outcome nothing = RunProgram("calibrate --device simulated:nothing");
  EXPECT_EQ(nothing.code, 1);
  EXPECT_NE(nothing.text.find("omega3"), std::string::npos) << nothing.text;
}

}  // namespace
}  // namespace enamel::station
