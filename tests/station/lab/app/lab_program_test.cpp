#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

// enamel-lab as people run it: exit codes and output.
namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int code = -1;
  std::string text;  // of both streams
};

Outcome RunProgram(const fs::path& program, const std::string& arguments) {
  Outcome out;
  FILE* pipe = ::popen((program.string() + " " + arguments + " 2>&1 </dev/null").c_str(), "r");
  if (pipe == nullptr) return out;
  char buffer[4096];
  while (size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) out.text.append(buffer, n);
  int state = ::pclose(pipe);
  out.code = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
  return out;
}

const fs::path kPrograms = ENAMEL_PROGRAMS;

Outcome Lab(const std::string& arguments) {
  return RunProgram(kPrograms / "enamel-lab", arguments);
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

TEST_F(LabProgramTest, WhereTheLogIsJsonErrorsAreLinesOfIt) {
  for (const std::string& arguments :
       {std::string("qualify --suite nonsense"), "fit-damping " + (folder_ / "none.csv").string(),
        std::string("explain builtin:nothing")}) {
    const Outcome out = Lab("--log-format json " + arguments);
    EXPECT_NE(out.code, 0) << arguments;
    EXPECT_TRUE(out.text.starts_with("{\"time\":")) << out.text;
    EXPECT_NE(out.text.find("\"level\":\"error\""), std::string::npos) << out.text;
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
