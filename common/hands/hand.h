#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.h"

// The hand that holds the tool, and which hands graded work admits. Pure functions, any thread.
namespace enamel {

// As the station found it when the attempt began. It is in the recording's header, whose hash the
// first signed chunk names. What it cannot prove: schemas/trace_format.md, "Hand".
enum class HandKind : uint8_t {
  kNotTold = 0,  // of a ticket for later, which was asked for without a hand
  kHaptic = 1,   // a person at a device with motors
  kPointer = 2,  // a person at a mouse, a keyboard or another device without motors
  kProgram = 3,  // a simulated hand on a simulated device
};
// Stable names: "not_told", "haptic", "pointer", "program".
const char* HandKindName(HandKind kind);
std::optional<HandKind> HandKindFromName(std::string_view name);

inline constexpr size_t kMaxHandTextBytes = 128;

// Each text is at most kMaxHandTextBytes of UTF-8 without control characters.
struct Hand {
  HandKind kind = HandKind::kNotTold;
  std::string device;  // the model as it names itself: "omega.3"
  std::string driver;  // "hid", "dhd", "mouse", "operator dentist"
  std::string unit;    // which one of its model, "hid:1209:0001:SERIAL"; empty: cannot be told

  bool operator==(const Hand&) const = default;
};
// Texts of a device's own, made printable and cut to length.
Hand MakeHand(HandKind kind, std::string_view device, std::string_view driver,
              std::string_view unit = {});
// For people: "a simulated hand (operator dentist)", "omega.3 (hid:1209:0001:A7)".
std::string HandText(const Hand& hand);
// By what a school's list names it: its unit, or where it has none its model.
const std::string& ListedAs(const Hand& hand);

// Which hands graded work admits. Each admits those before it too.
enum class HandsAllowed : uint8_t {
  kListed = 1,   // devices with motors that are on the school's list
  kHaptic = 2,   // every device with motors
  kPointer = 3,  // a mouse too
  kAny = 4,      // simulated hands too
};
// Stable names: "listed", "haptic", "pointer", "any".
const char* HandsAllowedName(HandsAllowed allowed);
std::optional<HandsAllowed> HandsAllowedFromName(std::string_view name);
// For people: "a haptic device on the school's list".
const char* HandsAllowedText(HandsAllowed allowed);

// `listed`: the hand is on the school's list; used for kListed only. Errors: kForbidden, field
// "hand". The message gives the expected and the found hand, and what to do.
Status MayHold(HandsAllowed allowed, const Hand& hand, bool listed);

}  // namespace enamel
