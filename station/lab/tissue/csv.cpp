#include "station/lab/tissue/csv.h"

namespace enamel::station::lab {
namespace {

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Result<std::vector<CsvRow>> Run() {
    if (text_.substr(0, 3) == "\xEF\xBB\xBF") at_ = 3;
    while (at_ < text_.size()) {
      ENAMEL_RETURN_IF_ERROR(Field());
      if (at_ < text_.size() && text_[at_] == ',') {
        ++at_;
        if (at_ == text_.size())
          row_.emplace_back(), EndRow();
        else if (AtNewline())
          row_.emplace_back(), EndRow();
        continue;
      }
      EndRow();
    }
    return std::move(rows_);
  }

 private:
  bool AtNewline() const {
    return at_ < text_.size() && (text_[at_] == '\n' || text_[at_] == '\r');
  }

  Status Field() {
    std::string field;
    bool quoted = at_ < text_.size() && text_[at_] == '"';
    if (quoted) {
      ENAMEL_RETURN_IF_ERROR(Quoted(&field));
    } else {
      while (at_ < text_.size() && text_[at_] != ',' && !AtNewline()) field += text_[at_++];
    }
    bool blank = !quoted && field.empty() && row_.empty() && (at_ == text_.size() || AtNewline());
    if (!blank) row_.push_back(std::move(field));
    return Status::Ok();
  }

  Status Quoted(std::string* field) {
    size_t opened = line_;
    for (++at_; at_ < text_.size(); ++at_) {
      char c = text_[at_];
      if (c == '\n') ++line_;
      if (c != '"') {
        *field += c;
      } else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"') {
        *field += '"';
        ++at_;
      } else {
        ++at_;
        if (at_ < text_.size() && text_[at_] != ',' && !AtNewline())
          return Wrong("text after a closing quote: expected a comma or the end of the line");
        return Status::Ok();
      }
    }
    line_ = opened;
    return Wrong("a quote that is never closed");
  }

  void EndRow() {
    if (at_ < text_.size() && text_[at_] == '\r') ++at_;
    if (at_ < text_.size() && text_[at_] == '\n') ++at_;
    ++line_;
    if (!row_.empty()) rows_.push_back(std::move(row_));
    row_.clear();
  }

  Status Wrong(const std::string& what) const {
    std::string line = "line " + std::to_string(line_);
    return {Code::kInvalidInput, "CSV " + line + ": " + what, line};
  }

  std::string_view text_;
  size_t at_ = 0, line_ = 1;
  CsvRow row_;
  std::vector<CsvRow> rows_;
};

}  // namespace

Result<std::vector<CsvRow>> ParseCsv(std::string_view text, size_t max_bytes) {
  if (text.size() > max_bytes) {
    return Status(Code::kTooLarge, "CSV of " + std::to_string(text.size()) + " bytes: at most " +
                                       std::to_string(max_bytes) + " are read");
  }
  return Parser(text).Run();
}

}  // namespace enamel::station::lab
