#include "server/auth/address_block.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace enamel::server::auth {
namespace {

std::string Text(int family, const void* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(family, address, text.data(), text.size());
  return text.data();
}

// The IPv6 address with nothing after the first `bytes`.
std::string Prefix(const std::string& address, int bytes) {
  in6_addr v6{};
  // IPv4, or a name in a test: a block of its own, bounded because it becomes a key.
  if (inet_pton(AF_INET6, address.c_str(), &v6) != 1) return address.substr(0, 64);
  // A listener on [::] sees IPv4 peers so; they are the same peers.
  if (IN6_IS_ADDR_V4MAPPED(&v6)) return Text(AF_INET, std::begin(v6.s6_addr) + 12);
  std::fill(std::begin(v6.s6_addr) + bytes, std::end(v6.s6_addr), uint8_t{0});
  return Text(AF_INET6, &v6) + "/" + std::to_string(8 * bytes);
}

}  // namespace

// One computer or household gets a /64: it can use another address of it for each guess.
std::string AddressBlock(const std::string& address) { return Prefix(address, 8); }

// A company gets a /48 for the asking, and some households do: 65 536 blocks.
std::string AddressSite(const std::string& address) { return Prefix(address, 6); }

std::string AddressText(const std::string& address) {
  std::string text = AddressBlock(address);
  // The result is safe in a log line and inside JSON quotes, whatever a proxy passed on.
  std::erase_if(text, [](unsigned char c) {
    return std::isalnum(c) == 0 && c != '.' && c != ':' && c != '/' && c != '%';
  });
  return text;
}

}  // namespace enamel::server::auth
