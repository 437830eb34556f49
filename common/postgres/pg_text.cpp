#include "common/postgres/pg_text.h"

namespace enamel::sql {

std::string WithDollars(std::string_view sql) {
  std::string out;
  out.reserve(sql.size());
  char quote = 0;  // what ends the quotation; 0: outside
  for (size_t i = 0; i < sql.size(); ++i) {
    const char c = sql[i];
    if (quote != 0) {
      // A doubled quote ends one quotation and begins the next.
      if (c == quote) quote = 0;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '?' && i + 1 < sql.size() && sql[i + 1] >= '1' && sql[i + 1] <= '9') {
      out += '$';
      continue;
    }
    out += c;
  }
  return out;
}

std::string FirstLine(const char* words) {
  const std::string all = words == nullptr ? "" : words;
  return all.substr(0, all.find('\n'));
}

std::string Quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

}  // namespace enamel::sql
