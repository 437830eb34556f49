#pragma once

#include <cstddef>
#include <string_view>

#include "common/base/result.h"

// The strict look at a request's raw head, before any parser sees it: a request that two programs
// could cut into messages in two ways (request smuggling) is refused, not repaired. Stricter than
// RFC 9112 wherever being generous gains nothing, because the only clients are browsers and tools.
// Source: RFC 9110, RFC 9112; verdicts of the http-desync-guardian suite in the tests.
namespace enamel::server::http {

// Where the head ends (one past its last byte), or npos when more bytes are needed. It ends at the
// first empty line, however that is spelt, and at the first byte that no head contains, so that the
// check below sees both at once. Scans from `from`, an earlier size of the same buffer or 0.
size_t FindHeadEnd(std::string_view bytes, size_t from = 0);

// `head` up to and including the empty line. Accepts exactly:
//   METHOD SP /target SP HTTP/1.1 CRLF, then `name: value` CRLF lines, then CRLF;
//   names are tokens, values visible ASCII, space, tab and 0x80-0xFF; no folding, no lone CR or LF;
//   exactly one Host; at most one Content-Length of decimal digits, or one Transfer-Encoding that
//   is "chunked", never both, neither with GET, HEAD (a length of 0 is accepted); nothing that
//   resembles those two names without being one.
// Errors: kInvalidInput, field() is the header's name or "request line".
Status CheckRequestHead(std::string_view head);

}  // namespace enamel::server::http
