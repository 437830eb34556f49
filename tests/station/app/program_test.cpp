#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "station/spool/spool.h"
#include "station/uplink/credentials.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

// enamel-station as people run it: exit codes and output.
namespace enamel::station {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int code = -1;
  std::string text;  // of the streams asked for
};

constexpr char kBoth[] = " 2>&1", kErrors[] = " 2>&1 >/dev/null";

Outcome RunProgram(const std::string& arguments, const char* streams = kBoth) {
  std::string line =
      std::string(ENAMEL_STATION_PROGRAM) + " " + arguments + streams + " </dev/null";
  Outcome out;
  FILE* pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) return out;
  char buffer[4096];
  while (size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) out.text.append(buffer, n);
  int state = ::pclose(pipe);
  out.code = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
  return out;
}

TEST(CommandLineTest, WrongUsageEndsWithTwoAndNamesWhatIsNear) {
  const struct {
    const char *arguments, *said;
  } wrong[] = {{"rnu", "did you mean 'run'?"},
               {"simulate --sede 3", "did you mean '--seed'?"},
               {"simulate --seed -3", "--seed"},
               {"simulate --operator nobody", "--operator"},
               {"open --quality finest", "--quality"},
               {"open --window big", "WIDTHxHEIGHT"},
               {"run --seed -3", "--seed"}};
  for (const auto& each : wrong) {
    const Outcome out = RunProgram(each.arguments);
    EXPECT_EQ(out.code, 2) << each.arguments << ": " << out.text;
    EXPECT_NE(out.text.find(each.said), std::string::npos) << out.text;
  }
}

class ProgramTest : public testing::Test {
 protected:
  ProgramTest() {
    ::setenv("ENAMEL_PASSWORD", "secret", 1);
    ::setenv("ENAMEL_PIN", "804217", 1);
    ::unsetenv("DISPLAY");  // nothing here is to be shown
    ::unsetenv("WAYLAND_DISPLAY");
  }

  std::string data() const { return " --data " + (folder_ / "data").string(); }
  void Enrol(uint16_t port) {
    Credentials c;
    c.server = {"127.0.0.1", port};
    c.station = Uuid::New();
    c.secret_key = trace::NewKeyPair().secret_key;
    ASSERT_TRUE(SaveCredentials(folder_ / "data", c).ok());
  }

  // An attempt that the server has had whole for this long.
  Uuid KeptForDays(int days) {
    trace::Header header;
    header.ticket.attempt = Uuid::New();
    header.hand.kind = HandKind::kProgram;
    auto spool = Spool::Open(folder_ / "data");
    EXPECT_TRUE(spool.ok()) << spool.status().message();
    EXPECT_TRUE((*spool)->BeginAttempt(header, "e", "p").ok());
    trace::ChunkHead head;
    head.attempt = header.ticket.attempt;
    head.previous = HashSha256(trace::EncodeHeader(header));
    Bytes chunk =
        trace::EncodeChunk(head, std::vector<trace::Tick>(3), trace::NewKeyPair().secret_key);
    EXPECT_TRUE((*spool)->PutChunk(head.attempt, chunk).ok());
    EXPECT_TRUE((*spool)->CloseAttempt(head.attempt).ok());
    EXPECT_TRUE((*spool)->MarkCommitted(head.attempt, 0).ok());
    EXPECT_TRUE((*spool)->MarkSealedAtServer(head.attempt).ok());
    sqlite3* db = nullptr;
    EXPECT_EQ(sqlite3_open((folder_ / "data" / "spool.sqlite").c_str(), &db), SQLITE_OK);
    const std::string sql = "UPDATE attempts SET committed_unix_ms = committed_unix_ms - " +
                            std::to_string(days * int64_t{86'400'000});
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(db);
    return head.attempt;
  }
  // What a command that ends well writes with --json.
  boost::json::value FactsFrom(const std::string& command) {
    const fs::path file = folder_ / "facts.json";
    const Outcome out = RunProgram(command + " --json " + file.string() + data());
    EXPECT_EQ(out.code, 0) << out.text;
    EXPECT_FALSE(out.text.empty()) << "what people read is printed, too";
    std::ifstream in(file);
    return boost::json::parse(std::string((std::istreambuf_iterator<char>(in)), {}));
  }
  bool SpoolHas(const Uuid& attempt) { return (*Spool::Open(folder_ / "data"))->Get(attempt).ok(); }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
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

TEST_F(ProgramTest, FirstHourReplaysAFileOfAnswersAndKeepsWhatWasFoundWhenItEnds) {
  const fs::path out = folder_ / "hour.json", answers = folder_ / "answers";
  const std::string command = "first-hour --device simulated:omega3 --out " + out.string() +
                              " --answers " + answers.string();
  std::ofstream(answers) << "start.open:\nhoming.did: pit\nhoming.middle @1:\n"
                            "workspace.end: skip no room\ndirections.right.from: skip\n"
                            "directions.why: no time\nforce.x.yes: yes\n";
  const Outcome ended = RunProgram(command);
  EXPECT_EQ(ended.code, 1) << ended.text;
  EXPECT_NE(ended.text.find("has none for 'force.y.yes'"), std::string::npos) << ended.text;
  EXPECT_NE(ended.text.find("the input ended"), std::string::npos) << ended.text;
  const auto document = boost::json::parse(AsText(*ReadFile(out))).as_object();
  EXPECT_FALSE(document.at("complete").as_bool());
  EXPECT_EQ(document.at("steps").at("directions").at("reason"), "no time");
  EXPECT_EQ(document.at("steps").at("force").at("found").at("x").at("axis"), "+x");
  EXPECT_NE(document.at("computer").at("kernel").as_string(), "");

  std::ofstream(answers) << "start.open\n";
  const Outcome wrong = RunProgram(command);
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.text.find("line 1: expected ID: ANSWER"), std::string::npos) << wrong.text;
}

