#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/sql/db.h"

// A school's rows as a whole, whichever engine has them: copied from one to the other, and
// compared.
namespace enamel::server {

struct Table {
  struct Column {
    std::string name;
    sql::Type type;
  };
  std::string name;
  std::vector<Column> columns;
  std::vector<size_t> key;  // which of them are the primary key, in its order
};

// Every table of the newest schema, each after those that it refers to, without those of the
// installation: places of blobs and keys, and messages between running servers. Read from a SQLite
// database that has the schema; PostgreSQL has the same tables and columns
// (tests/server/storage/pg_schema_test.cpp).
Result<std::vector<Table>> TablesOfSchool(sql::Db& sqlite);

// All rows of a table in the order of its key, as bytes that do not depend on the engine
// (school_tables.cpp).
struct TableDigest {
  std::string table;
  uint64_t rows = 0;
  Sha256 hash;
  bool operator==(const TableDigest&) const = default;
};

// Called after so many rows of the table, at times.
using RowProgress = std::function<void(const std::string& table, uint64_t rows)>;

// Part of a transaction of the caller's, in which both see one moment. Errors: the database's.
Result<std::vector<TableDigest>> DigestRows(sql::Db& db, const std::vector<Table>& tables,
                                            const RowProgress& progress = {});
// Copies the rows of `from` into `to` and returns their digests. `to` has no rows but those that a
// migration makes: these are deleted first. Part of a transaction of the caller's in each.
Result<std::vector<TableDigest>> CopyRows(sql::Db& from, sql::Db& to,
                                          const std::vector<Table>& tables,
                                          const RowProgress& progress = {});

// The tables whose digests differ, as a sentence; empty: none.
std::string Differences(const std::vector<TableDigest>& expected,
                        const std::vector<TableDigest>& found);

}  // namespace enamel::server
