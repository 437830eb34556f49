#pragma once

#include <array>
#include <string>
#include <string_view>

// Reads the bytes of a table as text. Spreadsheets save in the encoding of their country and do not
// name it in the file. Pure functions, any thread.
namespace enamel::server::roster {

// IANA's names. windows-1252 includes Latin-1; spreadsheets in China save gb18030.
inline constexpr std::array<std::string_view, 7> kReadings = {
    "utf-8", "utf-16le", "utf-16be", "windows-1252", "windows-1250", "windows-1251", "gb18030"};
bool IsReading(std::string_view name);

// The encoding that a byte order mark names. Without one, zero bytes mean UTF-16 and valid UTF-8 is
// UTF-8. All else counts as windows-1252: a person has to look at the names.
std::string_view ReadingOf(std::string_view bytes);

// The text in UTF-8 without a byte order mark. U+FFFD stands for bytes that are no text in this
// reading.
// Requires: IsReading(reading).
std::string TextOf(std::string_view bytes, std::string_view reading);

}  // namespace enamel::server::roster
