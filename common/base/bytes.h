#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Bounded little-endian reading and writing of byte strings: the base of every codec of ours
// (trace chunks, volume blobs, wire frames). All formats are little-endian.
namespace enamel {

using Bytes = std::vector<uint8_t>;
using ByteView = std::span<const uint8_t>;

inline ByteView AsBytes(std::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}
inline std::string_view AsText(ByteView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Appends to a buffer it owns. Thread safety: none. Real-time: not safe (allocates).
class ByteWriter {
 public:
  void U8(uint8_t v) { out_.push_back(v); }
  void U16(uint16_t v) { Little(v, 2); }
  void U32(uint32_t v) { Little(v, 4); }
  void U64(uint64_t v) { Little(v, 8); }
  void I16(int16_t v) { Little(static_cast<uint16_t>(v), 2); }
  void I32(int32_t v) { Little(static_cast<uint32_t>(v), 4); }
  void I64(int64_t v) { Little(static_cast<uint64_t>(v), 8); }
  void Raw(ByteView v) { out_.insert(out_.end(), v.begin(), v.end()); }
  // Length (u32) and then the bytes.
  void Blob(ByteView v) {
    U32(static_cast<uint32_t>(v.size()));
    Raw(v);
  }
  void Text(std::string_view v) { Blob(AsBytes(v)); }
  // Unsigned LEB128, at most 10 bytes.
  void Varint(uint64_t v) {
    while (v >= 0x80) {
      out_.push_back(static_cast<uint8_t>(v | 0x80));
      v >>= 7;
    }
    out_.push_back(static_cast<uint8_t>(v));
  }
  // Zigzag, then LEB128: small magnitudes of either sign are short.
  void SignedVarint(int64_t v) {
    Varint((static_cast<uint64_t>(v) << 1) ^ static_cast<uint64_t>(v >> 63));
  }

  const Bytes& bytes() const { return out_; }
  Bytes Take() { return std::move(out_); }
  size_t size() const { return out_.size(); }

 private:
  void Little(uint64_t v, int n) {
    for (int i = 0; i < n; ++i) out_.push_back(static_cast<uint8_t>(v >> (8 * i)));
  }
  Bytes out_;
};

// Reads from a view it does not own. After any read past the end `ok()` is false for good and
// every read returns zero or empty: decode first, check once. Thread safety: none.
class ByteReader {
 public:
  explicit ByteReader(ByteView view) : view_(view) {}

  uint8_t U8() { return static_cast<uint8_t>(Little(1)); }
  uint16_t U16() { return static_cast<uint16_t>(Little(2)); }
  uint32_t U32() { return static_cast<uint32_t>(Little(4)); }
  uint64_t U64() { return Little(8); }
  int16_t I16() { return static_cast<int16_t>(U16()); }
  int32_t I32() { return static_cast<int32_t>(U32()); }
  int64_t I64() { return static_cast<int64_t>(U64()); }
  ByteView Raw(size_t n) {
    if (n > view_.size() - at_) {
      Fail();
      return {};
    }
    ByteView out = view_.subspan(at_, n);
    at_ += n;
    return out;
  }
  // Length-prefixed bytes, refused beyond `max_size`.
  ByteView Blob(size_t max_size) {
    uint32_t n = U32();
    if (n > max_size) {
      Fail();
      return {};
    }
    return Raw(n);
  }
  std::string Text(size_t max_size) { return std::string(AsText(Blob(max_size))); }
  uint64_t Varint() {
    uint64_t v = 0;
    for (int shift = 0; shift < 70; shift += 7) {
      if (at_ >= view_.size()) {
        Fail();
        return 0;
      }
      uint8_t b = view_[at_++];
      if (shift == 63 && b > 1) {
        Fail();
        return 0;
      }
      v |= static_cast<uint64_t>(b & 0x7f) << shift;
      if (!(b & 0x80)) return v;
    }
    Fail();
    return 0;
  }
  int64_t SignedVarint() {
    uint64_t v = Varint();
    return static_cast<int64_t>((v >> 1) ^ (0 - (v & 1)));
  }

  bool ok() const { return ok_; }
  bool AtEnd() const { return at_ == view_.size(); }
  size_t offset() const { return at_; }
  size_t remaining() const { return view_.size() - at_; }

 private:
  void Fail() {
    ok_ = false;
    at_ = view_.size();
  }
  uint64_t Little(int n) {
    if (static_cast<size_t>(n) > view_.size() - at_) {
      Fail();
      return 0;
    }
    uint64_t v = 0;
    for (int i = 0; i < n; ++i) v |= static_cast<uint64_t>(view_[at_ + i]) << (8 * i);
    at_ += n;
    return v;
  }
  ByteView view_;
  size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace enamel
