#pragma once

#include <string>

#include "common/scene/types.h"

namespace enamel::scene {

// Finds the device profile that a person names: a built-in one by its name, or a document by its
// path, which ends in .json. Thread safety: a function, any thread. Real-time: not safe. Errors:
// kNotFound, with the built-in names (field "profile"); ReadFile's and ProfileFromJson's with the
// path before them.
Result<DeviceProfile> FindProfile(const std::string& name_or_path);

}  // namespace enamel::scene
