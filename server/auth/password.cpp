#include "server/auth/password.h"

#include <sodium.h>

#include <array>

#include "server/auth/guesses.h"
#include "server/training/names.h"

namespace enamel::server::auth {
Status CheckPasswordPolicy(std::string_view password, std::string_view login,
                           std::string_view name) {
  if (password.size() < kMinPasswordLength || password.size() > kMaxPasswordLength) {
    return Status(Code::kInvalidInput,
                  "a password has " + std::to_string(kMinPasswordLength) + " to " +
                      std::to_string(kMaxPasswordLength) + " bytes, this one has " +
                      std::to_string(password.size()) + "; a sentence of 15 or more is best",
                  "password");
  }
  // The demo's passwords are public, and somebody may have learnt theirs there.
  const std::string of_the_demo = "enamel-demo-" + std::string(login);
  if (Log10Guesses(password, {login, name, of_the_demo}) < kMinLog10Guesses) {
    return Status(Code::kInvalidInput,
                  "this password is among the first that are guessed: common words and passwords, "
                  "names, rows of keys, dates, and those with a few characters more; take four "
                  "words that have nothing to do with each other, or with you",
                  "password");
  }
  return Status::Ok();
}

Result<std::string> HashPassword(std::string_view typed, const PasswordCost& cost) {
  const std::string password = Composed(typed);
  std::array<char, crypto_pwhash_STRBYTES> out{};
  if (crypto_pwhash_str_alg(out.data(), password.data(), password.size(), cost.passes,
                            cost.memory_bytes, crypto_pwhash_ALG_ARGON2ID13) != 0) {
    return Status(Code::kUnavailable, "no memory to hash a password (" +
                                          std::to_string(cost.memory_bytes >> 20) +
                                          " MiB needed); try again");
  }
  return std::string(out.data());
}

OneTimePassword MakeOneTimePassword() {
  // 31 characters that are easy to distinguish on paper: no 0 and o, no 1, i and l. 16 of them are
  // 79 bits.
  constexpr std::string_view kAlphabet = "23456789abcdefghjkmnpqrstuvwxyz";
  constexpr size_t kLetters = 16, kGroup = 4;
  OneTimePassword out;
  for (size_t i = 0; i < kLetters; ++i) {
    if (i > 0 && i % kGroup == 0) out.text += '-';
    out.text += kAlphabet[randombytes_uniform(kAlphabet.size())];
  }
  PasswordCost cheap{crypto_pwhash_argon2id_OPSLIMIT_MIN, crypto_pwhash_argon2id_MEMLIMIT_MIN};
  if (auto verifier = HashPassword(out.text, cheap); verifier.ok()) out.verifier = *verifier;
  return out;
}

bool CostsAsMuch(const std::string& verifier, const PasswordCost& cost) {
  return crypto_pwhash_str_needs_rehash(verifier.c_str(), cost.passes, cost.memory_bytes) == 0;
}

bool VerifyPassword(std::string_view typed, const std::string& verifier) {
  const std::string password = Composed(typed);
  return crypto_pwhash_str_verify(verifier.c_str(), password.data(), password.size()) == 0;
}

}  // namespace enamel::server::auth
