#include <algorithm>
#include <regex>
#include <string_view>
#include <utility>

#include "server/storage/engine/database.h"
#include "server/storage/engine/pg_database.h"

namespace enamel::server {
namespace {

using Words = std::pair<std::string_view, std::string_view>;

// Text is compared byte by byte ("C"), as SQLite does, whatever the database's language is.
constexpr Words kOtherWords[] = {{"INTEGER", "BIGINT"},
                                 {"REAL", "DOUBLE PRECISION"},
                                 {"BLOB", "BYTEA"},
                                 {"TEXT", "TEXT COLLATE \"C\""}};
constexpr std::string_view kSameWords[] = {
    "ADD",     "ALTER",  "AND",   "BETWEEN", "CASCADE",  "CHECK",   "COLUMN",     "CREATE",
    "DEFAULT", "DELETE", "DESC",  "FOREIGN", "IN",       "INDEX",   "INSERT",     "INTO",
    "IS",      "KEY",    "NOT",   "NULL",    "ON",       "PRIMARY", "REFERENCES", "TABLE",
    "UNIQUE",  "VALUES", "WHERE", "length(", "coalesce("};

}  // namespace

Result<std::string> InPostgres(const std::string& sqlite) {
  // A token is a comment or a word without a counterpart, a string (1), or another word, of a function with its parenthesis (2).
  static const std::regex kTokens(
      "--[^\n]*| STRICT(?:, WITHOUT ROWID)?|('[^']*')|\\b([A-Z]\\w*|[a-z]\\w*\\()");
  const std::string text = sqlite.substr(0, sqlite.find("-- For SQLite alone"));
  std::string out;
  auto rest = text.begin();
  for (std::sregex_iterator at(text.begin(), text.end(), kTokens), end; at != end; ++at) {
    out.append(rest, (*at)[0].first);
    rest = (*at)[0].second;
    const std::string word = (*at)[2];
    const auto other = std::ranges::find(kOtherWords, word, &Words::first);
    if (other != std::end(kOtherWords)) {
      out += other->second;
    } else if (word.empty() || std::ranges::find(kSameWords, word) != std::end(kSameWords)) {
      out += (*at)[1].str() + word;
    } else {
      return Status(Code::kInternal, "pg_migrations.cpp does not know the word " + word);
    }
  }
  return out.append(rest, text.end());
}

const std::vector<sql::Migration>& PgMigrations() {
  static const std::vector<sql::Migration> kMigrations = [] {
    std::vector<sql::Migration> out = SqliteMigrations();
    for (sql::Migration& each : out) {
      each.sql = InPostgres(each.sql).value();
      const auto own = std::ranges::find(OwnPgMigrations(), each.version, &sql::Migration::version);
      if (own != OwnPgMigrations().end()) each.sql += own->sql;
    }
    return out;
  }();
  return kMigrations;
}

}  // namespace enamel::server
