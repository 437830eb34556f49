#pragma once

#include <chrono>
#include <string>

#include "common/base/result.h"
#include "common/math/vec.h"

// What devices have in common that say where they are only in answer to a force.
namespace enamel::station::sdk {

// Two answers may be lost before the loop has missed five ticks and latches a fault.
inline constexpr std::chrono::milliseconds kAnswerPatience{2};
// Of a device whose answers usually take longer: then none may be lost, and one that takes longer than
// this is a fault.
inline constexpr std::chrono::milliseconds kLongestPatience{4};
// Questions to a device that was just opened: for a second.
inline constexpr int kFirstQuestions = 500;

// Of a device that answered none of them.
Status SaysNothing(const std::string& name);

// Whether a first pose, m from the middle of the workspace, is within the arm's reach. One whose encoders
// lost their home is not, or by chance. Errors: kUnavailable, with `how_to_home`.
Status CheckHome(const std::string& name, const dvec3& tip_m, double reach_m,
                 const char* how_to_home);

}  // namespace enamel::station::sdk
