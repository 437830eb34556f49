#include "server/roster/text_reading.h"

#include <unicode/ucnv.h>

#include <algorithm>

#include "common/base/check.h"
#include "common/base/utf8.h"

namespace enamel::server::roster {
namespace {

struct Mark {
  std::string_view bytes, reading;
};
constexpr Mark kMarks[] = {
    {"\xef\xbb\xbf", "utf-8"}, {"\xff\xfe", "utf-16le"}, {"\xfe\xff", "utf-16be"}};

// Most characters of a table are Latin letters and separators, whose other byte is zero.
constexpr size_t kLooksAt = 4096;

std::string_view WithoutMark(std::string_view bytes, std::string_view reading) {
  for (const Mark& mark : kMarks) {
    if (mark.reading == reading && bytes.starts_with(mark.bytes)) {
      bytes.remove_prefix(mark.bytes.size());
    }
  }
  return bytes;
}

}  // namespace

bool IsReading(std::string_view name) {
  return std::ranges::find(kReadings, name) != kReadings.end();
}

std::string_view ReadingOf(std::string_view bytes) {
  for (const Mark& mark : kMarks) {
    if (bytes.starts_with(mark.bytes)) return mark.reading;
  }
  const std::string_view begin = bytes.substr(0, kLooksAt);
  size_t zeros[2] = {};
  for (size_t i = 0; i < begin.size(); ++i) zeros[i % 2] += begin[i] == '\0' ? 1 : 0;
  if (4 * std::max(zeros[0], zeros[1]) > begin.size()) {
    return zeros[1] > zeros[0] ? "utf-16le" : "utf-16be";
  }
  return IsUtf8(bytes) ? "utf-8" : "windows-1252";
}

std::string TextOf(std::string_view bytes, std::string_view reading) {
  ENAMEL_CHECK(IsReading(reading));
  bytes = WithoutMark(bytes, reading);
  if (reading == "utf-8") return AsUtf8(bytes);
  UErrorCode error = U_ZERO_ERROR;
  const std::string name(reading);
  // A byte is three in UTF-8 at most, and two that are one character are four.
  std::string out(3 * bytes.size() + 4, '\0');
  const int32_t size =
      ucnv_convert("utf-8", name.c_str(), out.data(), static_cast<int32_t>(out.size()),
                   bytes.data(), static_cast<int32_t>(bytes.size()), &error);
  ENAMEL_CHECK(U_SUCCESS(error));
  out.resize(static_cast<size_t>(size));
  return out;
}

}  // namespace enamel::server::roster
