#include "station/desk/result_loss_view.h"

#include <algorithm>
#include <utility>

#include "station/desk/desk_attempt.h"

namespace enamel::station::desk {
namespace {

// Half the picture's height: the bur's head and the walls around the place are in it.
constexpr float kRadius_mm = 4.5f;
constexpr double kLongestStep_s = 0.1;

// A wall is seen over the opposite one's rim: upright as far as its own lean allows.
glm::vec3 SeenFrom(const dvec3& facing) { return glm::vec3(facing) + glm::vec3(0, 0, 1.2f); }

// The bur that made the mistake, with nothing around it.
render::ViewOptions WithoutHandpiece(const PreparedAttempt& prepared) {
  render::ViewOptions view = ViewOf(prepared);
  view.handpiece = false;
  return view;
}

}  // namespace

LossView::LossView(const PreparedAttempt& prepared, Stretch stretch,
                   const scoring::Deduction& place)
    : stretch_(std::move(stretch)),
      tick_s_(1.0 / prepared.header.params.rate_hz),
      place_mm_(place.position_m * 1000.0),
      view_(WithoutHandpiece(prepared), stretch_.core->volume()),
      passed_ticks_(stretch_.passed_ticks) {
  view_.camera().LookAt(place_mm_, SeenFrom(place.facing), kRadius_mm);
}

void LossView::Step() {
  const core::TickInput& input = stretch_.ticks[next_++].input;
  core::Core& core = *stretch_.core;
  const core::TickOutput out = core.Step(input);
  passed_ticks_ += 1 + input.gap_ticks;
  render::FrameState frame;
  frame.tick = core.ticks();
  frame.time_s = time_s();
  frame.anchor = out.anchor;
  frame.device = out.anchor;  // of the hand only the bur is shown
  frame.pressed_n = out.pressed_n();
  frame.bur_on = (input.flags & core::kBurOn) != 0;
  frame.bur = static_cast<uint8_t>(core.bur());
  view_.Publish(frame);
  view_.PublishBricks(core.volume(), core.touched());
}

void LossView::Advance(double dt_s) {
  // Until the tooth as it was is there, nothing is cut out of it.
  if (next_ == 0 && !drawn()) return;
  if (over()) return view_.PublishBricks(stretch_.core->volume(), {});
  owed_s_ += std::min(dt_s, kLongestStep_s);
  for (; owed_s_ >= tick_s_ && !over(); owed_s_ -= tick_s_) Step();
}

double LossView::time_s() const { return static_cast<double>(passed_ticks_) * tick_s_; }

LossView::Ring LossView::RingIn(int width, int height) const {
  const render::Camera& camera = view_.camera();
  const float h = static_cast<float>(height), w = static_cast<float>(width);
  const glm::mat4 clip_from_scene = camera.ClipFromView(w / h) * camera.ViewFromScene();
  auto in_pixels = [&](const glm::vec3& at_mm) {
    const glm::vec4 clip = clip_from_scene * glm::vec4(at_mm, 1);
    return glm::vec2(0.5f * (1 + clip.x / clip.w) * w, 0.5f * (1 - clip.y / clip.w) * h);
  };
  // As far as the score counts a fault as being at this place.
  const auto radius_mm = static_cast<float>(scoring::kNearPlace_m * 1000);
  const glm::vec2 middle = in_pixels(place_mm_);
  return {middle, glm::distance(middle, in_pixels(place_mm_ + radius_mm * camera.Right()))};
}

}  // namespace enamel::station::desk
