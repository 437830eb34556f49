#include "tests/server/storage/backends.h"

#include <cstdlib>

#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/ticket_key.h"
#include "server/storage/engine/verify_audit.h"
#include "server/storage/engine/verify_stage.h"

namespace enamel::server::testing {
namespace {

void ExpectNoFindings(sql::Db& db, const std::filesystem::path& folder) {
  VerifyReport report;
  Status checked = sqlite::CheckAudit(db, ReadTicketKey(folder)->public_key, {}, report, {});
  EXPECT_TRUE(checked.ok()) << checked.message();
  checked = sqlite::CheckStages(db, report);
  EXPECT_TRUE(checked.ok()) << checked.message();
  for (const Finding& finding : report.findings) {
    ADD_FAILURE() << finding.kind << " " << finding.object << ": expected " << finding.expected
                  << ", found " << finding.found;
  }
  EXPECT_EQ(report.unsigned_audit, 0u);
}

class SqlitePlace : public Place {
 public:
  std::unique_ptr<Store> Open() override { return OpenStore(folder_.path()); }
  void ExpectTrailAgrees() const override {
    auto db = sqlite::OpenDatabase(folder_.path() / "enamel.db", sqlite::DbMode::kReadOnly);
    ASSERT_TRUE(db.ok()) << db.status().message();
    ExpectNoFindings(**db, folder_.path());
  }

 protected:
  TempFolder folder_;
};

// The same, all files through the seams that the power-cut test uses.
class SqliteOnSimulatedDisk final : public SqlitePlace {
 public:
  std::unique_ptr<Store> Open() override {
    SqliteOptions options;
    options.folder = folder_.path();
    options.vfs = disk_.vfs();
    options.disk = &disk_;
    auto store = OpenSqliteStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }

 private:
  SimulatedDisk disk_{folder_.path()};
};

// Every change made twice: what it says and leaves is of the second time alone.
class SqliteTwice final : public SqlitePlace {
 public:
  std::unique_ptr<Store> Open() override {
    SqliteOptions options;
    options.folder = folder_.path();
    options.change_twice = true;
    auto store = OpenSqliteStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }
};

// Rows in a schema of their own on the server that ENAMEL_POSTGRES names.
class PostgresPlace final : public Place {
 public:
  explicit PostgresPlace(std::string server) : server_(std::move(server)) {}
  ~PostgresPlace() override {
    auto db = sqlite::OpenPgDatabase(server_, {}, /*read_only=*/false, {});
    EXPECT_TRUE(db.ok() && (*db)->Exec(("DROP SCHEMA \"" + schema_ + "\" CASCADE").c_str()).ok());
  }
  std::unique_ptr<Store> Open() override {
    PostgresOptions options;
    options.server = server_;
    options.schema = schema_;
    options.folder.folder = folder_.path();
    auto store = OpenPostgresStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }
  void ExpectTrailAgrees() const override {
    auto db = sqlite::OpenPgDatabase(server_, schema_, /*read_only=*/true, {});
    ASSERT_TRUE(db.ok()) << db.status().message();
    ExpectNoFindings(**db, folder_.path());
  }

 private:
  const std::string server_;
  const std::string schema_ = "s" + Uuid::New().Text();
  TempFolder folder_;
};

}  // namespace

const std::vector<Backend>& Backends() {
  static const std::vector<Backend> kBackends = [] {
    std::vector<Backend> out = {
        {"Sqlite", [] { return std::make_unique<SqlitePlace>(); }},
        {"SqliteOnSimulatedDisk", [] { return std::make_unique<SqliteOnSimulatedDisk>(); }},
        {"SqliteTwice", [] { return std::make_unique<SqliteTwice>(); }},
    };
    if (const char* server = std::getenv("ENAMEL_POSTGRES")) {
      out.push_back({"Postgres", [server] { return std::make_unique<PostgresPlace>(server); }});
    }
    return out;
  }();
  return kBackends;
}

}  // namespace enamel::server::testing
