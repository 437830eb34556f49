#pragma once

#include <map>
#include <string>
#include <vector>

#include "server/storage/engine/query.h"

// The decisions of people and the inputs of scores, as the audit trail states them and `verify`
// compares them (schemas/audit.md). A subject is a kind and a key, "attempt <id>"; its state is one
// JSON object with all decided columns.
namespace enamel::server {

std::string SubjectOf(const std::string& kind, const std::string& key);
// The subject of a row with this action and object; empty: nothing is compared.
std::string SubjectOfAction(const std::string& action, const std::string& object);

// The present state, as of this transaction; empty: the subject does not exist. Words are in it as
// their SHA-256. Errors: kInternal (no such kind).
Result<std::string> StateOf(Db& db, const std::string& subject);
// Column to value. What has no value is left out. Empty too when it is no state.
std::map<std::string, std::string> ColumnsOf(const std::string& state);
struct PresentSubject {
  std::string subject;
  std::string object;  // of the row that tells of it
};
// Every existing subject.
Result<std::vector<PresentSubject>> PresentSubjects(Db& db);

}  // namespace enamel::server
