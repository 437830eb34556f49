#include "common/sql/query.h"

#include "common/base/utf8.h"

namespace enamel::sql {

Query& Query::Check(bool bound) {
  // The first failure is the cause; those after it follow from it.
  if (!bound && status_.ok()) status_ = statement_->Failure();
  return *this;
}

Query& Query::BindInt(int64_t value) {
  return statement_ == nullptr ? *this : Check(statement_->BindInt(next_parameter_++, value));
}

Query& Query::BindReal(double value) {
  return statement_ == nullptr ? *this : Check(statement_->BindReal(next_parameter_++, value));
}

// The same for every engine: PostgreSQL keeps neither, and SQLite would.
Query& Query::BindText(std::string_view value) {
  if (status_.ok() && (value.find('\0') != std::string_view::npos || !IsUtf8(value))) {
    status_ = Status(Code::kInvalidInput, "expected text in UTF-8 without zero bytes, found \"" +
                                              Printable(value) + "\"; write it again");
  }
  return statement_ == nullptr ? *this : Check(statement_->BindText(next_parameter_++, value));
}

Query& Query::BindBlob(ByteView value) {
  return statement_ == nullptr ? *this : Check(statement_->BindBlob(next_parameter_++, value));
}

Query& Query::BindNull(Type type) {
  return statement_ == nullptr ? *this : Check(statement_->BindNull(next_parameter_++, type));
}

Query& Query::BindSame(const Query& row, int column) {
  // A NULL does not tell the type of its column, so none is stated for it.
  const Type type = row.IsNull(column) ? Type::kNull : row.statement_->TypeOf(column);
  switch (type) {
    case Type::kInt:
      return BindInt(row.Int(column));
    case Type::kReal:
      return BindReal(row.Real(column));
    case Type::kText:
      return BindText(AsText(row.View(column)));
    case Type::kBlob:
      return BindBlob(row.View(column));
    case Type::kNull:
      break;
  }
  return BindNull(Type::kNull);
}

// Also after a failed Bind: a statement with a parameter missing would find something else.
bool Query::Next() {
  // First of all, since there is no statement where Take failed.
  if (!status_.ok()) return false;
  switch (statement_->Next()) {
    case Statement::Step::kRow:
      return true;
    case Statement::Step::kEnd:
      break;
    case Statement::Step::kFailed:
      status_ = statement_->Failure();
  }
  return false;
}

Status Query::Run() {
  // The first step does all that a statement changes.
  Next();
  return status_;
}

// Looked for each time: rows read by name are few, and a SELECT * may have other columns next
// time.
int Query::ColumnNamed(std::string_view name) const {
  for (int i = 0; i < columns(); ++i) {
    if (statement_->NameOf(i) == name) return i;
  }
  return -1;
}

Bytes Query::Blob(int column) const {
  ByteView view = View(column);
  return Bytes(view.begin(), view.end());
}

Uuid Query::Id(int column) const {
  ByteView view = View(column);
  // FromBytes ends the program over any other length, and a damaged file may hold one.
  return view.size() == 16 ? Uuid::FromBytes(view) : Uuid{};
}

Sha256 Query::Hash(int column) const {
  ByteView view = View(column);
  return view.size() == 32 ? Sha256::FromBytes(view) : Sha256{};
}

}  // namespace enamel::sql
