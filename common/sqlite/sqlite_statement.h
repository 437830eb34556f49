#pragma once

#include <sqlite3.h>

#include "common/sqlite/sqlite_db.h"

namespace enamel::sql {

// Private to common/sqlite: what SqliteDb keeps and lends.
class SqliteStatement final : public Statement {
 public:
  SqliteStatement(SqliteDb& db, sqlite3_stmt* statement) : db_(db), statement_(statement) {}
  ~SqliteStatement() override { sqlite3_finalize(statement_); }
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  bool BindInt(int place, int64_t value) override;
  bool BindReal(int place, double value) override;
  bool BindText(int place, std::string_view value) override;
  bool BindBlob(int place, ByteView value) override;
  bool BindNull(int place, Type type) override;
  Step Next() override;
  Status Failure() const override { return failure_; }
  int columns() const override { return sqlite3_column_count(statement_); }
  std::string NameOf(int column) const override;
  Type TypeOf(int column) const override;
  int64_t Int(int column) const override { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const override { return sqlite3_column_double(statement_, column); }
  ByteView View(int column) const override;
  void GiveBack() override;

  bool in_use() const { return users_ > 0; }
  // Stepped, and not at its end.
  bool busy() const { return sqlite3_stmt_busy(statement_) != 0; }
  uint64_t last_use() const { return last_use_; }
  void Use(uint64_t use) {
    ++users_;
    last_use_ = use;
  }

 private:
  bool Check(int rc);

  SqliteDb& db_;
  sqlite3_stmt* statement_;
  Status failure_;
  int users_ = 0;
  uint64_t last_use_ = 0;
};

}  // namespace enamel::sql