TEST_F(ProgramTest, FirstHourLetsNoRealUnitPushWithoutATerminal) {
  const Outcome out =
      RunProgram("first-hour --device dhd --out " + (folder_ / "hour.json").string());
  EXPECT_EQ(out.code, 1);
  EXPECT_NE(out.text.find("run this on a terminal"), std::string::npos) << out.text;
  EXPECT_FALSE(fs::exists(folder_ / "hour.json"));
}

TEST_F(ProgramTest, WrongCommandLineIsExitCodeTwo) {
  EXPECT_EQ(RunProgram("spool").code, 2);
  EXPECT_EQ(RunProgram("run").code, 2);
  EXPECT_EQ(RunProgram("no-such-thing").code, 2);
}

// Guide and unit write it so: a desktop's icon names the folder and no command.
TEST_F(ProgramTest, WithoutACommandItTakesTheOptionsOfTheWindow) {
  const std::string settings = (folder_ / "station.toml").string();
  std::ofstream(settings) << "monitor = \"HDMI-1\"\nlanguage = \"de\"\n";
  for (const std::string& arguments :
       {data(), data() + " --server 127.0.0.1:9 --window 640x480 --monitor 1 --simulated",
        "--config " + settings + data(), "--log-level=warning" + data(),
        "--log-format text --config " + settings + data() + " --language zh --no-sound",
        data() + " --config " + settings}) {
    const Outcome out = RunProgram(" " + arguments);
    EXPECT_EQ(out.code, 1) << arguments << ": " << out.text;
    EXPECT_NE(out.text.find("not enrolled"), std::string::npos) << arguments << ": " << out.text;
  }
  const struct {
    std::string arguments;
    const char* said;
  } wrong[] = {{"--dta x", "did you mean '--data'?"},
               {"--window big", "WIDTHxHEIGHT"},
               {"--data x run", "run"},
               {"--config", "--config"}};
  for (const auto& each : wrong) {
    const Outcome out = RunProgram(each.arguments);
    EXPECT_EQ(out.code, 2) << each.arguments << ": " << out.text;
    EXPECT_NE(out.text.find(each.said), std::string::npos) << out.text;
  }
  EXPECT_NE(RunProgram("--version").text.find("enamel-station"), std::string::npos);
  EXPECT_NE(RunProgram("--data x --help").text.find("--monitor"), std::string::npos);
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
  EXPECT_EQ(out.code, 2);
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
  Enrol(1);
  EXPECT_EQ(RunProgram("spool list" + data()).code, 0);
  EXPECT_EQ(RunProgram("spool verify" + data()).code, 0);
  Outcome out = RunProgram("upload" + data());
  EXPECT_EQ(out.code, 0);
  EXPECT_NE(out.text.find("nothing to upload"), std::string::npos) << out.text;
}

