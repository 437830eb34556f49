#pragma once

#include <cstdint>
#include <string>

#include "server/training/types.h"

// Names of our enums in SQL, so that a statement names its values:
//   "… WHERE state = " + Sql(AttemptState::kScored) + " AND flags & " + Sql(kExcused) + " = 0"
namespace enamel::server {

inline std::string Sql(AttemptState state) { return std::to_string(static_cast<int>(state)); }
inline std::string Sql(ExerciseState state) { return std::to_string(static_cast<int>(state)); }
inline std::string Sql(Role role) { return std::to_string(static_cast<int>(role)); }
// Bits of AttemptFlag.
inline std::string Sql(uint32_t flags) { return std::to_string(flags); }

}  // namespace enamel::server
