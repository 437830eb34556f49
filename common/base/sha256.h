#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel {

// A SHA-256 digest: the name of every content-addressed thing (volume blobs, exercises, traces)
// and the link of the chunk chain. All zero means "none".
struct Sha256 {
  std::array<uint8_t, 32> bytes{};

  auto operator<=>(const Sha256&) const = default;
  bool IsZero() const { return *this == Sha256{}; }
  // 64 lower-case hexadecimal digits.
  std::string Hex() const;
  static Result<Sha256> FromHex(std::string_view hex);
  static Sha256 FromBytes(ByteView view);  // Requires: view.size() == 32.
  ByteView view() const { return bytes; }
};

// Digest of one byte string.
Sha256 HashSha256(ByteView data);

// Digest of a stream. Thread safety: none. Real-time: not safe.
class Sha256Stream {
 public:
  Sha256Stream();
  ~Sha256Stream();
  void Update(ByteView data);
  Sha256 Finish();  // Once.

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace enamel
