#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <memory>

#include "server/http/server_context.h"
#include "server/net/listener.h"

namespace enamel::server::http {

// One browser's connection, over TLS when the context has a certificate: requests one after the
// other, each answered before the next is read, or a stream of events until either side has had
// enough. One coroutine on `strand`, which alone owns the stream and its buffers.
//
// It gives way for another first while it waits for a request, then while its answer is not taken;
// not while a request is being done, nor while it watches. `context` is kept.
std::shared_ptr<AcceptedConnection> MakeConnection(boost::asio::ip::tcp::socket socket,
                                                   std::string peer, Strand strand,
                                                   std::shared_ptr<ServerContext> context);

}  // namespace enamel::server::http
