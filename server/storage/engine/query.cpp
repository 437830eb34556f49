#include "server/storage/engine/query.h"

namespace enamel::server {

Status Insert(Db& db, const std::string& table, const Cells& cells, const char* rest) {
  std::string columns, places;
  for (size_t i = 0; i < cells.size(); ++i) {
    columns += std::string(", ") + cells[i].first;
    places += ", ?" + std::to_string(i + 2);
  }
  Query q(db, "INSERT INTO " + table + " (tenant" + columns + ") VALUES (?1" + places + ")" + rest);
  for (const auto& [column, bind] : cells) bind(q);
  return q.Run();
}

}  // namespace enamel::server
