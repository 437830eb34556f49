#pragma once

#include <cstdint>
#include <string>

#include "common/hands/hand.h"

// An assignment in words, the same everywhere: one exercise may be assigned more than once.
namespace enamel {

struct AssignmentWords {
  std::string title;  // of the exercise
  bool exam = false;
  int64_t due_unix_ms = 0;                  // 0: never
  HandsAllowed hands = HandsAllowed::kAny;  // what may hold the tool in it; practice is free
};
// "Class I cavity (exam, due 2026-12-01 12:00 UTC, with a haptic device)".
std::string AssignmentText(const AssignmentWords& assignment);

// "2026-11-20 09:05 UTC", of milliseconds since 1970-01-01 UTC. The text names UTC because server,
// station and page may be in different time zones.
std::string TimeInWords(int64_t unix_ms);

}  // namespace enamel
