#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/cutting/volume.h"
#include "station/lab/laws/model.h"

// Six short motions of a hand (press, stroke, reverse, lift, nick, slip-out), run with the
// product's own core on a real volume with a real bur, and recorded tick by tick beside the ideal.
// SI units. Document: schemas/strokes.schema.json.
//
// Bur: cylinder of radius 0.6 mm, length 4 mm, upright. Block: WithdrawalBlock, enamel of
// B = 6.5 N s/mm at the reference engagement (cutting/engagement.h), 2 mm of the bur's side in it.
//
// Ideal: the bur is at the tip itself. The force is then B v, B the damping that the bur meets
// there in its direction, in a block cut by the tip; 0 where nothing is ahead. Each track has its
// own. Oracle: follows the ideal down at once, and rises by at most Kc |v| T in a tick: the best
// that a coupling of stiffness Kc could do without a memory.
namespace enamel::station::lab {

enum class StrokeCase { kPress, kStroke, kReverse, kLift, kNick, kSlipOut };
inline constexpr StrokeCase kStrokeCases[] = {StrokeCase::kPress,   StrokeCase::kStroke,
                                              StrokeCase::kReverse, StrokeCase::kLift,
                                              StrokeCase::kNick,    StrokeCase::kSlipOut};
// "press", "stroke", "reverse", "lift", "nick", "slip-out".
const char* StrokeName(StrokeCase c);

// One tick. Forces are those the hand feels against it, R = -F.
struct StrokePoint {
  double t_s = 0;
  double force_n = 0;      // part of R against the hand's motion; below 0: it pushes the hand along
  double magnitude_n = 0;  // |R|
  double ideal_n = 0, oracle_n = 0;  // parts against the motion
  double tip_m = 0, bur_m = 0;       // along the case's way, 0 where the record begins
};

// A measured number. Without a bound it is reported, not judged.
struct StrokeFigure {
  std::string name, unit;
  double value = 0;
  std::optional<double> bound;
  bool held() const { return !bound || value <= *bound + 1e-9; }
};

struct StrokeTrack {
  StrokeCase which = StrokeCase::kPress;
  haptics::LawKind law = haptics::kDefaultLaw;
  std::optional<double> leaves_s;   // when the ideal bur leaves the tissue behind for good
  std::vector<StrokePoint> points;  // every tick
  std::vector<StrokeFigure> figures;
  bool held() const;
};

// Deterministic. Thread safety: any thread; `block` is only read.
StrokeTrack RunStroke(const DeviceModel& model, StrokeCase c, haptics::LawKind law,
                      const cutting::Volume& block);

// Which points to draw: the first, the last, and the least and the largest force of equally many
// ticks, so that no peak is lost. At most `most` (>= 8) indices, rising.
std::vector<size_t> PointsToDraw(const std::vector<StrokePoint>& points, size_t most);

// Results of one device, in the order of kStrokeCases; for each case the default law first.
struct StrokeDevice {
  DeviceModel model;
  std::vector<StrokeTrack> tracks;
};
inline constexpr size_t kMaxDrawn = 800;
// The document of schemas/strokes.schema.json.
std::string StrokesJson(const std::vector<StrokeDevice>& devices, size_t most_points = kMaxDrawn);

}  // namespace enamel::station::lab
