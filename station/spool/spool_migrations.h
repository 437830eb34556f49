#pragma once

#include <string>
#include <vector>

namespace enamel::station {

struct SpoolMigration {
  std::string name;  // "0001_initial.sql"
  std::string sql;
};
// In order; the n-th (1-based) leads to version n of the spool. Generated from
// schemas/sql/station_spool.
const std::vector<SpoolMigration>& SpoolMigrations();

}  // namespace enamel::station
