#include "server/auth/token.h"

#include <sodium.h>

#include <algorithm>

#include "common/base/hex.h"

namespace enamel::server::auth {

Bytes NewToken() {
  Bytes out(32);
  randombytes_buf(out.data(), out.size());
  return out;
}

Sha256 TokenHash(ByteView token) { return HashSha256(token); }

std::string CsrfFor(ByteView token) {
  static constexpr std::string_view kPurpose = "enamel csrf 1";
  Bytes out(32);
  // BLAKE2b keyed with the token, over a purpose: the page may show this value, and it leads back
  // neither to the token nor to the store's copy.
  crypto_generichash(out.data(), out.size(), AsBytes(kPurpose).data(), kPurpose.size(),
                     token.data(), std::min<size_t>(token.size(), crypto_generichash_KEYBYTES_MAX));
  return ToHex(out);
}

bool SameSecret(std::string_view a, std::string_view b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace enamel::server::auth
