#include "common/base/csv.h"

#include <charconv>
#include <utility>

namespace enamel {
namespace {

// Excel begins a UTF-8 file with this mark; it would be part of the first column's name.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
// A cell that begins with one of these is a formula to a spreadsheet: a quote in front keeps a
// person's name from being computed on whoever opens the list (OWASP, "CSV Injection").
constexpr std::string_view kComputed = "=+-@\t\r";

// One pass over the text, character by character.
class Reader {
 public:
  Reader(const CsvLimits& limits, char separator, CsvTable& table)
      : limits_(limits), separator_(separator), table_(table) {}

  void Read(std::string_view text) {
    for (size_t i = 0; i < text.size() && !failed(); ++i) {
      bool crlf = text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n';
      // Inside quotes a line end is text, as it stands.
      if (crlf && place_ != Place::kQuoted) ++i;
      Take(text[i]);
    }
    if (failed()) return;
    if (place_ == Place::kQuoted) return Fail("a quote that is never closed", kQuoting);
    if (place_ != Place::kBegin || !current_.cells.empty()) EndRow();
  }

 private:
  enum class Place { kBegin, kBare, kQuoted, kAfterQuote };
  static constexpr const char* kQuoting =
      "quotes around a whole cell, and \"\" for a quote inside one";

  bool failed() const { return table_.problem_row != 0; }
  void Fail(std::string found, std::string expected) {
    if (failed()) return;
    table_.problem_row = current_.row;
    table_.found = std::move(found);
    table_.expected = std::move(expected);
  }

  void Take(char c) {
    if (place_ == Place::kQuoted) return c == '"' ? Go(Place::kAfterQuote) : Append(c);
    // RFC 4180, 2.7: two quotes inside quotes are one.
    if (place_ == Place::kAfterQuote && c == '"') {
      Append(c);
      return Go(Place::kQuoted);
    }
    if (c == separator_) return EndCell();
    // A lone CR ends a row too: old spreadsheets for the Mac write it.
    if (c == '\n' || c == '\r') return EndRow();
    if (place_ == Place::kAfterQuote) return Fail("text after a closing quote", kQuoting);
    if (place_ == Place::kBegin && c == '"') return Go(Place::kQuoted);
    Go(Place::kBare);
    Append(c);
  }

  void Go(Place place) { place_ = place; }

  void Append(char c) {
    if (cell_.size() < limits_.cell_bytes) {
      cell_ += c;
      return;
    }
    Fail("a cell of more than " + std::to_string(limits_.cell_bytes) + " bytes",
         "at most as many; is a quote missing?");
  }

  void EndCell() {
    if (current_.cells.size() == limits_.columns) {
      return Fail("a cell number " + std::to_string(limits_.columns + 1),
                  "at most " + std::to_string(limits_.columns) + " cells");
    }
    has_text_ |= !cell_.empty();
    current_.cells.push_back(std::exchange(cell_, {}));
    Go(Place::kBegin);
  }

  void EndRow() {
    EndCell();
    if (failed()) return;
    // Rows without text are left out and not counted: spreadsheets write them below the last.
    if (has_text_ && table_.rows.size() == limits_.rows) {
      return Fail("a row number " + std::to_string(limits_.rows + 1) + " with text",
                  "at most " + std::to_string(limits_.rows) + " rows; split the file");
    }
    uint32_t next = current_.row + 1;
    if (has_text_) table_.rows.push_back(std::move(current_));
    current_ = {next, {}};
    has_text_ = false;
  }

  const CsvLimits& limits_;
  const char separator_;
  CsvTable& table_;
  Place place_ = Place::kBegin;
  std::string cell_;
  CsvRow current_{1, {}};
  bool has_text_ = false;
};

// Spreadsheets in countries with a decimal comma separate cells by semicolons. The first line names
// the columns: it has the one or the other.
char SeparatorOf(std::string_view text) {
  const std::string_view first = text.substr(0, text.find_first_of("\r\n"));
  const bool commas = first.find(',') != std::string_view::npos;
  return !commas && first.find(';') != std::string_view::npos ? ';' : ',';
}

bool IsNumber(std::string_view text) {
  double value = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && rest == text.data() + text.size();
}

std::string Cell(std::string_view text) {
  std::string out;
  if (!text.empty() && kComputed.find(text.front()) != std::string_view::npos && !IsNumber(text))
    out = "'";
  out += text;
  if (out.find_first_of(",\"\r\n") == std::string::npos) return out;
  std::string quoted = "\"";
  for (char c : out) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

CsvTable ReadCsv(std::string_view text, const CsvLimits& limits) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  CsvTable table;
  Reader(limits, SeparatorOf(text), table).Read(text);
  return table;
}

Status CsvTable::status() const {
  if (problem_row == 0) return Status::Ok();
  const std::string row = "row " + std::to_string(problem_row);
  return Status(Code::kInvalidInput, "CSV " + row + ": " + found + ": expected " + expected, row);
}

std::string CsvLine(std::initializer_list<std::string_view> cells) {
  std::string out;
  const char* separator = "";
  for (std::string_view cell : cells) {
    out += std::exchange(separator, ",") + Cell(cell);
  }
  return out + "\r\n";
}

}  // namespace enamel
