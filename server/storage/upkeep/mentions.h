#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/sql/db.h"
#include "server/training/types.h"

namespace enamel::server {

// Where a person's name is in what people typed. An erasure does not change such texts: they are
// others' (a remark about another student, the name of a cohort), and only people know what to write
// instead.
struct Mentions {
  // Where: "attempt" (remarks, appeals, marks, reasons), "reference" (the dentist), "exercise" (title,
  // reason of a rubric), "cohort", "station", "scene", "profile", "device", "batch" (titles).
  std::string kind;
  size_t count = 0;
  // Where to edit them, at most kMaxPlaces: the attempt, also of a reference; the exercise; the
  // cohort. Empty for the others, which have no page of their own.
  std::vector<std::string> places;

  static constexpr size_t kMaxPlaces = 20;
};

// Looks for the display name and the login, as whole words, without case and accents. Reads every
// such text of the school. Those of kinds without any are left out.
Result<std::vector<Mentions>> MentionsOf(sql::Db& db, const Person& person);

}  // namespace enamel::server
