#pragma once

#include <vector>

#include "common/fidelity/plant.h"
#include "station/lab/laws/strokes.h"

// The hand's way in each of the six strokes, and the hand that goes it. Private to strokes.cpp and stroke_way.cpp.
namespace enamel::station::lab {

// Cylinder r 0.6 x 4 mm.
const cutting::Bur& StrokeBur();

struct StrokeLeg {
  dvec3 to{0};
  double speed_m_per_s = 0;  // 0: stays where it is for hold_s
  double hold_s = 0;
};

// The hand's path for the tip. A force at the end: the hand then pushes along `push`.
struct StrokeWay {
  dvec3 start{0};
  std::vector<StrokeLeg> legs;
  size_t record_from = 0;  // leg before whose begin half a second is recorded
  dvec3 along{1, 0, 0};    // positions are drawn along this
  dvec3 push{0};           // newtons; 0: the hand prescribes all of its way
  double push_end_m = 0;   // the record ends when the tip is so far along
  bool leaves = false;     // ends with nothing ahead
  bool withdraws = false;  // by going back or up
};

StrokeWay WayOf(StrokeCase c, const DeviceModel& m);

// Follows the legs, then pushes if the case has a push, kept on its line by a soft spring across. `way` outlives it.
class LegHand final : public Hand {
 public:
  explicit LegHand(const StrokeWay& way);
  double mass_kg() const override;
  Grip At(double t_s) override;
  // Direction of the intended motion, unit.
  dvec3 DirectionAt(double t_s) const;
  bool pushing(double t_s) const { return Dot(way_.push, way_.push) > 0 && t_s > end_s_; }
  double end_s() const { return end_s_; }
  double record_from_s() const;
  // Once a tick: the tip's position, and the resistance to the hand. Starts the push.
  void Feels(const dvec3& tip_m, const dvec3& r_n, double t_s);

 private:
  struct Part {
    double from_s = 0, lasts_s = 0;
    dvec3 from{0}, to{0}, direction{1, 0, 0};
  };
  const Part& PartAt(double t_s) const;

  const StrokeWay& way_;
  std::vector<Part> parts_;
  double end_s_ = 0, led_with_n_ = 0;
  dvec3 tip_{0};
};

}  // namespace enamel::station::lab
