#include "server/net/proxy_header.h"

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>
#include <string_view>

namespace enamel::server {
namespace {

constexpr std::array<uint8_t, 12> kSignature = {0x0D, 0x0A, 0x0D, 0x0A, 0x00, 0x0D,
                                                0x0A, 0x51, 0x55, 0x49, 0x54, 0x0A};
constexpr uint8_t kUnknownFamily = 0x00, kTcpOverIp4 = 0x11, kTcpOverIp6 = 0x21;
// Both addresses, then both ports.
constexpr size_t kIp4Bytes = 4 + 4 + 2 + 2, kIp6Bytes = 16 + 16 + 2 + 2;

Status Expected(const std::string& found) {
  return {Code::kInvalidInput,
          "expected a header of the PROXY protocol, version 2 (send-proxy-v2), found " + found};
}

std::string WhatElse(std::span<const uint8_t, kProxyStartBytes> bytes) {
  constexpr std::string_view kVersion1 = "PROXY ";
  if (std::ranges::equal(bytes.first<kVersion1.size()>(), kVersion1)) return "version 1 of it";
  return "other bytes";
}

}  // namespace

Result<ProxyStart> ReadProxyStart(std::span<const uint8_t, kProxyStartBytes> bytes) {
  if (!std::ranges::equal(bytes.first<kSignature.size()>(), kSignature)) {
    return Expected(WhatElse(bytes));
  }
  const uint8_t version = bytes[12] >> 4, command = bytes[12] & 0x0F;
  if (version != 2) return Expected("version " + std::to_string(version));
  constexpr uint8_t kOwn = 0, kPassedOn = 1;
  if (command > kPassedOn) return Expected("command " + std::to_string(command));
  const size_t rest = size_t{bytes[14]} << 8 | bytes[15];
  if (rest > kMaxProxyRestBytes) {
    return Expected("one of " + std::to_string(rest) + " bytes, of at most " +
                    std::to_string(kMaxProxyRestBytes));
  }
  return ProxyStart{command == kOwn, bytes[13], rest};
}

Result<std::string> ReadProxyPeer(const ProxyStart& start, std::span<const uint8_t> rest) {
  if (start.is_own || start.family == kUnknownFamily) return std::string();
  if (start.family != kTcpOverIp4 && start.family != kTcpOverIp6) {
    return Expected("addresses of the kind " + std::to_string(start.family));
  }
  const bool ip4 = start.family == kTcpOverIp4;
  const size_t needed = ip4 ? kIp4Bytes : kIp6Bytes;
  if (rest.size() < needed) {
    return Expected(std::to_string(rest.size()) + " bytes of addresses, which take " +
                    std::to_string(needed));
  }
  if (ip4) {
    boost::asio::ip::address_v4::bytes_type from{};
    std::ranges::copy(rest.first(from.size()), from.begin());
    return boost::asio::ip::address_v4(from).to_string();
  }
  boost::asio::ip::address_v6::bytes_type from{};
  std::ranges::copy(rest.first(from.size()), from.begin());
  return boost::asio::ip::address_v6(from).to_string();
}

}  // namespace enamel::server
