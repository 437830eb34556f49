#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/json.hpp>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/http/wire/http_server.h"
#include "tests/server/http/raw_client.h"
#include "tests/server/http/school.h"

namespace enamel::server::http {

// The server on a free loopback port, with a thread of its own, until destroyed.
class RunningServer {
 public:
  explicit RunningServer(School& school, HttpOptions options = {});
  ~RunningServer();

  uint16_t port() const { return port_; }
  HttpServer& server() { return *server_; }
  // Waits until the server has no more work. Requires: Stop was called.
  void Join();

 private:
  boost::asio::io_context io_;
  std::unique_ptr<HttpServer> server_;
  uint16_t port_ = 0;
  std::thread thread_;
};

// Somebody at a browser: keeps cookie and csrf.
class Visitor {
 public:
  explicit Visitor(uint16_t port) : port_(port) {}
  // Signs in with kPassword; dies when that fails.
  Visitor(uint16_t port, const std::string& login);

  RawResponse Get(const std::string& target);
  RawResponse Post(const std::string& target, const std::string& json = "");
  // Judges an attempt at its present revision: `rest` is "/release", "/override", "/excuse".
  RawResponse Judge(const std::string& method, const std::string& attempt, const std::string& rest,
                    const std::string& json = "");
  // A request with exactly these extra header lines ("Name: value\r\n…").
  RawResponse Send(const std::string& method, const std::string& target, const std::string& headers,
                   const std::string& body = "");

  std::string cookie, csrf;

 private:
  uint16_t port_;
};

boost::json::value Parsed(const RawResponse& response);
std::string ErrorCode(const RawResponse& response);

}  // namespace enamel::server::http
