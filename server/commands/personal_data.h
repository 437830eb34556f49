#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

// Requests that a person may make: a copy of all data about them, and its erasure.
namespace enamel::server::app {

// Writes all data about a person into a new folder (schemas/person_export.md). Audited. Errors:
// kNotFound, kConflict (the folder is not empty), kStorage.
Status ExportPerson(const std::filesystem::path& data, const std::string& login,
                    const std::filesystem::path& target);

// `confirm` must repeat the login. Errors: those of Erasures::ErasePerson; kInvalidInput.
Status ErasePerson(const std::filesystem::path& data, const std::string& login,
                   const std::string& confirm, bool with_references);

struct CommandGroup;
// On the command line (command_line.h).
void DeclarePersonalData(CommandGroup admin);

}  // namespace enamel::server::app
