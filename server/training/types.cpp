#include "server/training/types.h"

#include <array>
#include <string_view>

namespace enamel::server {
namespace {

constexpr std::array kRoles = {Role::kStudent, Role::kInstructor, Role::kAdmin};

}  // namespace

const char* RoleName(Role role) {
  switch (role) {
    case Role::kStudent:
      return "student";
    case Role::kInstructor:
      return "instructor";
    case Role::kAdmin:
      return "admin";
  }
  return "student";
}

std::optional<Role> RoleFromName(std::string_view name) {
  for (Role role : kRoles) {
    if (name == RoleName(role)) return role;
  }
  return std::nullopt;
}

const char* AttemptStateName(AttemptState state) {
  switch (state) {
    case AttemptState::kTicketed:
      return "ticketed";
    case AttemptState::kRecording:
      return "recording";
    case AttemptState::kSealed:
      return "sealed";
    case AttemptState::kScoring:
      return "scoring";
    case AttemptState::kScored:
      return "scored";
    case AttemptState::kFailed:
      return "failed";
    case AttemptState::kQuarantined:
      return "quarantined";
  }
  return "failed";
}

}  // namespace enamel::server
