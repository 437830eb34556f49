#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/base/result.h"

// Passwords: argon2id by libsodium. Thread safety: functions, any thread. Blocks for about 50 ms
// and takes `memory_bytes`: callers bound how many run at once (Authenticator does).
namespace enamel::server::auth {

struct PasswordCost {
  unsigned long long passes = 2;
  size_t memory_bytes = size_t{64} << 20;
};

inline constexpr size_t kMinPasswordLength = 8;
inline constexpr size_t kMaxPasswordLength = 256;

// Refuses what is too short, too long, equal to the login or among the commonest. No composition
// rules.
Status CheckPasswordPolicy(std::string_view password, std::string_view login);
// A verifier string in libsodium's form. Errors: kUnavailable when the memory cannot be had.
Result<std::string> HashPassword(std::string_view password, const PasswordCost& cost = {});
bool VerifyPassword(std::string_view password, const std::string& verifier);

}  // namespace enamel::server::auth
