#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

// The tree's layers, as a table: which directories a directory may include from. Downward only. The
// table is the design (CONTRIBUTING.md, "Layers"); the sources and the link graph must agree with
// it.
namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

const fs::path kRoot = ENAMEL_SOURCE_DIR;

const std::map<std::string, Names>& Allowed() {
  static const std::map<std::string, Names> table = [] {
    // Direct dependencies; Closure() adds what those may include.
    std::map<std::string, Names> t = {
        {"common/base", {}},
        {"common/language", {"common/base", "common/scoring"}},
        {"common/sql", {"common/base"}},
        {"common/sqlite", {"common/sql"}},
        {"server/postgres", {"common/sql"}},
        {"server/s3", {"common/base"}},
        {"common/math", {"common/base"}},
        {"common/board", {}},
        {"common/haptics", {"common/board", "common/math"}},
        {"common/cutting", {"common/math"}},
        {"common/core", {"common/haptics", "common/cutting"}},
        {"common/scene", {"common/core"}},
        {"common/fidelity", {"common/scene"}},
        {"common/surface", {"common/core"}},
        {"common/mesh", {"common/math"}},
        {"common/import", {"common/mesh", "common/scene", "common/surface"}},
        {"common/hands", {"common/base"}},
        {"common/trace", {"common/core", "common/hands"}},
        {"common/scoring", {"common/scene", "common/surface", "common/trace"}},
        {"common/timeline", {"common/scene", "common/surface"}},
        {"common/protocol", {"common/hands"}},
        {"common/net", {"common/protocol"}},
        {"common/program", {"common/base"}},
        {"station/devices", {"common/core", "common/fidelity", "common/hands", "common/scene"}},
        {"station/hid", {"common/board", "station/devices", "common/scene"}},
        {"station/sdk", {"station/hid", "station/devices", "common/scene"}},
        {"station/loop", {"station/devices", "common/trace"}},
        {"station/render", {"common/core", "common/language", "common/surface"}},
        {"station/mouth", {"station/render", "common/scene", "common/surface"}},
        {"station/spool", {"station/loop", "common/protocol", "common/sqlite", "common/trace"}},
        {"station/uplink", {"station/spool", "common/net", "common/trace", "common/scene"}},
        {"station/session", {"station/uplink", "station/devices", "station/loop", "common/scene"}},
        {"station/sound", {"common/base"}},
        {"station/words", {"common/language", "common/scoring"}},
        {"station/desk",
         {"station/session", "station/sound", "station/words", "station/mouth", "station/render",
          "station/sdk", "station/hid", "station/devices", "station/loop", "common/language",
          "common/scoring", "common/scene", "common/timeline"}},
        {"station/lab/devices", {"common/math"}},
        {"station/lab/cutting", {"common/scoring"}},
        {"station/lab/grades",
         {"common/scoring", "station/devices", "station/loop", "station/lab/laws"}},
        {"station/lab/sheet", {"station/lab/grades", "station/words", "common/language"}},
        {"station/lab/laws", {"common/fidelity"}},
        {"station/lab/suites", {"station/lab/cutting", "station/lab/grades", "station/lab/laws"}},
        {"station/lab/report", {"station/lab/suites", "common/program"}},
        {"station/lab/tissue", {"station/lab/report", "common/program"}},
        {"station/lab/bench",
         {"station/lab/grades", "station/lab/cutting", "station/lab/devices", "station/desk",
          "station/sdk", "station/session", "station/spool", "station/devices", "station/mouth",
          "station/render", "common/import", "common/program", "common/scoring",
          "common/timeline"}},
        {"station/lab/pictures", {"station/desk"}},
        {"station/lab/app",
         {"station/lab/bench", "station/lab/pictures", "station/lab/grades", "station/lab/report",
          "station/lab/sheet", "station/lab/tissue", "station/devices", "station/mouth",
          "common/import", "common/program"}},
        {"station/app",
         {"station/devices", "station/hid", "station/sdk", "station/loop", "station/render",
          "station/spool", "station/uplink", "station/session", "station/desk", "common/language",
          "common/program", "common/import", "common/scene", "common/scoring"}},
        {"server/ops", {"common/base"}},
        {"server/net", {"common/base"}},
        {"server/training", {"common/hands"}},
        {"server/agreement", {"common/base"}},
        {"server/results", {"server/training", "common/trace"}},
        {"server/storage",
         {"server/ops", "server/training", "server/results", "common/sqlite", "server/postgres",
          "server/s3", "common/protocol", "common/trace", "common/scene", "common/scoring"}},
        {"server/auth", {"server/storage"}},
        {"server/roster", {"server/auth", "server/storage", "server/training"}},
        {"server/live", {"server/training", "server/storage", "common/protocol", "common/trace"}},
        {"server/stations",
         {"server/auth", "server/live", "server/net", "server/ops", "server/storage", "server/jobs",
          "common/net", "common/trace", "common/scene"}},
        {"server/jobs",
         {"server/storage", "server/results", "server/agreement", "common/fidelity",
          "common/import", "common/scoring", "common/timeline"}},
        {"server/http",
         {"server/auth", "server/roster", "server/live", "server/net", "server/ops",
          "server/storage", "server/jobs", "server/agreement", "common/scene", "common/net"}},
        {"server/app",
         {"server/http", "server/ops", "server/stations", "server/jobs", "common/import"}},
        {"server/doctor",
         {"server/app", "common/program", "common/net", "server/postgres", "server/s3"}},
        {"server/commands",
         {"server/app", "server/doctor", "common/program", "server/agreement", "common/scoring",
          "common/language"}},
    };
    bool grew = true;
    while (grew) {
      grew = false;
      for (auto& [name, uses] : t) {
        Names more = uses;
        for (const auto& u : uses) more.insert(t.at(u).begin(), t.at(u).end());
        grew |= more.size() > uses.size();
        uses = more;
      }
    }
    return t;
  }();
  return table;
}

