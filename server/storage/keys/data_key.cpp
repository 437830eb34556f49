#include "server/storage/keys/data_key.h"

#include <sodium.h>

#include <algorithm>

#include "common/base/check.h"

namespace enamel::server {

static_assert(DataKey::kBytes == crypto_kdf_KEYBYTES);
static_assert(sizeof(char[9]) == crypto_kdf_CONTEXTBYTES + 1);

DataKey::DataKey(ByteView bytes) {
  ENAMEL_CHECK(bytes.size() == kBytes);
  std::ranges::copy(bytes, bytes_.begin());
}

DataKey::~DataKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

DataKey DataKey::New() {
  DataKey key;
  randombytes_buf(key.bytes_.data(), key.bytes_.size());
  return key;
}

DataKey DataKey::Derive(const char (&context)[9], uint64_t number) const {
  DataKey out;
  crypto_kdf_derive_from_key(out.bytes_.data(), out.bytes_.size(), number, context, bytes_.data());
  return out;
}

}  // namespace enamel::server
