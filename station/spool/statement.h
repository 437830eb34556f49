#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string>

#include "common/base/bytes.h"

namespace enamel::station {

inline constexpr char kSpoolFile[] = "spool.sqlite";

// One prepared statement; parameters are bound in order, then it steps through its rows. Not
// thread-safe. Columns of another type than asked for read as empty or 0.
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

 private:
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

}  // namespace enamel::station
