#include "server/training/names.h"

#include <unicode/bytestream.h>
#include <unicode/normalizer2.h>
#include <unicode/translit.h>
#include <unicode/uchar.h>
#include <unicode/unistr.h>
#include <unicode/uscript.h>
#include <unicode/uspoof.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/base/check.h"
#include "common/base/utf8.h"

namespace enamel::server {
namespace {

bool IsAlphanumeric(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool IsLoginCharacter(char c) {
  return IsAlphanumeric(c) || std::string_view(".-_@").find(c) != std::string_view::npos;
}

// Spaces, and what leaves no mark by itself: fillers, joiners, variation selectors, tags (Unicode
// 15, White_Space and Default_Ignorable_Code_Point), the blank braille pattern.
bool LeavesNoMark(uint32_t c) {
  struct Range {
    uint32_t first, last;
  };
  constexpr Range kBlank[] = {
      {0x20, 0x20},       {0xa0, 0xa0},      {0xad, 0xad},     {0x34f, 0x34f},   {0x61c, 0x61c},
      {0x115f, 0x1160},   {0x1680, 0x1680},  {0x17b4, 0x17b5}, {0x180b, 0x180f}, {0x2000, 0x200f},
      {0x202f, 0x202f},   {0x205f, 0x2065},  {0x206a, 0x206f}, {0x2800, 0x2800}, {0x3000, 0x3000},
      {0x3164, 0x3164},   {0xfe00, 0xfe0f},  {0xffa0, 0xffa0}, {0xfff0, 0xfff8}, {0x1bca0, 0x1bca3},
      {0x1d173, 0x1d17a}, {0xe0000, 0xe0fff}};
  return std::ranges::any_of(kBlank, [&](Range r) { return c >= r.first && c <= r.last; });
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
    return Refused(
        "login", "1 to 64 letters a-z, digits or any of . - _ @, the first a letter or digit",
        long_one ? std::to_string(login.size()) + " bytes" : "\"" + AsUtf8(login) + "\"");
  }
  std::ranges::transform(login, login.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return login;
}

std::string Composed(std::string_view text) {
  const bool ascii = std::ranges::all_of(text, [](char c) { return (c & 0x80) == 0; });
  if (ascii || !IsUtf8(text)) return std::string(text);
  UErrorCode error = U_ZERO_ERROR;
  const icu::Normalizer2* composing = icu::Normalizer2::getNFCInstance(error);
  std::string composed, out;
  icu::StringByteSink<std::string> sink(&composed);
  composing->normalizeUTF8(0, {text.data(), static_cast<int32_t>(text.size())}, sink, nullptr,
                           error);
  ENAMEL_CHECK(U_SUCCESS(error));
  for (std::string_view rest = composed; !rest.empty();) {
    const std::string_view before = rest;
    const uint32_t code = *NextCodePoint(rest);
    // No-break, figure and narrow no-break space.
    const bool space = code == 0xa0 || code == 0x2007 || code == 0x202f;
    out += space ? std::string_view(" ") : before.substr(0, before.size() - rest.size());
  }
  return out;
}

Result<std::string> CheckedName(std::string_view text, std::string_view field) {
  const std::string composed = Composed(text);
  std::string_view name = Trim(composed);
  if (name.empty() || name.size() > kMaxNameBytes) {
    return Refused(field, "a name of 1 to 200 bytes", std::to_string(name.size()) + " bytes");
  }
  // Lists of people are opened in spreadsheets, which take such a cell for a formula (OWASP, CSV
  // injection).
  if (std::string_view("=+-@").find(name.front()) != std::string_view::npos) {
    return Refused(field,
                   "a name that does not begin with = + - or @ (a spreadsheet would compute it)",
                   "\"" + AsUtf8(name) + "\"");
  }
  bool marks = false;
  for (std::string_view rest = name; !rest.empty();) {
    std::optional<uint32_t> code = NextCodePoint(rest);
    if (!code) return Refused(field, "text in UTF-8", "bytes that are not; save the file as UTF-8");
    if (IsControl(*code) || IsInvisibleTrick(*code)) {
      return Refused(field, "a name without control characters and line breaks",
                     "character number " + std::to_string(*code));
    }
    marks |= !LeavesNoMark(*code);
  }
  if (!marks)
    return Refused(field, "a name that can be seen", "only characters that leave no mark");
  return std::string(name);
}

namespace {

const USpoofChecker& Checker() {
  static const USpoofChecker* const kChecker = [] {
    UErrorCode error = U_ZERO_ERROR;
    USpoofChecker* made = uspoof_open(&error);
    uspoof_setChecks(made, USPOOF_RESTRICTION_LEVEL, &error);
    uspoof_setRestrictionLevel(made, USPOOF_HIGHLY_RESTRICTIVE);
    ENAMEL_CHECK(U_SUCCESS(error));
    return made;
  }();
  return *kChecker;
}

bool HasOneScript(std::string_view word) {
  UErrorCode error = U_ZERO_ERROR;
  const int32_t found =
      uspoof_checkUTF8(&Checker(), word.data(), static_cast<int32_t>(word.size()), nullptr, &error);
  ENAMEL_CHECK(U_SUCCESS(error));
  return found == 0;
}

// Marks belong to the letter before them.
bool IsInWord(uint32_t code) {
  const auto c = static_cast<UChar32>(code);
  return u_isalpha(c) || (U_GET_GC_MASK(c) & U_GC_M_MASK) != 0;
}

bool IsLatin(uint32_t code) {
  UErrorCode error = U_ZERO_ERROR;
  const UScriptCode script = uscript_getScript(static_cast<UChar32>(code), &error);
  return script == USCRIPT_LATIN || script == USCRIPT_COMMON || script == USCRIPT_INHERITED;
}

bool IsAllLatin(std::string_view text) {
  while (!text.empty()) {
    const std::optional<uint32_t> code = NextCodePoint(text);
    if (!code || !IsLatin(*code)) return false;
  }
  return true;
}

}  // namespace

Result<std::string> CheckedPersonName(std::string_view text, std::string_view field) {
  ENAMEL_ASSIGN_OR_RETURN(std::string name, CheckedName(text, field));
  for (std::string_view rest = name; !rest.empty();) {
    const std::string_view begin = rest;
    std::string_view after = rest;
    while (!rest.empty() && IsInWord(*NextCodePoint(after))) rest = after;
    const std::string_view word = begin.substr(0, begin.size() - rest.size());
    if (!word.empty() && !HasOneScript(word)) {
      return Refused(field, "a name whose words are each in the letters of one script",
                     "\"" + std::string(word) +
                         "\", which mixes several; type this word again on one keyboard");
    }
    if (word.empty()) (void)NextCodePoint(rest);
  }
  return name;
}

std::string LookOf(std::string_view text) {
  UErrorCode error = U_ZERO_ERROR;
  icu::UnicodeString look;
  uspoof_getSkeletonUnicodeString(
      &Checker(), 0, icu::UnicodeString::fromUTF8({text.data(), static_cast<int32_t>(text.size())}),
      look, &error);
  ENAMEL_CHECK(U_SUCCESS(error));
  std::string out;
  return look.foldCase().toUTF8String(out);
}

bool LooksLatin(std::string_view name) { return !IsAllLatin(name) && IsAllLatin(LookOf(name)); }

Status CheckOneLine(std::string_view text, std::string_view field) {
  for (std::string_view rest = text; !rest.empty();) {
    const std::optional<uint32_t> code = NextCodePoint(rest);
    if (!code) return Refused(field, "text in UTF-8", "bytes that are not");
    if (IsControl(*code) || IsInvisibleTrick(*code)) {
      return Refused(field, "text on one line, without control characters and direction marks",
                     "character number " + std::to_string(*code));
    }
  }
  return Status::Ok();
}

Result<std::string> CheckedReason(std::string_view text, std::string_view field) {
  const std::string_view reason = Trim(text);
  if (reason.empty() || reason.size() > kMaxReasonBytes) {
    return Refused(field, "a reason of 1 to " + std::to_string(kMaxReasonBytes) + " bytes",
                   std::to_string(reason.size()) + " bytes");
  }
  ENAMEL_RETURN_IF_ERROR(CheckOneLine(reason, field));
  return std::string(reason);
}

namespace {

// Lower case, without accents, ligatures and full-width forms taken apart. Case is folded before,
// because some capitals have a plain form only as small letters (U+01F6), and after, because NFKD
// writes capitals (U+2121).
std::string Folded(std::string_view text) {
  if (!IsUtf8(text)) return std::string(text);
  static const std::unique_ptr<const icu::Transliterator> kPlain = [] {
    UErrorCode error = U_ZERO_ERROR;
    std::unique_ptr<const icu::Transliterator> made(icu::Transliterator::createInstance(
        "NFKD; [\\u0300-\\u036f] Remove; [[:Latin:]] Latin-ASCII; NFC", UTRANS_FORWARD, error));
    ENAMEL_CHECK(U_SUCCESS(error));
    return made;
  }();
  icu::UnicodeString folded =
      icu::UnicodeString::fromUTF8({text.data(), static_cast<int32_t>(text.size())});
  folded.foldCase();
  kPlain->transliterate(folded);
  folded.foldCase();
  std::string out;
  return folded.toUTF8String(out);
}

}  // namespace

std::vector<std::string> SearchWords(std::string_view text) {
  constexpr size_t kMaxWords = 8;
  std::vector<std::string> out;
  const std::string folded = Folded(text);
  for (std::string_view rest = Trim(folded); !rest.empty() && out.size() < kMaxWords;
       rest = Trim(rest)) {
    const size_t end = std::min(rest.find(' '), rest.size());
    out.emplace_back(rest.substr(0, end));
    rest.remove_prefix(end);
  }
  return out;
}

std::string SearchName(std::string_view display_name) {
  std::string out;
  // Folding writes spaces too: U+00A0 becomes one.
  const std::string folded = Folded(display_name);
  for (char c : Trim(folded)) {
    if (c != ' ' || !out.ends_with(' ')) out += c;
  }
  return out;
}

std::string NameKey(std::string_view name) {
  std::string out;
  for (char c : Trim(name)) {
    bool space = c == ' ';
    // ASCII alone: "Year 2" and "year  2" are one cohort for people; other scripts' cases are left
    // to them.
    if (space && out.ends_with(' ')) continue;
    out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return out;
}

}  // namespace enamel::server
