#include "common/timeline/deflate.h"

#include <zlib.h>

#include <string>

namespace enamel::timeline {
namespace {

// The most that a byte of a deflate stream can stand for (zlib's "Technical Details").
constexpr size_t kMaxRatio = 1032;

}  // namespace

Bytes Deflate(ByteView raw, Effort effort) {
  uLongf size = compressBound(raw.size());
  Bytes out(size);
  const int done =
      compress2(out.data(), &size, raw.data(), raw.size(), effort == Effort::kMost ? 9 : 6);
  ENAMEL_CHECK(done == Z_OK);
  out.resize(size);
  return out;
}

Result<Bytes> Inflate(ByteView packed, size_t size, std::string_view blob,
                      std::string_view section) {
  const auto damaged = [&](const std::string& why) {
    return Status(Code::kInvalidInput, std::string(blob) + ": section '" + std::string(section) +
                                           "' " + why + "; the file is damaged, make it again");
  };
  if (size / kMaxRatio > packed.size()) {
    return damaged("cannot hold the " + std::to_string(size) + " bytes its header asks for");
  }
  // One byte more than expected, so that a longer stream is noticed.
  Bytes out(size + 1);
  uLongf found = out.size();
  uLong used = packed.size();
  const int done = uncompress2(out.data(), &found, packed.data(), &used);
  if (done != Z_OK || found != size || used != packed.size()) {
    return damaged("does not hold the " + std::to_string(size) + " bytes its header asks for");
  }
  out.resize(size);
  return out;
}

}  // namespace enamel::timeline
