#include "tests/server/storage/backends.h"

#include <cstdlib>

#include "server/storage/engine/pg_database.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/keys/master_key.h"
#include "server/storage/verify/verify_audit.h"
#include "server/storage/verify/verify_stage.h"
#include "tests/support/s3_stand_in.h"

namespace enamel::server::testing {
namespace {

void ExpectNoFindings(sql::Db& db, const std::filesystem::path& folder) {
  VerifyReport report;
  Status checked = CheckAudit(db, ReadTicketKey(folder)->public_key, {}, report, {});
  EXPECT_TRUE(checked.ok()) << checked.message();
  checked = CheckStages(db, report);
  EXPECT_TRUE(checked.ok()) << checked.message();
  for (const Finding& finding : report.findings) {
    ADD_FAILURE() << finding.kind << " " << finding.object << ": expected " << finding.expected
                  << ", found " << finding.found;
  }
}

class SqlitePlace : public Place {
 public:
  Result<std::unique_ptr<Store>> Try() override { return OpenSqliteStore(Options()); }
  std::unique_ptr<sql::Db> Connect() const override {
    auto db = OpenDatabase(folder_.path() / "enamel.db", DbMode::kExisting);
    EXPECT_TRUE(db.ok()) << db.status().message();
    return std::move(db).value();
  }
  const std::vector<sql::Migration>& migrations() const override { return SqliteMigrations(); }
  void ExpectTrailAgrees() const override { ExpectNoFindings(*Connect(), folder_.path()); }

 protected:
  StoreOptions Options() const {
    StoreOptions out;
    out.folder = folder_.path();
    out.trace_part_bytes = kSmallPart;
    return out;
  }
  TempFolder folder_;
};

// The same, all files through the seams that the power-cut test uses.
class SqliteOnSimulatedDisk final : public SqlitePlace {
 public:
  Result<std::unique_ptr<Store>> Try() override {
    StoreOptions options = Options();
    options.vfs = disk_.vfs();
    options.disk = &disk_;
    return OpenSqliteStore(options);
  }

 private:
  SimulatedDisk disk_{folder_.path()};
};

// Every change runs twice: its status and its effect are those of the second run alone.
class SqliteTwice final : public SqlitePlace {
 public:
  Result<std::unique_ptr<Store>> Try() override {
    StoreOptions options = Options();
    options.change_twice = true;
    return OpenSqliteStore(options);
  }
};

S3Place PlaceIn(const test::S3StandIn& stand_in) {
  S3Place out;
  out.store = stand_in.options();
  out.prefix = "enamel/";
  return out;
}

// A school's S3 stores: blobs in one bucket, keys in another.
class Buckets {
 public:
  void Use(StoreOptions& options) const {
    options.s3_blobs = PlaceIn(blobs_);
    options.s3_keys = {PlaceIn(keys_), master_.path() / "master.key"};
    EXPECT_TRUE(EnsureMasterKey(options.s3_keys->master_key, SystemDisk()).ok());
  }
  void ExpectNoComplaints() const {
    EXPECT_EQ(blobs_.complaints(), std::vector<std::string>{});
    EXPECT_EQ(keys_.complaints(), std::vector<std::string>{});
  }

 private:
  test::S3StandIn blobs_, keys_;
  TempFolder master_;
};

// Blobs and keys in S3 stores.
class SqliteS3 final : public SqlitePlace {
 public:
  Result<std::unique_ptr<Store>> Try() override {
    StoreOptions options = Options();
    buckets_.Use(options);
    return OpenSqliteStore(options);
  }
  void ExpectTrailAgrees() const override {
    SqlitePlace::ExpectTrailAgrees();
    buckets_.ExpectNoComplaints();
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path() / "blobs"));
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "keyring"));
  }

 private:
  Buckets buckets_;
};

// Rows in a schema of their own on the server that ENAMEL_POSTGRES names.
class PostgresPlace : public Place {
 public:
  explicit PostgresPlace(std::string server) : server_(std::move(server)) {}
  ~PostgresPlace() override {
    auto db = OpenPgDatabase(server_, {}, /*read_only=*/false, {});
    EXPECT_TRUE(db.ok() && (*db)->Exec(("DROP SCHEMA \"" + schema_ + "\" CASCADE").c_str()).ok());
  }
  Result<std::unique_ptr<Store>> Try() override {
    PostgresOptions options;
    options.server = server_;
    options.schema = schema_;
    options.folder.folder = folder_.path();
    options.folder.trace_part_bytes = kSmallPart;
    if (buckets_ != nullptr) buckets_->Use(options.folder);
    return OpenPostgresStore(options);
  }
  std::unique_ptr<sql::Db> Connect() const override {
    auto db = OpenPgDatabase(server_, schema_, /*read_only=*/false, {});
    EXPECT_TRUE(db.ok()) << db.status().message();
    return std::move(db).value();
  }
  const std::vector<sql::Migration>& migrations() const override { return PgMigrations(); }
  void ExpectTrailAgrees() const override { ExpectNoFindings(*Connect(), folder_.path()); }

 protected:
  std::unique_ptr<Buckets> buckets_;  // none: in the folder

 private:
  const std::string server_;
  const std::string schema_ = "s" + Uuid::New().Text();
  TempFolder folder_;
};

// As many servers share them: rows in PostgreSQL, blobs and keys in S3 stores.
class PostgresS3 final : public PostgresPlace {
 public:
  explicit PostgresS3(std::string server) : PostgresPlace(std::move(server)) {
    buckets_ = std::make_unique<Buckets>();
  }
};

}  // namespace

const std::vector<Backend>& Backends() {
  static const std::vector<Backend> kBackends = [] {
    std::vector<Backend> out = {
        {"Sqlite", [] { return std::make_unique<SqlitePlace>(); }},
        {"SqliteOnSimulatedDisk", [] { return std::make_unique<SqliteOnSimulatedDisk>(); }},
        {"SqliteTwice", [] { return std::make_unique<SqliteTwice>(); }},
        {"SqliteS3", [] { return std::make_unique<SqliteS3>(); }},
    };
    if (const char* server = std::getenv("ENAMEL_POSTGRES")) {
      out.push_back({"Postgres", [server] { return std::make_unique<PostgresPlace>(server); }});
      out.push_back({"PostgresS3", [server] { return std::make_unique<PostgresS3>(server); }});
    }
    return out;
  }();
  return kBackends;
}

}  // namespace enamel::server::testing
