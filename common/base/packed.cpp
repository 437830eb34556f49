#include "common/base/packed.h"

#include <zstd.h>

#include <string>

#include "common/base/check.h"

namespace enamel {

Bytes Pack(ByteView raw, int level) {
  Bytes out(ZSTD_compressBound(raw.size()));
  const size_t size = ZSTD_compress(out.data(), out.size(), raw.data(), raw.size(), level);
  ENAMEL_CHECK(!ZSTD_isError(size));
  out.resize(size);
  return out;
}

Result<Bytes> Unpack(ByteView packed, size_t size, std::string_view what) {
  const auto cannot = [&](const std::string& why) {
    return Status(Code::kInvalidInput, std::string(what) + " cannot be unpacked: " + why);
  };
  const std::string expected = "expected " + std::to_string(size) + " bytes, found ";
  // Before any memory is taken.
  const unsigned long long claimed = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (claimed == ZSTD_CONTENTSIZE_ERROR || claimed == ZSTD_CONTENTSIZE_UNKNOWN) {
    return cannot("it does not say how much is in it");
  }
  if (claimed != size) return cannot(expected + std::to_string(claimed));
  Bytes out(size);
  // Never writes beyond `out`.
  const size_t found = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
  if (ZSTD_isError(found)) return cannot(ZSTD_getErrorName(found));
  if (found != size) return cannot(expected + std::to_string(found));
  return out;
}

}  // namespace enamel
