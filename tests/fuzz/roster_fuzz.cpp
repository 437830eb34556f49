#include "common/base/check.h"
#include "common/base/csv.h"
#include "server/roster/roster_file.h"

// A roster as somebody might upload it. An accepted roster is within its bounds, and the table
// written from it reads back.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel::server;
  std::string_view text(reinterpret_cast<const char*>(data), size);
  roster::RosterFile file = roster::ReadRoster(text, {"Given", size % 2 == 0});
  for (const RosterRow& row : file.rows) {
    ENAMEL_CHECK(!row.login.empty() && row.login.size() <= 64 && row.row >= 2);
    ENAMEL_CHECK(row.role != Role::kAdmin && !row.cohort.empty());
    std::string line = enamel::CsvLine({row.login, row.display_name, row.cohort, "x"});
    enamel::CsvTable table = enamel::ReadCsv(line);
    ENAMEL_CHECK(table.problem_row == 0 && table.rows.size() == 1);
    ENAMEL_CHECK(table.rows[0].cells.size() == 4 && table.rows[0].cells[1] == row.display_name);
  }
  for (const RosterProblem& problem : file.problems) ENAMEL_CHECK(problem.row >= 1);
  return 0;
}
