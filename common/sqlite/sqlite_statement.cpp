#include "common/sqlite/sqlite_statement.h"

namespace enamel::sql {

bool SqliteStatement::Check(int rc) {
  if (rc != SQLITE_OK) failure_ = db_.Fail();
  return rc == SQLITE_OK;
}

bool SqliteStatement::BindInt(int place, int64_t value) {
  return Check(sqlite3_bind_int64(statement_, place, value));
}

bool SqliteStatement::BindReal(int place, double value) {
  return Check(sqlite3_bind_double(statement_, place, value));
}

bool SqliteStatement::BindText(int place, std::string_view value) {
  // Never a null pointer: SQLite would take an empty text for NULL.
  return Check(sqlite3_bind_text64(statement_, place, value.empty() ? "" : value.data(),
                                   value.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
}

bool SqliteStatement::BindBlob(int place, ByteView value) {
  // Never a null pointer, as above.
  static const uint8_t kNothing = 0;
  return Check(sqlite3_bind_blob64(statement_, place, value.empty() ? &kNothing : value.data(),
                                   value.size(), SQLITE_TRANSIENT));
}

// SQLite's NULL has no type.
bool SqliteStatement::BindNull(int place, Type) {
  return Check(sqlite3_bind_null(statement_, place));
}

Statement::Step SqliteStatement::Next() {
  // Only what writes fails by order: a test counts writes.
  if (sqlite3_stmt_readonly(statement_) == 0 && db_.InjectedFailure()) {
    failure_ = Status(Code::kStorage, "injected failure");
    return Step::kFailed;
  }
  const int rc = sqlite3_step(statement_);
  if (rc == SQLITE_ROW) return Step::kRow;
  if (rc == SQLITE_DONE) return Step::kEnd;
  failure_ = db_.Fail();
  return Step::kFailed;
}

std::string SqliteStatement::NameOf(int column) const {
  const char* name = sqlite3_column_name(statement_, column);
  return name == nullptr ? "" : name;
}

Type SqliteStatement::TypeOf(int column) const {
  switch (sqlite3_column_type(statement_, column)) {
    case SQLITE_INTEGER:
      return Type::kInt;
    case SQLITE_FLOAT:
      return Type::kReal;
    case SQLITE_TEXT:
      return Type::kText;
    case SQLITE_BLOB:
      return Type::kBlob;
    default:
      return Type::kNull;
  }
}

ByteView SqliteStatement::View(int column) const {
  // The order matters: asking for the bytes may convert the value, and then moves it.
  const void* data = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  return {static_cast<const uint8_t*>(data), static_cast<size_t>(size)};
}

void SqliteStatement::GiveBack() {
  // An unfinished statement would hold its read transaction, and keep the log from being emptied.
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
  failure_ = Status::Ok();
  --users_;
}

}  // namespace enamel::sql
