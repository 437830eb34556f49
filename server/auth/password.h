#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/base/password.h"
#include "common/base/result.h"

// Passwords: argon2id by libsodium, over what was typed in composed form (RFC 8265, 4.2.2: NFC, one
// kind of space): keyboards of two systems write the same letter in two ways. Thread safety: functions, any thread. Blocks for about 50 ms
// and takes `memory_bytes`: callers bound how many run at once (Authenticator does).
namespace enamel::server::auth {

struct PasswordCost {
  unsigned long long passes = 2;
  size_t memory_bytes = size_t{64} << 20;
};

// A password has to withstand this many guesses (guesses.h). At the sign-in that is years: a login
// gets at most some 650 000 tries a month from all addresses together (throttle.h). Somebody who
// has stolen the verifiers and does 1000 argon2id a second needs a day for one person.
inline constexpr double kMinLog10Guesses = 8;

// Refuses passwords that are too short or too long, or that somebody who knows the owner's login
// and name guesses too soon. No composition rules. For new passwords; accepted ones stay valid.
Status CheckPasswordPolicy(std::string_view password, std::string_view login,
                           std::string_view name = {});
// A verifier string in libsodium's form. Errors: kUnavailable (not enough memory).
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
