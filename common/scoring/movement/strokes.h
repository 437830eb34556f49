#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/core/core.h"
#include "common/trace/trace.h"

// The strokes of an attempt: what people who look at a recording count and name.
//
// A tick is in contact when the hand presses (core::PressedForce_mn is not 0) or something is
// removed. A contact begins at a tick in contact and lasts until none has followed for kLift_s, or
// until the tip's way is broken (core::kAnchorReset: a gap, a fault). Its end is its last tick in
// contact. A stroke is a contact in which something was removed. Strokes are numbered from 1.
//
// kLift_s is a tenth of a second: a bur that hops over the grain of a wall leaves it for a few
// milliseconds, a hand that lifts needs about 0.2 s to come back.
//
// Deterministic. Thread safety: one owner. Real-time: not safe (allocates).
namespace enamel::scoring {

struct Stroke {
  // Ticks of the recording, from 0, gaps not included; and the time since the start, gaps included.
  uint64_t first_tick = 0, last_tick = 0;
  double first_s = 0, last_s = 0;
  cutting::RemovedUnits removed{};  // per tissue, 1/65536 voxel

  bool operator==(const Stroke&) const = default;
};

class StrokeRecorder {
 public:
  static constexpr double kLift_s = 0.1;

  // Requires: ValidateParams(params).ok().
  explicit StrokeRecorder(const core::CoreParams& params);
  // Every tick, in order.
  void Add(const trace::Tick& tick, const core::TickOutput& output);

  // The strokes so far, including the current one.
  std::vector<Stroke> Strokes() const;
  bool in_contact() const { return open_; }        // after the last Add
  uint64_t contacts() const { return contacts_; }  // strokes and those without a cut
  double contact_s() const;                        // from first to last tick of each, summed
  uint32_t rate_hz() const { return rate_hz_; }
  // Time since the start of a tick, gaps included. Requires: it was added.
  double TimeOf_s(uint64_t tick) const;
  // Number of the stroke, from 1, that a tick is in; 0: in none. `strokes` as Strokes() gives them.
  static uint32_t NumberAt(const std::vector<Stroke>& strokes, uint64_t tick);

 private:
  struct Gap {
    uint64_t tick, sum;  // from this tick on, so many ticks are missing before
  };

  void Close();

  uint32_t rate_hz_;
  uint64_t lift_ticks_;
  uint64_t ticks_ = 0, contacts_ = 0, contact_ticks_ = 0;
  bool open_ = false;
  Stroke now_;
  std::vector<Stroke> strokes_;
  std::vector<Gap> gaps_;
};

}  // namespace enamel::scoring
