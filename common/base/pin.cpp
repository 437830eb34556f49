#include "common/base/pin.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace enamel {
namespace {

constexpr size_t kMinDigits = 6, kMaxDigits = 12;

// All steps from one digit to the next are `step`, 9 being followed by 0.
bool Steps(std::string_view pin, int step) {
  return std::ranges::adjacent_find(
             pin, [step](char a, char b) { return (b - a + 10) % 10 != step; }) == pin.end();
}

bool RepeatsOneOrTwo(std::string_view pin) {
  return pin.substr(2) == pin.substr(0, pin.size() - 2);
}

bool IsDay(int month, int day) {
  constexpr std::array kDays = {31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  return month >= 1 && month <= 12 && day >= 1 && day <= kDays.at(month - 1);
}

bool IsDate(std::string_view pin) {
  const auto number = [&](size_t at, size_t digits) {
    int value = 0;
    for (const char c : pin.substr(at, digits)) value = 10 * value + (c - '0');
    return value;
  };
  const auto is_year = [&](size_t at) { return number(at, 4) >= 1900 && number(at, 4) <= 2099; };
  const auto is_month = [&](size_t at) { return number(at, 2) >= 1 && number(at, 2) <= 12; };
  const auto is_day = [&](size_t at) {  // DDMM or MMDD
    const int first = number(at, 2), second = number(at + 2, 2);
    return IsDay(first, second) || IsDay(second, first);
  };
  if (pin.size() == 6) {
    return is_day(0) || IsDay(number(2, 2), number(4, 2)) || (is_month(0) && is_year(2)) ||
           (is_year(0) && is_month(4));
  }
  return pin.size() == 8 &&
         ((is_day(0) && is_year(4)) || (is_year(0) && IsDay(number(4, 2), number(6, 2))));
}

Status EasyToGuess(const char* field, const std::string& why) {
  return Status(Code::kInvalidInput, "this PIN is easy to guess: " + why, field);
}

}  // namespace

Status CheckPin(const std::string& pin) {
  bool digits = std::ranges::all_of(pin, [](char c) { return c >= '0' && c <= '9'; });
  if (pin.size() < kMinDigits || pin.size() > kMaxDigits || !digits) {
    return Status(Code::kInvalidInput,
                  "a PIN has 6 to 12 digits and nothing else: choose digits without a pattern",
                  kPinDigits);
  }
  if (RepeatsOneOrTwo(pin)) {
    return EasyToGuess(kPinRepeats, "it repeats one digit or two; choose digits without a pattern");
  }
  if (Steps(pin, 1) || Steps(pin, 9)) {
    return EasyToGuess(kPinRun, "its digits count up or down; choose digits without a pattern");
  }
  if (IsDate(pin)) {
    return EasyToGuess(kPinDate,
                       "it is a date, such as a birthday; choose digits that are no date");
  }
  return Status::Ok();
}

}  // namespace enamel
