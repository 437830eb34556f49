#pragma once

#include <cstddef>
#include <string>

#include "common/base/result.h"

// Where an S3 store is, as people write it. Pure functions. Thread safety: any thread. Private to
// server/s3.
namespace enamel::s3 {

// Letters, digits and `others` alone, at least one and at most `most` of them.
bool IsSimple(const std::string& text, const char* others, size_t most);

// Scheme and "HOST[:PORT]". Errors: kInvalidInput.
struct Place {
  bool secure = false;
  std::string host;
};
Result<Place> PlaceOf(const std::string& endpoint);

}  // namespace enamel::s3
