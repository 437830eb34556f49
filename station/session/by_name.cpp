#include "station/session/by_name.h"

namespace enamel::station {
namespace {

template <typename T>
Status Unknown(const char* what, const std::string& name, const std::vector<T>& known) {
  std::string names;
  for (const T& k : known) names += (names.empty() ? "" : ", ") + k.name;
  return Status(Code::kNotFound,
                std::string("no ") + what + " '" + name + "' for you on this server: " +
                    (names.empty() ? "there are none" : "there are " + names),
                what);
}

template <typename T>
const T* Find(const std::vector<T>& all, const std::string& name) {
  for (const T& one : all) {
    if (one.name == name) return &one;
  }
  return nullptr;
}

}  // namespace

Result<PreparedAttempt> PrepareByName(Workplace& workplace, const std::string& exercise_name,
                                      const std::string& profile_name) {
  auto catalogue = workplace.Exercises();
  if (!catalogue.ok()) return catalogue.status();
  const auto* exercise = Find(catalogue->exercises, exercise_name);
  if (exercise == nullptr) return Unknown("exercise", exercise_name, catalogue->exercises);
  const auto* profile = Find(catalogue->profiles, profile_name);
  if (profile == nullptr) return Unknown("device profile", profile_name, catalogue->profiles);
  return workplace.Prepare(*exercise, *profile);
}

}  // namespace enamel::station
