#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdlib>
#include <fstream>
#include <mutex>
#include <set>
#include <string>

#include "tests/server/storage/store_world.h"

// With ENAMEL_STATEMENTS=FILE, writes every statement that ran in this process to FILE.statements
// and a new store's tables to FILE.tables, each ended by a line "--". postgres.sh reads them.
namespace {

struct Log {
  std::mutex mutex;
  std::set<std::string> statements;  // guarded by mutex
};

Log& TheLog() {
  static Log log;
  return log;
}

int Note(unsigned what, void*, void* subject, void* text) {
  Log& log = TheLog();
  if (what == SQLITE_TRACE_STMT) {
    // What a trigger runs comes as a comment.
    const char* sql = sqlite3_sql(static_cast<sqlite3_stmt*>(subject));
    if (sql == nullptr || std::string(static_cast<const char*>(text)).starts_with("--")) return 0;
    std::lock_guard lock(log.mutex);
    log.statements.insert(sql);
  }
  return 0;
}

int Watch(sqlite3* db, char**, const sqlite3_api_routines*) {
  sqlite3_trace_v2(db, SQLITE_TRACE_STMT, Note, nullptr);
  return SQLITE_OK;
}

class StatementLog final : public ::testing::Environment {
 public:
  explicit StatementLog(std::string file) : file_(std::move(file)) {
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(Watch));
  }
  void TearDown() override {
    std::ofstream tables(file_ + ".tables");
    const enamel::test::TempFolder folder;
    enamel::server::testing::OpenStore(folder.path()).reset();
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open((folder.path() / "enamel.db").c_str(), &db), SQLITE_OK);
    auto write = [](void* into, int, char** columns, char**) {
      *static_cast<std::ofstream*>(into) << columns[0] << "\n--\n";
      return 0;
    };
    sqlite3_exec(db, "SELECT sql FROM sqlite_master WHERE type = 'table' ORDER BY rowid", write,
                 &tables, nullptr);
    sqlite3_close(db);
    EXPECT_TRUE(tables.good());
    std::ofstream out(file_ + ".statements");
    for (const std::string& sql : TheLog().statements) out << sql << "\n--\n";
    EXPECT_TRUE(out.good());
  }

 private:
  const std::string file_;
};

const bool kWatched = [] {
  const char* file = std::getenv("ENAMEL_STATEMENTS");
  if (file != nullptr) ::testing::AddGlobalTestEnvironment(new StatementLog(file));
  return file != nullptr;
}();

}  // namespace
