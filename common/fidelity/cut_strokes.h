#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/core/core.h"
#include "common/fidelity/felt.h"
#include "common/scene/types.h"

// The strokes in which tissue is removed, found in what was recorded, and how far a device's force is from
// the tissue's in them. Deterministic. SI units. Thread safety: functions, any thread; a recorder, one owner.
// Real-time: not safe.
namespace enamel::fidelity {

struct CutStroke {
  std::vector<dvec3> way_m;  // of the tip, from 0, one position a millisecond (way.h)
  // B that the bur met along its way: work of the resisting force over the square of the way, times the time.
  double b_n_s_per_m = 0;
  double speed_m_per_s = 0;  // of the bur, mean
  double seconds = 0;        // of the removal that this stroke stands for
};

// Finds the strokes of one recording. A stroke lasts while tissue is removed, with rests of at most a tenth of
// a second, for 0.3 to 4 s. Tissue counts as removed where a turning bur moves, faster than 0.02 mm/s, against more
// than 0.02 N. Memory: at most kMaxStrokes strokes, 6 MB. Beyond them the recorder drops every second stroke
// and counts its time for the one before.
class CutStrokes {
 public:
  static constexpr size_t kMaxStrokes = 64;

  // Requires: ValidateParams(params).ok().
  explicit CutStrokes(const core::CoreParams& params);
  // Every tick, in order.
  void Add(const core::TickInput& input, const core::TickWitness& witness);
  // Ends the recording. `count` strokes at even shares of the time in which tissue is removed, so that each
  // stands for the same time; a long one may be there twice. Empty: nothing was removed for 0.3 s.
  // Requires: count > 0.
  std::vector<CutStroke> Spread(int count);
  size_t kept() const { return strokes_.size(); }

 private:
  // A hundredth of a second: a witness says where the bur is to 0.1 um, and a slow bur moves less in a tick.
  struct Block {
    dvec3 moved_m{0}, resisted_n{0};
    bool turns = false;  // the bur, all the time
    bool removes() const;
  };

  void EndBlock(const dvec3& bur_m);
  // Takes the stroke under way, if it is long enough.
  void Close();
  CutStroke StrokeUnderWay() const;

  core::CoreParams params_;
  uint32_t every_, ticks_ = 0;  // ticks a position
  // The stroke under way has these positions, one a millisecond, and blocks; end_ is behind the last that removes.
  std::vector<dvec3> way_;
  std::vector<Block> blocks_;
  size_t end_ = 0;
  size_t filled_ = 0;  // positions of the block that is being filled
  dvec3 bur_m_{0}, sum_n_{0};
  bool turns_ = true;
  std::vector<CutStroke> strokes_;
};

// The stroke in a hand of this grip, with what the law leaves out; without the damper on the device.
FeltTrial TrialOf(const CutStroke& stroke, double grip_n_per_m, int delay_ticks,
                  const haptics::OwnFriction& told);

// The hand that a figure of an attempt is given for: between a loose grip and a firm one.
inline constexpr double kAttemptGrip_n_per_m = 1000;

// The device that an attempt was made with: the profile's mass and damping, the recording's spring and ceiling. Its
// friction is the unit's where that was measured, else the profile's.
FeltDevice FeltDeviceOf(const scene::DeviceProfile& profile, const core::CoreParams& params);

// By how much the force in a hand of that grip was off, as a share of the tissue's force (felt.h), in up to
// eight strokes at even shares of the cutting. Nothing where the device has no motors, where its board ran the
// spring, where nothing was cut, and at rates that are no whole number of kHz.
std::optional<double> FeltErrorOf(const scene::DeviceProfile& profile,
                                  const core::CoreParams& params, CutStrokes& strokes);

}  // namespace enamel::fidelity