TEST_F(ProgramTest, DataFolderIsForItsOwnerOnly) {
  RunProgram("enrol --server 127.0.0.1:1 --code c@" + std::string(64, 'a') + data() + "/below/");
  EXPECT_EQ(fs::status(folder_ / "data" / "below").permissions(), fs::perms::owner_all);
}

TEST_F(ProgramTest, MistypedFolderIsNotAnEmptySpool) {
  for (const char* command : {"spool list", "spool verify", "spool export last --out x"}) {
    Outcome out = RunProgram(command + data());
    EXPECT_EQ(out.code, 1) << command;
    EXPECT_NE(out.text.find("there is no spool in"), std::string::npos) << out.text;
    EXPECT_FALSE(fs::exists(folder_ / "data")) << command;
  }
}

TEST_F(ProgramTest, SettingsOfAWorkplaceAreRefusedOutOfRange) {
  for (const char* option : {"--uplink-kbit -1", "--keep-days 6", "--keep-mib -1"}) {
    for (const char* command : {"open ", "run ", "reserve ", "upload ", "spool upload "}) {
      EXPECT_EQ(RunProgram(command + std::string(option) + data()).code, 2) << command << option;
    }
  }
}

// The server has had an attempt for eight days: by default it is deleted.
TEST_F(ProgramTest, SettingsFileReachesEveryCommandThatOpensTheWorkplace) {
  Enrol(1);
  const std::string settings = (folder_ / "station.toml").string();
  for (const char* command :
       {"open --window 640x480", kRun, "reserve --exercise e --profile p --user u", "upload"}) {
    for (int days : {30, 7}) {
      std::ofstream(settings) << "keep-days = " << days << "\n";
      Uuid id = KeptForDays(8);
      Outcome out = RunProgram(command + data() + " --config " + settings);
      EXPECT_EQ(SpoolHas(id), days == 30) << command << ", " << days << " days: " << out.text;
    }
  }
}

TEST_F(ProgramTest, ListSaysWhyARecordingWaitsAndSinceWhen) {
  Enrol(1);
  const Uuid id = KeptForDays(0);
  {
    auto spool = Spool::Open(folder_ / "data");
    ASSERT_TRUE((*spool)->MarkWanted(id).ok());
  }
  Outcome never = RunProgram("spool list" + data());
  EXPECT_NE(never.text.find("nothing has tried to send it yet"), std::string::npos) << never.text;
  EXPECT_EQ(RunProgram("upload" + data()).code, 1);
  Outcome doctor = RunProgram("doctor --no-graphics" + data());
  EXPECT_NE(doctor.text.find("1 not yet on the server, 0 refused by it (the last try: "),
            std::string::npos)
      << doctor.text;
  Outcome list = RunProgram("spool list" + data());
  const std::string why = "127.0.0.1:1";
  const auto since = list.text.find("; since 20"), tried = list.text.find(", last tried 20");
  EXPECT_LT(since, tried) << list.text;
  EXPECT_LT(tried, list.text.find(why)) << list.text;
  ASSERT_NE(list.text.find(why), std::string::npos) << list.text;
  const auto attempt = FactsFrom("spool list").at("attempts").at(0);
  EXPECT_NE(attempt.at("waits").at("why").as_string().find(why), std::string::npos);
  EXPECT_GT(attempt.at("waits").at("since_unix_ms").as_int64(), 0);
  EXPECT_GE(attempt.at("waits").at("tried_unix_ms").as_int64(),
            attempt.at("waits").at("since_unix_ms").as_int64());
  {
    auto spool = Spool::Open(folder_ / "data");
    ASSERT_TRUE((*spool)->MarkRefused(id, "its person is not known").ok());
  }
  list = RunProgram("spool list" + data());
  EXPECT_NE(list.text.find(": the server refuses it: its person is not known"), std::string::npos)
      << list.text;
  {
    auto spool = Spool::Open(folder_ / "data");
    ASSERT_TRUE((*spool)->ClearRefusal(id).ok());
    ASSERT_TRUE((*spool)->MarkSealedAtServer(id).ok());
  }
  EXPECT_TRUE(FactsFrom("spool list").at("attempts").at(0).at("waits").is_null());
}

