#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "common/base/file.h"
#include "server/storage/engine/database.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/open_store.h"
#include "tests/server/storage/store_world.h"

// The program itself: its output and its end.
namespace enamel::server {
namespace {

using namespace testing;

class Program {
 public:
  explicit Program(std::vector<std::string> arguments) {
    int ends[2];
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::alarm(60);  // Bounds the test whatever happens to it.
      ::dup2(ends[1], STDOUT_FILENO);
      ::dup2(ends[1], STDERR_FILENO);
      std::vector<char*> argv{const_cast<char*>(ENAMEL_SERVER_PROGRAM)};
      for (auto& argument : arguments) argv.push_back(argument.data());
      argv.push_back(nullptr);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(ends[1]);
    out_ = ends[0];
  }
  ~Program() {
    if (!ended_) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    ::close(out_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // Reads until `text` or the end; returns everything read so far.
  std::string ReadUntil(const std::string& text) {
    char byte = 0;
    while (said_.find(text) == std::string::npos && ::read(out_, &byte, 1) == 1)
      said_.push_back(byte);
    return said_;
  }
  std::string ReadAll() { return ReadUntil(std::string(1, '\0')); }
  void Signal(int signal) { ::kill(pid_, signal); }
  int ExitCode() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
  int out_ = -1;
  bool ended_ = false;
  std::string said_;
};

class ServeProcessTest : public ::testing::Test {
 protected:
  std::vector<std::string> Serve(const std::string& folder,
                                 const std::string& stations = "127.0.0.1:0") const {
    return {"serve", "--data", folder, "--http", "127.0.0.1:0", "--stations", stations};
  }
  std::string Data() const { return (folder_.path() / "data").string(); }
  TempFolder folder_;
};

TEST_F(ServeProcessTest, SaysReadyAndEndsCleanlyOnTerm) {
  for (int signal : {SIGTERM, SIGINT}) {
    Program server(Serve(Data()));
    std::string said = server.ReadUntil("fingerprint");
    EXPECT_NE(said.find("ready: page http://127.0.0.1:"), std::string::npos) << said;
    server.Signal(signal);
    server.ReadAll();
    EXPECT_EQ(server.ExitCode(), 0);
  }
}

// A terminal's Ctrl-C comes to the whole group, and its leader asks once more: one wish, not two.
TEST_F(ServeProcessTest, SeveralSignalsAtOnceEndItCleanlyToo) {
  Program server(Serve(Data()));
  server.ReadUntil("fingerprint");
  for (int signal : {SIGINT, SIGTERM, SIGINT, SIGTERM}) server.Signal(signal);
  std::string said = server.ReadAll();
  EXPECT_NE(said.find("stopped"), std::string::npos) << said;
  EXPECT_EQ(server.ExitCode(), 0);
}

// As while `admin erase-person` rewrites a large database beside it.
TEST_F(ServeProcessTest, BeginsAndEndsWhileAnotherProcessErasesAndKeepsTheDatabase) {
  OpenStore(Data());
  std::ofstream(Data() + "/REWRITE").close();
  auto upkeep = TakeUpkeepLock(Data(), FolderLock::Mode::kExclusive);
  ASSERT_TRUE(upkeep.ok()) << upkeep.status().message();
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((Data() + "/enamel.db").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  {
    Program server(Serve(Data()));
    std::string said = server.ReadUntil("fingerprint");
    EXPECT_NE(said.find("ready: page"), std::string::npos) << said;
    server.Signal(SIGTERM);
    said = server.ReadAll();
    EXPECT_NE(said.find("stopped"), std::string::npos) << said;
    EXPECT_EQ(server.ExitCode(), 0);
  }
  sqlite3_close(other);
}

TEST_F(ServeProcessTest, SecondServerOnTheFolderIsRefused) {
  Program first(Serve(Data()));
  first.ReadUntil("fingerprint");
  Program second(Serve(Data()));
  std::string said = second.ReadAll();
  EXPECT_NE(said.find("another enamel-server"), std::string::npos) << said;
  EXPECT_EQ(second.ExitCode(), 1);
}

TEST_F(ServeProcessTest, PortInUseIsRefused) {
  Program first(Serve(Data()));
  std::string said = first.ReadUntil(", fingerprint");
  size_t at = said.find("stations ") + 9;
  std::string taken = said.substr(at, said.find(',', at) - at);
  Program second(Serve((folder_.path() / "other").string(), taken));
  EXPECT_NE(second.ReadAll().find("name another one"), std::string::npos);
  EXPECT_EQ(second.ExitCode(), 1);
}

TEST_F(ServeProcessTest, FolderThatCannotBeMadeIsRefused) {
  Program server(Serve("/proc/enamel"));
  std::string said = server.ReadAll();
  EXPECT_NE(said.find("name a folder this user may write"), std::string::npos) << said;
  EXPECT_EQ(server.ExitCode(), 1);
}

TEST_F(ServeProcessTest, NewerDatabaseIsRefused) {
  OpenStore(Data());
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open((Data() + "/enamel.db").c_str(), &handle), SQLITE_OK);
  std::string sql = "PRAGMA user_version = " + std::to_string(LatestSchemaVersion() + 1);
  EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(handle);
  Program server(Serve(Data()));
  std::string said = server.ReadAll();
  EXPECT_NE(said.find("newer enamel-server"), std::string::npos) << said;
  EXPECT_EQ(server.ExitCode(), 1);
}

TEST_F(ServeProcessTest, AddressThatIsNoneIsNamedWithItsOption) {
  Program server(Serve(Data(), "nowhere"));
  EXPECT_NE(server.ReadAll().find("--stations expects address:port"), std::string::npos);
  EXPECT_EQ(server.ExitCode(), 1);
}

TEST_F(ServeProcessTest, WrongUsageEndsWithTwo) {
  Program server({"serve", "--nonsense"});
  EXPECT_FALSE(server.ReadAll().empty());
  EXPECT_EQ(server.ExitCode(), 2);
}

TEST_F(ServeProcessTest, FolderOfTheCommandLineCountsMoreThanTheEnvironments) {
  const std::string other = (folder_.path() / "other").string();
  ::setenv("ENAMEL_DATA", other.c_str(), 1);
  Program given({"init", "--data", Data()});
  given.ReadAll();
  EXPECT_EQ(given.ExitCode(), 0);
  EXPECT_TRUE(std::filesystem::exists(Data() + "/enamel.db"));
  EXPECT_FALSE(std::filesystem::exists(other));
  Program inherited({"init"});
  inherited.ReadAll();
  EXPECT_EQ(inherited.ExitCode(), 0);
  EXPECT_TRUE(std::filesystem::exists(other + "/enamel.db"));
  ::unsetenv("ENAMEL_DATA");
  Program neither({"admin", "enrol-code"});
  EXPECT_NE(neither.ReadAll().find("--data"), std::string::npos);
  EXPECT_EQ(neither.ExitCode(), 2);
}

// The printed settings are a file that the server takes, and the one that comes with it is one too.
TEST_F(ServeProcessTest, SettingsComeFromTheFileThatComesWithTheServer) {
  Program print({"serve", "--config", ENAMEL_SOURCE_DIR "/server/ops/server.toml",
                 "--print-settings", "--min-free-mib", "77"});
  std::string said = print.ReadAll();
  EXPECT_EQ(print.ExitCode(), 0) << said;
  EXPECT_NE(said.find("log-format = 'text'"), std::string::npos) << said;
  EXPECT_NE(said.find("min-free-mib = '77'"), std::string::npos) << said;
  std::string file = (folder_.path() / "printed.toml").string();
  ASSERT_TRUE(WriteFileDurably(file, AsBytes(said)).ok());
  Program again({"serve", "--config", file, "--print-settings"});
  EXPECT_EQ(again.ReadAll(), said);
  EXPECT_EQ(again.ExitCode(), 0);
}

// Not the settings file, which commands on a terminal read, too.
TEST_F(ServeProcessTest, EveryUnitAsksForJsonLogs) {
  int units = 0;
  for (const auto& file : std::filesystem::directory_iterator(ENAMEL_SOURCE_DIR "/server/ops")) {
    if (file.path().extension() != ".service") continue;
    ++units;
    EXPECT_NE(AsText(*ReadFile(file.path())).find("\nEnvironment=ENAMEL_LOG_FORMAT=json\n"),
              std::string::npos)
        << file.path();
  }
  EXPECT_EQ(units, 3);
  ::setenv("ENAMEL_LOG_FORMAT", "json", 1);
  Program refused({"admin", "list-people", "--data", Data()});
  EXPECT_TRUE(refused.ReadAll().starts_with("{\"time\":"));
  ::unsetenv("ENAMEL_LOG_FORMAT");
}

TEST_F(ServeProcessTest, EnrolCodeIsOneWordWithTheFingerprint) {
  Program init({"init", "--data", Data()});
  init.ReadAll();
  ASSERT_EQ(init.ExitCode(), 0);
  Program server({"admin", "enrol-code", "--data", Data()});
  std::string said = server.ReadAll();
  EXPECT_EQ(said.size(), 32u + 1 + 64 + 1) << said;
  EXPECT_EQ(said.at(32), '@');
  EXPECT_EQ(server.ExitCode(), 0);
}

}  // namespace
}  // namespace enamel::server
