#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/base/byte_pieces.h"

// Several files as one answer: a tar archive (POSIX.1-1988, ustar), which every system unpacks. A
// value type, one thread at a time.
namespace enamel::server::http {

class Tar {
 public:
  // `unix_s`: the time that all files get.
  explicit Tar(int64_t unix_s) : unix_s_(unix_s) {}

  // Requires: a name of 1 to 100 bytes without a slash, content below 8 GiB.
  void Add(std::string_view name, BytePieces content);
  // The archive, which reads each content when its turn comes; nothing may be added after it.
  // Errors of reading: what a content returns; kStorage (a content has another size than it said).
  BytePieces Take();

 private:
  const int64_t unix_s_;
  std::vector<BytePieces> parts_;
};

}  // namespace enamel::server::http
