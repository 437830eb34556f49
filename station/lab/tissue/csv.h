#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace enamel::station::lab {

using CsvRow = std::vector<std::string>;

// RFC 4180 with what files in the wild do: LF as well as CRLF, a byte-order mark, no newline at the
// end, quotes as plain characters inside a bare field. Quoted fields may hold commas, newlines and
// doubled quotes; rows may differ in length. An empty line is no row. Errors (kInvalidInput, field
// "line N"): a quote that is never closed, text after a closing quote; kTooLarge above max_bytes.
Result<std::vector<CsvRow>> ParseCsv(std::string_view text, size_t max_bytes = 256u << 20);

}  // namespace enamel::station::lab
