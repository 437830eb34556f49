#include "common/protocol/remark.h"

#include <algorithm>

#include "common/base/utf8.h"

namespace enamel::protocol {
namespace {

Status Refused(const std::string& expected, const std::string& found) {
  return Status(Code::kInvalidInput, "expected " + expected + ", found " + found, "text");
}

std::string OneLine(std::string_view text) {
  std::string line(text);
  std::ranges::replace_if(
      line, [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
  const size_t from = line.find_first_not_of(' ');
  if (from == std::string::npos) return "";
  return line.substr(from, line.find_last_not_of(' ') - from + 1);
}

// The first `most` characters; an invalid byte counts as one.
std::string_view FirstCharacters(std::string_view text, size_t most) {
  std::string_view rest = text;
  for (size_t i = 0; i < most && !rest.empty(); ++i) {
    if (!NextCodePoint(rest)) rest.remove_prefix(1);
  }
  return text.substr(0, text.size() - rest.size());
}

}  // namespace

Result<std::string> CheckedRemark(std::string_view text) {
  std::string line = OneLine(text);
  if (line.empty()) return Refused("a remark to send", "nothing to read; write what to say");
  size_t characters = 0;
  for (std::string_view rest = line; !rest.empty(); ++characters) {
    const std::optional<uint32_t> code = NextCodePoint(rest);
    if (!code) return Refused("a remark in UTF-8", "bytes that are not");
    if (IsControl(*code) || IsInvisibleTrick(*code)) {
      return Refused("a remark without control characters and marks of direction; leave it out",
                     "character number " + std::to_string(*code));
    }
  }
  if (characters > kMaxRemarkCharacters) {
    return Refused("a remark of at most " + std::to_string(kMaxRemarkCharacters) + " characters",
                   std::to_string(characters) + "; shorten it");
  }
  return line;
}

void SetRemark(const Remark& remark, wire::Remark& message) {
  message.set_id(remark.id);
  message.set_text(remark.text);
  message.set_from(remark.from);
  message.set_sent_unix_ms(remark.sent_unix_ms);
}

Remark ReadRemark(const wire::Remark& message) {
  Remark out;
  out.id = message.id();
  out.text = Printable(FirstCharacters(OneLine(message.text()), kMaxRemarkCharacters));
  out.from = Printable(OneLine(ShortenedText(message.from(), kMaxRemarkSenderBytes)));
  out.sent_unix_ms = message.sent_unix_ms();
  return out;
}

}  // namespace enamel::protocol
