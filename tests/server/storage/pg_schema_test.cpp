#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "server/storage/engine/database.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/query.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/open_store.h"
#include "server/storage/store.h"
#include "server/storage/verify/verify_audit.h"
#include "tests/support/temp_folder.h"

// The tables that the store has in PostgreSQL are those that it has in SQLite, column by column.
namespace enamel::server {
namespace {

// "table.column" to "TYPE NOT NULL KEY".
using Columns = std::map<std::string, std::string>;

Columns OfSqlite(sql::Db& db) {
  const std::map<std::string, std::string> words = {
      {"INTEGER", "bigint"}, {"REAL", "double precision"}, {"TEXT", "text"}, {"BLOB", "bytea"}};
  Columns out;
  sql::Query q(db,
               "SELECT t.name || '.' || c.name, c.type, c.\"notnull\", c.pk FROM sqlite_master t, "
               "pragma_table_info(t.name) c WHERE t.type = 'table' AND t.name NOT LIKE 'sqlite%'");
  while (q.Next()) {
    out[q.Text(0)] = words.at(q.Text(1)) + (q.Int(2) != 0 ? " NOT NULL" : "") +
                     (q.Int(3) != 0 ? " KEY " + std::to_string(q.Int(3)) : "");
  }
  EXPECT_TRUE(q.status().ok()) << q.status().message();
  return out;
}

Columns OfPostgres(sql::Db& db) {
  Columns out;
  sql::Query q(
      db,
      "SELECT c.table_name || '.' || c.column_name, c.data_type::text, c.is_nullable = 'NO', "
      "coalesce(k.ordinal_position, 0) FROM information_schema.columns c LEFT JOIN "
      "(information_schema.key_column_usage k JOIN information_schema.table_constraints p ON "
      "p.constraint_schema = k.constraint_schema AND p.constraint_name = k.constraint_name AND "
      "p.constraint_type = 'PRIMARY KEY') ON k.table_schema = c.table_schema AND k.table_name = "
      "c.table_name AND k.column_name = c.column_name WHERE c.table_schema = current_schema() AND "
      "c.table_name NOT IN ('enamel_schema', 'enamel_commits')");
  while (q.Next()) {
    out[q.Text(0)] = q.Text(1) + (q.Int(2) != 0 ? " NOT NULL" : "") +
                     (q.Int(3) != 0 ? " KEY " + std::to_string(q.Int(3)) : "");
  }
  EXPECT_TRUE(q.status().ok()) << q.status().message();
  return out;
}

class PgSchemaTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* server = std::getenv("ENAMEL_POSTGRES");
    if (server == nullptr) GTEST_SKIP() << "ENAMEL_POSTGRES names no server";
    pg_ = std::move(OpenPgDatabase(server, "schema_test", /*read_only=*/false, {})).value();
    ASSERT_TRUE(pg_->Migrate(PgMigrations()).ok());
  }
  void TearDown() override {
    if (pg_ != nullptr) EXPECT_TRUE(pg_->Exec("DROP SCHEMA schema_test CASCADE").ok());
  }

  std::unique_ptr<sql::Db> pg_;
};

TEST(SchemaTest, IsMadeForPostgresOutOfWordsThatItKnows) {
  for (const sql::Migration& migration : SqliteMigrations()) {
    const auto made = InPostgres(migration.sql);
    EXPECT_TRUE(made.ok()) << migration.name << ": " << made.status().message();
  }
  EXPECT_EQ(
      *InPostgres("CREATE TABLE a (b TEXT DEFAULT 'BLOB', c REAL) STRICT, WITHOUT ROWID;  -- d"),
      "CREATE TABLE a (b TEXT COLLATE \"C\" DEFAULT 'BLOB', c DOUBLE PRECISION);  ");
  for (const char* sql : {"CREATE TABLE a (b NUMERIC)", "CREATE INDEX a ON b (lower(c))",
                          "CREATE TABLE a (b BLOB DEFAULT X'00')"}) {
    EXPECT_FALSE(InPostgres(sql).ok()) << sql;
  }
}

