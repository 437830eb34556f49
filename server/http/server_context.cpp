#include "server/http/server_context.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <utility>

#include "common/base/log_request.h"
#include "server/http/error_response.h"
#include "server/http/site.h"

namespace enamel::server::http {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

// Also for the proxy itself.
bool IsHealthPath(std::string_view path) {
  return path == "/livez" || path == "/readyz" || path == "/healthz";
}

}  // namespace

ServerContext::ServerContext(HttpOptions given, Store& store, auth::Authenticator& authenticator)
    : options(std::move(given)),
      api(std::make_shared<Api>(
          store, authenticator,
          Monitoring{options.metrics, options.metrics_token, options.peers, options.budgets_used},
          options.store_threads, options.max_in_flight, options.deadlines.work, options.budgets)),
      coming(options.bodies
                 ? options.bodies
                 : std::make_shared<HeldBytes>(ops::LimitOf(ops::kBodies, options.budgets))) {
  if (options.live) api->Show(*options.live);
  if (options.first_admin) api->Show(*options.first_admin);
  if (options.stations) api->Show(*options.stations);
  api->BackUpInto(options.backups);
  api->Enrol(options.station_fingerprint);
}

namespace {

constexpr const char* kRequestIdHeader = "X-Request-Id";

// The proxy's, so that its log and ours name it alike; others' own would let them choose what our
// log says.
std::string IdOf(const Request& request, bool from_proxy) {
  const std::string_view given = request.Header("x-request-id");
  return from_proxy && LogRequest::IsId(given) ? std::string(given) : LogRequest::NewId();
}

}  // namespace

void ServerContext::NoteRefusal(const std::string& peer, const std::string& reason) {
  refusals.Note(peer + " " + reason.substr(0, reason.find(' ')),
                "page: refused a peer at " + peer + ": " + reason);
}

asio::awaitable<Response> ServerContext::Answer(Request request) {
  Status known;
  const std::string peer = request.peer;
  const bool proxied = !options.trusted_proxies.empty() && !IsHealthPath(request.path);
  if (proxied) known = TakeFromProxy(options.trusted_proxies, request);
  const std::string id = request.id = IdOf(request, proxied && known.ok());
  Response response;
  if (known.ok()) {
    response = co_await AnswerKnown(std::move(request));
  } else {
    const LogRequest logged(id);
    NoteRefusal(peer, "403 " + known.message());
    response = ErrorResponse(known);
  }
  response.headers.emplace_back(kRequestIdHeader, id);
  co_return response;
}

asio::awaitable<Response> ServerContext::AnswerKnown(Request request) {
  std::shared_ptr<Api> asked = api;
  std::optional<OtherSchool> other;
  const bool own = HostAllowed(request.Header("host"), options.host_names);
  if (!own && options.other_schools) {
    other = options.other_schools(HostNameOf(request.Header("host")));
  }
  if (other) {
    asked = other->api;
    request.school_ended = other->ended;
  }
  // Against DNS rebinding: somebody else's name that points here gets no answer that its page could
  // read.
  if (!own && !other) {
    const LogRequest logged(request.id);
    NoteRefusal(request.peer, "421 the host it asked for is not one of this server's names");
    co_return ErrorResponse(421, "misdirected",
                            "expected a host name of this server, found " +
                                std::string(request.Header("host")) +
                                "; open the page under its own address",
                            "host");
  }
  if (Api::Owns(request.path) && !asked) {
    co_return ErrorResponse(
        {Code::kUnavailable, other->suspended
                                 ? "this school is suspended; ask the person who runs the server"
                                 : "this school cannot be reached at the moment; try again later"});
  }
  if (Api::Owns(request.path)) co_return co_await asked->Handle(std::move(request));
  if (files) co_return files->Serve(request);
  co_return ErrorResponse(Status{Code::kNotFound,
                                 "this server was started without the page; start it with --web "
                                 "and the folder of the built page, "
                                 "such as --web web/dist"});
}

std::string ServerContext::PeerOf(const Request& request, const std::string& peer) const {
  const auto& proxies = options.trusted_proxies;
  if (std::ranges::find(proxies, peer) == proxies.end()) return peer;
  return ForwardedFor(request).value_or(peer);
}

Status ServerContext::Prepare() {
  error_code error;
  asio::ip::address address = asio::ip::make_address(options.address, error);
  if (error) {
    return {Code::kInvalidInput,
            "expected a numeric address such as 127.0.0.1, found '" + options.address + "'",
            "address"};
  }
  if (!address.is_loopback() && !options.tls && options.trusted_proxies.empty()) {
    return {
        Code::kInvalidInput,
        "expected TLS for " + options.address +
            ": passwords do not travel in the clear; give a certificate and key, name the proxy "
            "that speaks TLS to the browsers, or listen on 127.0.0.1",
        "address"};
  }
  for (const std::string& proxy : options.trusted_proxies) {
    // In the spelling in which a peer's address is shown: they are compared as text.
    if (asio::ip::make_address(proxy, error).to_string() == proxy && !error) continue;
    return {Code::kInvalidInput,
            "expected a proxy's numeric address such as 10.0.0.5, found '" + proxy + "'",
            "trusted_proxies"};
  }
  bool reached_from_afar = !address.is_loopback() || !options.trusted_proxies.empty();
  if (options.host_names.empty() && reached_from_afar) {
    return {Code::kInvalidInput, "expected the host names the page is opened under", "host_names"};
  }
  if (options.host_names.empty()) options.host_names = {"127.0.0.1", "localhost", "[::1]"};
  if (options.tls) {
    ENAMEL_ASSIGN_OR_RETURN(tls, PageTls::Load(*options.tls));
  }
  if (!options.web_root.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(StaticFiles loaded, StaticFiles::Load(options.web_root));
    files = std::move(loaded);
  }
  return {};
}

}  // namespace enamel::server::http
