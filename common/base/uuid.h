#pragma once

#include <array>
#include <chrono>
#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/unix_time.h"

namespace enamel {

// UUID version 7 (RFC 9562): 48 bits of Unix milliseconds and 74 random bits, so keys sort by age.
struct Uuid {
  std::array<uint8_t, 16> bytes{};

  auto operator<=>(const Uuid&) const = default;
  bool IsZero() const { return *this == Uuid{}; }
  ByteView view() const { return bytes; }
  // 8-4-4-4-12 lower-case hexadecimal digits.
  std::string Text() const;
  static Result<Uuid> Parse(std::string_view text);
  static Uuid FromBytes(ByteView view);  // Requires: view.size() == 16.
  // Fresh, from the operating system's random source. Ids one process makes within a millisecond
  // keep their order (a 12-bit counter, RFC 9562 section 6.2 method 1), so sorting by id tells what
  // came first. Thread safety: any thread.
  static Uuid New(std::chrono::system_clock::time_point now = WallClock());
};

}  // namespace enamel
