#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "server/http/message.h"

namespace enamel::server::http {

// Status line and headers of an answer as sent (HTTP/1.1, RFC 9112), including the empty line.
// `length`: Content-Length; none: the head names no length. Without `keep_alive` it has
// "Connection: close". A header with a line end in its name or value would let somebody else add
// headers: it is left out and logged.
std::string HeadText(const Response& response, bool keep_alive, std::optional<size_t> length);

}  // namespace enamel::server::http
