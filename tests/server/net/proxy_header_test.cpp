#include "server/net/proxy_header.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

namespace enamel::server {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr std::array<uint8_t, 12> kSignature = {'\r', '\n', '\r', '\n', 0,   '\r',
                                                '\n', 'Q',  'U',  'I',  'T', '\n'};

std::array<uint8_t, kProxyStartBytes> Start(uint8_t version_and_command, uint8_t family,
                                            size_t rest) {
  std::array<uint8_t, kProxyStartBytes> out{};
  std::ranges::copy(kSignature, out.begin());
  out[12] = version_and_command;
  out[13] = family;
  out[14] = static_cast<uint8_t>(rest >> 8);
  out[15] = static_cast<uint8_t>(rest);
  return out;
}

std::string Problem(std::span<const uint8_t, kProxyStartBytes> bytes) {
  auto start = ReadProxyStart(bytes);
  return start.ok() ? "" : start.status().message();
}

TEST(ProxyHeaderTest, SaysWhoAskedOverIp4) {
  auto start = ReadProxyStart(Start(0x21, 0x11, 12));
  ASSERT_TRUE(start.ok()) << start.status().message();
  EXPECT_EQ(start->rest_bytes, 12u);
  EXPECT_EQ(*ReadProxyPeer(*start, Bytes{192, 0, 2, 7, 198, 51, 100, 1, 0xC0, 0, 0x20, 0xFB}),
            "192.0.2.7");
}

TEST(ProxyHeaderTest, SaysWhoAskedOverIp6AndMayAddMore) {
  Bytes rest = {0x20, 0x01, 0x0D, 0xB8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7};
  rest.resize(36);
  // A checksum over the header, as HAProxy adds on request: ignored.
  rest.insert(rest.end(), {0x03, 0, 4, 1, 2, 3, 4});
  auto start = ReadProxyStart(Start(0x21, 0x21, rest.size()));
  ASSERT_TRUE(start.ok()) << start.status().message();
  EXPECT_EQ(start->rest_bytes, 43u);
  EXPECT_EQ(*ReadProxyPeer(*start, rest), "2001:db8::7");
}

TEST(ProxyHeaderTest, OfItselfOrOfNobodyItNamesNoAddress) {
  for (auto bytes : {Start(0x20, 0x00, 0), Start(0x20, 0x11, 12), Start(0x21, 0x00, 0)}) {
    auto start = ReadProxyStart(bytes);
    ASSERT_TRUE(start.ok()) << start.status().message();
    EXPECT_EQ(*ReadProxyPeer(*start, Bytes(start->rest_bytes, 9)), "");
  }
}

TEST(ProxyHeaderTest, SaysWhatItFoundInstead) {
  std::array<uint8_t, kProxyStartBytes> other{};
  EXPECT_NE(Problem(other).find("found other bytes"), std::string::npos) << Problem(other);
  std::ranges::copy(std::string_view("PROXY TCP4 192.0"), other.begin());
  EXPECT_NE(Problem(other).find("found version 1 of it"), std::string::npos) << Problem(other);
  EXPECT_NE(Problem(Start(0x11, 0x11, 12)).find("found version 1"), std::string::npos);
  EXPECT_NE(Problem(Start(0x31, 0x11, 12)).find("found version 3"), std::string::npos);
  EXPECT_NE(Problem(Start(0x22, 0x11, 12)).find("found command 2"), std::string::npos);
  EXPECT_NE(Problem(Start(0x21, 0x11, kMaxProxyRestBytes + 1)).find("found one of 2049 bytes"),
            std::string::npos);
  EXPECT_EQ(Problem(Start(0x21, 0x11, kMaxProxyRestBytes)), "");
}

TEST(ProxyHeaderTest, AddressesThatAreCutOffOrOfAnotherKindAreNone) {
  // UDP, a path of this machine, and what no version has.
  for (uint8_t family : {0x12, 0x22, 0x31, 0x13, 0xFF}) {
    EXPECT_FALSE(ReadProxyPeer({false, family, 216}, Bytes(216)).ok()) << int{family};
  }
  for (size_t bytes = 0; bytes < 12; ++bytes) {
    EXPECT_FALSE(ReadProxyPeer({false, 0x11, bytes}, Bytes(bytes)).ok()) << bytes;
  }
  for (size_t bytes = 0; bytes < 36; ++bytes) {
    EXPECT_FALSE(ReadProxyPeer({false, 0x21, bytes}, Bytes(bytes)).ok()) << bytes;
  }
}

// Each byte of the start with each value: it is read, or refused with the bytes found.
TEST(ProxyHeaderTest, NoByteOfTheStartIsTakenForAnother) {
  const auto good = Start(0x21, 0x11, 12);
  for (size_t at = 0; at < good.size(); ++at) {
    for (int value = 0; value < 256; ++value) {
      auto bytes = good;
      bytes[at] = static_cast<uint8_t>(value);
      const bool same = bytes == good;
      const bool fits = at < 13 ? same || (at == 12 && value == 0x20)
                                : at != 14 || value < 8 || (value == 8 && good[15] == 0);
      EXPECT_EQ(ReadProxyStart(bytes).ok(), fits) << at << " " << value;
    }
  }
}

}  // namespace
}  // namespace enamel::server
