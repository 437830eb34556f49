#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "server/http/message.h"

namespace enamel::server::http {

// Status line and headers of an answer as they travel (HTTP/1.1, RFC 9112), up to and with the
// empty line. `length`: Content-Length; none: the head names no length. Without `keep_alive` it
// says "Connection: close". A header with a line end in its name or value would become a header of
// somebody else's choice: it is left out, and the log says so.
std::string HeadText(const Response& response, bool keep_alive, std::optional<size_t> length);

}  // namespace enamel::server::http
