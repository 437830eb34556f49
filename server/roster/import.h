#pragma once

#include <boost/json/object.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/roster/roster_file.h"
#include "server/storage/audit/actor.h"
#include "server/storage/people/roster_rows.h"

namespace enamel::server::roster {

// A person's first password, shown once and kept nowhere.
struct NewPassword {
  std::string login, display_name, cohort, password;
};

struct ImportOptions {
  RosterOptions file;
  bool dry_run = false;
  bool move = false;  // students who join a cohort leave their other ones (RosterStep::others)
  // Gets the passwords of the people to be added, before anybody is added; if it cannot keep them,
  // nobody is. None: only the result has the passwords. The set of new people may change until the
  // import is done; the result then has other passwords than this got.
  std::function<Status(const std::vector<NewPassword>&)> keep{};
};

struct ImportResult {
  bool done = false;    // false: only tried, or there are problems
  RosterPlan plan;      // `problems` has those of the file too, by row
  std::string reading;  // of the bytes (text_reading.h)
  std::vector<std::string> ignored_columns;
  std::vector<LeftOutRow> left_out;
  std::vector<NewPassword> passwords;  // of those created; none when only tried
};

// Reads the roster and brings the store in line with it, all or nothing. Blocks. Errors: those of
// the store, those of `keep`; problems of the roster are in the result.
Result<ImportResult> ImportRoster(RosterRows& roster, std::string_view bytes,
                                  const ImportOptions& options, const Actor& by);

// schemas/roster.md, "The outcome". At most 200 problems are listed, all are counted.
boost::json::object ImportJson(const ImportResult& result);
// login, display_name, cohort, password.
std::string PasswordsCsv(const std::vector<NewPassword>& passwords);

}  // namespace enamel::server::roster
