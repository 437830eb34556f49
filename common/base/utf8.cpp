#include "common/base/utf8.h"

#include <array>

namespace enamel {
namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";  // U+FFFD

std::string Escaped(uint32_t c) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out = c < 0x100 ? "\\x" : c < 0x10000 ? "\\u" : "\\U";
  for (int shift = c < 0x100 ? 4 : c < 0x10000 ? 12 : 28; shift >= 0; shift -= 4)
    out += kDigits[c >> shift & 15];
  return out;
}

}  // namespace

std::optional<uint32_t> NextCodePoint(std::string_view& text) {
  auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  uint8_t first = byte(0);
  // 0x80 to 0xbf only continue a code point, and 0xc0 and 0xc1 could only begin overlong forms.
  // Nothing is above 0xf4: the last code point is U+10FFFF.
  size_t size = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (size == 0 || first > 0xf4 || text.size() < size) return std::nullopt;
  uint32_t code = size == 1 ? first : first & (0x7fu >> size);
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return std::nullopt;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  constexpr std::array<uint32_t, 5> kSmallest = {0, 0, 0x80, 0x800, 0x10000};
  bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kSmallest[size] || code > 0x10ffff || surrogate) return std::nullopt;
  text.remove_prefix(size);
  return code;
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    if (!NextCodePoint(text)) return false;
  }
  return true;
}

std::string AsUtf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    std::string_view rest = text;
    if (NextCodePoint(rest)) {
      out += text.substr(0, text.size() - rest.size());
    } else {
      out += kReplacement;
      // One byte, not the length that the broken start promised: what follows may be a good
      // character.
      rest.remove_prefix(1);
    }
    text = rest;
  }
  return out;
}

bool IsControl(uint32_t code) { return code < 0x20 || (code >= 0x7f && code < 0xa0); }

bool IsInvisibleTrick(uint32_t code) {
  // The ranges: overrides, embeddings and isolates of the bidirectional algorithm (UAX #9); marks of
  // annotations; tags (which spell out a text that nobody sees). The zero-width joiners are not
  // among them: Persian, and many pictures, are written with them.
  return code == 0x200b || code == 0x2060 || (code >= 0xfff9 && code <= 0xfffb) ||
         (code >= 0xe0000 && code <= 0xe0fff) || code == 0x2028 || code == 0x2029 ||
         (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069) || code == 0xfeff;
}

std::string Printable(std::string_view text) {
  const std::string valid = AsUtf8(text);
  std::string out;
  for (std::string_view at = valid; !at.empty();) {
    std::string_view rest = at;
    uint32_t code = *NextCodePoint(rest);
    if (IsControl(code) || IsInvisibleTrick(code)) {
      out += Escaped(code);
    } else {
      out += at.substr(0, at.size() - rest.size());
    }
    at = rest;
  }
  return out;
}

std::string ShortenedText(std::string_view text, size_t most) {
  if (text.size() <= most) return std::string(text);
  // 10xxxxxx continues a character: not cut in the middle of one.
  while (most > 0 && (static_cast<uint8_t>(text[most]) & 0xc0) == 0x80) --most;
  return std::string(text.substr(0, most));
}

}  // namespace enamel
