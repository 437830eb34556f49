#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"

namespace enamel::net {

// One question to a web server, to find out whether and how it answers. Not for data: any
// certificate is accepted, and the answer names what is wrong with it.
struct WebQuestion {
  std::string host;  // name or numeric address
  uint16_t port = 443;
  bool tls = true;
  std::string host_name{};  // of the header Host and of the certificate; empty: `host`
  std::string path = "/";
  std::string ca_file{};  // PEM, beside the system's authorities
  std::chrono::milliseconds within{5000};
};

struct WebAnswer {
  int status = 0;
  std::string body;  // at most 64 KiB of it
  struct Certificate {
    int64_t until_ms = 0;  // Unix time
    std::string problem;   // why a browser would not trust it; empty: it would
  };
  std::optional<Certificate> certificate{};
};

// Blocks for `within` at most, and for looking up the name. Errors: kUnavailable (no answer; says at
// which step), kInvalidInput (what answers is no web server).
Result<WebAnswer> Ask(const WebQuestion& question);

}  // namespace enamel::net
