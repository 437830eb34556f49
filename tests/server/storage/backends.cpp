#include "tests/server/storage/backends.h"

#include "server/storage/engine/ticket_key.h"
#include "server/storage/engine/verify_audit.h"
#include "server/storage/engine/verify_stage.h"

namespace enamel::server::testing {
namespace {

class SqlitePlace : public Place {
 public:
  std::unique_ptr<Store> Open() override { return OpenStore(folder_.path()); }
  void ExpectTrailAgrees() const override {
    auto db = sqlite::OpenDatabase(folder_.path() / "enamel.db", sqlite::DbMode::kReadOnly);
    ASSERT_TRUE(db.ok()) << db.status().message();
    VerifyReport report;
    Status checked =
        sqlite::CheckAudit(**db, ReadTicketKey(folder_.path())->public_key, {}, report, {});
    EXPECT_TRUE(checked.ok()) << checked.message();
    checked = sqlite::CheckStages(**db, report);
    EXPECT_TRUE(checked.ok()) << checked.message();
    for (const Finding& finding : report.findings) {
      ADD_FAILURE() << finding.kind << " " << finding.object << ": expected " << finding.expected
                    << ", found " << finding.found;
    }
    EXPECT_EQ(report.unsigned_audit, 0u);
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

}  // namespace

const std::vector<Backend>& Backends() {
  static const std::vector<Backend> kBackends = {
      {"Sqlite", [] { return std::make_unique<SqlitePlace>(); }},
      {"SqliteOnSimulatedDisk", [] { return std::make_unique<SqliteOnSimulatedDisk>(); }},
      {"SqliteTwice", [] { return std::make_unique<SqliteTwice>(); }},
  };
  return kBackends;
}

}  // namespace enamel::server::testing
