#include "common/base/csv.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace enamel {
namespace {

// A cell that begins with one of these is a formula to a spreadsheet: a quote in front keeps a
// person's name from being computed on whoever opens the list (OWASP, "CSV Injection").
constexpr std::string_view kComputed = "=+-@\t\r\n";
// Full width: = + - @, which some spreadsheets accept as well.
constexpr std::string_view kComputedWide[] = {"\xef\xbc\x9d", "\xef\xbc\x8b", "\xef\xbc\x8d",
                                              "\xef\xbc\xa0"};

// One pass over the text, character by character.
class Reader {
 public:
  Reader(const CsvLimits& limits, char separator, uint32_t first_row, CsvTable& table)
      : limits_(limits), separator_(separator), table_(table), current_{first_row, {}} {}

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
  CsvRow current_;
  bool has_text_ = false;
};

// Spreadsheets in countries with a decimal comma separate cells by semicolons, and by tabs what they
// call text. The first line names the columns and has the separator most often; a name in quotes may
// have others in it.
char SeparatorOf(std::string_view text) {
  constexpr std::string_view kSeparators = ",;\t|";
  size_t counts[kSeparators.size()] = {};
  bool quoted = false;
  for (char c : text) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '\n' || c == '\r') break;
    if (const size_t at = kSeparators.find(c); at != std::string_view::npos) ++counts[at];
  }
  return kSeparators[static_cast<size_t>(std::ranges::max_element(counts) - counts)];
}

// Excel's line above the table that says what separates its cells: "sep=;".
struct Told {
  char separator = 0;  // none: there is no such line
  size_t size = 0;     // of the line, with its end
};

Told ToldSeparator(std::string_view text) {
  std::string_view line = text.substr(0, text.find_first_of("\r\n"));
  const std::string_view rest = text.substr(line.size());
  const size_t end = rest.starts_with("\r\n") ? 2 : std::min<size_t>(rest.size(), 1);
  const size_t size = line.size() + end;
  if (line.size() > 2 && line.front() == '"' && line.back() == '"') {
    line = line.substr(1, line.size() - 2);
  }
  constexpr std::string_view kTells = "sep=";
  const bool tells = line.size() == kTells.size() + 1 &&
                     std::ranges::equal(line.substr(0, kTells.size()), kTells,
                                        [](char a, char b) { return (a | 0x20) == (b | 0x20); });
  return tells ? Told{line.back(), size} : Told{};
}

bool IsNumber(std::string_view text) {
  double value = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && rest == text.data() + text.size();
}

bool IsComputed(std::string_view text) {
  if (text.empty() || IsNumber(text)) return false;
  return kComputed.find(text.front()) != std::string_view::npos ||
         std::ranges::any_of(kComputedWide, [&](auto sign) { return text.starts_with(sign); });
}

std::string Cell(std::string_view text) {
  std::string out;
  if (IsComputed(text)) out = "'";
  out += text;
  // Also what separates cells elsewhere: a first line with more of those than commas is read so.
  if (out.find_first_of(",;\t|\"\r\n") == std::string::npos) return out;
  std::string quoted = "\"";
  for (char c : out) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

CsvTable ReadCsv(std::string_view text, const CsvLimits& limits) {
  if (text.starts_with(kCsvByteOrderMark)) text.remove_prefix(kCsvByteOrderMark.size());
  CsvTable table;
  const Told told = ToldSeparator(text);
  const std::string_view rows = text.substr(told.size);
  const char separator = told.separator != 0 ? told.separator : SeparatorOf(rows);
  Reader(limits, separator, told.size > 0 ? 2 : 1, table).Read(rows);
  return table;
}

Status CsvTable::status() const {
  if (problem_row == 0) return Status::Ok();
  const std::string row = "row " + std::to_string(problem_row);
  return Status(Code::kInvalidInput, "CSV " + row + ": " + found + ": expected " + expected, row);
}

namespace {
template <typename Cells>
std::string LineOf(const Cells& cells) {
  std::string out;
  const char* separator = "";
  for (std::string_view cell : cells) {
    out += std::exchange(separator, ",") + Cell(cell);
  }
  return out + "\r\n";
}
}  // namespace

std::string CsvLine(std::initializer_list<std::string_view> cells) { return LineOf(cells); }
std::string CsvLine(const std::vector<std::string>& cells) { return LineOf(cells); }

}  // namespace enamel
