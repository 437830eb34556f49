#include "common/trace/layout.h"

#include <algorithm>

#include "common/trace/trace.h"

namespace enamel::trace {

void WriteMagic(const Magic& magic, ByteWriter& out) {
  out.Raw(magic);
  out.U16(kTraceVersion);
}

Status ReadMagic(const std::string& what, const Magic& magic, ByteReader& in) {
  ByteView found = in.Raw(magic.size());
  uint16_t version = in.U16();
  if (!in.ok() || !std::equal(found.begin(), found.end(), magic.begin())) {
    return Status(Code::kInvalidInput,
                  what + ": expected it to begin with \"" + std::string(AsText(magic)) +
                      "\" and a version; this is something else or cut short",
                  "magic");
  }
  if (version == kTraceVersion) return Status::Ok();
  return Status(Code::kVersion,
                what + " is of format version " + std::to_string(version) +
                    ", this program reads version " + std::to_string(kTraceVersion) +
                    "; use a program of the recording's version",
                "version");
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
