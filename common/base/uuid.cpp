#include "common/base/uuid.h"

#include <sodium.h>

#include "common/base/hex.h"
#include "common/base/mutex.h"

namespace enamel {

std::string Uuid::Text() const {
  std::string hex = ToHex(bytes);
  return hex.substr(0, 8) + "-" + hex.substr(8, 4) + "-" + hex.substr(12, 4) + "-" +
         hex.substr(16, 4) + "-" + hex.substr(20);
}

Result<Uuid> Uuid::Parse(std::string_view text) {
  Status bad(Code::kInvalidInput,
             "expected an id like 01234567-89ab-7cde-8f01-23456789abcd, found \"" +
                 std::string(text.substr(0, 64)) + "\"");
  if (text.size() != 36) return bad;
  std::string hex;
  for (size_t i = 0; i < text.size(); ++i) {
    bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    if (dash != (text[i] == '-')) return bad;
    if (!dash) hex.push_back(text[i]);
  }
  auto raw = FromHex(hex);
  if (!raw.ok()) return bad;
  return FromBytes(*raw);
}

Uuid Uuid::FromBytes(ByteView view) {
  ENAMEL_CHECK(view.size() == 16);
  Uuid out;
  std::copy(view.begin(), view.end(), out.bytes.begin());
  return out;
}

Uuid Uuid::New(std::chrono::system_clock::time_point now) {
  Uuid out;
  randombytes_buf(out.bytes.data(), out.bytes.size());
  auto ms = static_cast<uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count());
  static Mutex mutex;
  static uint64_t last_ms ENAMEL_GUARDED_BY(mutex) = 0;
  static uint32_t counter ENAMEL_GUARDED_BY(mutex) = 0;
  uint32_t order;
  {
    MutexLock lock(mutex);
    if (ms == last_ms && counter < 0xfff) {
      ++counter;
    } else {
      last_ms = ms;
      // Also when a millisecond has no number left, and when the clock was set back: then the order
      // is lost, and 62 random bits still keep ids apart.
      counter = out.bytes[7];  // random, with room to count up
    }
    order = counter;
  }
  for (int i = 0; i < 6; ++i) out.bytes[i] = static_cast<uint8_t>(ms >> (8 * (5 - i)));
  // Version 7 and variant 10 (binary) in the top bits (RFC 9562, section 5.7).
  out.bytes[6] = static_cast<uint8_t>(0x70 | (order >> 8));
  out.bytes[7] = static_cast<uint8_t>(order);
  out.bytes[8] = static_cast<uint8_t>(0x80 | (out.bytes[8] & 0x3f));
  return out;
}

}  // namespace enamel
