#pragma once

#include "common/base/result.h"
#include "server/http/routes.h"

// The caller of a request, as handlers need it. Pure functions of the call; any thread.
namespace enamel::server::http {

Actor ActorOf(const Call& call);

// For changes that somebody who finds a page left open must not make: the password must have been
// given within the last five minutes (by signing in, or POST /api/v1/session/confirm). Errors:
// kForbidden, field kConfirmPassword (HTTP 403 "confirm_password").
Status RequireConfirmed(const Call& call);

}  // namespace enamel::server::http
