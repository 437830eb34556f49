#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "common/sql/query.h"

namespace enamel::test {

// Standbys that PostgreSQL waits for and that are not there, until its end: meanwhile no change on the whole server ends.
// `db` is an administrator's, and outlives it. Thread safety: one thread.
class MissingStandbys {
 public:
  explicit MissingStandbys(sql::Db& db) : db_(db) {}
  ~MissingStandbys() {
    EXPECT_TRUE(db_.Exec("ALTER SYSTEM RESET synchronous_standby_names").ok());
    EXPECT_TRUE(Read());
  }
  MissingStandbys(const MissingStandbys&) = delete;
  MissingStandbys& operator=(const MissingStandbys&) = delete;

  // As in postgresql.conf. The server goes by it some milliseconds later.
  void Name(const std::string& names) {
    const std::string set = "ALTER SYSTEM SET synchronous_standby_names = '" + names + "'";
    ASSERT_TRUE(db_.Exec(set.c_str()).ok());
    ASSERT_TRUE(Read());
  }

 private:
  bool Read() { return sql::Query(db_, "SELECT pg_reload_conf()").Next(); }

  sql::Db& db_;
};

// Asks again and again, for ten seconds at most.
template <typename Is>
bool Becomes(const Is& is) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!is()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace enamel::test
