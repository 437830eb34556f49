#include "common/base/hex.h"

namespace enamel {
namespace {
// Not stoi: it takes blanks, a sign and "0x", and stops without a word at what is no digit.
int Digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}
}  // namespace

std::string ToHex(ByteView data) {
  static const char* kDigits = "0123456789abcdef";
  std::string out;
  out.reserve(data.size() * 2);
  for (uint8_t b : data) {
    out.push_back(kDigits[b >> 4]);
    out.push_back(kDigits[b & 15]);
  }
  return out;
}

Result<Bytes> FromHex(std::string_view hex) {
  if (hex.size() % 2 != 0) return Status(Code::kInvalidInput, "odd number of hexadecimal digits");
  Bytes out;
  out.reserve(hex.size() / 2);
  for (size_t i = 0; i < hex.size(); i += 2) {
    int hi = Digit(hex[i]), lo = Digit(hex[i + 1]);
    if (hi < 0 || lo < 0) {
      return Status(Code::kInvalidInput, "no hexadecimal digit at offset " + std::to_string(i));
    }
    out.push_back(static_cast<uint8_t>(hi * 16 + lo));
  }
  return out;
}

}  // namespace enamel
