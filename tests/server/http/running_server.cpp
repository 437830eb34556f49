#include "tests/server/http/running_server.h"

#include <gtest/gtest.h>

namespace enamel::server::http {

RunningServer::RunningServer(School& school, HttpOptions options) {
  options.port = 0;
  options.store_threads = 2;
  server_ = std::make_unique<HttpServer>(io_, options, *school.store, *school.authenticator);
  Result<uint16_t> port = server_->Start();
  EXPECT_TRUE(port.ok()) << port.status().message();
  if (!port.ok()) std::abort();
  port_ = *port;
  thread_ = std::thread([this] { io_.run(); });
}

RunningServer::~RunningServer() {
  server_->Stop();
  Join();
}

void RunningServer::Join() {
  if (thread_.joinable()) thread_.join();
}

Visitor::Visitor(uint16_t port, const std::string& login) : port_(port) {
  RawResponse response = Send("POST", "/api/v1/session", "Content-Type: application/json\r\n",
                              R"({"login":")" + login + R"(","password":")" + kPassword + R"("})");
  EXPECT_EQ(response.status, 200) << response.body;
  if (response.status != 200) std::abort();
  const std::string& set = response.headers["set-cookie"];
  cookie = set.substr(0, set.find(';'));
  csrf = std::string(Parsed(response).at("csrf").as_string());
}

RawResponse Visitor::Send(const std::string& method, const std::string& target,
                          const std::string& headers, const std::string& body) {
  RawClient client(port_);
  std::string request = method + " " + target + " HTTP/1.1\r\nHost: localhost\r\n" + headers;
  if (!cookie.empty()) request += "Cookie: " + cookie + "\r\n";
  if (!body.empty()) request += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  client.Send(request + "\r\n" + body);
  return client.Read(method == "HEAD").value_or(RawResponse{});
}

RawResponse Visitor::Get(const std::string& target) { return Send("GET", target, ""); }

RawResponse Visitor::Post(const std::string& target, const std::string& json) {
  return Send("POST", target, "X-Enamel-Csrf: " + csrf + "\r\nContent-Type: application/json\r\n",
              json);
}

RawResponse Visitor::Judge(const std::string& method, const std::string& attempt,
                           const std::string& rest, const std::string& json) {
  RawResponse seen = Get(attempt);
  std::string etag = seen.status == 200 ? seen.headers["etag"] : "\"1\"";
  return Send(
      method, attempt + rest,
      "X-Enamel-Csrf: " + csrf + "\r\nIf-Match: " + etag + "\r\nContent-Type: application/json\r\n",
      json);
}

boost::json::value Parsed(const RawResponse& response) {
  boost::json::error_code error;
  boost::json::value value = boost::json::parse(response.body, error);
  EXPECT_FALSE(error) << response.status << " " << response.body;
  return value;
}

std::string ErrorCode(const RawResponse& response) {
  boost::json::value value = Parsed(response);
  return std::string(value.at("error").at("code").as_string());
}

}  // namespace enamel::server::http
