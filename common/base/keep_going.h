#pragma once

#include <functional>

namespace enamel {

// Long work asks this between its pieces, at least every tenth of a second unless its header says otherwise.
// False: the work ends early, and its result must not be used. Empty: the work runs to its end.
using KeepGoing = std::function<bool()>;

}  // namespace enamel
