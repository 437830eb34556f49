#pragma once

#include <string>
#include <string_view>

#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"

namespace enamel::sql {

// One use of a statement: parameters are bound in order, then it steps through its rows.
//   Query q(db, "SELECT name FROM people WHERE id = ?1");
//   q.BindBlob(id.view());
//   while (q.Next()) … q.Text(0) …
//   if (!q.status().ok()) …
// A failure at any point makes Next() false and stays in status(). The same SQL text is not used by
// a second Query while one has a row. Thread safety: the connection's.
class Query {
 public:
  Query(Db& db, const char* sql) : statement_(db.Take(sql, status_)) {}
  Query(Db& db, const std::string& sql) : Query(db, sql.c_str()) {}
  ~Query() {
    if (statement_ != nullptr) statement_->GiveBack();
  }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  // The next parameter, of the type of the column that it is stored in or compared with. Text that
  // is no UTF-8, or has a zero byte in it, is refused (kInvalidInput).
  Query& BindInt(int64_t value);
  Query& BindReal(double value);
  Query& BindText(std::string_view value);
  Query& BindBlob(ByteView value);
  Query& BindNull(Type type);
  // Binds the value that `row` has in that column, with its type.
  Query& BindSame(const Query& row, int column);

  // Steps to the next row; false at the end or on failure.
  bool Next();
  // Runs a statement that returns no rows.
  Status Run();
  const Status& status() const { return status_; }

  int columns() const { return statement_ == nullptr ? 0 : statement_->columns(); }
  std::string NameOf(int column) const { return statement_->NameOf(column); }
  // The column's position; -1: no column has that name.
  int ColumnNamed(std::string_view name) const;

  // Of the row. A missing column (-1) reads as NULL, and NULL as 0 or empty.
  Type TypeOf(int column) const { return Has(column) ? statement_->TypeOf(column) : Type::kNull; }
  bool IsNull(int column) const { return TypeOf(column) == Type::kNull; }
  int64_t Int(int column) const { return Has(column) ? statement_->Int(column) : 0; }
  double Real(int column) const { return Has(column) ? statement_->Real(column) : 0; }
  std::string Text(int column) const { return std::string(AsText(View(column))); }
  Bytes Blob(int column) const;
  Uuid Id(int column) const;      // zero when it is no 16 bytes
  Sha256 Hash(int column) const;  // zero when it is no 32 bytes

  bool IsNull(std::string_view name) const { return IsNull(ColumnNamed(name)); }
  int64_t Int(std::string_view name) const { return Int(ColumnNamed(name)); }
  std::string Text(std::string_view name) const { return Text(ColumnNamed(name)); }
  Bytes Blob(std::string_view name) const { return Blob(ColumnNamed(name)); }

 private:
  bool Has(int column) const { return column >= 0 && statement_ != nullptr; }
  ByteView View(int column) const { return Has(column) ? statement_->View(column) : ByteView(); }
  Query& Check(bool bound);

  Status status_;  // before statement_, which Take may fail to give
  Statement* statement_;
  int next_parameter_ = 1;
};

}  // namespace enamel::sql
