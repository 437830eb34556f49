#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/sha256.h"
#include "common/base/uuid.h"

// The domain: people, cohorts, stations, exercises, attempts. Plain values, no I/O.
// Times are milliseconds since the Unix epoch (UTC).
namespace enamel::server {

using UnixMs = int64_t;

enum class Role : uint8_t { kStudent = 1, kInstructor = 2, kAdmin = 3 };
const char* RoleName(Role role);  // "student", "instructor", "admin"
std::optional<Role> RoleFromName(std::string_view name);

struct Person {
  Uuid id;
  std::string login;  // lower case, unique within the school
  std::string display_name;
  Role role = Role::kStudent;
  bool disabled = false;
  UnixMs created_ms = 0;
};

struct Cohort {
  Uuid id;
  std::string name;
};

struct StationRow {
  Uuid id;
  std::string name;
  std::vector<uint8_t> public_key;  // Ed25519, 32 bytes
  bool revoked = false;
  UnixMs enrolled_ms = 0;
  UnixMs last_seen_ms = 0;
};

struct ProfileRow {
  std::string name;
  std::string title;
  Sha256 content;  // JSON blob
};

struct SceneRow {
  std::string name;
  std::string title;
  Sha256 content;  // JSON blob
  Sha256 volume;
};

struct ExerciseRow {
  Uuid id;
  std::string name;
  std::string title;
  int32_t version = 1;
  Sha256 content;  // JSON blob of this version
  Sha256 scene;
  bool graded = true;
  UnixMs published_ms = 0;
};

// Life of an attempt. Stable names: "ticketed", "recording", "sealed", "scoring", "scored",
// "failed", "quarantined".
enum class AttemptState : uint8_t {
  kTicketed = 1,
  kRecording = 2,
  kSealed = 3,
  kScoring = 4,
  kScored = 5,
  kFailed = 6,
  kQuarantined = 7
};
const char* AttemptStateName(AttemptState state);

struct AttemptRow {
  Uuid id;
  Uuid person;
  std::string person_name;  // display name, joined
  Uuid station;
  Uuid exercise;
  std::string exercise_title;  // joined
  Sha256 exercise_content;
  Sha256 profile_content;
  AttemptState state = AttemptState::kTicketed;
  bool as_reference = false;  // recorded as a reference cut
  bool released = false;      // a graded score the student may see
  UnixMs ticketed_ms = 0;
  UnixMs sealed_ms = 0;
  uint32_t chunks = 0;  // committed
  uint64_t ticks = 0;
  uint64_t gap_ticks = 0;
  uint64_t trace_bytes = 0;  // header + committed chunks
  std::optional<double> score;
  bool critical_fail = false;
  double progress = 0;    // 0..1 while scoring
  UnixMs expired_ms = 0;  // when a retention rule removed the recording; 0: it is there
  std::string problem;    // why failed or quarantined
};

struct ReferenceRow {
  Uuid id;
  Uuid exercise;
  Uuid attempt;
  std::string dentist;  // as to be shown, with consent
  int32_t version = 1;
  UnixMs created_ms = 0;
};

}  // namespace enamel::server