TEST_F(ProgramTest, LoopsOfAnAttemptAreShownAsKept) {
  Enrol(1);
  const Uuid id = KeptForDays(0);
  Outcome none = RunProgram("spool loops last" + data());
  EXPECT_EQ(none.code, 0);
  EXPECT_NE(none.text.find("no loop of it ran to its end"), std::string::npos) << none.text;
  std::ifstream in(std::string(ENAMEL_SOURCE_DIR) + "/schemas/golden/loop_facts.json");
  const std::string golden((std::istreambuf_iterator<char>(in)), {});
  {
    auto spool = Spool::Open(folder_ / "data");
    ASSERT_TRUE((*spool)->loop_facts().Put(id, {0, 1'700'000'000'000, golden}).ok());
    ASSERT_TRUE((*spool)->loop_facts().Put(id, {1, 1'700'000'100'000, "{\"version\": 9}"}).ok());
  }
  Outcome text = RunProgram("spool loops " + id.Text() + data());
  EXPECT_EQ(text.code, 0);
  for (const char* words :
       {"run 0, ended 2023-11-", "120345 ticks, 1 late, 107 in gaps, 2 interruptions, 1 faults",
        "p99 71.0  max 107300", "fault at tick 90211: the computer was busy", "run 1, ended ",
        "{\"version\":9}"}) {
    EXPECT_NE(text.text.find(words), std::string::npos) << words << ": " << text.text;
  }
  EXPECT_EQ(text.text.find(" 0 ticks"), std::string::npos) << "nothing is made up: " << text.text;
  EXPECT_EQ(FactsFrom("spool loops last").at("runs").at(0).at("facts"), boost::json::parse(golden));
}

TEST_F(ProgramTest, WhereTheLogIsJsonSoIsAllOfStandardError) {
  Enrol(1);
  const std::string settings = (folder_ / "station.toml").string();
  std::ofstream(settings) << "keep-dayz = 3\n";
  struct Case {
    std::string arguments, says;
    int code;
  };
  for (const Case& c :
       {Case{kRun + data(), "127.0.0.1:1", 1}, Case{"run --no-such-option", "--no-such-option", 2},
        Case{"run --user u", "--exercise and --profile", 2},
        Case{"spool list --config " + settings + data(), "keep-dayz", 2},
        Case{"spool export last --out " + (folder_ / "x").string() + data(),
             "there is no such attempt", 1},
        Case{"run '--\xff'", "--\xef\xbf\xbd", 2},
        Case{"calibrate --device spacemouse", "only devices with motors", 1}}) {
    Outcome out = RunProgram("--log-format json " + c.arguments, kErrors);
    EXPECT_EQ(out.code, c.code) << c.arguments << ": " << out.text;
    std::istringstream lines(out.text);
    std::string line, last;
    while (std::getline(lines, line)) {
      boost::system::error_code error;
      EXPECT_TRUE(boost::json::parse(line, error).is_object() && !error) << line;
      last = line;
    }
    ASSERT_FALSE(last.empty()) << c.arguments;
    EXPECT_EQ(boost::json::parse(last).at("level").as_string(), "error");
    EXPECT_NE(boost::json::parse(last).at("message").as_string().find(c.says), std::string::npos)
        << last;
  }
}

// Somebody on a terminal reads the same settings file.
TEST_F(ProgramTest, UnitsAskForJsonLogsAndTheSettingsFileDoesNot) {
  const fs::path ops = fs::path(ENAMEL_SOURCE_DIR) / "station/ops";
  const std::string command =
      "verify nothing" + data() + " --config " + (ops / "station.toml").string();
  EXPECT_TRUE(RunProgram(command, kErrors).text.starts_with("enamel-station: "));
  ::setenv("ENAMEL_STATION_LOG_FORMAT", "json", 1);
  EXPECT_TRUE(RunProgram(command, kErrors).text.starts_with("{\"time\":"));
  ::unsetenv("ENAMEL_STATION_LOG_FORMAT");
  int units = 0;
  for (const auto& file : fs::directory_iterator(ops)) {
    if (file.path().extension() != ".service") continue;
    ++units;
    EXPECT_NE(AsText(*ReadFile(file.path())).find("\nEnvironment=ENAMEL_STATION_LOG_FORMAT=json\n"),
              std::string::npos)
        << file.path();
  }
  EXPECT_EQ(units, 2);
}

TEST_F(ProgramTest, WhereTheLogIsJsonNoProgressIsShown) {
  const std::string arguments = "calibrate --device simulated:bhhd3";
  const Outcome out = RunProgram("--log-format json " + arguments, kErrors);
  EXPECT_EQ(out.code, 0) << out.text;
  EXPECT_EQ(out.text, "");
  EXPECT_NE(RunProgram(arguments, kErrors).text, "") << "it has progress to show";
}

