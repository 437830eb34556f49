#include "common/net/web_question.h"

#include <openssl/err.h>
#include <openssl/x509v3.h>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/system/system_error.hpp>
#include <charconv>
#include <exception>
#include <string_view>

#include "common/net/certificate.h"

namespace enamel::net {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using asio::ip::tcp;

constexpr size_t kMaxAnswerBytes = 64 * 1024;

// How far it has come, for the message.
struct Asking {
  const WebQuestion& question;
  const char* step = "finding its address";
  std::string bytes{};
  std::optional<WebAnswer::Certificate> certificate{};
};

std::string TextOf(const WebQuestion& question) {
  const std::string& host = question.host_name.empty() ? question.host : question.host_name;
  return "GET " + question.path + " HTTP/1.1\r\nHost: " + host +
         "\r\nConnection: close\r\nAccept: application/json\r\n\r\n";
}

// To the end, which TLS of many servers does not say properly.
template <typename Stream>
asio::awaitable<void> Exchange(Stream& stream, Asking& asking) {
  const std::string text = TextOf(asking.question);
  asking.step = "asking";
  co_await asio::async_write(stream, asio::buffer(text), asio::use_awaitable);
  asking.step = "waiting for the answer";
  boost::system::error_code ended;
  co_await asio::async_read(stream, asio::dynamic_buffer(asking.bytes, kMaxAnswerBytes),
                            asio::redirect_error(asio::use_awaitable, ended));
}

WebAnswer::Certificate Look(SSL* tls, const std::string& name) {
  WebAnswer::Certificate out;
  X509* const leaf = SSL_get1_peer_certificate(tls);
  if (leaf == nullptr) return {0, "it has none"};
  out.until_ms = EndOfCertificateMs(leaf);
  const long trust = SSL_get_verify_result(tls);
  if (trust != X509_V_OK) {
    out.problem = X509_verify_cert_error_string(trust);
  } else if (X509_check_host(leaf, name.data(), name.size(), 0, nullptr) != 1 &&
             X509_check_ip_asc(leaf, name.c_str(), 0) != 1) {
    out.problem = "it is not for " + name;
  }
  X509_free(leaf);
  return out;
}

asio::awaitable<void> Run(Asking& asking) {
  const WebQuestion& question = asking.question;
  auto executor = co_await asio::this_coro::executor;
  tcp::resolver resolver(executor);
  const auto found = co_await resolver.async_resolve(question.host, std::to_string(question.port),
                                                     asio::use_awaitable);
  asking.step = "connecting";
  if (!question.tls) {
    tcp::socket socket(executor);
    co_await asio::async_connect(socket, found, asio::use_awaitable);
    co_await Exchange(socket, asking);
    co_return;
  }
  ssl::context context(ssl::context::tls_client);
  boost::system::error_code ignored;
  context.set_default_verify_paths(ignored);
  if (!question.ca_file.empty()) context.load_verify_file(question.ca_file, ignored);
  // Accepts any certificate; OpenSSL keeps the reason against it.
  context.set_verify_mode(ssl::verify_peer);
  context.set_verify_callback([](bool, ssl::verify_context&) { return true; });
  ssl::stream<tcp::socket> stream(executor, context);
  const std::string& name = question.host_name.empty() ? question.host : question.host_name;
  SSL_set_tlsext_host_name(stream.native_handle(), name.c_str());
  co_await asio::async_connect(stream.next_layer(), found, asio::use_awaitable);
  asking.step = "the TLS handshake";
  co_await stream.async_handshake(ssl::stream_base::client, asio::use_awaitable);
  asking.certificate = Look(stream.native_handle(), name);
  co_await Exchange(stream, asking);
}

Status NoAnswer(const Asking& asking, const std::string& why) {
  const WebQuestion& question = asking.question;
  return Status(Code::kUnavailable, "no answer from " + question.host + ":" +
                                        std::to_string(question.port) + " (" + asking.step + ": " +
                                        why + ")");
}

}  // namespace

Result<WebAnswer> Ask(const WebQuestion& question) {
  Asking asking{question};
  asio::io_context io;
  std::exception_ptr failure;
  bool ended = false;
  asio::co_spawn(io, Run(asking), [&](std::exception_ptr failed) {
    failure = failed;
    ended = true;
  });
  io.run_for(question.within);
  // Before what it waits with goes: the rest of the coroutine must not run.
  io.stop();
  if (!ended)
    return NoAnswer(asking, "nothing within " + std::to_string(question.within.count()) + " ms");
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const boost::system::system_error& error) {
    return NoAnswer(asking, error.code().message());
  } catch (const std::exception& error) {
    return NoAnswer(asking, error.what());
  }
  WebAnswer out;
  out.certificate = asking.certificate;
  constexpr std::string_view kBegin = "HTTP/1.";
  const size_t space = asking.bytes.find(' '), end = asking.bytes.find("\r\n\r\n");
  if (!asking.bytes.starts_with(kBegin) || space == std::string::npos || end == std::string::npos) {
    return Status(Code::kInvalidInput, "what answers at " + question.host + ":" +
                                           std::to_string(question.port) + " is no web server");
  }
  std::from_chars(asking.bytes.data() + space + 1, asking.bytes.data() + space + 4, out.status);
  out.body = asking.bytes.substr(end + 4);
  return out;
}

}  // namespace enamel::net
