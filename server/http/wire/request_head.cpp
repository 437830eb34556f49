#include "server/http/wire/request_head.h"

#include <algorithm>
#include <string>

namespace enamel::server::http {

using namespace std::string_literals;

namespace {

constexpr size_t kMaxLengthDigits = 18;  // below 2^63

bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsAlpha(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool IsTokenChar(char c) {
  return IsDigit(c) || IsAlpha(c) ||
         (c != '\0' && std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos);
}
bool IsToken(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), IsTokenChar);
}
bool IsValueChar(char c) {
  auto byte = static_cast<unsigned char>(c);
  return c == '\t' || (byte >= 0x20 && byte != 0x7f);
}
bool IsTargetChar(char c) {
  auto byte = static_cast<unsigned char>(c);
  return byte > 0x20 && byte != 0x7f;
}

std::string ToLower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), Lower);
  return out;
}

std::string_view Trim(std::string_view text) {
  size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

Status Refuse(std::string_view what, std::string message) {
  return {Code::kInvalidInput, std::move(message), std::string(what)};
}

// Letters only: "Content_Length" and "Transfer--Encoding" become what they imitate.
bool Imitates(std::string_view lower_name, std::string_view letters) {
  std::string kept;
  std::copy_if(lower_name.begin(), lower_name.end(), std::back_inserter(kept), IsAlpha);
  return kept == letters;
}

// RFC 9112 section 7, and "identity" of its forerunners.
bool IsCoding(std::string_view lower) {
  constexpr std::string_view kCodings[] = {"chunked",  "gzip",       "x-gzip",  "deflate",
                                           "compress", "x-compress", "identity"};
  return std::find(std::begin(kCodings), std::end(kCodings), lower) != std::end(kCodings);
}

// What the headers said about where the request ends. Collected first and judged at the end: each
// of several contradictions is a refusal, in whatever order they came.
struct Framing {
  bool bodyless = false;  // GET, HEAD
  bool old = false;       // HTTP/1.0
  std::string authority;  // of an absolute target, lower case
  std::string host;       // lower case
  bool has_host = false;
  bool length = false;
  bool nonzero_length = false;
  bool coding = false;
  bool chunked = false;
  bool other_coding = false;
  bool packed = false;  // Content-Encoding
};

// Well-formed, and nothing that this server speaks: 501, 505 or 415, not 400.
Status Unspoken(std::string_view what, std::string message) {
  return {Code::kVersion, std::move(message), std::string(what)};
}

Status TakeLength(std::string_view value, Framing& framing) {
  // Also a second one with the same number, which RFC 9112 would let pass: a proxy before us may
  // have used either.
  if (framing.length)
    return Refuse("content-length", "expected one Content-Length, found a second");
  bool digits = !value.empty() && std::all_of(value.begin(), value.end(), IsDigit);
  if (!digits || value.size() > kMaxLengthDigits) {
    return Refuse("content-length", "expected a decimal number of bytes as Content-Length");
  }
  framing.length = true;
  framing.nonzero_length = value.find_first_not_of('0') != std::string_view::npos;
  return {};
}

Status TakeCodings(std::string_view value, Framing& framing) {
  framing.coding = true;
  for (bool more = true; more;) {
    size_t end = value.find(',');
    more = end != std::string_view::npos;
    std::string coding = ToLower(Trim(value.substr(0, end)));
    value.remove_prefix(more ? end + 1 : value.size());
    if (framing.chunked || !IsCoding(coding)) {
      return Refuse("transfer-encoding", "expected chunked, once, as the last Transfer-Encoding");
    }
    (coding == "chunked" ? framing.chunked : framing.other_coding) = true;
  }
  return {};
}

Status TakeHeader(std::string_view line, Framing& framing) {
  size_t colon = line.find(':');
  if (colon == std::string_view::npos || !IsToken(line.substr(0, colon))) {
    return Refuse("header", "expected lines of the form 'name: value' with a token as name");
  }
  std::string name = ToLower(line.substr(0, colon));
  std::string_view value = Trim(line.substr(colon + 1));
  if (!std::all_of(value.begin(), value.end(), IsValueChar)) {
    return Refuse(name, "expected no control characters in a header's value");
  }
  if (name == "content-length") return TakeLength(value, framing);
  if (name == "transfer-encoding") return TakeCodings(value, framing);
  if (Imitates(name, "contentlength") || Imitates(name, "transferencoding")) {
    return Refuse(name, "expected Content-Length or Transfer-Encoding, found a misspelt one");
  }
  if (name == "host") {
    if (framing.has_host) return Refuse(name, "expected one Host, found a second");
    framing.has_host = true;
    framing.host = ToLower(value);
  }
  if (name == "content-encoding" && ToLower(value) != "identity") framing.packed = true;
  return {};
}

Status CheckTarget(std::string_view method, std::string_view target, Framing& framing) {
  constexpr std::string_view kField = "request line";
  if (!std::all_of(target.begin(), target.end(), IsTargetChar)) {
    return Refuse(kField, "expected a path without spaces and control characters");
  }
  if (target.starts_with('/') || (target == "*" && method == "OPTIONS")) return {};
  std::string lower = ToLower(target);
  for (std::string_view scheme : {"http://", "https://"}) {
    if (!lower.starts_with(scheme)) continue;
    size_t end = std::min(lower.find_first_of("/?#", scheme.size()), lower.size());
    framing.authority = lower.substr(scheme.size(), end - scheme.size());
    if (!framing.authority.empty()) return {};
  }
  return Refuse(kField, "expected a path that starts with '/'; this server is no proxy");
}

Status CheckVersion(std::string_view version, Framing& framing) {
  constexpr std::string_view kName = "HTTP/";
  if (version == "HTTP/1.1") return {};
  framing.old = version == "HTTP/1.0";
  if (framing.old) return {};
  bool well_formed = version.size() == 8 && version.starts_with(kName) && IsDigit(version[5]) &&
                     version[6] == '.' && IsDigit(version[7]);
  bool later = well_formed && version[5] != '0';
  return later ? Unspoken("request line", "expected version HTTP/1.1 or HTTP/1.0")
               : Refuse("request line", "expected version HTTP/1.1");
}

Status CheckRequestLine(std::string_view line, Framing& framing) {
  constexpr std::string_view kField = "request line";
  size_t first = line.find(' ');
  // First and last space: one within the target is then refused as part of it.
  size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) {
    return Refuse(kField, "expected 'METHOD /path HTTP/1.1'");
  }
  std::string_view method = line.substr(0, first);
  if (!IsToken(method)) return Refuse(kField, "expected a token as method");
  framing.bodyless = method == "GET" || method == "HEAD";
  ENAMEL_RETURN_IF_ERROR(CheckTarget(method, line.substr(first + 1, last - first - 1), framing));
  return CheckVersion(line.substr(last + 1), framing);
}