std::string ReadAll(const fs::path& path) {
  std::ifstream in(path);
  std::stringstream out;
  out << in.rdbuf();
  return out.str();
}

std::vector<fs::path> Sources(const std::string& folder) {
  std::vector<fs::path> out;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    auto ext = entry.path().extension();
    if (ext == ".h" || ext == ".cpp" || ext == ".c") out.push_back(entry.path());
  }
  return out;
}

// The nearest enclosing folder that is in the table; empty: none.
std::string FolderOf(std::string path) {
  for (size_t end; (end = path.rfind('/')) != std::string::npos;) {
    path.resize(end);
    if (Allowed().count(path)) return path;
  }
  return "";
}

std::vector<std::string> Includes(const fs::path& file) {
  static const std::regex pattern(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
  std::vector<std::string> out;
  std::istringstream lines(ReadAll(file));
  for (std::string line; std::getline(lines, line);) {
    std::smatch m;
    if (std::regex_search(line, m, pattern)) out.push_back(m[1].str() + m[2].str());
  }
  return out;
}

TEST(LayeringTest, EveryDirectoryHasItsPlaceInTheTable) {
  for (const char* area : {"common", "station", "server"}) {
    for (const auto& file : Sources(area)) {
      std::string name = fs::relative(file, kRoot).string();
      EXPECT_NE(FolderOf(name), "") << name << " is in no folder of the layering table";
    }
  }
}

TEST(LayeringTest, IncludesPointDownward) {
  for (const auto& [folder, allowed] : Allowed()) {
    if (!fs::exists(kRoot / folder)) continue;
    for (const auto& file : Sources(folder)) {
      for (const auto& include : Includes(file)) {
        if (include[0] != '"') continue;
        std::string used = FolderOf(include.substr(1));
        if (used.empty() || used == folder) continue;
        EXPECT_TRUE(allowed.count(used)) << file << " includes " << include.substr(1);
      }
    }
  }
}

// The link graph must agree: a target names only directories its folder may use.
TEST(LayeringTest, LinkGraphAgreesWithTheTable) {
  static const std::regex target(R"re(enamel_((?:common|station|server)_[a-z0-9_]+))re");
  for (const auto& [folder, allowed] : Allowed()) {
    fs::path list = kRoot / folder / "CMakeLists.txt";
    if (!fs::exists(list)) continue;
    std::string text = std::regex_replace(ReadAll(list), std::regex("#[^\n]*"), "");
    for (std::sregex_iterator it(text.begin(), text.end(), target), end; it != end; ++it) {
      std::string used = (*it)[1].str();
      std::replace(used.begin(), used.end(), '_', '/');
      used = FolderOf(used + "/");
      if (used == folder || used.empty()) continue;
      EXPECT_TRUE(allowed.count(used)) << list << " links " << used;
    }
  }
}

struct Ban {
  const char* what;
  const char* pattern;               // of the include line's target
  std::vector<std::string> only_in;  // folders that may; everything else may not
};

TEST(LayeringTest, LibrariesStayInTheirRooms) {
  const std::vector<Ban> bans = {
      {"SQLite", R"re(^<sqlite3\.h)re", {"common/sqlite"}},
      {"libpq", R"re(^<libpq)re", {"server/postgres"}},
      {"libcurl", R"re(^<curl/)re", {"server/s3"}},
      {"OpenGL", R"re(^<(epoxy|GL|GLFW)/)re", {"station/render"}},
      {"hidapi", R"re(^<hidapi)re", {"station/hid"}},
      {"libusb", R"re(^<libusb)re", {"station/sdk"}},
      {"libsodium",
       R"re(^<sodium)re",
       {"common/base", "server/s3", "common/trace", "server/auth", "server/storage", "server/app",
        "server/commands", "server/doctor", "station/app", "common/net", "server/stations",
        "station/session", "station/uplink"}},
  };
  for (const auto& ban : bans) {
    std::regex pattern(ban.pattern);
    for (const auto& [folder, unused] : Allowed()) {
      if (!fs::exists(kRoot / folder)) continue;
      if (std::find(ban.only_in.begin(), ban.only_in.end(), folder) != ban.only_in.end()) continue;
      for (const auto& file : Sources(folder))
        for (const auto& include : Includes(file))
          EXPECT_FALSE(std::regex_search(include, pattern)) << ban.what << " in " << file;
    }
  }
}

// Code that needs another table or query asks one of the two for it. What a driver says to its own
// engine is the driver's.
TEST(LayeringTest, SqlIsWrittenInServerStorageAndStationSpoolOnly) {
  const std::regex sql(
      R"re("(SELECT|INSERT (OR [A-Z]+ )?INTO|UPDATE [a-z_]+ SET|DELETE FROM|CREATE (TABLE|INDEX|TRIGGER)|DROP TABLE|ALTER TABLE|PRAGMA|BEGIN|COMMIT|ROLLBACK|SAVEPOINT|VACUUM)\b)re");
  EXPECT_TRUE(std::regex_search(R"sql(Query q(db, "SELECT id FROM people"))sql", sql));
  EXPECT_TRUE(std::regex_search(R"sql(Exec("INSERT OR REPLACE INTO t VALUES (1)"))sql", sql));
  size_t found = 0;
  for (const auto& [folder, unused] : Allowed()) {
    if (!fs::exists(kRoot / folder)) continue;
    const bool may = folder == "server/storage" || folder == "station/spool" ||
                     folder == "common/sqlite" || folder == "server/postgres";
    for (const auto& file : Sources(folder)) {
      std::istringstream lines(ReadAll(file));
      int number = 0;
      for (std::string line; std::getline(lines, line);) {
        ++number;
        const bool is = std::regex_search(line.substr(0, line.find("//")), sql);
        found += is;
        EXPECT_TRUE(may || !is) << file << ":" << number << ": " << line;
      }
    }
  }
  EXPECT_GT(found, 150u) << "the pattern finds the store's statements";
}

TEST(LayeringTest, CoreAndTickFoldersUseNothingThatBlocksOrVaries) {
  std::regex banned(
      R"re(^<(iostream|fstream|mutex|shared_mutex|condition_variable|filesystem|thread|random|unordered_map|unordered_set|boost/|sqlite3|epoxy|GL/|GLFW/|spdlog/))re");
  for (const char* folder :
       {"common/board", "common/math", "common/haptics", "common/cutting", "common/core"})
    for (const auto& file : Sources(folder)) {
      for (const auto& include : Includes(file)) {
        EXPECT_FALSE(std::regex_search(include, banned)) << file << " includes " << include;
      }
    }
  std::regex in_loop(R"re(^<(iostream|mutex|filesystem|boost/|sqlite3|epoxy|GL/|GLFW/))re");
  if (!fs::exists(kRoot / "station/loop")) return;
  for (const auto& file : Sources("station/loop")) {
    for (const auto& include : Includes(file)) {
      EXPECT_FALSE(std::regex_search(include, in_loop)) << file << " includes " << include;
    }
  }
}

// The core's promise of equal bits: + - * / sqrt and integers only.
TEST(LayeringTest, CoreCallsNoLibmTranscendental) {
  std::regex call(
      R"re(\b(std::|glm::)?(sin|cos|tan|asin|acos|atan|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|tanh|sinh|cosh|fma|slerp|lround|rotate|angle)\s*\()re");
  for (const char* folder :
       {"common/board", "common/haptics", "common/cutting", "common/core", "common/math"}) {
    for (const auto& file : Sources(folder)) {
      if (file.filename() == "orientation.cpp")
        continue;  // ToQuantised, for edges, rounds with lround
      std::istringstream lines(ReadAll(file));
      int number = 0;
      for (std::string line; std::getline(lines, line);) {
        ++number;
        std::string code = line.substr(0, line.find("//"));
        EXPECT_FALSE(std::regex_search(code, call)) << file << ":" << number << ": " << line;
      }
    }
  }
}

TEST(LayeringTest, BeastStaysOutOfHeaders) {
  for (const char* area : {"server", "station", "common"}) {
    for (const auto& file : Sources(area)) {
      if (file.extension() != ".h") continue;
      for (const auto& include : Includes(file)) {
        EXPECT_EQ(include.find("<boost/beast"), std::string::npos) << file;
      }
    }
  }
}

// The thread sanitizer runs over these folders of common/ only (tests/common/CMakeLists.txt): those whose sources
// or tests start a thread or share something between threads.
TEST(LayeringTest, EveryFolderWithThreadsIsLookedAtByTheThreadSanitizer) {
  const std::string list = ReadAll(kRoot / "tests/common/CMakeLists.txt");
  std::smatch m;
  ASSERT_TRUE(std::regex_search(list, m, std::regex(R"(foreach\(dir ([a-z0-9 ]+)\))")));
  std::istringstream words(m[1].str());
  const Names listed{std::istream_iterator<std::string>(words), {}};
  std::regex shared(R"re(^<(atomic|condition_variable|future|mutex|shared_mutex|thread)>?$)re");
  Names found;
  for (const char* area : {"common", "tests/common"}) {
    for (const auto& file : Sources(area)) {
      for (const auto& include : Includes(file)) {
        if (std::regex_search(include, shared))
          found.insert(fs::relative(file, kRoot / area).begin()->string());
      }
    }
  }
  EXPECT_EQ(found, listed);
}

TEST(LayeringTest, DomainKnowsNoTransportStorageOrText) {
  std::regex banned(R"re(^<(boost/|sqlite3|openssl/|google/))re");
  for (const auto& file : Sources("server/training"))
    for (const auto& include : Includes(file))
      EXPECT_FALSE(std::regex_search(include, banned)) << file << " includes " << include;
}

}  // namespace
