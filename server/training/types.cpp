#include "server/training/types.h"

#include <array>
#include <string_view>

namespace enamel::server {
namespace {

constexpr std::array kRoles = {Role::kStudent, Role::kInstructor, Role::kAdmin};
constexpr std::array kExerciseStates = {ExerciseState::kDraft, ExerciseState::kPublished,
                                        ExerciseState::kRetired};

constexpr std::array kCountings = {Counting::kBest, Counting::kLast, Counting::kMean,
                                   Counting::kMedian};

struct FlagName {
  AttemptFlag flag;
  const char* name;
};
constexpr FlagName kFlagNames[] = {{kLate, "late"},
                                   {kLateUpload, "late_upload"},
                                   {kOtherHand, "other_hand"},
                                   {kFasterThanTime, "faster_than_time"},
                                   {kOverTime, "over_time"},
                                   {kResumed, "resumed"},
                                   {kExcused, "excused"},
                                   {kReadmitted, "readmitted"},
                                   {kReturned, "returned"},
                                   {kContradicted, "contradicted"},
                                   {kNearAnother, "near_another"},
                                   {kShook, "shook"},
                                   {kBorderlineScore, "borderline_score"}};

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

const char* ExerciseStateName(ExerciseState state) {
  switch (state) {
    case ExerciseState::kDraft:
      return "draft";
    case ExerciseState::kPublished:
      return "published";
    case ExerciseState::kRetired:
      return "retired";
  }
  return "retired";
}

std::optional<ExerciseState> ExerciseStateFromName(std::string_view name) {
  for (ExerciseState state : kExerciseStates) {
    if (name == ExerciseStateName(state)) return state;
  }
  return std::nullopt;
}

std::vector<const char*> AttemptFlagNames(uint32_t flags) {
  std::vector<const char*> out;
  for (const FlagName& known : kFlagNames) {
    if (flags & known.flag) out.push_back(known.name);
  }
  return out;
}

std::optional<AttemptFlag> AttemptFlagFromName(std::string_view name) {
  for (const FlagName& known : kFlagNames) {
    if (name == known.name) return known.flag;
  }
  return std::nullopt;
}

const char* CountingName(Counting counting) {
  switch (counting) {
    case Counting::kBest:
      return "best";
    case Counting::kLast:
      return "last";
    case Counting::kMean:
      return "mean";
    case Counting::kMedian:
      return "median";
  }
  return "best";
}

std::optional<Counting> CountingFromName(std::string_view name) {
  for (Counting counting : kCountings) {
    if (name == CountingName(counting)) return counting;
  }
  return std::nullopt;
}

const char* OutlineShownName(OutlineShown shown) {
  switch (shown) {
    case OutlineShown::kPractice:
      return "practice";
    case OutlineShown::kAlways:
      return "always";
    case OutlineShown::kNever:
      return "never";
  }
  return "practice";
}

std::optional<OutlineShown> OutlineShownFromName(std::string_view name) {
  for (OutlineShown shown :
       {OutlineShown::kPractice, OutlineShown::kAlways, OutlineShown::kNever}) {
    if (name == OutlineShownName(shown)) return shown;
  }
  return std::nullopt;
}

const char* SignedAtName(SignedAt at) { return at == SignedAt::kStart ? "start" : "end"; }

std::optional<SignedAt> SignedAtFromName(std::string_view name) {
  for (SignedAt at : {SignedAt::kStart, SignedAt::kEnd}) {
    if (name == SignedAtName(at)) return at;
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

std::optional<AttemptState> AttemptStateFromName(std::string_view name) {
  for (int i = static_cast<int>(AttemptState::kTicketed);
       i <= static_cast<int>(AttemptState::kQuarantined); ++i) {
    auto state = static_cast<AttemptState>(i);
    if (name == AttemptStateName(state)) return state;
  }
  return std::nullopt;
}

}  // namespace enamel::server
