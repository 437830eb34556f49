#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/language/words.h"
#include "station/desk/ui.h"
#include "station/session/workplace.h"

// What the list of exercises shows of each of them. Functions, any thread.
namespace enamel::station::desk {

using language::Words;

// Status of an exercise before it is chosen: "due in 2 days, 3 attempts left".
std::string AssignmentText(const Words& words, const Catalogue::Exercise& exercise,
                           int64_t now_unix_ms);

// A device as people call it, for the name of its profile: "Omega 3DOF". `profiles`: the server's.
std::string DeviceText(const Words& words, std::string_view profile,
                       std::span<const Catalogue::Profile> profiles);
// An interrupted attempt: "Begun 3 hours ago; device: Omega 3DOF".
std::string CutOffText(const Words& words, const SpooledAttempt& attempt, const std::string& device,
                       int64_t now_unix_ms);
// An attempt handed in: "Handed in, made 5 minutes ago; device: Omega 3DOF".
std::string HandedInText(const Words& words, const SpooledAttempt& attempt,
                         const std::string& device, int64_t now_unix_ms);
// A ticket taken in advance: "Ada, 11 hours left; device: Omega 3DOF".
std::string ReservedText(const Words& words, const ReservedAttempt& reserved,
                         const std::string& device, int64_t now_unix_ms);
// Why an attempt at this exercise cannot be begun now; empty: it can.
std::string RefusalText(const Words& words, const Catalogue::Exercise& exercise);

// Of the chosen exercise: its tooth, when the score is shown, and the limits. `exam`: as an exam.
std::string FactsText(const Words& words, const scene::Exercise& exercise,
                      const std::string& scene_title, bool exam);
// Which tooth and side it is: "Tooth 46, occlusal, with caries". Empty: no tooth, or not known.
std::string PlaceText(const Words& words, const Catalogue::Exercise& exercise);
// An exercise in the list: title, place, and in one line whether it counts, its status, and the
// best score so far.
Card CardOf(const Words& words, const Catalogue::Exercise& exercise, int64_t now_unix_ms);

// The side to prepare, in the square that a dental chart has for a tooth, with the tooth's number:
// the chart is seen from the dentist's place, so the patient's right is at the left, and the teeth
// of the upper jaw have their buccal side up. Into the current ImGui window.
void DrawToothSymbol(const Catalogue::Facts& facts, const Rect& at);

}  // namespace enamel::station::desk
