#pragma once

#include <cstddef>

namespace enamel {

// Bytes of a new password. What else it has to withstand only the server checks
// (server/auth/password.h); whoever asks for one checks these before sending it.
inline constexpr size_t kMinPasswordLength = 8, kMaxPasswordLength = 256;
// Field of the errors about it.
inline constexpr const char* kNewPassword = "new_password";

}  // namespace enamel
