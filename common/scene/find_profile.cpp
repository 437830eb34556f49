#include "common/scene/find_profile.h"

#include "common/base/file.h"
#include "common/base/in_document.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"

namespace enamel::scene {
namespace {

constexpr size_t kLargestProfile = 1 << 20;

Result<DeviceProfile> ProfileIn(const std::string& path) {
  ENAMEL_ASSIGN_OR_RETURN(Bytes text, ReadFile(path, kLargestProfile));
  Result<DeviceProfile> profile = ProfileFromJson(AsText(text));
  if (profile.ok()) return profile;
  return InDocument(path, profile.status());
}

}  // namespace

Result<DeviceProfile> FindProfile(const std::string& name_or_path) {
  if (name_or_path.ends_with(".json")) return ProfileIn(name_or_path);
  std::string names;
  for (const DeviceProfile& p : BuiltinProfiles()) {
    if (p.name == name_or_path) return p;
    names += (names.empty() ? "" : ", ") + p.name;
  }
  return Status(Code::kNotFound,
                "no device profile '" + name_or_path + "': there are " + names +
                    ", or name a profile's document (FILE.json); 'enamel-station profiles' shows "
                    "the figures of each",
                "profile");
}

}  // namespace enamel::scene
