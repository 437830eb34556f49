#pragma once

#include <string>

#include "common/base/result.h"

namespace enamel {

// The refusal of a document, with where it came from: "FILE: rubric.criteria[2].weight: expected
// …". A message that begins with its member already does not get it a second time.
inline Status InDocument(const std::string& where, const Status& status) {
  const std::string& field = status.field();
  const bool placed = field.empty() || status.message().starts_with(field);
  return {status.code(), where + ": " + (placed ? "" : field + ": ") + status.message(), field};
}

}  // namespace enamel
