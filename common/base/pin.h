#pragma once

#include <string>

#include "common/base/result.h"

namespace enamel {

// Fields of a PIN that is refused, one for each rule: page and window have a sentence for each.
inline constexpr const char* kPinDigits = "pin";  // the number of digits, or other characters
inline constexpr const char* kPinRepeats = "pin_repeats";
inline constexpr const char* kPinRun = "pin_run";
inline constexpr const char* kPinDate = "pin_date";
// Field of kForbidden: too many wrong PINs, until the person chooses another with the password.
inline constexpr const char* kPinLocked = "pin_locked";

// A PIN has 6 to 12 digits and is not
//   one digit or two, repeated       111111, 121212
//   a run up or down, also past 0    123456, 654321, 567890
//   a date                           DDMMYY, MMDDYY, YYMMDD, MMYYYY, YYYYMM, and of eight digits
//                                    DDMMYYYY, MMDDYYYY, YYYYMMDD; years of four digits: 1900 to
//                                    2099
// Dates are 8.6 % of all PINs of six digits. Errors: kInvalidInput with the rule's field; the
// message names the rule and what to choose instead.
Status CheckPin(const std::string& pin);

}  // namespace enamel
