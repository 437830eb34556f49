#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/math/vec.h"
#include "common/scene/delay.h"
#include "common/scene/types.h"

// The map of what a hand can feel: per device, tissue and speed, whether the force follows
// F = max(Fth, Fc + B v) closely enough that a hand cannot tell, and if not, whether another law
// could.
//
// Each cell is simulated with the product's own coupling and default law: a hand that prescribes
// its way, oblique to the axes (1, 2, 3), encoder cells of edge delta along the axes, the device's
// Kc, rate and delay, uniform tissue. Beside the law runs the oracle of tracks.h under the same Kc
// and delay. The oracle is a reference, not a bound: from rest no passive law beats it; where
// strokes turn, a law with an energy tank may. It knows the speed that a law has to guess from one
// count every delta/v seconds. Not in it: the shape of a cut, a hand that gives way, joint
// encoders, the bur's axial B, motor heating.
//
// Deterministic. Work: at most 12 s of steady cutting and 6 s of strokes per tissue and speed,
// ticks of about 0.4 us. Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::fidelity {

// The smallest differences that a hand feels, as shares of the right value and as a time. The
// published figures are for trained hands in a laboratory that look for the difference: within them
// nobody feels one. Force: Jones 1989 (Perception 18:681), 7 %; Pang, Tan and Durlach 1991
// (Perception & Psychophysics 49:531), 5 to 10 %.
inline constexpr double kForceShare = 0.07;
// Viscosity: Jones, Hunter and Lafontaine 1997 (Perception 26:1571), 19 % between 4 and 512 N s/m.
// Tooth tissue is up to 22 times above that range; the figure is taken to hold there as well.
inline constexpr double kViscosityShare = 0.19;
// Delay of a damper's force: Rank, Shi, Mueller and Hirche 2010 (EuroHaptics, LNCS 6191), noticed
// from 15 ms.
inline constexpr double kDelay_s = 0.015;

struct Threshold {
  std::string_view name;  // stable: "force", "viscosity", "delay"
  double value;
  std::string_view unit;  // "share" or "s"
  std::string_view source;
};
std::span<const Threshold> Thresholds();

// Mean speeds of the hand. 0.43 mm/s is the speed of the paper's cuts.
inline constexpr double kSpeeds_m_per_s[] = {0.1e-3, 0.2e-3, 0.43e-3, 1e-3};

// A device as the coupling is run with it.
struct Device {
  std::string name;
  double resolution_m = 0;  // delta, edge of an encoder cell
  double kc_n_per_m = 0;
  double tick_s = 0;
  int delay_ticks = 0;  // from reading to force
  double peak_force_n = 0, continuous_force_n = 0;
};

// The device as an attached unit of this profile runs: with the delay that scene::DelayOfAttached
// gives it where the unit itself was not calibrated, and Kc lowered to what is passive then.
// `delay` as kProfile or kAssumed says where the ticks are from. Errors: kInvalidInput, field
// named, when the profile allows no coupling at all, or its resolution, rate or peak force is not
// above 0.
struct AttachedDevice {
  Device device;
  scene::DelayUsed delay;
};
Result<AttachedDevice> Attached(const scene::DeviceProfile& profile);
// With the profile's unchanged numbers: a simulated device. Errors as above.
Result<Device> AsItStands(const scene::DeviceProfile& profile);

// False for the built-in profile of what has no motors ("pointer"): its force is shown, not felt.
bool HasMotors(const scene::DeviceProfile& profile);

struct Tissue {
  std::string name;
  double b_n_s_per_m = 0;  // across the bur's axis
  double coulomb_n = 0, threshold_n = 0;
};
Tissue TissueOf(const scene::TissueSpec& spec);
// The right force at a speed along the motion, N.
double RightForce_n(const Tissue& tissue, double speed_m_per_s);

enum class Motion : uint8_t {
  kSteady = 0,   // straight on at constant speed, from rest
  kStrokes = 1,  // to and fro, minimum-jerk strokes of a second each
};
inline constexpr Motion kMotions[] = {Motion::kSteady, Motion::kStrokes};

// How close a force came to the right one. Shares are of the right force.
struct Figures {
  // Steady: mean of |F - right| after the rise, over at most the last 40 % of the cut. Strokes: RMS
  // over RMS, of the last two strokes to and two fro.
  double error = 0;
  // Force along the motion over what is right. Steady: of the means. Strokes: least squares, so
  // that B times this is the viscosity that is felt.
  double gain = 0;
  // Strokes: at which the force and what is right correlate best, within 0.75 s. Steady: 0.
  double lag_s = 0;
  // Steady: until the force is first within 7 % of what is right, -1: never. Strokes: 0.
  double rise_s = 0;
};

// In order of what they mean to a hand. Stable names: VerdictName.
enum class Verdict : uint8_t {
  kFelt = 0,      // within 7 %, and within 15 ms
  kLate = 1,      // within 7 %, but it takes longer than 15 ms to come
  kNearly = 2,    // within 19 %: a hand takes it for the same tissue, and may notice the force
  kLawShort = 3,  // beyond that, though the oracle is within 7 % and 15 ms: Kc would do, the law
                  // with what the encoder tells it does not
  kDeviceCannot = 4,  // beyond that, and the oracle is not within 7 % and 15 ms: no law without
                      // stored energy could, most often since Kc is too small
  kBeyondForce = 5,   // the motors cannot give it: RMS above continuous, or largest above peak
};
inline constexpr int kVerdictCount = 6;
std::string_view VerdictName(Verdict v);   // "felt", "late", "nearly", "law_falls_short", ...
std::string_view VerdictWords(Verdict v);  // "as it is", "late", ..., for tables
std::string_view MotionName(Motion m);     // "steady", "strokes"

struct Cell {
  size_t tissue = 0;         // index into the tissues asked for
  double speed_m_per_s = 0;  // mean
  Motion motion = Motion::kSteady;
  double rms_n = 0, largest_n = 0;  // of what is right
  Figures law, oracle;
  Verdict verdict = Verdict::kFelt;
};

// Within 7 % and 15 ms: the delay is the rise of a steady cut and the lag of strokes.
bool Holds(Motion motion, const Figures& figures);
// The verdict on a cell's figures; ignores its `verdict`.
Verdict VerdictOf(const Device& device, const Cell& cell);

// One cell, its verdict included. Requires: the device's numbers above 0, a B above 0, a speed
// above 0.
Cell Simulate(const Device& device, const Tissue& tissue, double speed_m_per_s, Motion motion);
// Every tissue at every speed of kSpeeds_m_per_s in both motions; tissue slowest, motion fastest.
std::vector<Cell> MapOf(const Device& device, std::span<const Tissue> tissues);

}  // namespace enamel::fidelity
