#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

// Names of people, cohorts and stations. Pure functions, any thread. Errors: kInvalidInput with the
// expected and found text.
namespace enamel::server {

inline constexpr size_t kMaxLoginBytes = 64;
inline constexpr size_t kMaxNameBytes = 200;
inline constexpr size_t kMaxReasonBytes = 1000;
inline constexpr size_t kMaxRemarkBytes = 4000;

// A login in the form that is stored: lower case. 1 to 64 ASCII letters, digits or . - _ @, the
// first a letter or digit. Field "login".
Result<std::string> CheckedLogin(std::string_view text);

// The text composed (NFC), with plain spaces in place of no-break ones: texts that look the same
// become equal. Text that is not UTF-8 stays as it is.
std::string Composed(std::string_view text);

// A name as people read it, composed and without the spaces around it: valid UTF-8, 1 to 200 bytes,
// no control characters, no character that changes the writing direction, at least one visible character. It
// may not begin with = + - @, which a spreadsheet that opens our tables would take for a formula
// (OWASP, "CSV Injection"). `field`: as named in the error.
Result<std::string> CheckedName(std::string_view text, std::string_view field);

// A person's name: as CheckedName, and no word of it mixes letters of scripts that are not written
// together (Unicode TR 39, "highly restrictive"), as the Cyrillic а in "аdmin". "Ольга Müller" and
// "李David" are names.
Result<std::string> CheckedPersonName(std::string_view text, std::string_view field);

// What a text looks like, without case: equal for texts that are drawn alike in any script (the
// skeleton of Unicode TR 39).
std::string LookOf(std::string_view text);
// Whether the name has letters of another script, and yet looks Latin from its beginning to its end:
// "Сора" in Cyrillic. Such a name may look like another person's.
bool LooksLatin(std::string_view name);

// Why something was done, as it stays beside it: 1 to 1000 bytes of UTF-8 on one line. Errors:
// kInvalidInput with `field`.
Result<std::string> CheckedReason(std::string_view text, std::string_view field);

// No control character, line break or mark that changes the writing direction: a terminal or table
// shows such text unchanged. Errors: kInvalidInput with `field`.
Status CheckOneLine(std::string_view text, std::string_view field);

// How a display name is searched and sorted: in lower case, without accents, ligatures and full-width
// forms taken apart, one space between words. "Zoë Ñandú" is "zoe nandu", "Łukasz Groß" is "lukasz
// gross". Scripts whose marks are no accents keep them. Text that is not UTF-8 keeps all of it.
std::string SearchName(std::string_view display_name);

// What somebody typed, in words of that form; at most 8.
std::vector<std::string> SearchWords(std::string_view text);

// Equal for names that people take for one: case (of ASCII) and the number of spaces do not count.
std::string NameKey(std::string_view name);

}  // namespace enamel::server
