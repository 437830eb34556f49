#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/bytes.h"

// Words and numbers of the text forms of mesh files, as exporters in the field write them.
namespace enamel::import {

// Lines of a text, without their ends ("\n", "\r\n" or "\r").
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool Next(std::string_view& line);
  std::string_view rest() const { return rest_; }
  bool whole() const { return whole_; }  // the last line given had an end

 private:
  std::string_view rest_;
  bool whole_ = true;
};

// Takes the next word off a line; empty at its end.
std::string_view Word(std::string_view& line);
// The same, over the ends of lines.
std::string_view WordAcrossLines(std::string_view& text);
// `word` is in small letters.
bool IsWord(std::string_view text, std::string_view word);
bool StartsWithWord(std::string_view text, std::string_view word);

// The whole word is one number. Errors: false.
bool Number(std::string_view word, uint64_t& value);
bool SignedNumber(std::string_view word, int64_t& value);
// A coordinate in any of the forms that exporters write: 1.5, +1.5, 1,5 (a decimal comma), 1.5D+00.
// NaN where the exporter wrote that it had no number: nan, -nan(ind), -1.#IND, 1.#QNAN, inf. Errors:
// false.
bool Coordinate(std::string_view word, double& value);

// The file without a byte-order mark, UTF-16 made UTF-8, and without the zero bytes and Ctrl-Z that
// some programs pad text with. Such text is in `converted`; else the view is of the file itself.
std::string_view PlainText(ByteView file, Bytes& converted);
inline constexpr size_t kUtf8Mark = 3;
bool HasUtf8Mark(ByteView file);

}  // namespace enamel::import
