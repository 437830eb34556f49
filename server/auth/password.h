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

// Refuses what is too short, too long, or made of what is guessed first: common words (also with
// digits for letters), rows of keys, sequences, repetitions, years, the login, however they are put
// together with a few characters more. No composition rules, no list of passwords: what a list of
// the commonest has in common (OWASP ASVS 5.0, 6.2.4 asks for the first 3000).
Status CheckPasswordPolicy(std::string_view password, std::string_view login);
// A verifier string in libsodium's form. Errors: kUnavailable when the memory cannot be had.
Result<std::string> HashPassword(std::string_view password, const PasswordCost& cost = {});
// A password made up here, to be changed by whoever signs in with it first: 79 random bits as four
// groups of four, without letters that look like others ("k7mq-2xhd-9rtp-w4nc"). Its verifier is
// cheap: nobody guesses 79 bits, however fast a guess is. Empty verifier: no memory.
struct OneTimePassword {
  std::string text, verifier;
};
OneTimePassword MakeOneTimePassword();
// False for verifiers made at another cost, one-time passwords' among them: who verifies one has to
// do the work of `cost` besides, so that the time does not tell.
bool CostsAsMuch(const std::string& verifier, const PasswordCost& cost);
bool VerifyPassword(std::string_view password, const std::string& verifier);

}  // namespace enamel::server::auth
