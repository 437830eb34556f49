#include "station/session/by_name.h"

#include <algorithm>
#include <cstdint>
#include <set>

#include "common/hands/assignment_text.h"

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

// Without a due date, it is due last.
int64_t DueOf(const Catalogue::Exercise& e) {
  return e.due_unix_ms > 0 ? e.due_unix_ms : INT64_MAX;
}

// Why the hand is not allowed; empty: no objection is known here.
std::string HandRefusal(const Catalogue::Exercise& e, const Hand& hand) {
  if (hand.kind == HandKind::kNotTold) return {};
  constexpr bool kMayBeListed = true;
  return MayHold(e.hands, hand, kMayBeListed).message();
}

// With the id, which requests use.
std::string WordsOf(const Catalogue::Exercise& e) {
  return e.assignment.Text() + ", " + AssignmentText({e.title, e.exam, e.due_unix_ms, e.hands});
}

Status NotAssigned(const WantedExercise& wanted, const std::vector<std::string>& known) {
  std::string ids;
  for (const std::string& one : known) ids += (ids.empty() ? "" : "; ") + one;
  return Status(Code::kNotFound,
                "no assignment " + wanted.assignment.Text() + " of exercise '" + wanted.name +
                    "' for you: " + (ids.empty() ? "it is not assigned" : "there are " + ids),
                "assignment");
}

}  // namespace

Result<Catalogue::Exercise> ChooseByName(const std::vector<Catalogue::Exercise>& exercises,
                                         const WantedExercise& wanted) {
  const Catalogue::Exercise* best = nullptr;
  std::vector<std::string> assignments;
  std::set<std::string> refusals;
  std::string exam_refusal;
  bool named = false;
  for (const Catalogue::Exercise& e : exercises) {
    if (e.name != wanted.name) continue;
    named = true;
    if (!e.assignment.IsZero()) assignments.push_back(WordsOf(e));
    if (!wanted.assignment.IsZero() && e.assignment != wanted.assignment) continue;
    if (!e.refusal.ok()) {
      refusals.insert(e.refusal.message());
      continue;
    }
    const std::string refusal = HandRefusal(e, wanted.hand);
    // An open exam must not be avoided by a hand that it does not admit.
    if (!refusal.empty() && e.exam) exam_refusal = refusal;
    if (!refusal.empty()) {
      refusals.insert(refusal);
    } else if (best == nullptr || DueOf(e) < DueOf(*best)) {
      best = &e;
    }
  }
  if (!exam_refusal.empty()) {
    return Status(Code::kForbidden,
                  "exercise '" + wanted.name + "' is an exam now: " + exam_refusal +
                      (best == nullptr ? "" : "; or name another assignment of it: ") +
                      (best == nullptr ? "" : WordsOf(*best)),
                  "hand");
  }
  if (best != nullptr) return *best;
  if (!named) return Unknown("exercise", wanted.name, exercises);
  if (refusals.empty()) return NotAssigned(wanted, assignments);
  std::string all;
  for (const std::string& refusal : refusals) all += (all.empty() ? "" : "; or: ") + refusal;
  return Status(Code::kForbidden, "exercise '" + wanted.name + "' cannot be begun now: " + all,
                "exercise");
}

Result<PreparedAttempt> PrepareByName(Workplace& workplace, const WantedExercise& wanted,
                                      const std::string& profile_name) {
  ENAMEL_ASSIGN_OR_RETURN(auto catalogue, workplace.Exercises());
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, ChooseByName(catalogue.exercises, wanted));
  auto profile = std::ranges::find(catalogue.profiles, profile_name, &Catalogue::Profile::name);
  if (profile == catalogue.profiles.end()) {
    return Unknown("device profile", profile_name, catalogue.profiles);
  }
  return workplace.Prepare(exercise, *profile);
}

}  // namespace enamel::station
