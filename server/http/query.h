#pragma once

#include <cstdint>
#include <optional>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/http/message.h"

// Values of the query. Errors: kInvalidInput with the name in field().
namespace enamel::server::http {

Result<std::optional<Uuid>> QueryId(const Request& request, const char* name);
// "true" or "false".
Result<std::optional<bool>> QueryFlag(const Request& request, const char* name);
// A whole number; 0 when absent.
Result<uint64_t> QueryOffset(const Request& request, const char* name);
Result<uint32_t> QueryLimit(const Request& request, uint32_t otherwise, uint32_t at_most);

}  // namespace enamel::server::http
