#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/core/core.h"
#include "server/storage/actor.h"
#include "server/training/types.h"

namespace enamel::load {

// By whom it is written, and when what ends at a time ends.
inline const server::Actor kLoadgen{{}, "enamel-loadgen"};
inline constexpr server::UnixMs kFarOff = server::UnixMs{1} << 60;

// What stations need to find on a server: written into its data folder, beside the server or before
// it is started. The person's password verifier is a cheap one, so that a thousand sign-ins measure
// the link and not argon2id.
struct School {
  std::string login, password;
  std::vector<std::string> codes;  // one-time enrolment codes
  Sha256 exercise, profile, scene, volume;
  core::CoreParams params;  // what exercise and profile compile to
  std::string instructor_login;
};

// Adds a student and an instructor of names of their own, a practice block with its exercise for
// everybody and `stations` enrolment codes. Errors: those of the store.
Result<School> FoundSchool(const std::filesystem::path& data, size_t stations);

}  // namespace enamel::load
