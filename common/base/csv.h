#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

// Comma-separated values (RFC 4180), bounded. Semicolons, tabs and bars are read as well. Pure
// functions, any thread.
//
// Why not libcsv: its strict mode refuses a quote inside a bare cell (37.8"N), which spreadsheets
// write and everybody reads. Its other mode accepts text after a closing quote and quotes that are
// never closed: a name could then swallow the rows behind it.
namespace enamel {

// Excel begins a UTF-8 file with this mark, and reads a file without it in the local code page.
inline constexpr std::string_view kCsvByteOrderMark = "\xef\xbb\xbf";

struct CsvRow {
  uint32_t row = 0;  // as a spreadsheet counts: 1 is the first, also when it is empty
  std::vector<std::string> cells;
};

struct CsvLimits {
  size_t rows = 5001;
  size_t columns = 32;
  size_t cell_bytes = 1000;
};

// The rows up to the first error in the CSV, without rows that have no text.
struct CsvTable {
  std::vector<CsvRow> rows;
  // Nothing wrong: empty. Otherwise where (a row, as above), and what was found and expected.
  uint32_t problem_row = 0;
  std::string found, expected;
  // The same as a status: kInvalidInput, field "row N".
  Status status() const;
};

// Line ends LF, CR LF or CR; quoted cells may have them inside. A byte order mark is skipped. Cells
// are separated by what a first line "sep=;" says, and without one by what the first line has most
// often: a comma, semicolon, tab or bar.
CsvTable ReadCsv(std::string_view text, const CsvLimits& limits = {});

// One line with its end, CR LF. A cell that a spreadsheet would compute, because it begins with
// = + - @ (also of full width), tab, CR or LF, gets an apostrophe in front (OWASP, "CSV
// Injection"). The number -0.5 stays a number.
std::string CsvLine(std::initializer_list<std::string_view> cells);
std::string CsvLine(const std::vector<std::string>& cells);

}  // namespace enamel
