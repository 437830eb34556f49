#include "server/storage/school/school_tables.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <set>
#include <string_view>
#include <variant>

#include "common/base/counted.h"
#include "common/sql/query.h"
#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

constexpr std::array<std::string_view, 11>
    kOfTheInstallation{"blobs",        // which object of an S3 store is a blob
                       "person_keys",  // which object is a key
                       "server_identity", "leases",        "rewrite_due", "sign_in_counters",
                       "running_servers", "station_links", "write_probe", "move_marks",
                       "schools"};  // the others, which are no part of this one

// Rows that are read, and put, at once. A row is at most some hundred kilobytes: a chunk of a
// recording.
constexpr size_t kRowsAtOnce = 64;

using Value = std::variant<std::monostate, int64_t, double, std::string, Bytes>;
using Row = std::vector<Value>;

Result<sql::Type> TypeNamed(const std::string& table, const std::string& name) {
  static const std::map<std::string_view, sql::Type> kTypes{{"INTEGER", sql::Type::kInt},
                                                            {"REAL", sql::Type::kReal},
                                                            {"TEXT", sql::Type::kText},
                                                            {"BLOB", sql::Type::kBlob}};
  const auto at = kTypes.find(name);
  if (at != kTypes.end()) return at->second;
  return Status(Code::kStorage, "table " + table + " has a column of an unknown type " + name);
}

// In order of columns.
std::string Names(const Table& table, const std::vector<size_t>& columns) {
  std::string out;
  for (size_t column : columns) out += (out.empty() ? "" : ", ") + table.columns[column].name;
  return out;
}

std::vector<size_t> All(const Table& table) {
  std::vector<size_t> out(table.columns.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = i;
  return out;
}

// "(?1, ?2, ?3)", from `next` on.
std::string Places(size_t count, int& next) {
  std::string out = "(";
  for (size_t i = 0; i < count; ++i) out += (i == 0 ? "?" : ", ?") + std::to_string(next++);
  return out + ")";
}

void Bind(sql::Query& q, const Value& value, sql::Type type) {
  if (const auto* whole = std::get_if<int64_t>(&value)) {
    q.BindInt(*whole);
  } else if (const auto* real = std::get_if<double>(&value)) {
    q.BindReal(*real);
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    q.BindText(*text);
  } else if (const auto* blob = std::get_if<Bytes>(&value)) {
    q.BindBlob(*blob);
  } else {
    q.BindNull(type);
  }
}

// By the schema's type, not by the engine's type of the value.
Value ValueOf(const sql::Query& q, int column, sql::Type type) {
  if (q.IsNull(column)) return {};
  switch (type) {
    case sql::Type::kInt:
      return q.Int(column);
    case sql::Type::kReal:
      return q.Real(column);
    case sql::Type::kText:
      return q.Text(column);
    case sql::Type::kBlob:
      return q.Blob(column);
    case sql::Type::kNull:
      break;
  }
  return {};
}

void Append(Bytes& out, uint64_t number) {
  for (int shift = 0; shift < 64; shift += 8) out.push_back(static_cast<uint8_t>(number >> shift));
}

// A byte for the kind of value, then an integer or the bits of a double as eight bytes, the least
// significant first, or the length of text or a blob in the same way and its bytes.
void Append(Bytes& out, const Value& value) {
  out.push_back(static_cast<uint8_t>(value.index()));
  if (const auto* whole = std::get_if<int64_t>(&value)) {
    Append(out, static_cast<uint64_t>(*whole));
  } else if (const auto* real = std::get_if<double>(&value)) {
    // SQLite keeps no sign of a zero.
    Append(out, std::bit_cast<uint64_t>(*real == 0 ? 0.0 : *real));
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    Append(out, text->size());
    const ByteView bytes = AsBytes(*text);
    out.insert(out.end(), bytes.begin(), bytes.end());
  } else if (const auto* blob = std::get_if<Bytes>(&value)) {
    Append(out, blob->size());
    out.insert(out.end(), blob->begin(), blob->end());
  }
}

// Those after `last` in the order of the key; none: from the beginning. Empty: that was all. Pages,
// because an engine may hold all that a statement gives in memory.
Result<std::vector<Row>> NextRows(sql::Db& db, const Table& table, const Row* last) {
  int next = 1;
  std::string sql = "SELECT " + Names(table, All(table)) + " FROM " + table.name;
  const std::string key = Names(table, table.key);
  if (last != nullptr) sql += " WHERE (" + key + ") > " + Places(table.key.size(), next);
  sql += " ORDER BY " + key + " LIMIT " + std::to_string(kRowsAtOnce);
  sql::Query q(db, sql);
  if (last != nullptr) {
    for (size_t column : table.key) Bind(q, (*last)[column], table.columns[column].type);
  }
  std::vector<Row> out;
  while (q.Next()) {
    Row& row = out.emplace_back();
    for (size_t i = 0; i < table.columns.size(); ++i) {
      row.push_back(ValueOf(q, static_cast<int>(i), table.columns[i].type));
    }
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return out;
}

Status PutRows(sql::Db& db, const Table& table, const std::vector<Row>& rows) {
  int next = 1;
  std::string sql = "INSERT INTO " + table.name + " (" + Names(table, All(table)) + ") VALUES ";
  for (size_t i = 0; i < rows.size(); ++i) {
    sql += (i == 0 ? "" : ", ") + Places(table.columns.size(), next);
  }
  sql::Query q(db, sql);
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) Bind(q, row[i], table.columns[i].type);
  }
  return q.Run();
}

