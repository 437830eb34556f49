#pragma once

#include <array>
#include <cstdint>

#include "common/base/bytes.h"

namespace enamel::server {

// A key of 256 bits. Wiped when it goes out of scope.
class DataKey {
 public:
  static constexpr size_t kBytes = 32;
  DataKey() = default;
  explicit DataKey(ByteView bytes);  // Requires: 32 bytes.
  ~DataKey();
  DataKey(const DataKey&) = default;
  DataKey& operator=(const DataKey&) = default;
  static DataKey New();
  // Sub-key `number` in a context of eight characters: crypto_kdf_derive_from_key of libsodium.
  DataKey Derive(const char (&context)[9], uint64_t number) const;
  ByteView view() const { return bytes_; }

 private:
  std::array<uint8_t, kBytes> bytes_{};
};

}  // namespace enamel::server
