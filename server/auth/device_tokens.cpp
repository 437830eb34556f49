#include "server/auth/device_tokens.h"

#include <sodium.h>

#include <algorithm>
#include <vector>

#include "common/base/hex.h"
#include "server/auth/token.h"

namespace enamel::server::auth {
namespace {

constexpr size_t kTimeBytes = 4, kNameBytes = 8, kHashBytes = 16;
constexpr size_t kTokenDigits = 2 * (kTimeBytes + kNameBytes + kHashBytes);

std::vector<std::string_view> Split(std::string_view tokens) {
  std::vector<std::string_view> out;
  // Bounded before anything is computed: the browser's text is anybody's.
  while (tokens.size() >= kTokenDigits && out.size() < DeviceTokens::kMaxLogins) {
    out.push_back(tokens.substr(0, kTokenDigits));
    tokens.remove_prefix(std::min(tokens.size(), kTokenDigits + 1));
  }
  return out;
}

std::string NameIn(std::string_view token) {
  return std::string(token.substr(2 * kTimeBytes, 2 * kNameBytes));
}

}  // namespace

std::string DeviceTokens::Token(std::string_view login, int64_t until_s,
                                const std::string& name) const {
  Bytes time(kTimeBytes);
  for (size_t i = 0; i < kTimeBytes; ++i) {
    time[i] = static_cast<uint8_t>(until_s >> (8 * (kTimeBytes - 1 - i)));
  }
  std::string token = ToHex(time) + name;
  const std::string text = token + std::string(login);
  Bytes hash(kHashBytes);
  crypto_generichash(hash.data(), hash.size(), AsBytes(text).data(), text.size(),
                     key_.view().data(), key_.view().size());
  return token + ToHex(hash);
}

bool DeviceTokens::IsOf(std::string_view login, std::string_view token, UnixMs now_ms) const {
  const auto time = FromHex(token.substr(0, 2 * kTimeBytes));
  if (!time.ok()) return false;
  int64_t until_s = 0;
  for (uint8_t byte : *time) until_s = until_s << 8 | byte;
  return until_s > now_ms / 1000 && SameSecret(token, Token(login, until_s, NameIn(token)));
}

std::string DeviceTokens::NameFor(std::string_view login, std::string_view tokens,
                                  UnixMs now_ms) const {
  for (std::string_view token : Split(tokens)) {
    if (IsOf(login, token, now_ms)) return NameIn(token);
  }
  return {};
}

std::string DeviceTokens::With(std::string_view login, std::string_view tokens,
                               UnixMs now_ms) const {
  std::string name = NameFor(login, tokens, now_ms);
  if (name.empty()) {
    Bytes random(kNameBytes);
    randombytes_buf(random.data(), random.size());
    name = ToHex(random);
  }
  std::string out = Token(login, now_ms / 1000 + kDays * 24 * 60 * 60, name);
  size_t kept = 1;
  for (std::string_view token : Split(tokens)) {
    // Its own shorter-lived one is replaced. Others' go along unread: whose they are is not known.
    const bool hex = std::ranges::all_of(
        token, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
    if (kept >= kMaxLogins || !hex || NameIn(token) == name) continue;
    out += "." + std::string(token);
    ++kept;
  }
  return out;
}

}  // namespace enamel::server::auth
