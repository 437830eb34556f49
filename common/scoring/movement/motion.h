#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/scoring/movement/process.h"

// How near one attempt's motion is to another's: schemas/motion.md. It finds copied motions and
// proves none: it costs no points. Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

// The bur's way while it pressed, in equal parts of that time: where it was on the mean in each.
// Pauses in the air are not in it, nor is how long it all took.
struct Motion {
  static constexpr size_t kParts = 512;
  static constexpr double kUnit_m = 10e-6;
  std::array<std::array<int16_t, 3>, kParts> at{};  // of kUnit_m, scene frame, within 327 mm

  bool operator==(const Motion&) const = default;
};

// Nothing of a hand that pressed for less than kMinPressed_s or went less than kMinWay_m while
// it did: everybody's short way is alike. Where there was never any force (a device without motors)
// all of the time counts. `samples`: ProcessRecorder's.
inline constexpr double kMinPressed_s = 5, kMinWay_m = 3e-3;
std::optional<Motion> MotionOf(const std::vector<PathSample>& samples);

// The same of a way that is known to be long enough, at equal steps of time. Requires: not empty.
Motion MotionAlong(std::span<const dvec3> way_m);

// Mean distance of the cheapest pairing in time, in a band of a twentieth (align.h); m. Symmetric
// but for the last digits.
double MotionDistance_m(const Motion& a, const Motion& b);

// A motion's distance to others of the same exercise.
struct Nearness {
  size_t others = 0;
  size_t nearest = 0;    // index of it
  double nearest_m = 0;  // how far it is
  double median_m = 0;   // how far the others are: the middle one, of two the nearer
  double size_m = 0;     // of the motion itself: root mean square distance from its middle

  bool operator==(const Nearness&) const = default;
};
// Nothing without others.
std::optional<Nearness> NearnessTo(const Motion& motion, std::span<const Motion> others);

// Whether a person should look at both: nearer than a twentieth of the motion's own size, or, among
// at least kEnoughOthers, nearer than a quarter of the median. Nobody has measured on teeth how
// many people this finds without cause: `enamel-lab hand-signs` prints what is known.
inline constexpr double kNearOfSize = 0.05, kNearOfOthers = 0.25;
inline constexpr size_t kEnoughOthers = 5;
bool IsWorthALook(const Nearness& nearness);

Bytes EncodeMotion(const Motion& motion);
// Accepts only what EncodeMotion writes. Errors: kInvalidInput, kVersion.
Result<Motion> DecodeMotion(ByteView bytes);

}  // namespace enamel::scoring
