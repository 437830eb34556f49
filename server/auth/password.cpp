#include "server/auth/password.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace enamel::server::auth {
namespace {

// See Surprises: five characters that nothing foretells.
constexpr int kLeastSurprises = 10;

// What the commonest leaked passwords are made of: words, names, teams, and what is at hand here.
constexpr std::string_view kWords[] = {
    "password",      "passwort",   "passwd",   "kennwort",   "contrasena", "motdepasse",
    "welcome",       "willkommen", "letmein",  "iloveyou",   "loveyou",    "princess",
    "sunshine",      "football",   "baseball", "basketball", "superman",   "batman",
    "spiderman",     "pokemon",    "starwars", "trustno",    "monkey",     "dragon",
    "master",        "shadow",     "michael",  "jordan",     "hunter",     "soccer",
    "hockey",        "killer",     "charlie",  "andrew",     "jessica",    "jennifer",
    "ashley",        "nicole",     "daniel",   "thomas",     "robert",     "matthew",
    "michelle",      "anthony",    "joshua",   "samantha",   "alexander",  "andrea",
    "whatever",      "freedom",    "secret",   "geheim",     "login",      "admin",
    "administrator", "root",       "user",     "guest",      "test",       "default",
    "changeme",      "computer",   "internet", "server",     "google",     "facebook",
    "summer",        "winter",     "spring",   "autumn",     "sommer",     "herbst",
    "january",       "february",   "march",    "april",      "june",       "july",
    "august",        "september",  "october",  "november",   "december",   "monday",
    "tuesday",       "wednesday",  "thursday", "friday",     "saturday",   "sunday",
    "hello",         "hallo",      "schatz",   "bonjour",    "soleil",     "chocolate",
    "cheese",        "cookie",     "flower",   "butterfly",  "ginger",     "pepper",
    "buster",        "tigger",     "maggie",   "liverpool",  "chelsea",    "arsenal",
    "barcelona",     "juventus",   "bayern",   "yankees",    "mustang",    "ferrari",
    "mercedes",      "corvette",   "harley",   "maverick",   "phoenix",    "enamel",
    "dentin",        "dental",     "dentist",  "tooth",      "teeth",      "molar",
    "school",        "schule",     "student",  "instructor", "teacher",    "university",
    "clinic",        "station",    "bench",    "demo"};
// Neighbours on keyboards (QWERTY, QWERTZ, AZERTY) and in the alphabet; read both ways.
constexpr std::string_view kRows[] = {"01234567890",
                                      "abcdefghijklmnopqrstuvwxyz",
                                      "qwertyuiop",
                                      "qwertzuiop",
                                      "asdfghjkl",
                                      "zxcvbnm",
                                      "yxcvbnm",
                                      "azertyuiop",
                                      "qsdfghjklm",
                                      "wxcvbn",
                                      "1qaz2wsx3edc4rfv5tgb",
                                      "1q2w3e4r5t6y7u8i9o0p",
                                      "1q2w3e4r5t6z7u",
                                      "q1w2e3r4t5y6",
                                      "qazwsxedcrfvtgbyhn",
                                      "!@#$%^&*()"};

std::string Lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

// "p@ssw0rd" -> "password".
std::string WithoutDisguise(std::string text) {
  constexpr std::string_view kShown = "0134578@$!", kMeant = "oleastbasi";
  for (char& c : text) {
    if (size_t at = kShown.find(c); at != std::string_view::npos) c = kMeant[at];
  }
  return text;
}

// How many characters of `text` from its first on are one of these, the longest.
size_t WordAt(std::string_view text, std::string_view login) {
  size_t longest = 0;
  for (std::string_view word : kWords) {
    if (text.starts_with(word)) longest = std::max(longest, word.size());
  }
  if (login.size() >= 3 && text.starts_with(login)) longest = std::max(longest, login.size());
  return longest;
}

size_t RowAt(std::string_view text) {
  constexpr size_t kLeast = 3;
  size_t longest = 0;
  for (std::string_view row : kRows) {
    const std::string back(row.rbegin(), row.rend());
    for (std::string_view way : {row, std::string_view(back)}) {
      for (size_t n = std::min(way.size(), text.size()); n >= kLeast && n > longest; --n) {
        if (way.find(text.substr(0, n)) != std::string_view::npos) longest = n;
      }
    }
  }
  return longest;
}

// The same character again and again, or what stood right before once more ("abcabc").
size_t RepeatAt(std::string_view text, size_t at) {
  size_t same = 1;
  while (at + same < text.size() && text[at + same] == text[at]) ++same;
  if (same >= 3) return same;
  for (size_t n = at; n >= 2; --n) {
    if (text.substr(at - n, n) == text.substr(at, n)) return n;
  }
  return 0;
}

size_t YearAt(std::string_view text) {
  bool year = text.size() >= 4 && (text.starts_with("19") || text.starts_with("20")) &&
              std::isdigit(static_cast<unsigned char>(text[2])) != 0 &&
              std::isdigit(static_cast<unsigned char>(text[3])) != 0;
  return year ? 4 : 0;
}

// What has to be guessed, piece by piece: 2 for a word, row, year or repetition, and for any other
// character 2, a digit 1.
int Surprises(std::string_view password, std::string_view login) {
  const std::string text = Lower(password), name = Lower(login);
  const std::string plain = WithoutDisguise(text);
  int out = 0;
  for (size_t i = 0; i < text.size();) {
    std::string_view rest = std::string_view(text).substr(i);
    std::string_view meant = std::string_view(plain).substr(i);
    size_t piece = std::max(
        {WordAt(rest, name), WordAt(meant, name), RowAt(rest), RepeatAt(text, i), YearAt(rest)});
    bool digit = std::isdigit(static_cast<unsigned char>(text[i])) != 0;
    out += piece == 0 && digit ? 1 : 2;
    i += std::max<size_t>(piece, 1);
  }
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
  if (Surprises(password, login) < kLeastSurprises) {
    return Status(
        Code::kInvalidInput,
        "this password is among the first that are guessed (a common word, a row of keys, a "
        "year, the login, a few digits); choose another, a sentence is best",
        "password");
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
