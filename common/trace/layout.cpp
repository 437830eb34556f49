#include "common/trace/layout.h"

#include <algorithm>

#include "common/base/letters.h"
#include "common/base/sha256.h"
#include "common/trace/trace.h"

namespace enamel::trace {
namespace {

// Against damage, not against anybody: what cannot be forged is the chain.
constexpr size_t kCheckBytes = 4;

Sha256 CheckOf(uint8_t kind, ByteView content) {
  ByteWriter prefix;
  prefix.U8(kind);
  prefix.U32(static_cast<uint32_t>(content.size()));
  Sha256Stream stream;
  stream.Update(prefix.bytes());
  stream.Update(content);
  return stream.Finish();
}

}  // namespace

void WriteMagic(const Magic& magic, ByteWriter& out) {
  out.Raw(magic);
  out.U16(kTraceVersion);
}

Status ReadMagic(const std::string& what, const Magic& magic, ByteReader& in) {
  ByteView found = in.Raw(magic.size());
  uint16_t version = in.U16();
  if (!in.ok() || !std::equal(found.begin(), found.end(), magic.begin())) {
    return Status(Code::kInvalidInput, what + ": " + OtherLetters(AsText(magic), found), "magic");
  }
  if (version == kTraceVersion) return Status::Ok();
  return Status(Code::kVersion,
                what + " is of format version " + std::to_string(version) +
                    ", this program reads version " + std::to_string(kTraceVersion) +
                    "; use a program of the recording's version",
                "version");
}

void WriteRecord(uint8_t kind, ByteView content, ByteWriter& out) {
  out.U8(kind);
  out.Blob(content);
  out.Raw(CheckOf(kind, content).view().first(kCheckBytes));
}

Result<std::optional<Record>> ReadRecord(const std::string& what, size_t max_bytes, size_t before,
                                         ByteReader& in) {
  size_t offset = before + in.offset();
  Record record;
  record.kind = in.U8();
  size_t size = in.U32();
  if (in.ok() && size > max_bytes) {
    return TooLarge(what + ", record at byte " + std::to_string(offset), max_bytes, size);
  }
  record.content = in.Raw(size);
  ByteView check = in.Raw(kCheckBytes);
  // Cut off, which is no damage: a file may still have been growing.
  if (!in.ok()) return std::optional<Record>();
  Sha256 expected = CheckOf(record.kind, record.content);
  if (!std::equal(check.begin(), check.end(), expected.bytes.begin())) {
    return DamagedAt(what, offset,
                     "its check does not fit its content, the file is damaged here; "
                     "fetch it again from the spool or the server");
  }
  return std::optional<Record>(record);
}

Status DamagedAt(const std::string& what, size_t offset, const std::string& why) {
  return Status(Code::kInvalidInput,
                what + ", record at byte " + std::to_string(offset) + ": " + why,
                std::to_string(offset));
}

Status EndsEarly(const std::string& what, size_t size) {
  return Status(Code::kInvalidInput,
                what + ": its " + std::to_string(size) +
                    " bytes end before the last field, or a length in it is too large");
}

Status WrongSize(const std::string& what, size_t expected, size_t found) {
  return Status(Code::kInvalidInput, what + ": expected " + std::to_string(expected) +
                                         " bytes, found " + std::to_string(found));
}

Status TooLarge(const std::string& what, size_t limit, size_t found) {
  return Status(Code::kTooLarge, what + ": expected at most " + std::to_string(limit) +
                                     " bytes, found " + std::to_string(found));
}

}  // namespace enamel::trace
