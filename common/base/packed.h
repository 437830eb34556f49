#pragma once

#include <cstddef>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"

// Bytes packed with zstd (RFC 8878). Functions, any thread; they allocate.
namespace enamel {

// Of text that a server keeps (schemas/personal_data.md, "Envelope").
inline constexpr int kTextLevel = 6;

// Equal bytes give equal ones with one version of zstd.
Bytes Pack(ByteView raw, int level);
// The `size` bytes that were packed. Takes no more memory than that, whatever the frame says: the
// caller bounds it. Errors: kInvalidInput, "`what` cannot be unpacked: …".
Result<Bytes> Unpack(ByteView packed, size_t size, std::string_view what);

}  // namespace enamel
