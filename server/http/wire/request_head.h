#pragma once

#include <cstddef>
#include <string_view>

#include "common/base/result.h"

// The strict look at a request's raw head, before any parser sees it: a request that two programs
// could cut into messages in two ways (request smuggling) is refused, not repaired. Stricter than
// RFC 9112 wherever being generous gains nothing, because the only clients are browsers and tools.
// Source: RFC 9110, RFC 9112; verdicts of the http-desync-guardian suite in the tests.
namespace enamel::server::http {

// Whether a connection begins with another protocol than HTTP/1.1, as a wrongly set proxy or client
// sends it: TLS, the PROXY protocol (either version), HTTP/2. Says what to do. Ok also while too
// little has come to tell: kLongestOpening bytes are enough.
inline constexpr size_t kLongestOpening = 14;
Status NotAnotherProtocol(std::string_view bytes);
// Where the head ends (one past its last byte), or npos when more bytes are needed. It ends at the
// first empty line, however that is spelt, and at the first byte that no head contains, so that the
// check below sees both at once. Scans from `from`, an earlier size of the same buffer or 0.
size_t FindHeadEnd(std::string_view bytes, size_t from = 0);

// `head` up to and including the empty line. Accepts exactly:
//   METHOD SP target SP HTTP/1.1 CRLF (or HTTP/1.0), `name: value` CRLF lines, then CRLF;
//   the target is /path?query, http(s)://host/path with the Host it names, or * with OPTIONS;
//   it has no space and no control character (TakeTarget encodes what a browser would have);
//   names are tokens, values visible ASCII, space, tab and 0x80-0xFF; no folding, no lone CR or LF;
//   exactly one Host; at most one Content-Length of decimal digits, or one Transfer-Encoding that
//   is "chunked", never both, neither with GET, HEAD (a length of 0 is accepted), no
//   Transfer-Encoding with HTTP/1.0; nothing that resembles those two names without being one.
//
// The suite calls these acceptable:
//   GetHeadZeroContentLength   accepted: some clients send it, and both readings are the same
//   NonCompliantHeader         refused: spaces and control characters in names and values
//   NonCompliantVersion        refused: HTTP/0.9 and none, spaces after the version; 1.2: see below
//   SpaceInUri                 refused: where the target ends is a guess
// It calls two more compliant that are refused here: an empty target, which shifts the version into
// its place, and parameters of a transfer coding, which RFC 9112 section 7.1 calls an error.
//
// Errors: kInvalidInput, field() is the header's name or "request line". kVersion for well-formed
// requests that are not spoken here: other versions ("request line"), codings of the message
// besides chunked ("transfer-encoding"), of its content ("content-encoding": nothing here
// decompresses a stranger's data).
Status CheckRequestHead(std::string_view head);

}  // namespace enamel::server::http
