#pragma once

#include <filesystem>

#include "common/base/byte_pieces.h"
#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel {

// Whole file into memory. Errors: kNotFound, kTooLarge beyond `max_bytes`, kStorage.
Result<Bytes> ReadFile(const std::filesystem::path& path, size_t max_bytes = size_t{1} << 31);

// Replaces `path` so that a reader, or the next start after a power cut, sees the old content or
// the new one and never a mixture: temporary file, fsync, rename, fsync of the folder.
Status WriteFileDurably(const std::filesystem::path& path, ByteView data, int mode = 0644);
// Errors also: what `next` returns. `path` then keeps its content.
Status WriteFileDurably(const std::filesystem::path& path, const BytePieces& content, int mode);

// The folder of the running program's file; "." where the system does not say.
std::filesystem::path OwnFolder();

}  // namespace enamel
