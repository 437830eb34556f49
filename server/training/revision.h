#pragma once

#include <string_view>

// Editable things carry a revision: 1 at first, one more with every change. A change names the
// revision that its author read.
namespace enamel::server {

// Field of kConflict when somebody else changed the thing since then: read it again.
inline constexpr std::string_view kStale = "revision";

// Field of kConflict for a request that is refused unless the caller insists with a reason; the
// reason goes to the audit trail.
inline constexpr std::string_view kAnyway = "anyway";

}  // namespace enamel::server
