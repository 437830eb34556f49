#include "server/s3/sigv4.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <map>

#include "common/base/hex.h"

namespace enamel::s3 {
namespace {

constexpr char kAlgorithm[] = "AWS4-HMAC-SHA256";
constexpr char kEnd[] = "aws4_request";

using Mac = std::array<uint8_t, crypto_auth_hmacsha256_BYTES>;

Mac Hmac(ByteView key, std::string_view text) {
  Mac out{};
  crypto_auth_hmacsha256_state state;
  crypto_auth_hmacsha256_init(&state, key.data(), key.size());
  crypto_auth_hmacsha256_update(&state, AsBytes(text).data(), text.size());
  crypto_auth_hmacsha256_final(&state, out.data());
  sodium_memzero(&state, sizeof state);
  return out;
}

bool IsUnreserved(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '.' || c == '_' || c == '~';
}

// Without spaces at both ends, and with one where there are several.
std::string Trimmed(std::string_view value) {
  std::string out;
  for (char c : value) {
    const bool space = c == ' ' || c == '\t';
    if (space && (out.empty() || out.back() == ' ')) continue;
    out += space ? ' ' : c;
  }
  if (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

// By name in lower case; values of one name joined.
std::map<std::string, std::string> CanonicalHeaders(const Pairs& headers) {
  std::map<std::string, std::string> out;
  for (const auto& [name, value] : headers) {
    std::string lower = name;
    for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    auto [place, first] = out.try_emplace(lower, Trimmed(value));
    if (!first) place->second += "," + Trimmed(value);
  }
  return out;
}

std::string SignedNames(const Pairs& headers) {
  std::string out;
  for (const auto& [name, value] : CanonicalHeaders(headers)) {
    out += (out.empty() ? "" : ";") + name;
  }
  return out;
}

std::string ScopeText(const Scope& scope, const std::string& amz_date) {
  return amz_date.substr(0, 8) + "/" + scope.region + "/" + scope.service + "/" + kEnd;
}

}  // namespace

std::string UriEncode(std::string_view text, bool slash) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  std::string out;
  for (char c : text) {
    if (IsUnreserved(c) || (c == '/' && !slash)) {
      out += c;
      continue;
    }
    const auto byte = static_cast<uint8_t>(c);
    out += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return out;
}

std::string CanonicalQuery(const Pairs& query) {
  Pairs encoded;
  for (const auto& [name, value] : query) {
    encoded.emplace_back(UriEncode(name, true), UriEncode(value, true));
  }
  std::ranges::sort(encoded);
  std::string out;
  for (const auto& [name, value] : encoded) {
    out += (out.empty() ? "" : "&") + name + "=" + value;
  }
  return out;
}

std::string CanonicalRequest(const Request& request) {
  std::string out = request.method + "\n" + UriEncode(request.path, false) + "\n" +
                    CanonicalQuery(request.query) + "\n";
  for (const auto& [name, value] : CanonicalHeaders(request.headers)) {
    out += name + ":" + value + "\n";
  }
  return out + "\n" + SignedNames(request.headers) + "\n" + request.body.Hex();
}

std::string AmzDate(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  const size_t size = std::strftime(text, sizeof text, "%Y%m%dT%H%M%SZ", &utc);
  return {text, size};
}

std::string StringToSign(const Request& request, const Scope& scope, const std::string& amz_date) {
  return std::string(kAlgorithm) + "\n" + amz_date + "\n" + ScopeText(scope, amz_date) + "\n" +
         HashSha256(AsBytes(CanonicalRequest(request))).Hex();
}

std::string Authorization(const Request& request, const Scope& scope,
                          const Credentials& credentials, const std::string& amz_date) {
  std::string secret = "AWS4" + credentials.secret_key;
  Mac key = Hmac(AsBytes(secret), amz_date.substr(0, 8));
  sodium_memzero(secret.data(), secret.size());
  key = Hmac(key, scope.region);
  key = Hmac(key, scope.service);
  key = Hmac(key, kEnd);
  const Mac signature = Hmac(key, StringToSign(request, scope, amz_date));
  sodium_memzero(key.data(), key.size());
  return std::string(kAlgorithm) + " Credential=" + credentials.access_key + "/" +
         ScopeText(scope, amz_date) + ",SignedHeaders=" + SignedNames(request.headers) +
         ",Signature=" + ToHex(signature);
}

}  // namespace enamel::s3
