#pragma once

#include <boost/pfr/core.hpp>
#include <concepts>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/check.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/unix_time.h"
#include "common/base/uuid.h"
#include "common/sql/query.h"

namespace enamel::server {

using sql::Db;

// One use of a statement of the store. ?1 is always the tenant; Bind fills ?2, ?3, … in order.
//   Query q(db, "SELECT name FROM people WHERE tenant = ?1 AND id = ?2");
//   return q.Bind(id).One<std::string>("no person " + id.Text());
class Query : public sql::Query {
 public:
  Query(Db& db, const char* sql) : sql::Query(db, sql) { BindInt(kTenant); }
  Query(Db& db, const std::string& sql) : Query(db, sql.c_str()) {}

  // Bind converts nothing: ids and hashes are BLOB, times, flags and enumerators INTEGER, scores
  // REAL; an optional without a value is NULL. Other C++ types have no Bind.
  template <typename... T>
  Query& Bind(const T&... values) {
    (Put(values), ...);
    return *this;
  }

  // Reads the row's columns from `first` on, each into the next variable, or the next member of a
  // struct. NULL reads as 0, empty, or an optional without a value. Members after the last column
  // keep their values.
  template <typename... T>
  void Read(int first, T&... out) const {
    (Fill(out, first), ...);
  }
  // Requires: a member of T for each column.
  template <typename T>
  T Row() const {
    T out{};
    int column = 0;
    Fill(out, column);
    ENAMEL_CHECK(column >= columns());
    return out;
  }

  // The rows that are found, each made by `of(query)` or Row<T>().
  template <typename F>
  auto All(const F& of) -> Result<std::vector<std::invoke_result_t<F, const Query&>>> {
    std::vector<std::invoke_result_t<F, const Query&>> out;
    while (Next()) out.push_back(std::invoke(of, *this));
    if (!status().ok()) return status();
    return out;
  }
  template <typename T>
  Result<std::vector<T>> All() {
    return All(&Query::Row<T>);
  }
  // The first one; none: nothing is found.
  template <typename F>
  auto Maybe(const F& of) -> Result<std::optional<std::invoke_result_t<F, const Query&>>> {
    std::optional<std::invoke_result_t<F, const Query&>> out;
    if (Next()) out = std::invoke(of, *this);
    if (!status().ok()) return status();
    return out;
  }
  template <typename T>
  Result<std::optional<T>> Maybe() {
    return Maybe(&Query::Row<T>);
  }
  // The first one. Errors also: kNotFound with `missing`.
  template <typename F>
  auto One(const F& of, const std::string& missing)
      -> Result<std::invoke_result_t<F, const Query&>> {
    if (Next()) return std::invoke(of, *this);
    if (!status().ok()) return status();
    return Status(Code::kNotFound, missing);
  }
  template <typename T>
  Result<T> One(const std::string& missing) {
    return One(&Query::Row<T>, missing);
  }
  // The first one, or T{}.
  template <typename T>
  Result<T> Value() {
    T out = Next() ? Row<T>() : T{};
    if (!status().ok()) return status();
    return out;
  }
  // Whether anything is found.
  Result<bool> Any() {
    const bool any = Next();
    if (!status().ok()) return status();
    return any;
  }

  static constexpr int64_t kTenant = 1;

 private:
  template <typename T>
  static constexpr bool kIsNumber = std::integral<T> || std::is_enum_v<T>;

  template <typename T>
  void Fill(T& out, int& column) const {
    if constexpr (requires { out.has_value(); }) {
      const bool none = column >= columns() || IsNull(column);
      Fill(out.emplace(), column);
      if (none) out.reset();
    } else if constexpr (requires { Get(column, out); }) {
      if (column < columns()) Get(column, out);
      ++column;
    } else {
      boost::pfr::for_each_field(out, [&](auto& member) { Fill(member, column); });
    }
  }
  template <typename T, typename = std::enable_if_t<kIsNumber<T>>>
  void Get(int column, T& out) const {
    out = static_cast<T>(Int(column));
  }
  void Get(int column, bool& out) const { out = Int(column) != 0; }
  void Get(int column, double& out) const { out = Real(column); }
  void Get(int column, std::string& out) const { out = Text(column); }
  void Get(int column, Bytes& out) const { out = Blob(column); }
  void Get(int column, Uuid& out) const { out = Id(column); }
  void Get(int column, Sha256& out) const { out = Hash(column); }

  template <typename T, typename = std::enable_if_t<kIsNumber<T>>>
  void Put(T value) {
    BindInt(static_cast<int64_t>(value));
  }
  void Put(double value) { BindReal(value); }
  void Put(std::string_view value) { BindText(value); }
  void Put(ByteView value) { BindBlob(value); }
  void Put(const Uuid& value) { BindBlob(value.view()); }
  void Put(const Sha256& value) { BindBlob(value.view()); }
  template <typename T>
  void Put(const std::optional<T>& value) {
    if (value) return Put(*value);
    BindNull(kIsNumber<T>                   ? sql::Type::kInt
             : std::same_as<T, double>      ? sql::Type::kReal
             : std::same_as<T, std::string> ? sql::Type::kText
                                            : sql::Type::kBlob);
  }
};

// INSERT of one row, of the tenant: columns and their values in turn, as Query::Bind takes them,
// then perhaps what follows VALUES.
//   Insert(db, "profiles", "name", row.name, "title", row.title, " ON CONFLICT DO NOTHING")
using Cells = std::vector<std::pair<const char*, std::function<void(Query&)>>>;
Status Insert(Db& db, const std::string& table, const Cells& cells, const char* rest = "");
template <typename T, typename... More>
Status Insert(Db& db, const std::string& table, Cells cells, const char* column, const T& value,
              const More&... more) {
  cells.emplace_back(column, [&value](Query& q) { q.Bind(value); });
  return Insert(db, table, std::move(cells), more...);
}
template <typename... T>
Status Insert(Db& db, const std::string& table, const char* column, const T&... more) {
  return Insert(db, table, Cells(), column, more...);
}

// Milliseconds since the epoch, now.
inline int64_t NowMs() { return enamel::UnixMs(); }

}  // namespace enamel::server
