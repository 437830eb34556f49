#include "station/render/tooth_view.h"

#include <algorithm>
#include <thread>

#include "station/render/gl_objects.h"
#include "station/render/handpiece.h"

namespace enamel::station::render {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kRingBricks = 1024;  // about 1 MB
constexpr auto kFlushLimit = std::chrono::seconds(30);
constexpr double kGhostFrom_m = 50e-6;  // apart by less, hand and bur look the same
constexpr float kArrowFullScale_mm = 5;
constexpr float kSpinPerFrame = 0.37f;  // for the eye: not the true speed

// Whether the brick has tissue of the tooth to work on.
bool IsOwn(const cutting::Volume& volume, int brick) {
  if (!volume.IsStored(brick)) return false;
  const auto neighbour = cutting::Tissue::kNeighbour;
  if (!volume.HasLabels(brick)) return volume.UniformTissue(brick) != neighbour;
  return std::ranges::any_of(volume.Labels(brick).tissue, [&](uint8_t label) {
    return label != static_cast<uint8_t>(cutting::Tissue::kAir) &&
           label != static_cast<uint8_t>(neighbour);
  });
}

// Half the larger of length and width of the solid without its neighbours, with a margin.
float RadiusOf(const cutting::Volume& volume) {
  const cutting::GridSpec& spec = volume.spec();
  ivec3 lo = spec.bricks, hi(-1);
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!IsOwn(volume, b)) continue;
    ivec3 at(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
             b / (spec.bricks.x * spec.bricks.y));
    lo = glm::min(lo, at);
    hi = glm::max(hi, at);
  }
  int bricks = std::max({hi.x - lo.x, hi.y - lo.y, 0}) + 1;
  return 0.62f * static_cast<float>(bricks * cutting::kBrickSide * spec.voxel_m() * 1000);
}

glm::mat4 FromPose(const cutting::Pose& pose) {
  glm::mat4 m(glm::mat3(pose.orientation.Matrix()));
  m[3] = glm::vec4(glm::vec3(pose.tip_m * 1000.0), 1);
  return m;
}

}  // namespace

ToothView::ToothView(const ViewOptions& options, const cutting::Volume& initial, VolumeWatch watch,
                     const cutting::Volume* uncut)
    : options_(options),
      camera_(glm::vec3(options.focus_m * 1000.0),
              options.view_radius_m > 0 ? static_cast<float>(options.view_radius_m * 1000)
                                        : RadiusOf(initial),
              options.aside, options.mesial_x),
      mirror_(glm::vec3((options.work_radius_m > 0 ? options.work_m : options.focus_m) * 1000.0),
              options.crown_aside),
      feed_(initial.spec().brick_count(), kRingBricks),
      mesher_(initial, feed_, std::move(watch), uncut),
      picture_(options.burs, mesher_.group_count()) {
  camera_.SetView(options.view);
}

void ToothView::PublishBricks(const cutting::Volume& volume,
                              std::span<const int32_t> touched) noexcept {
  feed_.Mark(touched);
  feed_.Send(volume, kBricksPerTick);
}

void ToothView::FlushBricks(const cutting::Volume& volume) {
  auto until = Clock::now() + kFlushLimit;
  while (feed_.dirty_count() > 0 && Clock::now() < until) {
    if (feed_.Send(volume, kRingBricks) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  mesher_.WaitIdle(kFlushLimit);
}

void ToothView::TakeNewest() {
  const auto& newest = latest_.Read();
  if (!newest) return;
  // What was removed before the first state was not seen to be removed.
  const FrameState before = has_state_ ? state_ : *newest;
  state_ = *newest;
  has_state_ = true;
  const auto dt_s = static_cast<float>(std::max(state_.time_s - before.time_s, 0.0));
  auto removed_mm3 = state_.removed_mm3;
  for (size_t t = 0; t < removed_mm3.size(); ++t) removed_mm3[t] -= before.removed_mm3[t];
  chips_.Step(dt_s);
  chips_.Add(removed_mm3, options_.burs[BurNow()], state_.anchor, dt_s);
}

size_t ToothView::BurNow() const { return std::min<size_t>(state_.bur, options_.burs.size() - 1); }

PictureState ToothView::PictureNow(float aspect) {
  PictureState picture;
  picture.view_from_scene = camera_.ViewFromScene();
  picture.clip_from_view = camera_.ClipFromView(aspect);
  picture.lines = outline_shown_;
  picture.scenery = true;
  if (mirror_.shown()) picture.scene_from_mirror = mirror_.SceneFromMirror();
  if (!has_state_) return picture;
  picture.chips = chips_.all();
  picture.scene_from_bur = FromPose(state_.anchor);
  if (glm::length(state_.device.tip_m - state_.anchor.tip_m) > kGhostFrom_m) {
    picture.scene_from_ghost = FromPose(state_.device);
  }
  picture.bur = BurNow();
  if (options_.handpiece)
    picture.handle_azimuth = HandleAzimuth(state_.anchor.orientation, camera_);
  dvec3 middle = state_.anchor.tip_m + state_.anchor.orientation.Matrix()[2] *
                                           (0.5 * options_.burs[picture.bur].height_m());
  picture.arrow_from_mm = glm::vec3(middle * 1000.0);
  picture.arrow_mm = glm::vec3(state_.pressed_n / options_.force_full_scale_n) * kArrowFullScale_mm;
  if (state_.bur_on) spin_ += kSpinPerFrame;
  picture.bur_spin = spin_;
  return picture;
}

std::optional<glm::vec2> ToothView::BurAway(int width, int height) const {
  if (!has_state_) return std::nullopt;
  return camera_.Away(glm::vec3(state_.anchor.tip_m * 1000.0),
                      static_cast<float>(width) / static_cast<float>(height));
}

Camera StillCamera(const ViewOptions& options, const cutting::Volume& tooth) {
  const bool near = options.work_radius_m > 0;
  const float whole_mm = RadiusOf(tooth);
  return {glm::vec3((near ? options.work_m : options.focus_m) * 1000.0),
          near ? std::min(static_cast<float>(options.work_radius_m * 1000), whole_mm) : whole_mm, 0,
          options.mesial_x};
}

Image ReadImage(const Target& picture) { return picture.Read(); }

unsigned TextureOf(const Target& picture) { return picture.colour(); }

void ToothView::Draw(int width, int height, const Quality& quality) {
  for (const GroupMesh& mesh : mesher_.TakeReady()) picture_.Replace(mesh);
  TakeNewest();
  picture_.Draw(PictureNow(static_cast<float>(width) / static_cast<float>(height)), width, height,
                quality);
}

}  // namespace enamel::station::render
