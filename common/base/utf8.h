#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// UTF-8 (RFC 3629) of texts that others wrote. Pure functions, any thread.
namespace enamel {

// Takes the next code point off `text`, which is not empty. None, and nothing taken, when `text`
// does not begin with one (overlong forms and surrogates do not count).
std::optional<uint32_t> NextCodePoint(std::string_view& text);

bool IsUtf8(std::string_view text);

// `text` with U+FFFD for each byte that belongs to no code point: safe inside JSON.
std::string AsUtf8(std::string_view text);

// C0 with line ends and tab, DEL, C1.
bool IsControl(uint32_t code);

// Unseen, and changes how what follows is laid out: line and paragraph separators; what overrides,
// embeds or isolates a direction; byte order mark; what has no width, and tags.
bool IsInvisibleTrick(uint32_t code);

// Text that a terminal shows and does not obey: AsUtf8, with control characters as "\x1b" and
// invisible tricks as "\u202e".
std::string Printable(std::string_view text);

// The first bytes of `text`, at most `most`, ending where a character ends: what a program says of
// itself and nobody is asked to correct.
std::string ShortenedText(std::string_view text, size_t most);

}  // namespace enamel
