#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "server/storage/people/cohort_rows.h"
#include "server/storage/people/people_rows.h"

// The `admin` commands. Each opens the data folder beside a running server, or without one, prints
// its outcome to standard output and returns.
namespace enamel::server::app {

// Errors: kNotFound, with what to do.
Result<Uuid> CohortByName(CohortRows& cohorts_rows, const std::string& name);

// A login is written in any case. Errors: kNotFound.
Result<Person> PersonNamed(PeopleRows& people, const std::string& login);

struct NewPerson {
  std::string login, display_name, role;
  std::string id;                    // of a person that a restore has forgotten; empty: a new one
  bool password_from_stdin = false;  // otherwise one is made up and printed, once
};
Status AddPerson(const std::filesystem::path& data, const NewPerson& person);
Status SetPassword(const std::filesystem::path& data, const std::string& login, bool from_stdin);
Status SetDisabled(const std::filesystem::path& data, const std::string& login, bool disabled);
Status AddCohort(const std::filesystem::path& data, const std::string& name);
Status AddToCohort(const std::filesystem::path& data, const std::string& cohort,
                   const std::string& login);

// Prints CODE@FINGERPRINT: the one-time code (128 random bits, hexadecimal) and the SHA-256 of the
// certificate that the station is to trust.
Status EnrolCode(const std::filesystem::path& data, int valid_minutes);
// The same for many stations, as schemas/enrolment_codes.md says: `names` has a name on each line
// ("-": standard input). Makes no code unless every name is valid and no two are equal. Errors:
// kInvalidInput with the line, and those of reading `names`.
Status EnrolCodes(const std::filesystem::path& data, const std::filesystem::path& names,
                  int valid_minutes);

Status MarkReference(const std::filesystem::path& data, const std::string& attempt,
                     const std::string& dentist, bool consent, const std::string& anyway = {});
// Of this exercise, by name; empty: of every one. Newest first, withdrawn ones too.
Status ListReferences(const std::filesystem::path& data, const std::string& exercise);
// `reference`: its id, or that of the attempt that it is. Scores made with it stay.
Status WithdrawReference(const std::filesystem::path& data, const std::string& reference);
Status ReleaseScore(const std::filesystem::path& data, const std::string& attempt);
Status ListAttempts(const std::filesystem::path& data, uint32_t limit);

struct CommandGroup;
// On the command line (command_line.h), by subject.
void DeclarePeople(CommandGroup admin);
void DeclareAttempts(CommandGroup admin);

}  // namespace enamel::server::app
