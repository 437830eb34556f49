#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"

namespace enamel::station {

// One prepared statement; parameters are bound in order, then it steps through its rows. Not
// thread-safe. Columns of another type than asked for read as empty or 0, and so do those named
// that the row does not have.
class Statement {
 public:
  Statement(sqlite3* db, const char* sql) { sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr); }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& Blob(ByteView v) {
    // Never null: an empty blob is not NULL.
    sqlite3_bind_blob(statement_, ++bound_,
                      v.empty() ? "" : reinterpret_cast<const char*>(v.data()),
                      static_cast<int>(v.size()), SQLITE_TRANSIENT);
    return *this;
  }
  Statement& Int(int64_t v) {
    sqlite3_bind_int64(statement_, ++bound_, v);
    return *this;
  }
  Statement& Text(const std::string& v) {
    sqlite3_bind_text(statement_, ++bound_, v.c_str(), -1, SQLITE_TRANSIENT);
    return *this;
  }
  // SQLITE_ROW, SQLITE_DONE or an error; an error too when the statement did not compile.
  int Step() { return statement_ == nullptr ? SQLITE_ERROR : sqlite3_step(statement_); }

  bool IsNull(int column) { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  int64_t IntAt(int column) { return sqlite3_column_int64(statement_, column); }
  std::string TextAt(int column) {
    auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return text == nullptr ? "" : text;
  }
  Bytes BlobAt(int column) {
    auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(statement_, column));
    return data == nullptr ? Bytes{} : Bytes(data, data + sqlite3_column_bytes(statement_, column));
  }

  int columns() const { return sqlite3_column_count(statement_); }
  std::string NameOf(int column) const { return sqlite3_column_name(statement_, column); }
  // By position; -1: there is none of that name.
  int ColumnNamed(std::string_view name) const {
    for (int i = 0; i < columns(); ++i) {
      if (sqlite3_column_name(statement_, i) == name) return i;
    }
    return -1;
  }
  // SQLite reads a column out of range as NULL.
  bool IsNull(std::string_view name) { return IsNull(ColumnNamed(name)); }
  int64_t IntAt(std::string_view name) { return IntAt(ColumnNamed(name)); }
  std::string TextAt(std::string_view name) { return TextAt(ColumnNamed(name)); }
  Bytes BlobAt(std::string_view name) { return BlobAt(ColumnNamed(name)); }
  // Binds the value that `row` has there, of whatever type.
  Statement& Same(const Statement& row, int column) {
    sqlite3_bind_value(statement_, ++bound_, sqlite3_column_value(row.statement_, column));
    return *this;
  }

 private:
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

}  // namespace enamel::station