// Servers of the previous version keep working while the others are replaced (server/README.md, "A
// new version"): everything their statements name stays, and the rows they write need no column
// that they do not know.
TEST(SchemaTest, AMigrationTakesNothingAwayFromServersOfTheVersionBefore) {
  const std::regex adds(
      "(CREATE (UNLOGGED )?TABLE|CREATE INDEX|ALTER TABLE [a-z_]+ ADD COLUMN) .*");
  const auto is_addition = [&](const std::string& sql) {
    const bool needed = sql.starts_with("ALTER") && sql.find("NOT NULL") != std::string::npos &&
                        sql.find("DEFAULT") == std::string::npos;
    return !needed && std::regex_match(sql, adds);
  };
  EXPECT_TRUE(is_addition("ALTER TABLE a ADD COLUMN b BIGINT NOT NULL DEFAULT 0"));
  EXPECT_FALSE(is_addition("ALTER TABLE a ADD COLUMN b BIGINT NOT NULL"));
  EXPECT_FALSE(is_addition("ALTER TABLE a DROP COLUMN b"));
  EXPECT_FALSE(is_addition("CREATE UNIQUE INDEX a ON b (c)"));
  const std::regex comment("--[^\n]*"), space("\\s+"), statement("([^;]+);");
  for (const sql::Migration& migration : PgMigrations()) {
    if (migration.version == 1) continue;  // nobody was there before
    const std::string text = std::regex_replace(migration.sql, comment, "");
    for (std::sregex_iterator at(text.begin(), text.end(), statement), end; at != end; ++at) {
      std::string sql = std::regex_replace((*at)[1].str(), space, " ");
      sql.erase(0, sql.find_first_not_of(' '));
      EXPECT_TRUE(is_addition(sql)) << migration.name << ": " << sql;
    }
  }
}

TEST_F(PgSchemaTest, HasTheTablesAndColumnsOfSqlite) {
  const test::TempFolder folder;
  auto sqlite = OpenDatabase(folder.path() / "a.db", DbMode::kCreate);
  ASSERT_TRUE(sqlite.ok() && (*sqlite)->Migrate(SqliteMigrations()).ok());
  const Columns expected = OfSqlite(**sqlite), found = OfPostgres(*pg_);
  EXPECT_GT(expected.size(), 200u);
  EXPECT_EQ(expected, found);
  EXPECT_EQ(*pg_->SchemaVersion(), SqliteMigrations().back().version);
}

// A database of another language would put names in another order, and find others equal.
TEST_F(PgSchemaTest, ComparesEveryTextByteByByte) {
  sql::Query q(*pg_,
               "SELECT table_name || '.' || column_name FROM information_schema.columns WHERE "
               "table_schema = current_schema() AND data_type = 'text' AND collation_name IS "
               "DISTINCT FROM 'C'");
  EXPECT_FALSE(q.Next()) << q.Text(0);
  EXPECT_TRUE(q.status().ok()) << q.status().message();
}

// Measured on a table that fills its pages: a third of updates touched every index.
TEST_F(PgSchemaTest, LeavesRoomBesideAnAttemptForItsNextVersion) {
  sql::Query q(*pg_,
               "SELECT array_to_string(reloptions, ' ') FROM pg_class WHERE relname = 'attempts' "
               "AND relnamespace = current_schema()::regnamespace");
  ASSERT_TRUE(q.Next()) << q.status().message();
  EXPECT_EQ(q.Text(0), "fillfactor=50 toast_tuple_target=128");
}

// Both extend the same audit trail, so their transactions conflict all the time: each is repeated
// until it commits, and counts once.
TEST_F(PgSchemaTest, TwoServersThatWriteAtOnceLoseAndDoubleNothing) {
  const test::TempFolder folder;
  PostgresOptions options;
  options.server = std::getenv("ENAMEL_POSTGRES");
  options.schema = "schema_test";
  options.folder.folder = folder.path();
  constexpr int kEach = 20;
  std::array<std::unique_ptr<Store>, 2> stores;
  for (auto& store : stores) store = std::move(OpenPostgresStore(options)).value();
  std::atomic<int> kept{0};
  {
    std::vector<std::jthread> writers;
    for (size_t i = 0; i < stores.size(); ++i) {
      writers.emplace_back([&, i] {
        for (int n = 0; n < kEach; ++n) {
          Person person;
          person.login = std::to_string(i) + "-" + std::to_string(n);
          person.display_name = person.login;
          const auto made = stores[i]->people.CreatePerson(person, "none", {}, {{}, "test"});
          EXPECT_TRUE(made.ok()) << made.status().message();
          kept += made.ok() ? 1 : 0;
        }
      });
    }
  }
  EXPECT_EQ(kept, 2 * kEach);
  EXPECT_EQ(stores[0]->people.People()->size(), static_cast<size_t>(2 * kEach));
  VerifyReport report;
  EXPECT_TRUE(CheckAudit(*pg_, ReadTicketKey(folder.path())->public_key, {}, report, {}).ok());
  EXPECT_TRUE(report.findings.empty()) << report.findings.front().found;
}

}  // namespace
}  // namespace enamel::server
