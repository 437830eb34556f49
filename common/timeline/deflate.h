#pragma once

#include <string_view>

#include "common/base/bytes.h"
#include "common/base/keep_going.h"
#include "common/base/result.h"

// Packing in the format of RFC 1950 ("zlib"), which browsers unpack by themselves. Bounded,
// deterministic with one version of the library. Thread safety: functions, any thread.
namespace enamel::timeline {

enum class Effort { kQuick, kMost };  // kMost: 4 % fewer bytes, four times as long
Bytes Deflate(ByteView raw, Effort effort = Effort::kQuick, const KeepGoing& keep_going = {});
// The `size` bytes that were packed. Errors: kInvalidInput when there is another number of them or
// they are damaged; the message begins with `blob`, what is read, and names the section. No memory
// is taken for a size that this many packed bytes cannot give.
Result<Bytes> Inflate(ByteView packed, size_t size, std::string_view blob,
                      std::string_view section);

}  // namespace enamel::timeline
