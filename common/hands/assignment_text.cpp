#include "common/hands/assignment_text.h"

#include <chrono>
#include <cstdio>

namespace enamel {

std::string AssignmentText(const AssignmentWords& assignment) {
  return assignment.title + " (" + (assignment.exam ? "exam, " : "") +
         (assignment.due_unix_ms == 0 ? "no due time"
                                      : "due " + TimeInWords(assignment.due_unix_ms)) +
         ", with " + HandsAllowedText(assignment.hands) + ")";
}

std::string TimeInWords(int64_t unix_ms) {
  using namespace std::chrono;
  sys_time<milliseconds> time{milliseconds(unix_ms)};
  auto day = floor<days>(time);
  year_month_day date(day);
  hh_mm_ss clock(floor<minutes>(time - day));
  char text[64];
  std::snprintf(text, sizeof text, "%04d-%02u-%02u %02d:%02d UTC", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()));
  return text;
}

}  // namespace enamel
