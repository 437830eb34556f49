#include "server/training/ticket_rules.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <optional>

#include "common/base/counted.h"
#include "common/hands/assignment_text.h"

namespace enamel::server {

std::string TimeText(UnixMs time_ms) { return TimeInWords(time_ms); }

std::string WordsOf(const AssignmentRow& row) {
  const bool counts = row.exam || row.graded;
  return AssignmentText({row.title.empty() ? row.exercise : row.title, row.exam, row.due_ms,
                         counts ? row.hands : HandsAllowed::kAny});
}

namespace {

// "Z", " UTC", "+01:00": minutes ahead of UTC. None: something else.
std::optional<int> OffsetOf(const std::string& zone) {
  if (zone == "Z" || zone == " UTC") return 0;
  char sign = 0;
  int used = 0;
  unsigned hour = 0, minute = 0;
  const int found = std::sscanf(zone.c_str(), "%c%2u:%2u%n", &sign, &hour, &minute, &used);
  const bool whole = found == 3 && static_cast<size_t>(used) == zone.size();
  if (!whole || (sign != '+' && sign != '-') || hour > 14 || minute > 59) return std::nullopt;
  const int offset = static_cast<int>(60 * hour + minute);
  return sign == '-' ? -offset : offset;
}

}  // namespace

Result<UnixMs> TimeFromText(const std::string& text) {
  using namespace std::chrono;
  int year = 0, used = 0;
  unsigned month = 0, day = 0, hour = 0, minute = 0;
  char between = 0;
  int found = std::sscanf(text.c_str(), "%4d-%2u-%2u%c%2u:%2u%n", &year, &month, &day, &between,
                          &hour, &minute, &used);
  // sscanf stops at what it does not know. The rest is checked, so that "09:05 CET" is not taken
  // for local time.
  const std::string zone = found == 6 ? text.substr(static_cast<size_t>(used)) : "?";
  const std::optional<int> offset = zone.empty() ? std::optional(0) : OffsetOf(zone);
  year_month_day date{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
  bool fits = (between == ' ' || between == 'T') && date.ok() && year >= 2000 && year < 2100 &&
              hour < 24 && minute < 60 && offset;
  if (!fits) {
    return Status(
        Code::kInvalidInput,
        "expected a time like \"2026-11-20 09:05\", in this computer's time zone, or with "
        "its own, as \"2026-11-20 09:05+01:00\" or \"2026-11-20 08:05Z\"; found \"" +
            text + "\"");
  }
  if (zone.empty()) {
    std::tm local{};
    local.tm_year = year - 1900;
    local.tm_mon = static_cast<int>(month) - 1;
    local.tm_mday = static_cast<int>(day);
    local.tm_hour = static_cast<int>(hour);
    local.tm_min = static_cast<int>(minute);
    local.tm_isdst = -1;  // as the zone has it on that day
    return UnixMs{1000 * static_cast<int64_t>(std::mktime(&local))};
  }
  milliseconds time =
      sys_days(date).time_since_epoch() + hours(hour) + minutes(static_cast<int>(minute) - *offset);
  return UnixMs{time.count()};
}

Status CheckTerms(const AssignmentRow& assignment) {
  if (assignment.due_ms != 0 && assignment.due_ms <= assignment.opens_ms) {
    return Status(
        Code::kInvalidInput,
        "expected the due time after the opening, or none; found " + TimeText(assignment.due_ms),
        "due_ms");
  }
  if (!assignment.exam && !assignment.stations.empty()) {
    return Status(Code::kInvalidInput,
                  "expected stations of an exam only; make it an exam, or name no stations",
                  "station_ids");
  }
  if (!assignment.exam && assignment.sign_off) {
    return Status(
        Code::kInvalidInput,
        "expected sign-off at the chair of an exam only; make it an exam, or require none",
        "sign_off");
  }
  return Status::Ok();
}

Status CheckReference(bool exam, const ExerciseRow& version, bool has_reference) {
  if (has_reference || (!exam && !version.graded)) return Status::Ok();
  return Status(
      Code::kConflict,
      "expected version " + std::to_string(version.version) + " of \"" + version.name +
          "\" to have a reference, since it is " + (exam ? "an exam" : "graded work") +
          "; found none: cut it as a reference at a station and mark the cut, then assign "
          "it, or assign a practice exercise",
      "reference");
}

bool IsLate(const AssignmentRow& assignment, UnixMs now_ms) {
  return assignment.due_ms != 0 && now_ms > assignment.due_ms;
}

Status MayBegin(const AssignedRow& assigned, UnixMs now_ms, const std::optional<Uuid>& station,
                const std::string& stations_text) {
  const AssignmentRow& row = assigned.assignment;
  std::string what = "\"" + assigned.exercise.title + "\"";
  if (row.opens_ms != 0 && now_ms < row.opens_ms) {
    return Status(Code::kForbidden,
                  what + " opens " + TimeText(row.opens_ms) + ", it is " + TimeText(now_ms) +
                      "; come back then",
                  "opens");
  }
  if (IsLate(row, now_ms) && !row.late_allowed) {
    return Status(Code::kForbidden,
                  what + " was due " + TimeText(row.due_ms) + ", it is " + TimeText(now_ms) +
                      "; ask an instructor for more time",
                  "due");
  }
  if (row.attempt_limit != 0 && assigned.attempts_used >= row.attempt_limit) {
    return Status(Code::kForbidden,
                  what + " allows " + Counted(row.attempt_limit, "attempt") + ", " +
                      Counted(assigned.attempts_used, "is", "are") +
                      " used; an instructor can excuse one so that it does not count",
                  "attempt_limit");
  }
  bool elsewhere = station && !row.stations.empty() &&
                   std::ranges::find(row.stations, *station) == row.stations.end();
  if (row.exam && elsewhere) {
    return Status(Code::kForbidden,
                  "the exam " + what + " is taken at " + stations_text + "; go there", "stations");
  }
  return Status::Ok();
}

const AssignedRow* PickAssignment(const std::vector<AssignedRow>& rows, const Sha256& content,
                                  const std::optional<Uuid>& wanted, UnixMs now_ms,
                                  const std::optional<Uuid>& station) {
  const AssignedRow* first = nullptr;
  for (const AssignedRow& row : rows) {
    if (row.exercise.content != content || (wanted && row.assignment.id != *wanted)) continue;
    if (MayBegin(row, now_ms, station, {}).ok()) return &row;
    if (!first) first = &row;
  }
  return first;
}

UnixMs TicketEnd(const std::optional<AssignedRow>& assigned, UnixMs now_ms) {
  if (!assigned) return now_ms + kTicketValidMs;
  const AssignmentRow& terms = assigned->assignment;
  UnixMs end = now_ms + (terms.exam ? kExamTicketValidMs : kTicketValidMs);
  if (terms.due_ms == 0 || terms.late_allowed) return end;
  return std::min(end, terms.due_ms);
}

bool Counts(const AssignedRow& assigned) {
  return assigned.assignment.exam || assigned.exercise.graded;
}

Status MayBeginByClock(const AssignedRow& assigned, UnixMs now_ms, UnixMs station_ms) {
  // Compared with both bounds: a difference of two foreign numbers may overflow.
  const bool near =
      station_ms >= now_ms - kMaxStationClockOffMs && station_ms <= now_ms + kMaxStationClockOffMs;
  if (near || !Counts(assigned)) return Status::Ok();
  return Status(Code::kForbidden,
                "expected this station's clock within 2 minutes of the server's, " +
                    TimeText(now_ms) + "; found " +
                    (station_ms > 0 ? TimeText(station_ms) : std::string("none")) +
                    ": use another station, and let an admin set this one's clock",
                "clock");
}

HandsAllowed HandsFor(const AssignedRow& assigned) {
  return Counts(assigned) ? assigned.assignment.hands : HandsAllowed::kAny;
}

bool ShowsOutline(const std::optional<AssignedRow>& assigned, const ExerciseRow& exercise) {
  if (!assigned) return !exercise.graded;
  switch (assigned->assignment.outline) {
    case OutlineShown::kPractice:
      return !Counts(*assigned);
    case OutlineShown::kAlways:
      return true;
    case OutlineShown::kNever:
      return false;
  }
  return false;
}

void SetTerms(const std::optional<AssignedRow>& assigned, AttemptRow& row) {
  if (!assigned) return;
  const AssignmentRow& terms = assigned->assignment;
  row.assignment = terms.id;
  row.exam = terms.exam;
  row.due_ms = terms.due_ms;
  row.hands = HandsFor(*assigned);
  row.sign_off = terms.sign_off;
  if (IsLate(terms, row.ticketed_ms)) row.flags |= kLate;
}

}  // namespace enamel::server