TEST_F(ProgramTest, UnknownSettingIsAnsweredAlikeByEveryCommand) {
  Enrol(1);
  const std::string settings = (folder_ / "station.toml").string();
  std::ofstream(settings) << "keep-dayz = 3\n";
  std::string first;
  for (const char* command : {kRun, "spool list", "upload", "doctor", "open", ""}) {
    Outcome out = RunProgram(command + std::string(" --config ") + settings);
    const auto at = out.text.find(settings + ":1:1: expected one of ");
    ASSERT_NE(at, std::string::npos) << command << ": " << out.text;
    const std::string said = out.text.substr(at, out.text.find('\n', at) - at);
    if (first.empty()) first = said;
    EXPECT_EQ(said, first) << command;
    EXPECT_NE(said.find("keep-days"), std::string::npos) << said;
  }
}

TEST_F(ProgramTest, RefusedRecordingIsCountedAndToldAndFailsTheUpload) {
  Enrol(1);
  Uuid id = KeptForDays(0);
  {
    auto spool = Spool::Open(folder_ / "data");
    ASSERT_TRUE((*spool)->MarkRefused(id, "its person is not known").ok());
  }
  Outcome list = RunProgram("spool list" + data());
  EXPECT_NE(list.text.find("1 that it refuses"), std::string::npos) << list.text;
  EXPECT_NE(list.text.find("its person is not known"), std::string::npos) << list.text;
  Outcome doctor = RunProgram("doctor --no-graphics" + data());
  EXPECT_NE(doctor.text.find("1 refused by it"), std::string::npos) << doctor.text;
  Outcome upload = RunProgram("upload" + data());
  EXPECT_EQ(upload.code, 1);
  EXPECT_NE(upload.text.find("its person is not known"), std::string::npos) << upload.text;
  EXPECT_NE(upload.text.find("--again " + id.Text()), std::string::npos) << upload.text;
  RunProgram("spool upload --again " + id.Text() + data());
  EXPECT_TRUE((*Spool::Open(folder_ / "data"))->Get(id)->refused.empty());
}

// Overwrites a page in the middle of the older of two recordings.
TEST_F(ProgramTest, UploadSendsWhatCanBeReadAndFailsNamingWhatCannot) {
  FakeServer server(folder_);
  ASSERT_TRUE(SaveCredentials(folder_ / "data", server.NewStation()).ok());
  const auto keys = trace::NewKeyPair();
  std::vector<Uuid> ids;
  Bytes hit;
  for (uint32_t chunks : {300U, 3U}) {
    const trace::Header header = HeaderOf(server.person);
    ids.push_back(header.ticket.attempt);
    auto spool = Spool::Open(folder_ / "data");
    ASSERT_TRUE((*spool)->BeginAttempt(header, "e", "p").ok());
    trace::ChunkHead head;
    head.attempt = header.ticket.attempt;
    head.previous = HashSha256(trace::EncodeHeader(header));
    for (head.seq = 0; head.seq < chunks; ++head.seq) {
      const Bytes chunk = trace::EncodeChunk(head, std::vector<trace::Tick>(3), keys.secret_key);
      ASSERT_TRUE((*spool)->PutChunk(head.attempt, chunk).ok());
      head.previous = HashSha256(chunk);
      head.first_tick += 3;
      if (head.seq == 200) hit = chunk;
    }
    ASSERT_TRUE((*spool)->CloseAttempt(head.attempt).ok());
    ::usleep(2000);  // the next is begun later, by the clock
  }
  const fs::path file = folder_ / "data" / "spool.sqlite";
  {
    const Bytes all = *ReadFile(file);
    const auto at = std::search(all.begin(), all.end(), hit.begin(), hit.end());
    ASSERT_NE(at, all.end());
    std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp((at - all.begin()) / 4096 * 4096);
    out << std::string(4096, '\x5a');
  }
  const Outcome upload = RunProgram("upload" + data());
  EXPECT_EQ(upload.code, 1) << upload.text;
  for (const std::string& words :
       {"attempt " + ids[0].Text() + " cannot be sent whole", std::string("spool salvage"),
        ids[1].Text() + "  uploaded  3 of 3 chunks"}) {
    EXPECT_NE(upload.text.find(words), std::string::npos) << words << ": " << upload.text;
  }
  const auto attempts = FactsFrom("spool list").at("attempts");
  EXPECT_NE(attempts.at(0).at("waits").at("why").as_string().find("damaged"), std::string::npos);
  EXPECT_TRUE(attempts.at(1).at("waits").is_null());
}

