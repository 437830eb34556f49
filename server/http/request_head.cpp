#include "server/http/request_head.h"

#include <algorithm>
#include <string>

namespace enamel::server::http {
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
// RFC 3986 without the fragment; what a browser encodes must come encoded.
bool IsTargetChar(char c) { return c > 0x20 && c < 0x7f && c != '#'; }

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

struct Framing {
  bool host = false;
  bool length = false;
  bool nonzero_length = false;
  bool chunked = false;
};

Status TakeLength(std::string_view value, Framing& framing) {
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

Status TakeCoding(std::string_view value, Framing& framing) {
  if (framing.chunked) {
    return Refuse("transfer-encoding", "expected one Transfer-Encoding, found a second");
  }
  if (ToLower(value) != "chunked") {
    return Refuse("transfer-encoding", "expected chunked as the only Transfer-Encoding");
  }
  framing.chunked = true;
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
  if (name == "transfer-encoding") return TakeCoding(value, framing);
  if (Imitates(name, "contentlength") || Imitates(name, "transferencoding")) {
    return Refuse(name, "expected Content-Length or Transfer-Encoding, found an imitation");
  }
  if (name == "host") {
    if (framing.host) return Refuse(name, "expected one Host, found a second");
    framing.host = true;
  }
  return {};
}

Status CheckRequestLine(std::string_view line, bool& bodyless) {
  constexpr std::string_view kField = "request line";
  size_t first = line.find(' ');
  size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) {
    return Refuse(kField, "expected 'METHOD /path HTTP/1.1'");
  }
  std::string_view method = line.substr(0, first);
  std::string_view target = line.substr(first + 1, last - first - 1);
  if (!IsToken(method)) return Refuse(kField, "expected a token as method");
  if (line.substr(last + 1) != "HTTP/1.1") return Refuse(kField, "expected version HTTP/1.1");
  if (target.empty() || target[0] != '/') {
    return Refuse(kField, "expected a path that starts with '/'; this server is no proxy");
  }
  if (!std::all_of(target.begin(), target.end(), IsTargetChar)) {
    return Refuse(kField, "expected a percent-encoded path without spaces and fragment");
  }
  bodyless = method == "GET" || method == "HEAD";
  return {};
}

Status CheckFraming(const Framing& framing, bool bodyless) {
  if (!framing.host) return Refuse("host", "expected a Host header, found none");
  if (framing.length && framing.chunked) {
    return Refuse("transfer-encoding", "expected Content-Length or Transfer-Encoding, found both");
  }
  if (bodyless && (framing.nonzero_length || framing.chunked)) {
    return Refuse("content-length", "expected no body with GET and HEAD");
  }
  return {};
}

}  // namespace

size_t FindHeadEnd(std::string_view bytes, size_t from) {
  for (size_t i = from; i < bytes.size(); ++i) {
    char c = bytes[i];
    if (c != '\r' && c != '\n' && !IsValueChar(c)) return i + 1;
    if (c != '\n') continue;
    if (i >= 1 && bytes[i - 1] == '\n') return i + 1;
    if (i >= 2 && bytes[i - 1] == '\r' && bytes[i - 2] == '\n') return i + 1;
  }
  return std::string_view::npos;
}

Status CheckRequestHead(std::string_view head) {
  bool bodyless = false;
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
      ENAMEL_RETURN_IF_ERROR(CheckRequestLine(line, bodyless));
      first = false;
    } else if (line.empty()) {
      return head.empty() ? CheckFraming(framing, bodyless)
                          : Refuse("header", "expected nothing after the empty line");
    } else {
      ENAMEL_RETURN_IF_ERROR(TakeHeader(line, framing));
    }
  }
  return Refuse("header", "expected an empty line after the headers");
}

}  // namespace enamel::server::http
