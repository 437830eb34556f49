#pragma once

#include <string>

namespace enamel::server::auth {

// The text that identifies one peer: an IPv4 address by itself, an IPv6 address by its /64, all of
// which one machine may use. An IPv4 address mapped into IPv6 (::ffff:203.0.113.7, as a socket that
// listens on [::] shows it) is that IPv4 address. "203.0.113.7" -> "203.0.113.7"; "2001:db8:1:2::3"
// -> "2001:db8:1:2::/64"; other text unchanged, at most 64 bytes. Any thread.
std::string AddressBlock(const std::string& address);

// What one party may hold many blocks of: the /48 of an IPv6 address. Everything else is its own
// AddressBlock.
std::string AddressSite(const std::string& address);

// The same with nothing in it that an address does not have: fit for a log and for a JSON string.
std::string AddressText(const std::string& address);

}  // namespace enamel::server::auth
