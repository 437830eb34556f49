#include "server/http/site.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cstdio>
#include <utility>

#include "server/auth/device_tokens.h"

namespace enamel::server::http {
namespace {

constexpr std::pair<const char*, const char*> kSecurityHeaders[] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
     "font-src 'self'; connect-src 'self'; worker-src 'self'; manifest-src 'self'; "
     "frame-ancestors 'none'; base-uri 'none'; object-src 'none'; form-action 'self'; "
     // One policy, and nobody can make it again: web/src/tooth/link.ts lets it name the script
     // of its worker and nothing else.
     "require-trusted-types-for 'script'; trusted-types enamel-worker"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Embedder-Policy", "require-corp"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Permissions-Policy",
     "camera=(), display-capture=(), geolocation=(), hid=(), microphone=(), midi=(), payment=(), "
     "serial=(), usb=()"},
};
constexpr const char* kHsts = "max-age=31536000; includeSubDomains";

std::string ToLower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return out;
}

bool IsPort(std::string_view text) {
  return !text.empty() && text.size() <= 5 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Without the port; empty when there is no valid one after the colon.
std::string_view HostName(std::string_view host) {
  size_t end = !host.empty() && host.front() == '[' ? host.find(']') : host.find(':');
  if (end == std::string_view::npos) return host.empty() || host.front() != '[' ? host : "";
  if (host.front() == '[') ++end;
  if (end == host.size()) return host;
  if (host[end] != ':' || !IsPort(host.substr(end + 1))) return "";
  return host.substr(0, end);
}

std::string_view Trim(std::string_view text) {
  size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

// A proxy may compress text. Clients compare recordings, archives and pictures by their bytes and
// read parts of them. An event comes late where a proxy collects several to compress them.
bool MayBeTransformed(const Response& response) {
  const std::string_view type = response.content_type;
  return !response.events && (type.empty() || type.starts_with("text/") ||
                              type == "application/json" || type == "image/svg+xml");
}

}  // namespace

std::string HostNameOf(std::string_view host_header) { return ToLower(HostName(host_header)); }

bool HostAllowed(std::string_view host_header, const std::vector<std::string>& allowed) {
  const std::string name = HostNameOf(host_header);
  return !name.empty() && std::find(allowed.begin(), allowed.end(), name) != allowed.end();
}

Status CheckSameSite(const Request& request) {
  std::string_view site = request.Header("sec-fetch-site");
  // Browsers write this header and pages cannot. Programs leave it out, and have no cookie that a
  // foreign page could use. "none": typed or from a bookmark.
  if (!site.empty() && site != "same-origin" && site != "none") {
    return {Code::kForbidden,
            "expected a request from this server's own page, found one from " + std::string(site) +
                "; open the page itself and try again",
            "sec-fetch-site"};
  }
  // For browsers that know no Sec-Fetch-Site. Behind a proxy `tls` and the host are what the
  // browser sees: TakeFromProxy has set them.
  std::string_view origin = request.Header("origin");
  std::string own = (request.tls ? "https://" : "http://") + std::string(request.Header("host"));
  if (!origin.empty() && ToLower(origin) != ToLower(own)) {
    return {Code::kForbidden,
            "expected origin " + own + ", found " + std::string(origin) +
                "; open the page itself and try again",
            "origin"};
  }
  return {};
}

std::optional<std::string> ForwardedFor(const Request& request) {
  const std::string_view passed = request.Header("x-forwarded-for");
  // The last one, which our proxy appended. Those in front of it are what the client claimed.
  const std::string_view last = Trim(passed.substr(passed.rfind(',') + 1));
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(last, error);
  if (error) return std::nullopt;
  return address.to_string();
}

Status TakeFromProxy(const std::vector<std::string>& proxies, Request& request) {
  if (std::find(proxies.begin(), proxies.end(), request.peer) == proxies.end()) {
    return {Code::kForbidden, "expected the proxy in front of this server; open the page there"};
  }
  if (request.Header("x-forwarded-proto") != "https") {
    return {
        Code::kForbidden,
        "expected the proxy to say X-Forwarded-Proto: https; let it serve the page over TLS and "
        "set that header",
        "x-forwarded-proto"};
  }
  const auto address = ForwardedFor(request);
  if (!address) {
    return {Code::kForbidden,
            "expected the proxy to end X-Forwarded-For with the address it was asked from; let it "
            "set that header",
            "x-forwarded-for"};
  }
  request.peer = *address;
  request.tls = true;
  return {};
}

namespace {

std::string CookieName(std::string_view name, bool tls) {
  return (tls ? "__Host-" : "") + std::string(name);
}

std::optional<std::string> Cookie(const Request& request, const std::string& name) {
  std::optional<std::string> found;
  std::string_view rest = request.Header("cookie");
  while (!rest.empty()) {
    size_t end = std::min(rest.find(';'), rest.size());
    std::string_view pair = Trim(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    size_t equals = pair.find('=');
    if (equals == std::string_view::npos || pair.substr(0, equals) != name) continue;
    // Twice: one was planted by a neighbouring site under the same domain, and nobody can say
    // which.
    if (found) return std::nullopt;
    found = std::string(pair.substr(equals + 1));
  }
  return found;
}

std::string SetCookie(const std::string& name, const std::string& value, bool tls) {
  return name + "=" + value + "; Path=/; HttpOnly; SameSite=Strict" + (tls ? "; Secure" : "");
}

}  // namespace

std::string SessionCookieName(bool tls) { return CookieName("enamel_session", tls); }

std::optional<std::string> SessionCookie(const Request& request) {
  return Cookie(request, SessionCookieName(request.tls));
}

std::string SetSessionCookie(const std::string& token_hex, bool tls) {
  // No Max-Age: it ends with the browser, and at the latest when the session does.
  return SetCookie(SessionCookieName(tls), token_hex, tls) +
         (token_hex.empty() ? "; Max-Age=0" : "");
}

std::string DeviceCookie(const Request& request) {
  return Cookie(request, CookieName("enamel_device", request.tls)).value_or("");
}

std::string SetDeviceCookie(const std::string& tokens, bool tls) {
  return SetCookie(CookieName("enamel_device", tls), tokens, tls) +
         "; Max-Age=" + std::to_string(auth::DeviceTokens::kDays * 24 * 60 * 60);
}

void AddCommonHeaders(Response& response, bool tls) {
  response.headers.emplace_back("Date", HttpDate(std::time(nullptr)));
  for (const auto& [name, value] : kSecurityHeaders) response.headers.emplace_back(name, value);
  if (tls) response.headers.emplace_back("Strict-Transport-Security", kHsts);
  auto caching = std::ranges::find(response.headers, "Cache-Control",
                                   &std::pair<std::string, std::string>::first);
  if (caching == response.headers.end()) {
    caching = response.headers.insert(caching, {"Cache-Control", "no-store"});
  }
  if (!MayBeTransformed(response)) caching->second += ", no-transform";
  // nginx otherwise collects an answer, and shows the first event of a live view seconds late.
  if (response.events) response.headers.emplace_back("X-Accel-Buffering", "no");
}

std::string HttpDate(std::time_t when) {
  // Not strftime: its names follow the locale.
  constexpr const char* kDays[] = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  constexpr const char* kMonths[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                     "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  std::tm t{};
  gmtime_r(&when, &t);
  char text[40];
  std::snprintf(text, sizeof text, "%s, %02d %s %04d %02d:%02d:%02d GMT", kDays[t.tm_wday],
                t.tm_mday, kMonths[t.tm_mon], t.tm_year + 1900, t.tm_hour, t.tm_min, t.tm_sec);
  return text;
}

}  // namespace enamel::server::http
