#pragma once

#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/base/sha256.h"

namespace enamel::server::auth {

// A session or credential token: 256 random bits. Only its SHA-256 is stored.
Bytes NewToken();
Sha256 TokenHash(ByteView token);
// What the page must send back in X-Enamel-Csrf: a keyed hash of the session token, 64 hex digits,
// so nothing more is stored and a leaked value does not open a session.
std::string CsrfFor(ByteView token);
// In time that does not depend on where they differ.
bool SameSecret(std::string_view a, std::string_view b);

}  // namespace enamel::server::auth
