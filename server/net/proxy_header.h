#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/base/result.h"

// The PROXY protocol, version 2: a proxy that passes bytes on unread first names its own peer. Read
// only from listed proxies: anybody else could claim any address. Source: W. Tarreau, "The PROXY
// protocol, versions 1 & 2", HAProxy, section 2.2. Pure, any thread.
namespace enamel::server {

inline constexpr size_t kProxyStartBytes = 16;
// What TLS begins with instead (RFC 8446, section 5.1).
inline constexpr uint8_t kTlsHandshake = 22;
// What follows the start: addresses and whatever else the proxy says, which is not looked at. The
// protocol allows 65 535; HAProxy with every option it has stays below this.
inline constexpr size_t kMaxProxyRestBytes = 2'048;

struct ProxyStart {
  // The proxy itself connects, to see whether the server is up.
  bool is_own = false;
  uint8_t family = 0;     // of the addresses, and their transport, as in the bytes
  size_t rest_bytes = 0;  // that follow, at most kMaxProxyRestBytes
};

// Errors: kInvalidInput naming the bytes found, such as version 1.
Result<ProxyStart> ReadProxyStart(std::span<const uint8_t, kProxyStartBytes> bytes);

// The numeric address that the proxy was asked from; empty if the proxy itself connects or does not
// know it. Errors: kInvalidInput for a family that station links do not use, or fewer bytes than
// its addresses take.
Result<std::string> ReadProxyPeer(const ProxyStart& start, std::span<const uint8_t> rest);

}  // namespace enamel::server