using UseRows = std::function<Status(const std::vector<Row>&)>;

Result<TableDigest> EachRow(sql::Db& db, const Table& table, const RowProgress& progress,
                            const UseRows& use) {
  TableDigest out{table.name, 0, {}};
  Sha256Stream hash;
  std::vector<Row> rows;
  do {
    const Row last = rows.empty() ? Row() : rows.back();
    ENAMEL_ASSIGN_OR_RETURN(rows, NextRows(db, table, rows.empty() ? nullptr : &last));
    Bytes bytes;
    for (const Row& row : rows) {
      for (const Value& value : row) Append(bytes, value);
    }
    hash.Update(bytes);
    out.rows += rows.size();
    if (use && !rows.empty()) ENAMEL_RETURN_IF_ERROR(use(rows));
    if (progress) progress(table.name, out.rows);
  } while (rows.size() == kRowsAtOnce);
  out.hash = hash.Finish();
  return out;
}

Result<Table> TableNamed(sql::Db& sqlite, const std::string& name) {
  Table out{name, {}, {}};
  std::map<int64_t, size_t> key;
  sql::Query q(sqlite, "SELECT name, type, pk FROM pragma_table_info(?1) ORDER BY cid");
  for (q.BindText(name); q.Next();) {
    ENAMEL_ASSIGN_OR_RETURN(const sql::Type type, TypeNamed(name, q.Text(1)));
    if (q.Int(2) > 0) key[q.Int(2)] = out.columns.size();
    out.columns.push_back({q.Text(0), type});
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  for (const auto& [place, column] : key) out.key.push_back(column);
  if (!out.key.empty()) return out;
  return Status(Code::kStorage, "table " + name + " has no primary key, which rows are read by");
}

// What each table refers to, itself apart.
Result<std::map<std::string, std::set<std::string>>> References(sql::Db& sqlite) {
  std::map<std::string, std::set<std::string>> out;
  sql::Query q(sqlite,
               "SELECT t.name, f.\"table\" FROM sqlite_master t LEFT JOIN "
               "pragma_foreign_key_list(t.name) f ON f.\"table\" <> t.name WHERE t.type = 'table' "
               "AND t.name NOT LIKE 'sqlite%'");
  while (q.Next()) {
    auto& to = out[q.Text(0)];
    if (!q.IsNull(1)) to.insert(q.Text(1));
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return out;
}

}  // namespace

Result<std::vector<Table>> TablesOfSchool(sql::Db& sqlite) {
  ENAMEL_ASSIGN_OR_RETURN(auto references, References(sqlite));
  for (std::string_view name : kOfTheInstallation) references.erase(std::string(name));
  std::vector<Table> out;
  while (!references.empty()) {
    // One that refers to none of those that are left.
    const auto next = std::ranges::find_if(references, [&](const auto& table) {
      return std::ranges::none_of(table.second,
                                  [&](const auto& to) { return references.contains(to); });
    });
    if (next == references.end()) {
      return Status(Code::kStorage,
                    "the tables refer to each other in a ring: " + references.begin()->first);
    }
    ENAMEL_ASSIGN_OR_RETURN(auto table, TableNamed(sqlite, next->first));
    out.push_back(std::move(table));
    references.erase(next);
  }
  return out;
}

Result<std::vector<TableDigest>> DigestRows(sql::Db& db, const std::vector<Table>& tables,
                                            const RowProgress& progress) {
  std::vector<TableDigest> out;
  for (const Table& table : tables) {
    ENAMEL_ASSIGN_OR_RETURN(auto digest, EachRow(db, table, progress, {}));
    out.push_back(std::move(digest));
  }
  return out;
}

Result<std::vector<TableDigest>> CopyRows(sql::Db& from, sql::Db& to,
                                          const std::vector<Table>& tables,
                                          const RowProgress& progress) {
  for (auto table = tables.rbegin(); table != tables.rend(); ++table) {
    ENAMEL_RETURN_IF_ERROR(to.Exec(("DELETE FROM " + table->name).c_str()));
  }
  std::vector<TableDigest> out;
  for (const Table& table : tables) {
    ENAMEL_ASSIGN_OR_RETURN(auto digest,
                            EachRow(from, table, progress, [&](const std::vector<Row>& rows) {
                              return PutRows(to, table, rows);
                            }));
    out.push_back(std::move(digest));
  }
  return out;
}

std::string Differences(const std::vector<TableDigest>& expected,
                        const std::vector<TableDigest>& found) {
  std::string out;
  for (size_t i = 0; i < expected.size(); ++i) {
    if (i < found.size() && expected[i] == found[i]) continue;
    out += (out.empty() ? "" : "; ") + expected[i].table + ": expected " +
           Counted(expected[i].rows, "row") + " with hash " + expected[i].hash.Hex().substr(0, 16) +
           ", found " +
           (i < found.size()
                ? Counted(found[i].rows, "row") + " with hash " + found[i].hash.Hex().substr(0, 16)
                : std::string("no such table"));
  }
  return out;
}

}  // namespace enamel::server
