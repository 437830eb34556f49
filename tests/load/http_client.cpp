#include "tests/load/http_client.h"

#include <sys/socket.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <optional>

namespace enamel::load {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::system::error_code;

constexpr timeval kPatience{20, 0};

}  // namespace

struct HttpClient::Impl {
  // Connects if needed. Any failure leaves it disconnected.
  Status Exchange(const net::Endpoint& page, http::request<http::string_body>& request,
                  http::response<http::string_body>& response) {
    error_code error;
    if (!socket) {
      socket.emplace(io);
      buffer.clear();
      socket->connect({asio::ip::make_address(page.host, error), page.port}, error);
      if (!error) {
        ::setsockopt(socket->native_handle(), SOL_SOCKET, SO_RCVTIMEO, &kPatience,
                     sizeof kPatience);
        socket->set_option(tcp::no_delay(true), error);
      }
    }
    request.set(http::field::host, page.Text());
    request.prepare_payload();
    if (!error) http::write(*socket, request, error);
    if (!error) http::read(*socket, buffer, response, error);
    if (error || !response.keep_alive()) socket.reset();
    if (!error) return Status::Ok();
    return Status(Code::kUnavailable, page.Text() + ": " + error.message());
  }

  asio::io_context io{1};
  std::optional<tcp::socket> socket;
  boost::beast::flat_buffer buffer;
};

HttpClient::HttpClient(net::Endpoint page)
    : page_(std::move(page)), impl_(std::make_unique<Impl>()) {}
HttpClient::~HttpClient() = default;

Status HttpClient::SignIn(const std::string& login, const std::string& password) {
  http::request<http::string_body> request(http::verb::post, "/api/v1/session", 11);
  request.set(http::field::content_type, "application/json");
  request.body() =
      boost::json::serialize(boost::json::object{{"login", login}, {"password", password}});
  http::response<http::string_body> response;
  ENAMEL_RETURN_IF_ERROR(impl_->Exchange(page_, request, response));
  auto cookie = response.find(http::field::set_cookie);
  if (response.result() != http::status::ok || cookie == response.end()) {
    return Status(Code::kUnauthenticated, "cannot sign in as " + login + ": " + response.body());
  }
  std::string value(cookie->value());
  cookie_ = value.substr(0, value.find(';'));
  return Status::Ok();
}

Result<std::string> HttpClient::Get(const std::string& path) {
  http::request<http::string_body> request(http::verb::get, path, 11);
  if (!cookie_.empty()) request.set(http::field::cookie, cookie_);
  http::response<http::string_body> response;
  ENAMEL_RETURN_IF_ERROR(impl_->Exchange(page_, request, response));
  if (response.result() == http::status::ok) return std::move(response.body());
  return Status(Code::kInternal,
                path + ": " + std::to_string(response.result_int()) + " " + response.body());
}

}  // namespace enamel::load
