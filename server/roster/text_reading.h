#pragma once

#include <array>
#include <string>
#include <string_view>

// The bytes of a table as text: spreadsheets save the encoding of their country, and no file says
// which. Pure functions, any thread.
namespace enamel::server::roster {

// Names as IANA has them. windows-1252 has all of Latin-1; gb18030 is what spreadsheets save in
// China.
inline constexpr std::array<std::string_view, 7> kReadings = {
    "utf-8", "utf-16le", "utf-16be", "windows-1252", "windows-1250", "windows-1251", "gb18030"};
bool IsReading(std::string_view name);

// Of bytes without a byte order mark, UTF-16 is known by its zeros and UTF-8 by being valid. What
// is left is taken for windows-1252: somebody has to look at the names.
std::string_view ReadingOf(std::string_view bytes);

// As UTF-8 without a byte order mark, with U+FFFD for bytes that are no text in this reading.
// Requires: IsReading(reading).
std::string TextOf(std::string_view bytes, std::string_view reading);

}  // namespace enamel::server::roster
