#include "server/http/error_response.h"

#include <spdlog/spdlog.h>

#include <boost/json.hpp>

#include "common/base/utf8.h"
#include "server/training/revision.h"

namespace enamel::server::http {
namespace {

// Where the refusal knows no time of its own.
constexpr int32_t kRetryAfterSeconds = 5;

// Refusals that are finer than a Code, identified by their field.
struct Finer {
  Code code;
  std::string_view field;
  int http_status;
  const char* name;
  bool shows_field;
};
// The page acts upon these names: it asks for the password again, for a new one, or shows what
// changed meanwhile.
constexpr Finer kFiner[] = {
    {Code::kUnavailable, "throttled", 429, "throttled", false},
    {Code::kInvalidInput, "if-match", 428, "precondition_required", true},
    {Code::kConflict, kStale, 412, "precondition_failed", false},
    {Code::kForbidden, kConfirmPassword, 403, "confirm_password", false},
    {Code::kForbidden, kChangePassword, 403, "change_password", false},
};

const Finer* FinerOf(const Status& status) {
  for (const Finer& finer : kFiner) {
    if (finer.code == status.code() && finer.field == status.field()) return &finer;
  }
  return nullptr;
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
      return 503;
    // A status that no handler should have let through: the peer learns nothing of disk or schema,
    // the log does.
    case Code::kOk:
    case Code::kStorage:
    case Code::kVersion:
    case Code::kInternal:
      return 500;
  }
  return 500;
}

Response MadeResponse(int status, std::string_view code, std::string_view message,
                      std::string_view field, int32_t retry_after_s = 0) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.refusal = code;
  response.body = boost::json::serialize(boost::json::object{
      // A message may quote what the peer sent, which need not be UTF-8; JSON has to be.
      {"error", {{"code", AsUtf8(code)}, {"message", AsUtf8(message)}, {"field", AsUtf8(field)}}}});
  // RFC 9110, 15.5.2, asks for one. A scheme that no browser knows, so that none opens a window of
  // its own for login and password: the page asks for them.
  if (status == 401) response.headers.emplace_back("WWW-Authenticate", "Session realm=\"Enamel\"");
  if (status == 503 || status == 429) {
    response.headers.emplace_back(
        "Retry-After", std::to_string(retry_after_s > 0 ? retry_after_s : kRetryAfterSeconds));
  }
  return response;
}

}  // namespace

Response ErrorResponse(int status, std::string_view code, std::string_view message,
                       std::string_view field) {
  return MadeResponse(status, code, message, field);
}

Response ErrorResponse(const Status& status) {
  if (const Finer* finer = FinerOf(status)) {
    return MadeResponse(finer->http_status, finer->name, status.message(),
                        finer->shows_field ? finer->field : std::string_view{},
                        status.retry_after_s());
  }
  int http_status = HttpStatus(status);
  if (http_status == 500) {
    spdlog::error("http: {}: {} {}", CodeName(status.code()), status.field(), status.message());
    return ErrorResponse(500, "internal",
                         "The server could not do this; its log says why. Try again, or tell the "
                         "person who runs the server.");
  }
  return MadeResponse(http_status, CodeName(status.code()), status.message(), status.field(),
                      status.retry_after_s());
}

Response Done() {
  Response response;
  response.status = 204;
  return response;
}

Result<Response> DoneOr(const Status& status) {
  ENAMEL_RETURN_IF_ERROR(status);
  return Done();
}

Response Answered(Result<Response> result) {
  return result.ok() ? std::move(result).value() : ErrorResponse(result.status());
}

}  // namespace enamel::server::http
