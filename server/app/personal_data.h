#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

// What a person may ask for: a copy of everything kept about them, and its end.
namespace enamel::server::app {

// Writes what is kept about a person into a new folder (schemas/person_export.md). Audited. Errors:
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
