#pragma once

#include <algorithm>
#include <array>
#include <string_view>

// Why a device cannot be used, as the field of a driver's Status. The message is for the log and
// the commands; the chair has a sentence for each field in every language (desk/problem_words.h).
namespace enamel::station::trouble {

inline constexpr const char* kPermission = "permission";  // this user may not open it
inline constexpr const char* kConfined =
    "confined";                                  // the unit of this program does not list its kind
inline constexpr const char* kInUse = "in_use";  // by another program
inline constexpr const char* kNotAttached = "not_attached";
inline constexpr const char* kSilent = "silent";  // attached, and gives no pose or no answer
inline constexpr const char* kSlow = "slow";      // answers too late for the loop
inline constexpr const char* kPower = "power";
inline constexpr const char* kNoGrip = "no_grip";  // nothing to hold it by is connected
inline constexpr const char* kNotReady = "not_ready";
inline constexpr const char* kLibrary = "library";       // of its maker: missing or too old
inline constexpr const char* kService = "service";       // of its maker: not running, or too old
inline constexpr const char* kDamping = "damping";       // which the maker's service adds
inline constexpr const char* kFirmware = "firmware";     // missing, or not the right one
inline constexpr const char* kModel = "model";           // another one than its profile
inline constexpr const char* kOtherUnit = "other_unit";  // than the one that went away
inline constexpr const char* kLost = "lost";  // it came back, and may be elsewhere than it says
// Not calibrated, by what a person does about it.
inline constexpr const char* kPit = "pit";
inline constexpr const char* kInkwell = "inkwell";
inline constexpr const char* kGrip = "grip";
inline constexpr const char* kMiddle = "middle";
// None of these.
inline constexpr const char* kDevice = "device";

inline constexpr std::array<std::string_view, 21> kAll = {
    kPermission, kConfined, kInUse,   kNotAttached, kSilent,  kSlow,     kPower,
    kNoGrip,     kNotReady, kLibrary, kService,     kDamping, kFirmware, kModel,
    kOtherUnit,  kLost,     kPit,     kInkwell,     kGrip,    kMiddle,   kDevice};

constexpr bool IsListed(std::string_view field) {
  return std::ranges::find(kAll, field) != kAll.end();
}

}  // namespace enamel::station::trouble
