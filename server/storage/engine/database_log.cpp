#include "server/storage/engine/database_log.h"

#include "server/ops/repeat_log.h"

namespace enamel::server {

void WarnOfDatabase(const std::string& words) {
  // One for all connections of the process, as the program's log is.
  static ops::RepeatLog log;
  log.Note(words, "database: " + words);
}

}  // namespace enamel::server
