#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <regex>
#include <string>

// enamel-lab as people run it, and its older names: exit codes and output.
namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int code = -1;
  std::string text;  // of both streams

  bool operator==(const Outcome&) const = default;
};
void PrintTo(const Outcome& outcome, std::ostream* out) {
  *out << outcome.code << ": " << outcome.text;
}

Outcome RunProgram(const fs::path& program, const std::string& arguments) {
  Outcome out;
  FILE* pipe = ::popen((program.string() + " " + arguments + " 2>&1 </dev/null").c_str(), "r");
  if (pipe == nullptr) return out;
  char buffer[4096];
  while (size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) out.text.append(buffer, n);
  int state = ::pclose(pipe);
  out.code = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
  // Compares two runs of one command without the log's times.
  out.text = std::regex_replace(out.text, std::regex(R"re("time":"[^"]*")re"), "");
  return out;
}

const fs::path kPrograms = ENAMEL_PROGRAMS;

Outcome Lab(const std::string& arguments) {
  return RunProgram(kPrograms / "enamel-lab", arguments);
}
Outcome Station(const std::string& arguments) {
  return RunProgram(kPrograms / "enamel-station", arguments);
}
Outcome Bench(const std::string& arguments) {
  return RunProgram(kPrograms / "enamel-bench", arguments);
}

class LabProgramTest : public testing::Test {
 protected:
  LabProgramTest() {
    std::string name = (fs::temp_directory_path() / "enamel_lab_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~LabProgramTest() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(LabProgramTest, HelpListsEveryCommandAndEachOnesHelpShowsHow) {
  Outcome all = Lab("--help");
  EXPECT_EQ(all.code, 0);
  for (const char* command : {"qualify", "error", "bench", "explain", "fit-damping", "reasons"}) {
    EXPECT_NE(all.text.find(std::string("enamel-lab ") + command), std::string::npos) << command;
    Outcome one = Lab(command + std::string(" --help"));
    EXPECT_EQ(one.code, 0) << command;
    EXPECT_NE(one.text.find("enamel-lab "), std::string::npos) << command << ": " << one.text;
  }
}

TEST_F(LabProgramTest, WrongCommandLineIsExitCodeTwo) {
  EXPECT_EQ(Lab("").code, 2);
  EXPECT_EQ(Lab("no-such-thing").code, 2);
  EXPECT_EQ(Lab("bench").code, 2);
  EXPECT_EQ(Lab("qualify --threads 0").code, 2);
}

TEST_F(LabProgramTest, OlderNamesSayWhatTheLabSays) {
  const std::string none = (folder_ / "none.csv").string();
  for (const std::string& arguments :
       {std::string("qualify --help"), std::string("qualify --suite nonsense"),
        std::string("qualify --threads 0"), "fit-damping " + none, std::string("explain --help"),
        std::string("--log-format json explain builtin:nothing"),
        std::string("--log-format=json qualify --profile nothing")}) {
    const Outcome lab = Lab(arguments);
    EXPECT_NE(lab.text, "") << arguments;
    EXPECT_EQ(Station(arguments), lab) << arguments;
  }
  EXPECT_EQ(Station("frame-bench --frames 0"), Lab("bench frames --frames 0"));
  EXPECT_EQ(Station("frame-bench --frames 0").code, 1);
  for (const char* arguments : {"--help", "tick --help", "tick --replays 1", ""}) {
    EXPECT_EQ(Bench(arguments), Lab("bench " + std::string(arguments))) << arguments;
  }
  EXPECT_EQ(Bench("error --help"), Lab("error --help"));
}

// A word that names a command of the lab only at a later place.
TEST_F(LabProgramTest, OnlyTheCommandItselfIsForwarded) {
  const Outcome out = Station("spool list --data qualify");
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("there is no spool in"), std::string::npos) << out.text;
}

TEST_F(LabProgramTest, WithoutTheLabTheOlderNamesSayWhatToDo) {
  for (const char* name : {"enamel-station", "enamel-bench"}) {
    fs::copy_file(kPrograms / name, folder_ / name);
    const Outcome out = RunProgram(folder_ / name, "explain builtin:block");
    EXPECT_EQ(out.code, 1) << name;
    EXPECT_NE(out.text.find((folder_ / "enamel-lab").string()), std::string::npos) << out.text;
    EXPECT_NE(out.text.find("build"), std::string::npos) << out.text;
  }
}

// The machine's settings are the station's: the lab uses those it knows.
TEST_F(LabProgramTest, KeysOfTheStationsSettingsArePassedOverAndItsOwnAreTaken) {
  const std::string settings = (folder_ / "station.toml").string();
  std::ofstream(settings) << "keep-days = 30\nprofile = \"no_such_device\"\n";
  const Outcome out = Lab("qualify --suite strokes --config " + settings);
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("no_such_device"), std::string::npos) << out.text;
  EXPECT_EQ(out.text.find("keep-days"), std::string::npos) << out.text;
}

}  // namespace
}  // namespace enamel::station::lab
