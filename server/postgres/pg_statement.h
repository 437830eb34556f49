#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/postgres/libpq.h"
#include "server/postgres/pg_db.h"

// Private to server/postgres.
namespace enamel::sql {

// Parameters and rows travel in PostgreSQL's binary form (network byte order). Prepared when it is
// first run, since the types of its parameters are known then; again when they are others, or the
// connection is.
class PgStatement final : public Statement {
 public:
  PgStatement(PgDb& db, std::string sql) : db_(db), sql_(std::move(sql)) {}
  ~PgStatement() override;

  bool BindInt(int place, int64_t value) override;
  bool BindReal(int place, double value) override;
  bool BindText(int place, std::string_view value) override;
  bool BindBlob(int place, ByteView value) override;
  bool BindNull(int place, Type type) override;
  Step Next() override;
  Status Failure() const override { return failure_; }
  int columns() const override;
  std::string NameOf(int column) const override;
  Type TypeOf(int column) const override;
  int64_t Int(int column) const override;
  double Real(int column) const override;
  ByteView View(int column) const override;
  void GiveBack() override;

  bool in_use() const { return users_ > 0; }
  // Stepped, and not at its end.
  bool busy() const;
  void Use(uint64_t use) {
    ++users_;
    last_use_ = use;
    Forget();
    parameters_.clear();
  }
  uint64_t last_use() const { return last_use_; }
  // Its name on the server, in the connection that there is; empty: none.
  std::string name() const;

  struct Parameter {
    Oid type = 0;
    bool null = true;
    std::string bytes{};
  };
  // A prepared statement and its bound values, to be sent later. The statement can be bound again
  // before that.
  struct Call {
    std::string name;
    std::vector<Parameter> parameters;
  };
  Result<Call> ToSendLater();

 private:
  bool Bind(int place, Oid type, std::string bytes);
  Status Prepare();
  Status Execute();
  void Forget();  // its rows
  ByteView Raw(int column) const;

  PgDb& db_;
  const std::string sql_;
  std::vector<Parameter> parameters_;
  std::vector<Oid> prepared_types_;
  std::string name_;
  uint64_t prepared_in_ = 0;  // the connection
  pg_result* result_ = nullptr;
  int row_ = -1;
  Status failure_;
  int users_ = 0;
  uint64_t last_use_ = 0;
};

// Parameters as libpq takes them; what they point to is the parameters'.
struct PgArguments {
  explicit PgArguments(const std::vector<PgStatement::Parameter>& parameters);
  int count() const { return static_cast<int>(values.size()); }

  std::vector<const char*> values;
  std::vector<int> lengths, formats;
};

}  // namespace enamel::sql
