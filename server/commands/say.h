#pragma once

#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/base/result.h"
#include "common/base/utf8.h"
#include "server/training/revision.h"
#include "server/training/types.h"

// What commands print on standard output.
namespace enamel::server::app {

template <typename T>
using Shown = std::conditional_t<std::is_convertible_v<const T&, std::string_view>, std::string,
                                 std::remove_cvref_t<T>>;

template <typename T>
Shown<T> ShownAs(const T& value) {
  if constexpr (std::is_convertible_v<const T&, std::string_view>) {
    return Printable(value);
  } else {
    return value;
  }
}

// As fmt::format says it. Every text among `values` may be somebody else's (a name, a document, a
// reason): the terminal shows its control characters and does not obey them; line ends and tabs
// belong into `format`.
template <typename... Values>
void Say(fmt::format_string<Shown<Values>...> format, const Values&... values) {
  std::cout << fmt::format(format, ShownAs(values)...);
}

// Ends the lines of a table (CsvLine) with LF, as other text files on this system do.
std::string WithPlainLineEnds(std::string csv);

// An attempt's state in the page's words: "waiting to be scored".
const char* StateText(AttemptState state);

// "2026-09-01 08:30", UTC; "-" for 0.
std::string UtcText(UnixMs ms);

// A refusal; if the caller may insist (kAnyway), with the option that insists.
inline Status InsistWith(const Status& refused, const std::string& option) {
  if (refused.field() != kAnyway) return refused;
  return {refused.code(), refused.message() + " with " + option, refused.field()};
}

}  // namespace enamel::server::app
