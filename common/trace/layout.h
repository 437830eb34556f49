#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/trace/trace.h"

// Magics, sizes and the refusals shared by the codecs of this directory (schemas/trace_format.md).
namespace enamel::trace {

using Magic = std::array<uint8_t, 4>;
inline constexpr Magic kTicketMagic = {'E', 'N', 'a', 't'};
inline constexpr Magic kHeaderMagic = {'E', 'N', 'a', 'h'};
inline constexpr Magic kChunkMagic = {'E', 'N', 'a', 'c'};
inline constexpr Magic kSealMagic = {'E', 'N', 'a', 's'};
inline constexpr Magic kFileMagic = {'E', 'N', 'a', 'f'};
inline constexpr Magic kKeyframesMagic = {'E', 'N', 'a', 'k'};
inline constexpr size_t kSealBytes = 74;

// Magic and version.
void WriteMagic(const Magic& magic, ByteWriter& out);
// Errors: kInvalidInput for another magic, kVersion for another version.
Status ReadMagic(const std::string& what, const Magic& magic, ByteReader& in);

// A file is its magic, version and reserved field, a body if it has one, and records: kind, size,
// content, check. `what` names the file in refusals.
struct Record {
  uint8_t kind = 0;
  ByteView content;
};
void WriteRecord(uint8_t kind, ByteView content, ByteWriter& out);
// The next record; nothing (and in.ok() false) when the file ends inside it. `before`: where in the
// file `in` begins. Errors: kTooLarge, kInvalidInput with the offset.
Result<std::optional<Record>> ReadRecord(const std::string& what, size_t max_bytes, size_t before,
                                         ByteReader& in);
Status DamagedAt(const std::string& what, size_t offset, const std::string& why);

Status EndsEarly(const std::string& what, size_t size);
Status WrongSize(const std::string& what, size_t expected, size_t found);
Status TooLarge(const std::string& what, size_t limit, size_t found);

}  // namespace enamel::trace
