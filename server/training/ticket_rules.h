#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/training/types.h"

// When a person may begin an attempt: the rules of assignments, as pure functions. They do not
// apply to reference cuts and instructors' trials. Two stations could both pass the attempt limit
// or the limit of one exam at a time, so TicketRows::CreateAttempt checks both again.
namespace enamel::server {

// An attempt must begin within this time of its ticket; the station checks it. An exam begins while
// the server is connected, so its ticket is for now.
inline constexpr UnixMs kTicketValidMs = 12 * 60 * 60 * 1000;
inline constexpr UnixMs kExamTicketValidMs = 10 * 60 * 1000;

// "2026-11-20 09:05 UTC".
std::string TimeText(UnixMs time_ms);
// "2026-11-20 09:05" or "2026-11-20T09:05", in this computer's time zone; with "Z", " UTC" or
// "+01:00" behind it in that one. Errors: kInvalidInput.
Result<UnixMs> TimeFromText(const std::string& text);

// As AssignmentText says it.
std::string WordsOf(const AssignmentRow& row);

// Terms that contradict themselves. Errors: kInvalidInput, field "due_ms", "station_ids" or
// "sign_off".
Status CheckTerms(const AssignmentRow& assignment);

// Graded work and exams are judged against a reference: a version without one is assigned as
// practice only. Errors: kConflict, field "reference".
Status CheckReference(bool exam, const ExerciseRow& version, bool has_reference);

bool IsLate(const AssignmentRow& assignment, UnixMs now_ms);

// Errors: kForbidden with the obstacle, when it ends, and what to do; field() is "opens", "due",
// "attempt_limit" or "stations". `station`: where; none: anywhere. `stations_text`: the named
// stations, for people.
Status MayBegin(const AssignedRow& assigned, UnixMs now_ms, const std::optional<Uuid>& station,
                const std::string& stations_text);

// Whether the attempts count: exams and graded work, in contrast to practice.
bool Counts(const AssignedRow& assigned);

// Graded work and exams begin only where the station's clock is within kMaxStationClockOffMs of
// the server's: the station checks by its own clock whether a ticket has expired. Errors:
// kForbidden, field "clock".
inline constexpr UnixMs kMaxStationClockOffMs = 2 * 60 * 1000;
Status MayBeginByClock(const AssignedRow& assigned, UnixMs now_ms, UnixMs station_ms);

// A person whose attempt another station records gets no ticket here. Its newest chunk came within
// this time; a station that lost its power is not waited for.
inline constexpr UnixMs kElsewhereMs = 60 * 1000;

// What may hold the tool in an attempt under these terms: practice is free, as are reference cuts
// and instructors' own tries.
HandsAllowed HandsFor(const AssignedRow& assigned);

// The chair may show the target's outline on the tooth during an attempt under these terms; without an
// assignment, in practice only.
bool ShowsOutline(const std::optional<AssignedRow>& assigned, const ExerciseRow& exercise);

// The assignment a ticket for this exercise version counts for: `wanted`, or the first that allows
// an attempt now, or else the first; null: none is for this exercise. `rows` as
// AssignmentRows::AssignmentsFor sorts them, exams first, so that an exam is not dodged by saying
// nothing.
const AssignedRow* PickAssignment(const std::vector<AssignedRow>& rows, const Sha256& content,
                                  const std::optional<Uuid>& wanted, UnixMs now_ms,
                                  const std::optional<Uuid>& station);

// When a ticket issued now runs out: not after the due time unless late work is allowed. None: no
// assignment.
UnixMs TicketEnd(const std::optional<AssignedRow>& assigned, UnixMs now_ms);

// Writes the assignment's terms into an attempt that was ticketed at row.ticketed_ms.
void SetTerms(const std::optional<AssignedRow>& assigned, AttemptRow& row);

}  // namespace enamel::server
