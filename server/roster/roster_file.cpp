#include "server/roster/roster_file.h"

#include <algorithm>
#include <array>
#include <optional>

#include "common/base/csv.h"
#include "common/base/utf8.h"
#include "server/roster/text_reading.h"
#include "server/training/names.h"

namespace enamel::server::roster {
namespace {

constexpr std::array<std::string_view, 4> kColumns = {"login", "display_name", "role", "cohort"};
constexpr std::string_view kHeader =
    "a first row with the names of the columns: login, "
    "display_name, role, cohort";

constexpr std::string_view kReplacement = "\xef\xbf\xbd";  // U+FFFD

std::string Lower(std::string_view text) {
  std::string out;
  for (char c : text) out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

std::string Trimmed(std::string_view text) {
  size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

// "Display Name" and "display-name" are display_name.
std::string ColumnName(std::string_view cell) {
  std::string out = Lower(Trimmed(cell));
  std::ranges::replace_if(
      out, [](char c) { return c == ' ' || c == '-'; }, '_');
  return out;
}

std::string Shown(std::string_view text) {
  constexpr size_t kMost = 80;
  std::string out;
  for (char c : text.substr(0, kMost)) {
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  // A character that was cut in two is no text.
  while (text.size() > kMost && !out.empty() && static_cast<unsigned char>(out.back()) >= 0x80) {
    out.pop_back();
  }
  return '"' + out + (text.size() > kMost ? "…\"" : "\"");
}

// The row a byte is in, lines ending in LF, CR LF or CR.
uint32_t RowOf(std::string_view text, size_t at) {
  uint32_t row = 1;
  for (size_t i = 0; i < at; ++i) {
    bool crlf = text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n';
    if ((text[i] == '\n' || text[i] == '\r') && !crlf) ++row;
  }
  return row;
}

bool IsKnown(const std::string& column) {
  return std::ranges::find(kColumns, column) != kColumns.end();
}

// The roster being read: columns first, then row by row.
class Reader {
 public:
  Reader(const RosterOptions& options, RosterFile& out) : options_(options), out_(out) {}

  bool ReadHeader(const CsvRow& header) {
    for (size_t i = 0; i < header.cells.size(); ++i) TakeColumn(header, i);
    if (Place("login")) return out_.problems.empty();
    Refuse(header.row, "login", "no such column", std::string(kHeader));
    return false;
  }

  // Spreadsheets put totals and notes below a list: one text, and no login.
  bool IsFooter(const CsvRow& row) const {
    if (named_ < 2) return false;
    const auto texts = std::ranges::count_if(
        row.cells, [](const std::string& cell) { return !Trimmed(cell).empty(); });
    return texts == 1 && Text(row).find(' ') != std::string::npos;
  }
  void LeaveOut(const CsvRow& row) { out_.left_out.push_back({row.row, Text(row)}); }

  void ReadRow(const CsvRow& row) {
    if (row.cells.size() < named_) {
      return Refuse(row.row, "", std::to_string(row.cells.size()) + " cells",
                    std::to_string(named_) +
                        " as in the first row; is a comma inside a name without quotes around it?");
    }
    for (size_t i = 0; i < row.cells.size(); ++i) {
      if ((i < columns_.size() && !columns_[i].empty()) || Trimmed(row.cells[i]).empty()) continue;
      return Refuse(row.row, "", Shown(row.cells[i]) + " in a column without a name",
                    "nothing there, or a name of the column in the first row; is a comma inside a "
                    "name without quotes around it?");
    }
    // A row with a problem in any cell is left out of the plan, which compares only readable rows.
    size_t before = out_.problems.size();
    RosterRow person;
    person.row = row.row;
    person.login = Checked(row, "login", [](std::string_view text) { return CheckedLogin(text); });
    if (std::string name = Cell(row, "display_name"); !name.empty()) {
      person.display_name = CheckedText(row, "display_name", name, [](std::string_view text) {
        return CheckedPersonName(text, "display_name");
      });
    }
    person.role = RoleOf(row);
    std::string cohort = Cell(row, "cohort");
    if (cohort.empty()) cohort = options_.cohort;
    if (!cohort.empty()) {
      person.cohort = CheckedText(
          row, "cohort", cohort, [](std::string_view text) { return CheckedName(text, "cohort"); });
    }
    if (out_.problems.size() == before) out_.rows.push_back(std::move(person));
  }

 private:
  void Refuse(uint32_t row, std::string column, std::string found, std::string expected) {
    out_.problems.push_back({row, std::move(column), std::move(found), std::move(expected)});
  }

  static std::string Text(const CsvRow& row) {
    for (const std::string& cell : row.cells) {
      if (std::string text = Trimmed(cell); !text.empty()) return text;
    }
    return {};
  }

  void TakeColumn(const CsvRow& header, size_t i) {
    std::string name = ColumnName(header.cells[i]);
    columns_.push_back(name);
    // Spreadsheets write empty columns beside a table.
    if (name.empty()) return;
    named_ = i + 1;
    if (std::count(columns_.begin(), columns_.end(), name) > 1 && IsKnown(name)) {
      return Refuse(header.row, name, "the column twice", "each column once");
    }
    if (IsKnown(name)) return;
    if (options_.ignore_unknown_columns) {
      out_.ignored_columns.push_back(Trimmed(header.cells[i]));
      return;
    }
    Refuse(header.row, Shown(header.cells[i]), "a column of this name",
           "login, display_name, role, cohort; take the column out, or say that columns which are "
           "not known are to be ignored");
  }

  std::optional<size_t> Place(std::string_view column) const {
    auto found = std::ranges::find(columns_, column);
    if (found == columns_.end()) return std::nullopt;
    return static_cast<size_t>(found - columns_.begin());
  }
  // Without the spaces around it; empty when there is no such column.
  std::string Cell(const CsvRow& row, std::string_view column) const {
    std::optional<size_t> place = Place(column);
    return place ? Trimmed(row.cells.at(*place)) : std::string();
  }

  template <typename Check>
  std::string CheckedText(const CsvRow& row, const char* column, std::string_view text,
                          const Check& check) {
    Result<std::string> checked = check(text);
    if (checked.ok()) return *checked;
    // "expected E, found F": the two stand apart in the answer.
    std::string message = checked.status().message();
    constexpr std::string_view kExpected = "expected ", kFound = ", found ";
    // The first one: what was found may have these words in it, and our own texts have not.
    size_t found = message.find(kFound);
    Refuse(row.row, column,
           found == std::string::npos ? Shown(text) : message.substr(found + kFound.size()),
           message.substr(kExpected.size(), found == std::string::npos ? std::string::npos
                                                                       : found - kExpected.size()));
    return {};
  }
  template <typename Check>
  std::string Checked(const CsvRow& row, const char* column, const Check& check) {
    return CheckedText(row, column, Cell(row, column), check);
  }

  Role RoleOf(const CsvRow& row) {
    std::string text = Lower(Cell(row, "role"));
    // A file that somebody else may have edited makes no admins.
    std::optional<Role> role = text.empty() ? Role::kStudent : RoleFromName(text);
    if (role && *role != Role::kAdmin) return *role;
    Refuse(row.row, "role", Shown(text),
           role ? "student or instructor; admins are added one by one"
                : "student or instructor, or nothing for a student");
    return Role::kStudent;
  }

  const RosterOptions& options_;
  RosterFile& out_;
  std::vector<std::string> columns_;  // of the file, in its order; empty: one without a name
  size_t named_ = 0;                  // behind the last that has one
};

}  // namespace

RosterFile ReadRoster(std::string_view bytes, const RosterOptions& options) {
  RosterFile out;
  out.reading = options.reading.empty() ? ReadingOf(bytes) : options.reading;
  if (bytes.size() > kMaxRosterBytes) {
    out.problems.push_back(
        {1, "", std::to_string(bytes.size()) + " bytes", "at most 1 MiB; split the file"});
    return out;
  }
  const std::string text = Composed(TextOf(bytes, out.reading));
  if (const size_t lost = text.find(kReplacement); lost != std::string::npos) {
    out.problems.push_back({RowOf(text, lost), "", "bytes that are no text in " + out.reading,
                            "another reading of the file; or save it as \"CSV UTF-8\""});
    return out;
  }
  // One row more than people for the header; 32 columns and 1000 bytes a cell are far more than a
  // roster needs.
  CsvTable table = ReadCsv(text, {kMaxRosterRows + 1, 32, 1000});
  Reader reader(options, out);
  if (table.rows.empty() && table.problem_row == 0) {
    out.problems.push_back({1, "", "an empty file", std::string(kHeader)});
    return out;
  }
  if (!table.rows.empty() && reader.ReadHeader(table.rows.front())) {
    size_t end = table.rows.size();
    while (end > 2 && reader.IsFooter(table.rows[end - 1])) --end;
    for (size_t i = 1; i < end; ++i) reader.ReadRow(table.rows[i]);
    for (size_t i = end; i < table.rows.size(); ++i) reader.LeaveOut(table.rows[i]);
  }
  if (table.problem_row != 0) {
    out.problems.push_back({table.problem_row, "", table.found, table.expected});
  }
  return out;
}

}  // namespace enamel::server::roster
