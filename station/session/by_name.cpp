#include "station/session/by_name.h"

#include <algorithm>
#include <cstdint>
#include <set>

namespace enamel::station {
namespace {

template <typename T>
Status Unknown(const char* what, const std::string& name, const std::vector<T>& known) {
  std::set<std::string> distinct;  // an exercise may be assigned more than once
  for (const T& k : known) distinct.insert(k.name);
  std::string names;
  for (const std::string& one : distinct) names += (names.empty() ? "" : ", ") + one;
  return Status(Code::kNotFound,
                std::string("no ") + what + " '" + name + "' for you on this server: " +
                    (names.empty() ? "there are none" : "there are " + names),
                what);
}

// Without an end is due last.
int64_t DueOf(const Catalogue::Exercise& e) {
  return e.due_unix_ms > 0 ? e.due_unix_ms : INT64_MAX;
}

}  // namespace

Result<Catalogue::Exercise> ChooseByName(const std::vector<Catalogue::Exercise>& exercises,
                                         const std::string& name) {
  const Catalogue::Exercise* best = nullptr;
  const Catalogue::Exercise* refused = nullptr;
  for (const Catalogue::Exercise& e : exercises) {
    if (e.name != name) continue;
    if (!e.refusal.empty()) {
      refused = &e;
    } else if (best == nullptr || DueOf(e) < DueOf(*best)) {
      best = &e;
    }
  }
  if (best != nullptr) return *best;
  if (refused == nullptr) return Unknown("exercise", name, exercises);
  return Status(Code::kForbidden,
                "exercise '" + name + "' cannot be begun now: " + refused->refusal, "exercise");
}

Result<PreparedAttempt> PrepareByName(Workplace& workplace, const std::string& exercise_name,
                                      const std::string& profile_name) {
  ENAMEL_ASSIGN_OR_RETURN(auto catalogue, workplace.Exercises());
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, ChooseByName(catalogue.exercises, exercise_name));
  auto profile = std::ranges::find(catalogue.profiles, profile_name, &Catalogue::Profile::name);
  if (profile == catalogue.profiles.end()) {
    return Unknown("device profile", profile_name, catalogue.profiles);
  }
  return workplace.Prepare(exercise, *profile);
}

}  // namespace enamel::station
