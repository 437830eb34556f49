#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/core/core.h"
#include "server/storage/audit/actor.h"
#include "server/training/types.h"

namespace enamel::load {

// The author of the generator's writes, and an end that is never reached.
inline const server::Actor kLoadgen{{}, "enamel-loadgen"};
inline constexpr server::UnixMs kFarOff = server::UnixMs{1} << 60;

// Data that stations need on a server: written into its data folder, before or while it runs. The
// person's password verifier is cheap, so that a thousand sign-ins measure the link and not
// argon2id.
struct School {
  std::string login, password;
  std::vector<std::string> codes;  // one-time enrolment codes
  Sha256 exercise, profile, scene, volume;
  core::CoreParams params;  // what exercise and profile compile to
  std::string instructor_login, admin_login;
};

// Adds a student, an instructor and an admin with their own names, a practice block with its exercise for
// everybody and `stations` enrolment codes. Errors: those of the store.
Result<School> FoundSchool(const std::filesystem::path& data, size_t stations);

}  // namespace enamel::load
