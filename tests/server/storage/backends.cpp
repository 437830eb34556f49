#include "tests/server/storage/backends.h"

#include <cstdlib>
#include <utility>

#include "common/sql/query.h"
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

// Schemas of the server that ENAMEL_POSTGRES names. Making one takes PostgreSQL a second and more, emptying one some
// milliseconds: a schema goes from test to test until one has changed its tables.
class EmptySchemas {
 public:
  std::string Take(const std::string& server) {
    if (!kept_.empty()) return std::exchange(kept_, {});
    const std::string schema = "s" + Uuid::New().Text();
    const auto db = Open(server, schema);
    EXPECT_TRUE(db->Migrate(PgMigrations()).ok());
    structure_ = Structure(*db);
    Do(*db, "DROP SCHEMA IF EXISTS first_rows CASCADE; CREATE SCHEMA first_rows");
    Do(*db, R"(DO $$ DECLARE t text; any_row boolean; BEGIN
      FOR t IN SELECT tablename FROM pg_tables WHERE schemaname = current_schema() LOOP
        EXECUTE format('SELECT EXISTS (SELECT FROM %I)', t) INTO any_row;
        IF any_row THEN EXECUTE format('CREATE TABLE first_rows.%I AS TABLE %I', t, t); END IF;
      END LOOP; END $$)");
    return schema;
  }

  void GiveBack(const std::string& server, const std::string& schema) {
    const auto db = Open(server, schema);
    if (!kept_.empty() || Structure(*db) != structure_) {
      return Do(*db, ("DROP SCHEMA \"" + schema + "\" CASCADE").c_str());
    }
    // The audit trail's triggers forbid every delete. In the role of a replica PostgreSQL fires none of them.
    Do(*db, R"(SET session_replication_role = replica; DO $$ DECLARE t text; BEGIN
      FOR t IN SELECT tablename FROM pg_tables WHERE schemaname = current_schema() LOOP
        EXECUTE format('DELETE FROM %I', t);
      END LOOP;
      FOR t IN SELECT tablename FROM pg_tables WHERE schemaname = 'first_rows' LOOP
        EXECUTE format('INSERT INTO %I SELECT * FROM first_rows.%I', t, t);
      END LOOP; END $$)");
    kept_ = schema;
  }

 private:
  static std::unique_ptr<sql::Db> Open(const std::string& server, const std::string& schema) {
    auto db = OpenPgDatabase(server, schema, /*read_only=*/false, {});
    EXPECT_TRUE(db.ok()) << db.status().message();
    return std::move(db).value();
  }
  static void Do(sql::Db& db, const char* sql) {
    const Status done = db.Exec(sql);
    EXPECT_TRUE(done.ok()) << done.message();
  }
  // Describes every column, constraint and trigger of the schema: what a test may make, drop or alter.
  static std::string Structure(sql::Db& db) {
    sql::Query q(db, R"(SELECT string_agg(what, ' ' ORDER BY what) FROM (
      SELECT format('%s %s %s %s', attrelid, attname, atttypid, attnotnull) AS what FROM pg_attribute
        JOIN pg_class c ON c.oid = attrelid WHERE relnamespace = current_schema()::regnamespace AND attnum > 0
      UNION ALL SELECT oid::text FROM pg_constraint WHERE connamespace = current_schema()::regnamespace
      UNION ALL SELECT format('%s %s', t.oid, tgenabled) FROM pg_trigger t
        JOIN pg_class c ON c.oid = tgrelid WHERE relnamespace = current_schema()::regnamespace) AS everything)");
    EXPECT_TRUE(q.Next()) << q.status().message();
    return q.Text(0);
  }

  std::string kept_, structure_;
};

// Rows in a schema of their own.
class PostgresPlace : public Place {
 public:
  explicit PostgresPlace(std::string server) : server_(std::move(server)) {}
  ~PostgresPlace() override { Schemas().GiveBack(server_, schema_); }
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
  static EmptySchemas& Schemas() {
    static EmptySchemas schemas;
    return schemas;
  }

  const std::string server_;
  const std::string schema_ = Schemas().Take(server_);
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
