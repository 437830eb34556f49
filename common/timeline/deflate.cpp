#include "common/timeline/deflate.h"

#include <zlib.h>

#include <algorithm>
#include <string>

namespace enamel::timeline {
namespace {

// The most that a byte of a deflate stream can stand for (zlib's "Technical Details").
constexpr size_t kMaxRatio = 1032;
// Packed between two questions whether to keep going.
constexpr size_t kPiece = 64 * 1024;

}  // namespace

Bytes Deflate(ByteView raw, Effort effort, const KeepGoing& keep_going) {
  z_stream stream{};
  ENAMEL_CHECK(deflateInit(&stream, effort == Effort::kMost ? 9 : 6) == Z_OK);
  Bytes out(deflateBound(&stream, static_cast<uLong>(raw.size())));
  // zlib reads through a pointer that is not const.
  stream.next_in = const_cast<Bytef*>(raw.data());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  size_t left = raw.size();
  int done = Z_OK;
  while (done == Z_OK && (!keep_going || keep_going())) {
    stream.avail_in = static_cast<uInt>(std::min(left, kPiece));
    left -= stream.avail_in;
    done = deflate(&stream, left == 0 ? Z_FINISH : Z_NO_FLUSH);
  }
  ENAMEL_CHECK(done == Z_OK || done == Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
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
