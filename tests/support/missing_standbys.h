#pragma once

#include <gtest/gtest.h>

#include <string>

#include "common/sql/query.h"

namespace enamel::test {

// Makes PostgreSQL wait for standbys that do not exist: until this object ends, no change on the
// whole server completes. `db` is an administrator's, and outlives it. Thread safety: one thread.
class MissingStandbys {
 public:
  explicit MissingStandbys(sql::Db& db) : db_(db) {}
  ~MissingStandbys() {
    EXPECT_TRUE(db_.Exec("ALTER SYSTEM RESET synchronous_standby_names").ok());
    EXPECT_TRUE(Read());
  }
  MissingStandbys(const MissingStandbys&) = delete;
  MissingStandbys& operator=(const MissingStandbys&) = delete;

  // As in postgresql.conf. The server applies it some milliseconds later.
  void Name(const std::string& names) {
    const std::string set = "ALTER SYSTEM SET synchronous_standby_names = '" + names + "'";
    ASSERT_TRUE(db_.Exec(set.c_str()).ok());
    ASSERT_TRUE(Read());
  }

 private:
  bool Read() { return sql::Query(db_, "SELECT pg_reload_conf()").Next(); }

  sql::Db& db_;
};

}  // namespace enamel::test
