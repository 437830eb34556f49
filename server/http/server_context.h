#pragma once

#include <boost/asio/awaitable.hpp>
#include <memory>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "server/http/api.h"
#include "server/http/message.h"
#include "server/http/static_files.h"
#include "server/http/wire/http_server.h"
#include "server/http/wire/page_tls.h"
#include "server/ops/repeat_log.h"

namespace enamel::server::http {

// What all connections of one server use. Thread safety: Prepare before anything else; then any
// strand.
struct ServerContext {
  ServerContext(HttpOptions given, Store& store, auth::Authenticator& authenticator);

  // Checks the options, sets the defaults, and loads certificate and page. Errors: kInvalidInput,
  // kNotFound.
  Status Prepare();

  // The answer to a request as it came from a connection: of the proxy's rules and the host names,
  // then of the API or the page. Names the request (Request::id).
  boost::asio::awaitable<Response> Answer(Request request);

  // `reason` begins with the HTTP status, which alone tells refusals apart: what follows may be
  // what the peer wrote.
  void NoteRefusal(const std::string& peer, const std::string& reason);

  // Whoever sends this request over a connection from `peer`: behind a trusted proxy, whom that
  // names.
  std::string PeerOf(const Request& request, const std::string& peer) const;

  // The browser's end of the line is TLS, here or at the proxy.
  bool secure() const { return options.tls.has_value() || !options.trusted_proxies.empty(); }

  // Constant after Prepare.
  HttpOptions options;
  std::unique_ptr<PageTls> tls;  // null: plain HTTP
  std::optional<StaticFiles> files;

  const std::shared_ptr<Api> api;
  ops::RepeatLog refusals;
  // Bodies that have begun to come, by the address that sends them: nobody is signed in for this
  // server before the whole request is here.
  const std::shared_ptr<HeldBytes> coming;

 private:
  boost::asio::awaitable<Response> AnswerKnown(Request request);
};

}  // namespace enamel::server::http
