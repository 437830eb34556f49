#include <algorithm>

#include "common/base/check.h"
#include "server/net/proxy_header.h"

// A proxy's header, before all other data: the start, and then the length given in it.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel::server;
  if (size < kProxyStartBytes) return 0;
  const std::span<const uint8_t> bytes(data, size);
  const auto start = ReadProxyStart(bytes.first<kProxyStartBytes>());
  if (!start.ok()) return 0;
  ENAMEL_CHECK(start->rest_bytes <= kMaxProxyRestBytes);
  const auto rest = bytes.subspan(kProxyStartBytes);
  const auto peer = ReadProxyPeer(*start, rest.first(std::min(rest.size(), start->rest_bytes)));
  // The longest numeric address.
  if (peer.ok()) ENAMEL_CHECK(peer->size() <= 45);
  return 0;
}
