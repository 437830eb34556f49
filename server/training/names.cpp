#include "server/training/names.h"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace enamel::server {
namespace {

bool IsAlphanumeric(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool IsLoginCharacter(char c) {
  return IsAlphanumeric(c) || std::string_view(".-_@").find(c) != std::string_view::npos;
}

// The next code point (RFC 3629), taken off `text`; none when it is not valid.
std::optional<uint32_t> NextCodePoint(std::string_view& text) {
  auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  uint8_t first = byte(0);
  size_t size = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (size == 0 || first > 0xf4 || text.size() < size) return std::nullopt;
  uint32_t code = size == 1 ? first : first & (0x7fu >> size);
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return std::nullopt;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  constexpr uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kSmallest[size] || code > 0x10ffff || surrogate) return std::nullopt;
  text.remove_prefix(size);
  return code;
}

bool IsControl(uint32_t c) { return c < 0x20 || (c >= 0x7f && c < 0xa0); }
// Line and paragraph separators; what overrides, embeds or isolates a direction; byte order mark.
bool IsInvisibleTrick(uint32_t c) {
  return c == 0x2028 || c == 0x2029 || (c >= 0x202a && c <= 0x202e) ||
         (c >= 0x2066 && c <= 0x2069) || c == 0xfeff;
}

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

Status Refused(std::string_view field, const std::string& expected, std::string_view found) {
  return {Code::kInvalidInput, "expected " + expected + ", found " + std::string(found),
          std::string(field)};
}

}  // namespace

Result<std::string> CheckedLogin(std::string_view text) {
  std::string login(Trim(text));
  bool fits = !login.empty() && login.size() <= kMaxLoginBytes && IsAlphanumeric(login.front()) &&
              std::ranges::all_of(login, IsLoginCharacter);
  if (!fits) {
    bool long_one = login.size() > kMaxLoginBytes;
    return Refused("login",
                   "1 to 64 letters a-z, digits or any of . - _ @, the first a letter or digit",
                   long_one ? std::to_string(login.size()) + " bytes" : "\"" + login + "\"");
  }
  std::ranges::transform(login, login.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return login;
}

Result<std::string> CheckedName(std::string_view text, std::string_view field) {
  std::string_view name = Trim(text);
  if (name.empty() || name.size() > kMaxNameBytes) {
    return Refused(field, "a name of 1 to 200 bytes", std::to_string(name.size()) + " bytes");
  }
  if (std::string_view("=+-@").find(name.front()) != std::string_view::npos) {
    return Refused(field,
                   "a name that does not begin with = + - or @ (a spreadsheet would compute it)",
                   "\"" + std::string(name) + "\"");
  }
  for (std::string_view rest = name; !rest.empty();) {
    std::optional<uint32_t> code = NextCodePoint(rest);
    if (!code) return Refused(field, "text in UTF-8", "bytes that are not; save the file as UTF-8");
    if (IsControl(*code) || IsInvisibleTrick(*code)) {
      return Refused(field, "a name without control characters and line breaks",
                     "character number " + std::to_string(*code));
    }
  }
  return std::string(name);
}

std::string ShortenedText(std::string_view text, size_t most) {
  if (text.size() <= most) return std::string(text);
  while (most > 0 && (static_cast<uint8_t>(text[most]) & 0xc0) == 0x80) --most;
  return std::string(text.substr(0, most));
}

}  // namespace enamel::server
