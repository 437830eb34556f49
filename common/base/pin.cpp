#include "common/base/pin.h"

#include <algorithm>

namespace enamel {
namespace {

constexpr size_t kMinDigits = 6, kMaxDigits = 12;

// All steps from one digit to the next are `step`.
bool Steps(const std::string& pin, int step) {
  return std::adjacent_find(pin.begin(), pin.end(),
                            [step](char a, char b) { return b - a != step; }) == pin.end();
}

}  // namespace

Status CheckPin(const std::string& pin) {
  bool digits = std::ranges::all_of(pin, [](char c) { return c >= '0' && c <= '9'; });
  if (pin.size() < kMinDigits || pin.size() > kMaxDigits || !digits) {
    return Status(Code::kInvalidInput, "a PIN has 6 to 12 digits and nothing else", "pin");
  }
  if (Steps(pin, 0) || Steps(pin, 1) || Steps(pin, -1)) {
    return Status(
        Code::kInvalidInput,
        "this PIN is easy to guess: choose digits that are not all the same and not in a row",
        "pin");
  }
  return Status::Ok();
}

}  // namespace enamel
