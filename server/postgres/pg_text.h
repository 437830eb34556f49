#pragma once

#include <string>
#include <string_view>

// The store's SQL in PostgreSQL's words. Private to server/postgres.
namespace enamel::sql {

// Parameters: "?1" becomes "$1". Text inside '…' and "…" is unchanged.
std::string WithDollars(std::string_view sql);

// Of PostgreSQL's words, which may be null.
std::string FirstLine(const char* words);

// The SQLSTATE in the words of a connection that was refused (PQERRORS_VERBOSE), which loses it:
// libpq shows it nowhere else. 25006 where libpq itself leaves a server that takes no changes.
// Empty: there is none.
std::string TakeState(std::string& words);

// As an SQL name: between double quotes, those inside doubled.
std::string Quoted(const std::string& name);

}  // namespace enamel::sql
