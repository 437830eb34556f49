#include "server/auth/password.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace enamel::server::auth {
namespace {

// The commonest passwords of eight characters and more in published lists of leaked ones.
constexpr std::array<std::string_view, 24> kCommon = {
    "password",   "password1", "12345678", "123456789", "1234567890", "qwertyui",
    "qwertyuiop", "iloveyou",  "princess", "sunshine",  "football",   "baseball",
    "welcome1",   "superman",  "trustno1", "passw0rd",  "11111111",   "00000000",
    "abcd1234",   "1q2w3e4r",  "1qaz2wsx", "qwerty123", "letmein1",   "password123"};

std::string Lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

}  // namespace

Status CheckPasswordPolicy(std::string_view password, std::string_view login) {
  if (password.size() < kMinPasswordLength || password.size() > kMaxPasswordLength) {
    return Status(Code::kInvalidInput,
                  "a password has " + std::to_string(kMinPasswordLength) + " to " +
                      std::to_string(kMaxPasswordLength) + " bytes, this one has " +
                      std::to_string(password.size()) + "; a sentence of 15 or more is best",
                  "password");
  }
  std::string lower = Lower(password);
  if (lower == Lower(login) || std::find(kCommon.begin(), kCommon.end(), lower) != kCommon.end()) {
    return Status(Code::kInvalidInput,
                  "this password is among the first that are guessed; choose another", "password");
  }
  return Status::Ok();
}

Result<std::string> HashPassword(std::string_view password, const PasswordCost& cost) {
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

bool VerifyPassword(std::string_view password, const std::string& verifier) {
  return crypto_pwhash_str_verify(verifier.c_str(), password.data(), password.size()) == 0;
}

}  // namespace enamel::server::auth
