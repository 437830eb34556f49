#pragma once

#include <filesystem>
#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel::server {

// A file with a secret, which only its owner may read. In messages, `what` it is ("the master key")
// and what to do if it is missing ("write it"). Errors: kNotFound (no such file), kForbidden
// (others may read it), kStorage (it cannot be read, or is a link that leads nowhere: its target
// may be on a disk that is not mounted yet).
Result<Bytes> ReadPrivateFile(const std::filesystem::path& path, size_t max_bytes,
                              const std::string& what, const std::string& remedy);

}  // namespace enamel::server
