#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/protocol/station.pb.h"

// What an instructor writes to the person who makes an attempt, during the attempt
// (schemas/wire/README.md, "Remarks"). Pure functions, any thread.
namespace enamel::protocol {

inline constexpr size_t kMaxRemarkCharacters = 500;
inline constexpr size_t kMaxRemarkSenderBytes = 200;
// That one message carries, and that wait to be shown at one attempt.
inline constexpr size_t kMaxRemarks = 8;

struct Remark {
  uint64_t id = 0;  // grows along an attempt's remarks
  std::string text, from;
  int64_t sent_unix_ms = 0;
};

// One line of 1 to kMaxRemarkCharacters characters, as it may be sent: without the spaces around
// it, line breaks and tabs made spaces. Errors: kInvalidInput, field "text": nothing to read, too
// long, no UTF-8, control characters, what turns the direction of writing.
Result<std::string> CheckedRemark(std::string_view text);

void SetRemark(const Remark& remark, wire::Remark& message);
// As it may be shown, whoever sent it: bounded, one line, control characters and bytes that are no
// text as Printable writes them.
Remark ReadRemark(const wire::Remark& message);

}  // namespace enamel::protocol
