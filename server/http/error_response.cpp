#include "server/http/error_response.h"

#include <spdlog/spdlog.h>

#include <boost/json.hpp>

namespace enamel::server::http {
namespace {

constexpr const char* kRetryAfterSeconds = "5";

bool Throttled(const Status& status) {
  return status.code() == Code::kUnavailable && status.field() == "throttled";
}

int HttpStatus(const Status& status) {
  switch (status.code()) {
    case Code::kInvalidInput:
      return 400;
    case Code::kUnauthenticated:
      return 401;
    case Code::kForbidden:
      return 403;
    case Code::kNotFound:
      return 404;
    case Code::kConflict:
      return 409;
    case Code::kTooLarge:
      return 413;
    case Code::kUnavailable:
      return Throttled(status) ? 429 : 503;
    case Code::kOk:
    case Code::kStorage:
    case Code::kVersion:
    case Code::kInternal:
      return 500;
  }
  return 500;
}

}  // namespace

Response ErrorResponse(int status, std::string_view code, std::string_view message,
                       std::string_view field) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.body = boost::json::serialize(
      boost::json::object{{"error", {{"code", code}, {"message", message}, {"field", field}}}});
  if (status == 503 || status == 429) {
    response.headers.emplace_back("Retry-After", kRetryAfterSeconds);
  }
  return response;
}

Response ErrorResponse(const Status& status) {
  int http_status = HttpStatus(status);
  if (http_status == 500) {
    spdlog::error("http: {}: {} {}", CodeName(status.code()), status.field(), status.message());
    return ErrorResponse(500, "internal",
                         "The server could not do this; its log says why. Try again, or tell the "
                         "person who runs the server.");
  }
  const char* code = Throttled(status) ? "throttled" : CodeName(status.code());
  return ErrorResponse(http_status, code, status.message(),
                       Throttled(status) ? std::string_view{} : status.field());
}

}  // namespace enamel::server::http