Status CheckFraming(const Framing& framing) {
  if (!framing.has_host) return Refuse("host", "expected a Host header, found none");
  // RFC 9112 would let the request line win. A proxy that goes by Host would have sent the request
  // elsewhere.
  if (!framing.authority.empty() && framing.authority != framing.host) {
    return Refuse("host", "expected the Host that the request line names, found another");
  }
  if (framing.length && framing.coding) {
    return Refuse("transfer-encoding", "expected Content-Length or Transfer-Encoding, found both");
  }
  if (framing.bodyless && (framing.nonzero_length || framing.coding)) {
    return Refuse("content-length", "expected no body with GET and HEAD");
  }
  if (framing.old && framing.coding) {
    return Refuse("transfer-encoding", "expected no Transfer-Encoding with HTTP/1.0");
  }
  if (framing.coding && !framing.chunked) {
    return Refuse("transfer-encoding", "expected chunked as the last Transfer-Encoding");
  }
  if (framing.other_coding) {
    return Unspoken("transfer-encoding", "expected chunked as the only Transfer-Encoding");
  }
  if (framing.packed)
    return Unspoken("content-encoding", "expected a body without Content-Encoding");
  return {};
}

}  // namespace

Status NotAnotherProtocol(std::string_view bytes) {
  // RFC 8446, 5.1: a record of the kind handshake.
  if (bytes.starts_with("\x16\x03")) {
    return Refuse("tls",
                  "expected HTTP, found TLS; this port speaks plain HTTP: use http://, or give "
                  "the server a certificate");
  }
  // The PROXY protocol, versions 1 and 2, section 2.
  if (bytes.starts_with("PROXY ") || bytes.starts_with("\r\n\r\n\0\r\nQUIT\n"s)) {
    return Refuse("proxy",
                  "expected HTTP, found the PROXY protocol; switch it off for this port: the "
                  "proxy names its peer in X-Forwarded-For");
  }
  // RFC 9113, 3.4.
  if (bytes.starts_with("PRI * HTTP/2.0"))
    return Refuse("http2", "expected HTTP/1.1, found HTTP/2; let the proxy speak HTTP/1.1");
  return Status::Ok();
}

size_t FindHeadEnd(std::string_view bytes, size_t from) {
  for (size_t i = from; i < bytes.size(); ++i) {
    char c = bytes[i];
    // A byte that no head may have ends the search: CheckRequestHead then refuses it, and nobody
    // waits for a head's end that may never come.
    if (c != '\r' && c != '\n' && !IsValueChar(c)) return i + 1;
    if (c != '\n') continue;
    if (i >= 1 && bytes[i - 1] == '\n') return i + 1;
    if (i >= 2 && bytes[i - 1] == '\r' && bytes[i - 2] == '\n') return i + 1;
  }
  return std::string_view::npos;
}

Status CheckRequestHead(std::string_view head) {
  bool first = true;
  Framing framing;
  while (!head.empty()) {
    size_t end = head.find("\r\n");
    if (end == std::string_view::npos) {
      return Refuse("header", "expected every line to end with CR LF, and no control characters");
    }
    std::string_view line = head.substr(0, end);
    head.remove_prefix(end + 2);
    if (line.find_first_of("\r\n") != std::string_view::npos) {
      return Refuse("header", "expected every line to end with CR LF, found a lone CR or LF");
    }
    if (first) {
      ENAMEL_RETURN_IF_ERROR(CheckRequestLine(line, framing));
      first = false;
    } else if (line.empty()) {
      return head.empty() ? CheckFraming(framing)
                          : Refuse("header", "expected nothing after the empty line");
    } else {
      ENAMEL_RETURN_IF_ERROR(TakeHeader(line, framing));
    }
  }
  return Refuse("header", "expected an empty line after the headers");
}

}  // namespace enamel::server::http
