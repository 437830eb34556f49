#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>

#include "common/base/check.h"
#include "common/base/triple_buffer.h"
#include "common/cutting/bur.h"
#include "common/cutting/volume.h"
#include "station/render/brick_feed.h"
#include "station/render/camera.h"
#include "station/render/chips.h"
#include "station/render/frame_state.h"
#include "station/render/mesher.h"
#include "station/render/mouth_mirror.h"
#include "station/render/picture.h"
#include "station/render/png_file.h"
#include "station/render/quality.h"
#include "station/render/view.h"

namespace enamel::station::render {

// A tooth being cut, the bur, the forces: the solid picture of one attempt.
//
// How the picture is fed without the tick ever waiting:
//
//   tick thread ── Publish ──────▶ latest-value mailbox ────────────────▶ main thread (draws)
//               └─ PublishBricks ▶ dirty set ▶ bounded ring ▶ mesher (replica) ▶ meshes ┘
//
// The mesher owns a replica of the volume. The tick thread marks each brick that the cut changes as
// dirty; each tick copies at most kBricksPerTick dirty bricks (1 kB each) into a ring that the
// mesher empties. A full ring leaves bricks dirty, so nothing is lost and no resync is needed: a
// brick that changes many times while it waits is copied once, in its last state. The picture lags
// by dirty bricks / kBricksPerTick ticks at most, and the recording is not affected.
//
// Thread safety: one thread, the producer, calls Publish and PublishBricks (the tick thread or, in
// lockstep, the one that steps the core); everything else is on the thread that has the OpenGL
// context. Destroy after the producer has stopped. Before the first Publish the bur is not drawn;
// after the last one the picture does not change.
class ToothView {
 public:
  static constexpr size_t kBricksPerTick = 4;

  // Starts meshing a copy of `initial`. `watch` sees the replica at intervals (mesher.h). `uncut`: the
  // tooth before a bur touched it, which must outlive the view, `initial` itself if none has; null:
  // what is cut looks as if it were not. Throws std::runtime_error when the driver refuses a resource.
  ToothView(const ViewOptions& options, const cutting::Volume& initial, VolumeWatch watch = {},
            const cutting::Volume* uncut = nullptr);

  // --- producer ---
  // Sets the newest state; older ones that were not drawn are dropped. Real-time: safe, wait-free.
  ENAMEL_REALTIME void Publish(const FrameState& state) noexcept { latest_.Write(state); }
  // `touched` bricks of `volume` changed (core::Core::touched()). Call each tick, also with an
  // empty span, so that waiting bricks are sent. `volume` must be the same object each time.
  // Real-time: safe, wait-free; cost at most kBricksPerTick copies of 1 kB.
  ENAMEL_REALTIME void PublishBricks(const cutting::Volume& volume,
                                     std::span<const int32_t> touched) noexcept;
  // Sends everything that waits and blocks until the mesher has it: for the end of an attempt.
  // Requires: the producer has stopped or is the caller. Not real-time.
  void FlushBricks(const cutting::Volume& volume);

  // --- main thread ---
  void Draw(int width, int height, const Quality& quality);
  const Target& result() const { return picture_.result(); }
  const PictureWork& work() const { return picture_.work(); }
  Camera& camera() { return camera_; }
  const Camera& camera() const { return camera_; }
  MouthMirror& mirror() { return mirror_; }
  // The target's outline, drawn on the tooth while it is shown.
  void SetOutline(std::span<const surface::LineSegment> lines) { picture_.SetLines(lines); }
  void ShowOutline(bool shown) { outline_shown_ = shown; }
  // What stands around the tooth, from the next picture on.
  void SetScenery(const Scenery& scenery) { picture_.SetScenery(scenery); }
  // Where the bur's tip left the picture (Camera::Away); none before the first tick.
  std::optional<glm::vec2> BurAway(int width, int height) const;
  // Newest state drawn; none before the first tick.
  const FrameState& state() const { return state_; }
  bool has_state() const { return has_state_; }
  // Waits until every brick received is meshed. False on time-out.
  bool WaitIdle(std::chrono::milliseconds limit) { return mesher_.WaitIdle(limit); }

 private:
  // Takes the newest state, and lets fly what was removed since the last one drawn.
  void TakeNewest();
  PictureState PictureNow(float aspect);
  // Of the view's burs, the one in the handpiece.
  size_t BurNow() const;

  const ViewOptions options_;
  Camera camera_;
  MouthMirror mirror_;
  FrameState state_;
  bool has_state_ = false;
  float spin_ = 0;
  Chips chips_;
  bool outline_shown_ = false;
  TripleBuffer<std::optional<FrameState>> latest_;  // none before the first Publish
  BrickFeed feed_;
  Mesher mesher_;
  Picture picture_;
};

// As a view of this tooth begins, but near the place to cut where there is one.
Camera StillCamera(const ViewOptions& options, const cutting::Volume& tooth);

Image ReadImage(const Target& picture);
// OpenGL's name of the picture's texture, whose first row is the lowest.
unsigned TextureOf(const Target& picture);

}  // namespace enamel::station::render