TEST_F(ProgramTest, PlaceThatCannotBeWrittenIsRefusedBeforeTheWork) {
  std::string nowhere = (folder_ / "none" / "facts.json").string();
  std::string file = (folder_ / "file").string();
  std::fclose(std::fopen(file.c_str(), "w"));
  for (const std::string& arguments :
       {"simulate --json " + nowhere, "simulate --json " + folder_.string(),
        kRun + data() + " --json " + nowhere,
        "import nothing.stl --tooth 46 --unit mm --out " + file + "/scene"}) {
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

// As over ssh.
TEST_F(ProgramTest, DoctorDoesNotFailAChairForASessionWithoutADisplay) {
  const Outcome out = RunProgram("doctor" + data());
  const auto at = out.text.find("warn  graphics");
  ASSERT_NE(at, std::string::npos) << out.text;
  for (const char* said : {"not checked", "DISPLAY=:0 enamel-station doctor"}) {
    EXPECT_NE(out.text.find(said, at), std::string::npos) << out.text;
  }
  // A display that was named and does not answer is a failure.
  ::setenv("DISPLAY", ":17999", 1);
  EXPECT_NE(RunProgram("doctor" + data()).text.find("fail  graphics"), std::string::npos);
  ::unsetenv("DISPLAY");
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
  Outcome again = RunProgram("calibrate --device simulated:" + out_file + " --profile " + out_file);
  EXPECT_EQ(again.code, 0) << again.text;
}

TEST_F(ProgramTest, CalibrateRefusesWhatHasNoMotorsAndWhatIsNotThere) {
  Outcome mouse = RunProgram("calibrate --device spacemouse");
  EXPECT_EQ(mouse.code, 1);
  EXPECT_NE(mouse.text.find("only devices with motors"), std::string::npos) << mouse.text;
  Outcome nothing = RunProgram("calibrate --device simulated:nothing");
  EXPECT_EQ(nothing.code, 1);
  EXPECT_NE(nothing.text.find("omega3"), std::string::npos) << nothing.text;
}

// Whether the program's error is JSON tells which log-format it took.
TEST_F(ProgramTest, SettingsFromTheServerAreKeptTakenAndSaid) {
  const std::string file = (folder_ / "station.toml").string();
  const auto is_json = [&](const std::string& more) {
    const Outcome out = RunProgram("verify nothing" + data() + " --config " + file + more, kErrors);
    return out.text.starts_with("{");
  };
  {
    FakeServer server(folder_);
    ASSERT_TRUE(SaveCredentials(folder_ / "data", server.NewStation()).ok());
    std::ofstream(file) << "";
    EXPECT_FALSE(is_json(""));
    server.Set("log-format", "json", false);
    server.Set("keep-days", "30", true);
    EXPECT_EQ(RunProgram("upload" + data()).code, 0);
    // From now on without it.
  }
  EXPECT_TRUE(is_json(""));
  EXPECT_FALSE(is_json(" --log-format text"));
  std::ofstream(file) << "log-format = 'text'\nkeep-days = 10\n";
  EXPECT_FALSE(is_json(""));
  const Outcome doctor = RunProgram("doctor --no-graphics --config " + file + data());
  for (const char* said : {"from the server: keep-days 30 (fixed)",
                           "not taken, as this chair sets its own: log-format json"}) {
    EXPECT_NE(doctor.text.find(said), std::string::npos) << doctor.text;
  }
  {
    FakeServer server(folder_);
    ASSERT_TRUE(SaveCredentials(folder_ / "data", server.NewStation()).ok());
    server.Set("log-format", "json", true);
    server.Set("moon", "1", false);
    server.Set("keep-days", "3", true);
    EXPECT_EQ(RunProgram("upload" + data()).code, 0);
  }
  EXPECT_TRUE(is_json(""));
  const Outcome list = RunProgram("upload --log-format text --config " + file + data());
  for (const char* said : {"no setting is called moon; ignored", "keep-days: "}) {
    EXPECT_NE(list.text.find(said), std::string::npos) << list.text;
  }
  EXPECT_NE(
      RunProgram("doctor --no-graphics" + data()).text.find("not known here, and ignored: moon 1"),
      std::string::npos);
}

}  // namespace
}  // namespace enamel::station
