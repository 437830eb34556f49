#pragma once

#include <memory>
#include <string>

#include "common/base/result.h"
#include "common/net/frame_client.h"

namespace enamel::load {

// A browser's side of the API on one kept-alive connection, blocking; every wait ends after 20 s.
// Plain HTTP on loopback. Thread safety: none.
class HttpClient {
 public:
  explicit HttpClient(net::Endpoint page);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  // Keeps the session's cookie. Errors: kUnavailable, kUnauthenticated.
  Status SignIn(const std::string& login, const std::string& password);
  // The body of a 200. Errors: kUnavailable (no server; the next call connects again), kInternal
  // with another status.
  Result<std::string> Get(const std::string& path);
  const std::string& cookie() const { return cookie_; }

 private:
  struct Impl;
  net::Endpoint page_;
  std::string cookie_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::load
