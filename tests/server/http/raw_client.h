#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace enamel::server::http {

struct RawResponse {
  int status = 0;
  std::map<std::string, std::string>
      headers;  // names in lower case; a repeated one: joined by ", "
  std::string body;
};

// Bytes in, answers out, on a loopback TCP connection; shares no code with the server. Every wait
// ends after 20 s.
class RawClient {
 public:
  explicit RawClient(uint16_t port);
  ~RawClient();
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  // False when the server has closed the connection.
  bool Send(std::string_view bytes);
  // One answer; none when the connection ends before a whole one came. `head`: the answer to a
  // HEAD.
  std::optional<RawResponse> Read(bool head = false);
  // True when the server ends the connection without another byte.
  bool ClosedByServer();
  // Everything until the server ends the connection.
  std::string ReadToEnd();
  // No more will be sent.
  void EndSending();

 private:
  bool Fill();

  int socket_ = -1;
  std::string buffer_;
};

}  // namespace enamel::server::http
