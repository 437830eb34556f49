#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "common/base/check.h"
#include "common/base/result.h"
#include "common/cutting/bur.h"
#include "common/cutting/volume.h"
#include "station/render/frame_state.h"

// The station's window: the tooth being cut, the bur, the forces.
//
// How the picture is fed without the tick ever waiting:
//
//   tick thread ── Publish ──────▶ latest-value mailbox ─────────────────────────▶ main thread
//   (draws)
//               └─ PublishBricks ▶ dirty set ▶ bounded ring ▶ mesher (replica) ▶ meshes ┘
//
// The mesher owns a replica of the volume. A brick the cut changes is marked dirty on the tick
// thread; each tick copies at most kBricksPerTick dirty bricks (1 kB each) into a ring that the
// mesher empties. A full ring leaves bricks dirty, so nothing is ever lost and no resync is needed:
// a brick that changes many times while it waits is copied once, as it is then. The picture lags by
// dirty bricks / kBricksPerTick ticks at most, and the recording is never touched by it.
namespace enamel::station::render {

enum class View { kOblique, kOcclusal, kBuccal, kMesial };

struct WindowOptions {
  std::string title = "Enamel";
  std::string heading;  // who and what, shown in the panel: "Class I, molar 46"
  int width_px = 1280;
  int height_px = 800;
  bool visible = true;  // false: drawn off screen, for screenshots and tests
  bool panel = true;    // false: only the solid picture
  cutting::Bur bur;
  double force_full_scale_n = 3.0;  // right end of the force bar: the device's continuous force
  double time_limit_s = 0;          // 0: none; the timer counts up either way
  View view = View::kOblique;
  // What the camera circles around, scene frame; the middle of the crown for a tooth.
  dvec3 focus_m{0};
  // Radius (m) of what should fill the view; 0: from the volume's surface.
  double view_radius_m = 0;
};

// Thread safety: Publish and PublishBricks are called by one thread, the producer (the tick thread
// or, in lockstep, the one that steps the core); everything else on the thread that called Create,
// which on some systems must be the process's main thread. One window per process. Lifetime:
// destroy after the producer has stopped. Before the first Publish the bur is not drawn; after the
// last one the picture stays as it is.
class Window {
 public:
  static constexpr size_t kBricksPerTick = 4;

  // Opens the window and begins to mesh `initial` (copied).
  // Errors: kUnavailable when there is no display or no OpenGL 3.3, with what to do.
  static Result<std::unique_ptr<Window>> Create(const WindowOptions& options,
                                                const cutting::Volume& initial);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // --- producer ---
  // Latest state; older ones that were not drawn are dropped. Real-time: safe, wait-free.
  ENAMEL_REALTIME void Publish(const FrameState& state) noexcept;
  // `touched` bricks of `volume` changed (core::Core::touched()). Call each tick, also with an
  // empty span, so that bricks which wait are sent. `volume` must be the same object each time.
  // Real-time: safe, wait-free; cost at most kBricksPerTick copies of 1 kB.
  ENAMEL_REALTIME void PublishBricks(const cutting::Volume& volume,
                                     std::span<const int32_t> touched) noexcept;
  // Sends all that waits and blocks until the mesher has it all: for the end of an attempt.
  // Requires: the producer has stopped or is the caller. Not real-time.
  void FlushBricks(const cutting::Volume& volume);

  // --- main thread ---
  // Draws one frame and handles input. False once the operator closed the window.
  // Waits for the display's refresh where there is one.
  bool PumpOnce();
  // Pumps until `done` returns true (asked once a frame) or the window is closed.
  void Run(const std::function<bool()>& done);
  // Waits (at most 30 s) until every brick received is meshed, draws one frame and writes it as
  // PNG. Errors: kStorage with the path when it cannot be written; kUnavailable when meshing did
  // not end.
  Status WriteScreenshot(const std::string& path);
  void SetView(View view);

 private:
  class Impl;
  explicit Window(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::station::render
