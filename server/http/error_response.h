#pragma once

#include <string_view>

#include "common/base/result.h"
#include "server/http/message.h"

// The one place where a refusal becomes an HTTP answer (schemas/api/openapi.yaml, schema Error).
namespace enamel::server::http {

// Fields of kForbidden that the page acts upon: 403 "confirm_password" (give the password again,
// POST /api/v1/session/confirm) and 403 "change_password" (the password is for one use only).
inline constexpr std::string_view kConfirmPassword = "confirm-password";
inline constexpr std::string_view kChangePassword = "change-password";

// 400, 401, 403, 404, 409, 412, 413, 428, 429, 503 carry the Status's message. Every fault of ours
// (kStorage, kVersion, kInternal) becomes a 500 without detail, which goes to the log here.
// Retry-After is the Status's, else 5 s. A message may repeat any bytes of
// the peer: invalid UTF-8 is replaced.
Response ErrorResponse(const Status& status);

// Refusals that only exist in HTTP: 405 "method_not_allowed", 415 "unsupported_media_type",
// 421 "misdirected", 431 "too_large", …
Response ErrorResponse(int status, std::string_view code, std::string_view message,
                       std::string_view field = {});

// 204: done, and there is nothing to say about it.
Response Done();
// That, or the refusal.
Result<Response> DoneOr(const Status& status);
// A handler's response, or its refusal as one.
Response Answered(Result<Response> result);

}  // namespace enamel::server::http
