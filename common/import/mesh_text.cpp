#include "common/import/mesh_text.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string>

namespace enamel::import {
namespace {

char Small(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// The longest that a number of a sane exporter is; longer words are none.
constexpr size_t kLongestNumber = 64;

bool Plain(std::string_view word, double& value, std::string_view& rest) {
  auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::invalid_argument) return false;
  rest = word.substr(static_cast<size_t>(end - word.data()));
  // Too small for a double is nothing; too large is no coordinate, as infinity is none.
  if (error == std::errc::result_out_of_range) {
    const bool tiny = word.find("e-") != word.npos || word.find("E-") != word.npos;
    value = tiny ? 0 : std::numeric_limits<double>::quiet_NaN();
  }
  return true;
}

// UTF-16, little- or big-endian, to UTF-8. Half a pair becomes a question mark.
Bytes FromUtf16(ByteView file, bool big) {
  Bytes out;
  out.reserve(file.size());
  auto unit = [&](size_t i) {
    return static_cast<uint32_t>(big ? file[i] << 8 | file[i + 1] : file[i + 1] << 8 | file[i]);
  };
  for (size_t i = 0; i + 1 < file.size(); i += 2) {
    uint32_t c = unit(i);
    if (c >= 0xd800 && c < 0xe000) {
      const bool pair = c < 0xdc00 && i + 3 < file.size() && unit(i + 2) >> 10 == 0x37;
      c = pair ? 0x10000 + ((c & 0x3ff) << 10) + (unit(i + 2) & 0x3ff) : '?';
      if (pair) i += 2;
    }
    if (c < 0x80) {
      out.push_back(static_cast<uint8_t>(c));
      continue;
    }
    const int more = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
    constexpr uint8_t kLead[] = {0, 0xc0, 0xe0, 0xf0};
    out.push_back(static_cast<uint8_t>(kLead[more] | c >> (6 * more)));
    for (int k = more; k-- > 0;) out.push_back(static_cast<uint8_t>(0x80 | (c >> (6 * k) & 0x3f)));
  }
  return out;
}

}  // namespace

bool Lines::Next(std::string_view& line) {
  if (rest_.empty()) return false;
  const size_t end = rest_.find_first_of("\r\n");
  line = rest_.substr(0, end);
  if (end == std::string_view::npos) {
    rest_ = {};
    whole_ = false;
    return true;
  }
  const bool pair = rest_.substr(end, 2) == "\r\n";
  rest_.remove_prefix(end + (pair ? 2 : 1));
  return true;
}

std::string_view Word(std::string_view& line) {
  const size_t first = line.find_first_not_of(" \t\v\f");
  if (first == std::string_view::npos) return line = {};
  line.remove_prefix(first);
  const std::string_view word = line.substr(0, line.find_first_of(" \t\v\f"));
  line.remove_prefix(word.size());
  return word;
}

std::string_view WordAcrossLines(std::string_view& text) {
  constexpr std::string_view kSpace = " \t\v\f\r\n";
  const size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return text = {};
  text.remove_prefix(first);
  const std::string_view word = text.substr(0, text.find_first_of(kSpace));
  text.remove_prefix(word.size());
  return word;
}

bool IsWord(std::string_view text, std::string_view word) {
  return text.size() == word.size() && std::equal(word.begin(), word.end(), text.begin(),
                                                  [](char w, char t) { return w == Small(t); });
}

bool StartsWithWord(std::string_view text, std::string_view word) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\v\f\r\n"), text.size()));
  return IsWord(text.substr(0, word.size()), word);
}

bool Number(std::string_view word, uint64_t& value) {
  auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

bool SignedNumber(std::string_view word, int64_t& value) {
  auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

bool Coordinate(std::string_view word, double& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  std::string_view rest;
  if (!Plain(word, value, rest)) return false;
  if (rest.empty() || rest == ",") return true;
  // The C library of Windows: -1.#IND, 1.#QNAN, 1.#INF00.
  if (rest.front() == '#') {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  if (word.size() > kLongestNumber) return false;
  std::string form(word);
  if (form.find('.') == form.npos) std::replace(form.begin(), form.end(), ',', '.');
  std::replace(form.begin(), form.end(), 'D', 'e');  // FORTRAN
  std::replace(form.begin(), form.end(), 'd', 'e');
  return Plain(form, value, rest) && rest.empty();
}

bool HasUtf8Mark(ByteView file) { return AsText(file).starts_with("\xef\xbb\xbf"); }

std::string_view PlainText(ByteView file, Bytes& converted) {
  std::string_view text = AsText(file);
  // With a mark, or without it where the first letters show it.
  const bool little = text.starts_with("\xff\xfe") ||
                      (file.size() > 3 && file[0] != 0 && file[1] == 0 && file[3] == 0);
  const bool big = text.starts_with("\xfe\xff") ||
                   (file.size() > 3 && file[0] == 0 && file[1] != 0 && file[2] == 0);
  if (little || big) {
    converted = FromUtf16(file, big);
    text = AsText(converted);
  }
  if (HasUtf8Mark(AsBytes(text))) text.remove_prefix(kUtf8Mark);
  const size_t last = text.find_last_not_of(std::string_view("\0\x1a", 2));
  return text.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

}  // namespace enamel::import
