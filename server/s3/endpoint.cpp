#include "server/s3/endpoint.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "common/base/utf8.h"

namespace enamel::s3 {

bool IsSimple(const std::string& text, const char* others, size_t most) {
  auto may = [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::strchr(others, c) != nullptr;
  };
  return !text.empty() && text.size() <= most && std::ranges::all_of(text, may);
}

Result<Place> PlaceOf(const std::string& endpoint) {
  Place out;
  std::string_view rest = endpoint;
  out.secure = rest.starts_with("https://");
  if (!out.secure && !rest.starts_with("http://")) {
    return Status(
        Code::kInvalidInput,
        "expected an endpoint like https://s3.example.org, found \"" + Printable(endpoint) + "\"",
        "endpoint");
  }
  rest.remove_prefix(out.secure ? 8 : 7);
  if (rest.ends_with('/')) rest.remove_suffix(1);
  out.host = rest;
  if (!IsSimple(out.host, ".-:[]", 300)) {
    return Status(Code::kInvalidInput,
                  "expected an endpoint of scheme, host and port alone, like "
                  "https://s3.example.org, found \"" +
                      Printable(endpoint) + "\"; buckets are named apart",
                  "endpoint");
  }
  // The default port is not in the header Host, which is signed.
  const std::string usual = out.secure ? ":443" : ":80";
  if (out.host.ends_with(usual)) out.host.resize(out.host.size() - usual.size());
  const bool here = out.host == "localhost" || out.host.starts_with("localhost:") ||
                    out.host == "[::1]" || out.host.starts_with("[::1]:") ||
                    (out.host.starts_with("127.") && IsSimple(out.host, ".:", 30) &&
                     out.host.find_first_not_of("0123456789.:") == std::string::npos);
  if (!out.secure && !here) {
    return Status(Code::kInvalidInput,
                  "expected an endpoint with https://, found \"" + Printable(endpoint) +
                      "\"; only a store on this machine may be used without TLS",
                  "endpoint");
  }
  return out;
}

}  // namespace enamel::s3
