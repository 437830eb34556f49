#include "server/postgres/pg_text.h"

#include <algorithm>

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

std::string TakeState(std::string& words) {
  constexpr std::string_view kBefore = ":  ", kAfter = ": ";
  constexpr size_t kDigits = 5;
  for (size_t at = words.find(kBefore); at != std::string::npos; at = words.find(kBefore, at + 1)) {
    const size_t begin = at + kBefore.size(), end = begin + kDigits;
    if (end > words.size() || words.compare(end, kAfter.size(), kAfter) != 0) continue;
    std::string state = words.substr(begin, kDigits);
    const auto digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z'); };
    if (!std::ranges::all_of(state, digit)) continue;
    words.erase(begin, kDigits + kAfter.size());
    return state;
  }
  for (const char* read_only : {"session is read-only", "server is in hot standby mode"}) {
    if (words.find(read_only) != std::string::npos) return "25006";
  }
  return {};
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
