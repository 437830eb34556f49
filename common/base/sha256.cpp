#include "common/base/sha256.h"

#include <sodium.h>

#include "common/base/hex.h"

namespace enamel {

// Behind a pointer, so that users of the header need not see libsodium's.
struct Sha256Stream::State {
  crypto_hash_sha256_state sodium;
};

std::string Sha256::Hex() const { return ToHex(bytes); }

Result<Sha256> Sha256::FromHex(std::string_view hex) {
  auto bytes = enamel::FromHex(hex);
  if (!bytes.ok() || bytes->size() != 32) {
    return Status(Code::kInvalidInput, "expected a SHA-256 as 64 hexadecimal digits, found \"" +
                                           std::string(hex.substr(0, 80)) + "\"");
  }
  return FromBytes(*bytes);
}

Sha256 Sha256::FromBytes(ByteView view) {
  ENAMEL_CHECK(view.size() == 32);
  Sha256 out;
  std::copy(view.begin(), view.end(), out.bytes.begin());
  return out;
}

Sha256 HashSha256(ByteView data) {
  Sha256 out;
  crypto_hash_sha256(out.bytes.data(), data.data(), data.size());
  return out;
}

Sha256Stream::Sha256Stream() : state_(std::make_unique<State>()) {
  crypto_hash_sha256_init(&state_->sodium);
}
Sha256Stream::~Sha256Stream() = default;
void Sha256Stream::Update(ByteView data) {
  crypto_hash_sha256_update(&state_->sodium, data.data(), data.size());
}
Sha256 Sha256Stream::Finish() {
  Sha256 out;
  crypto_hash_sha256_final(&state_->sodium, out.bytes.data());
  return out;
}

}  // namespace enamel
