#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "server/storage/engine/database.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server::testing {

inline std::unique_ptr<SqliteDb> OpenMigrated(const std::filesystem::path& path) {
  auto db = std::move(OpenDatabase(path, DbMode::kCreate)).value();
  EXPECT_TRUE(db->Migrate(SqliteMigrations()).ok());
  return db;
}

// How rows of a database are reached without a store around them. `before_write` is called once,
// before the next transaction.
inline Transactions::Connections ConnectionsTo(const std::filesystem::path& path,
                                               std::function<void()>& before_write) {
  auto writer = OpenDatabase(path, DbMode::kExisting, {}, [&before_write] {
    if (before_write) std::exchange(before_write, {})();
    return false;
  });
  EXPECT_TRUE(writer.ok()) << writer.status().message();
  return {std::move(writer).value(), [path]() -> Result<std::unique_ptr<sql::Db>> {
            ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(path, DbMode::kReadOnly));
            return std::unique_ptr<sql::Db>(std::move(db));
          }};
}

}  // namespace enamel::server::testing
