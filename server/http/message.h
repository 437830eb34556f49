#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/byte_pieces.h"
#include "server/net/held_bytes.h"

// A request and its answer as plain values: what the handlers see. No sockets, no Beast; a test
// makes one with braces.
namespace enamel::server::http {

enum class Method : uint8_t { kGet, kHead, kPost, kPut, kPatch, kDelete, kOther };
const char* MethodName(Method method);

// Thread safety: a value.
struct Request {
  Method method = Method::kGet;
  std::string path;                            // as sent, still percent-encoded, without the query
  std::map<std::string, std::string> query;    // decoded; a name given twice: the last
  std::map<std::string, std::string> headers;  // names in lower case; a repeated one joined by ", "
  std::string body;
  std::string peer;  // IP address
  bool tls = false;
  std::string id;  // what the log calls it (LogRequest); the answer's X-Request-Id
  // Its school, which lives as long as anybody holds this: true once it is no longer served. Null:
  // the server's own.
  std::shared_ptr<const std::atomic<bool>> school_ended;
  // Nobody waits for the answer after it.
  std::chrono::steady_clock::time_point answer_by = std::chrono::steady_clock::time_point::max();

  // Empty when absent.
  std::string_view Header(std::string_view lower_case_name) const;
};

// The stream that follows an answer's head: server-sent events (WHATWG HTML, "Server-sent events"),
// fetched as often as the connection likes. Thread safety: one thread at a time.
class EventSource {
 public:
  virtual ~EventSource() = default;
  struct Event {
    std::shared_ptr<const std::string> data;  // one line; null: nothing new
    bool last = false;                        // nothing will come after it
  };
  // Must not block.
  virtual Event Take() = 0;
  // Whether whoever asked may still see them: asked every few seconds. May block.
  virtual bool StillAllowed() { return true; }
};

struct Response {
  int status = 200;
  std::string content_type;  // none when empty
  std::string body;
  // Instead of `body`: what many answers share, or a part of it.
  std::shared_ptr<const std::string> shared_body;
  size_t from = 0, size = std::string::npos;
  // Instead of both: what is read while it is sent.
  std::optional<BytePieces> pieces{};
  std::vector<std::pair<std::string, std::string>> headers;
  std::string refusal;                  // the error's code, when this is one; for the server itself
  std::shared_ptr<EventSource> events;  // instead of a body; the connection ends with them
  std::shared_ptr<const std::atomic<bool>> school_ended;  // the request's
  std::shared_ptr<void> place;                            // RequestPlaces'
  std::shared_ptr<HeldBytes::Held> held;                  // of a large one

  uint64_t BodyBytes() const { return pieces ? pieces->size : Body().size(); }
  std::string_view Body() const {
    return shared_body ? std::string_view(*shared_body).substr(from, size) : body;
  }
};

}  // namespace enamel::server::http
