#pragma once

#include <bit>
#include <cstdint>
#include <span>

namespace enamel {

// Running 64-bit hash of the deterministic core: fast (8 bytes per multiply), no allocation,
// integer arithmetic only, so it repeats on every machine. It finds divergence, it does not defend
// against forgery: the chunk chain (SHA-256, signed) does that.
// Thread safety: none. Real-time: safe.
class StateHash {
 public:
  void U64(uint64_t v) noexcept {
    h_ = (h_ ^ v) * 0x9fb21c651e98df25ull;
    h_ ^= h_ >> 29;
  }
  void I32x2(int32_t a, int32_t b) noexcept {
    U64(static_cast<uint32_t>(a) | static_cast<uint64_t>(static_cast<uint32_t>(b)) << 32);
  }
  // The bit pattern; -0.0 and 0.0 differ, which is wanted.
  void F64(double v) noexcept { U64(std::bit_cast<uint64_t>(v)); }
  // Four lanes, so that long runs go at memory speed. Requires: words.size() % 4 == 0.
  void Words(std::span<const uint64_t> words) noexcept {
    uint64_t a = h_, b = h_ ^ 0x243f6a8885a308d3ull, c = h_ ^ 0x13198a2e03707344ull,
             d = h_ ^ 0xa4093822299f31d0ull;
    for (size_t i = 0; i + 3 < words.size(); i += 4) {
      a = (std::rotl(a, 29) ^ words[i]) * 0x9fb21c651e98df25ull;
      b = (std::rotl(b, 29) ^ words[i + 1]) * 0x9fb21c651e98df25ull;
      c = (std::rotl(c, 29) ^ words[i + 2]) * 0x9fb21c651e98df25ull;
      d = (std::rotl(d, 29) ^ words[i + 3]) * 0x9fb21c651e98df25ull;
    }
    U64(a);
    U64(b);
    U64(c);
    U64(d);
  }
  uint64_t value() const noexcept { return h_; }

 private:
  uint64_t h_ = 0x452821e638d01377ull;
};

}  // namespace enamel
