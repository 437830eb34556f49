#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"

// Several files as one answer: a tar archive (POSIX.1-1988, ustar), which every system unpacks. A
// value type, one thread at a time.
namespace enamel::server::http {

class Tar {
 public:
  // `unix_s`: the time that all files get.
  explicit Tar(int64_t unix_s) : unix_s_(unix_s) {}

  // Requires: a name of 1 to 100 bytes without a slash, content below 8 GiB.
  void Add(std::string_view name, ByteView content);
  // The archive; nothing may be added after it.
  std::string Take();

 private:
  const int64_t unix_s_;
  std::string bytes_;
};

}  // namespace enamel::server::http
