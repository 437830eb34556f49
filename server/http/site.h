#pragma once

#include <ctime>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "server/http/message.h"

// What ties a request to this site: host name, origin, cookie; and what every answer says to the
// browser. Pure functions; any thread. Source: OWASP ASVS 5.0, Fetch Metadata.
namespace enamel::server::http {

// In lower case, without port; empty: the header names no host.
std::string HostNameOf(std::string_view host_header);

// True when the Host header names one of `allowed` (lower case, without port; IPv6 in brackets): a
// page of another name that was made to resolve to this address (DNS rebinding) is no page of ours.
bool HostAllowed(std::string_view host_header, const std::vector<std::string>& allowed);

// For requests that change something. Errors: kForbidden when Origin is not the host the request
// was sent to, or Sec-Fetch-Site says that another site made it. Neither header: not a browser,
// accepted.
Status CheckSameSite(const Request& request);

// The last address of X-Forwarded-For, in the spelling in which a peer's is shown; none: there is no
// address. Means something only where a trusted proxy has sent the request.
std::optional<std::string> ForwardedFor(const Request& request);

// For a server that only a proxy talks to: checks that the peer is one of `proxies` (numeric
// addresses), and puts the proxy's peer into the request: the last address of X-Forwarded-For, and
// TLS, which X-Forwarded-Proto must confirm. Errors: kForbidden. A proxy that is not set up for
// this would make everybody one peer, with the machine's own address.
Status TakeFromProxy(const std::vector<std::string>& proxies, Request& request);

// "enamel_session"; over TLS "__Host-enamel_session", which no other host or plain page can set.
std::string SessionCookieName(bool tls);
// The session cookie's value; none when absent, and when given more than once.
std::optional<std::string> SessionCookie(const Request& request);
// Value of Set-Cookie. An empty token removes the cookie.
std::string SetSessionCookie(const std::string& token_hex, bool tls);
// auth::DeviceTokens of the browser; none: empty. Kept over sign-out and the end of the browser.
std::string DeviceCookie(const Request& request);
std::string SetDeviceCookie(const std::string& tokens, bool tls);

// Adds what every answer carries: the date; content security policy, with no policy that could make
// markup of text; isolation, no sniffing, no referrer; HSTS over TLS; `Cache-Control: no-store`
// unless the answer has a Cache-Control of its own, and `no-transform` where bytes or time matter;
// of events, that no proxy holds them back.
void AddCommonHeaders(Response& response, bool tls);

// As RFC 9110, 5.6.7, wants it: "Sun, 06 Nov 1994 08:49:37 GMT".
std::string HttpDate(std::time_t when);

}  // namespace enamel::server::http
