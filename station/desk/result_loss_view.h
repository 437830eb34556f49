#pragma once

#include <memory>

#include "common/scoring/deductions.h"
#include "station/render/tooth_view.h"
#include "station/session/look_back.h"

namespace enamel::station::desk {

// Shows from near a place that lost points, and replays the stroke that took them, as fast as it was
// made. Needs the OpenGL context current. Owner's thread only.
class LossView {
 public:
  // Throws std::runtime_error when the driver refuses the picture.
  LossView(const PreparedAttempt& prepared, Stretch stretch, const scoring::Deduction& place);

  // Makes the next ticks, once the tooth is drawn. A window that hung skips nothing: it continues
  // where it was.
  void Advance(double dt_s);
  bool drawn() { return view_.WaitIdle(std::chrono::milliseconds(0)); }
  bool over() const { return next_ == stretch_.ticks.size(); }
  render::ToothView& view() { return view_; }
  // Time of the attempt.
  double time_s() const;
  // The ring around the place, pixels of a window of this size.
  struct Ring {
    glm::vec2 middle_px{0};
    float radius_px = 0;
  };
  Ring RingIn(int width, int height) const;

 private:
  void Step();

  Stretch stretch_;
  const double tick_s_;
  const glm::vec3 place_mm_;
  render::ToothView view_;
  size_t next_ = 0;
  double owed_s_ = 0;
  uint64_t passed_ticks_;
};

}  // namespace enamel::station::desk
