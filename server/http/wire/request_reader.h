#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "server/http/message.h"

namespace enamel::server::http {

inline constexpr size_t kMaxHeadBytes = 16 * 1024;
inline constexpr size_t kMaxBodyBytes = 1024 * 1024;
// A body as it travels: chunks of one byte each take six.
inline constexpr size_t kMaxBodyWireBytes = 8 * kMaxBodyBytes;

// Bytes in, one request out; no I/O. The strict look at the head (request_head.h) comes first, then
// Beast cuts out the body. Trailers are read and dropped (RFC 9110 section 6.5.1). Bounded: holds
// the head, the body and nothing else, and asks for more only with less than kMaxHeadBytes
// unused. Thread safety: one thread at a time.
class RequestReader {
 public:
  enum class Step {
    kMore,      // call again with the unused bytes and more behind them
    kContinue,  // send "100 Continue", then as kMore; at most once
    kRequest,   // done: request()
    kRefused,  // done: refusal(); the connection must end, for where the next one begins is unknown
  };

  RequestReader();
  ~RequestReader();

  // `bytes`: all that arrived and was not used yet. `used`: how many of them are done with.
  // Requires: neither kRequest nor kRefused was returned before.
  Step Feed(std::string_view bytes, size_t& used);

  bool in_head() const;
  // Of the body: as announced, else as many as one may have. Requires: !in_head().
  size_t expected_bytes() const;
  // Instead of a body that is too much at the moment, and forgets what has come of it: kRefused.
  void RefuseForNow(const Status& why);
  // Peer and tls are for the caller to fill in.
  Request& request() { return request_; }
  bool keep_alive() const { return keep_alive_; }
  Response& refusal() { return refusal_; }

 private:
  struct Parser;

  Step TakeHead(std::string_view head);
  Step TakeBody(std::string_view bytes, size_t& used);
  Step Refuse(Response refusal);

  std::unique_ptr<Parser> parser_;  // none: the head is not complete yet
  size_t searched_ = 0;             // bytes without the head's end
  size_t body_wire_bytes_ = 0;
  bool wants_continue_ = false;
  bool keep_alive_ = false;
  Request request_;
  Response refusal_;
};

}  // namespace enamel::server::http
