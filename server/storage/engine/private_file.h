#pragma once

#include <filesystem>
#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel::server {

// A file of a secret, which nobody but its owner may read; `what` it is, in messages: "a master key".
// Errors: kNotFound (no such file), kForbidden (others may read it), kStorage (it cannot be read, or is a
// link that leads nowhere: what it leads to may be on a disk that is not there yet).
Result<Bytes> ReadPrivateFile(const std::filesystem::path& path, size_t max_bytes,
                              const std::string& what);

}  // namespace enamel::server
