#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"
#include "station/desk/target_outline.h"
#include "station/mouth/mouth.h"
#include "station/render/window.h"
#include "tests/station/render/virtual_display.h"

// Cuts part of a class I cavity into the built-in molar and writes the window's picture of it, for
// people: cut_screenshot OUT.png [voxel_um [view [exercise [scene]]]]. With an exercise's kind
// ("crown") it shows that outline on the uncut tooth. With --mirror also what the mirror shows, with --mouth the mouth around it, with
// --dam with the exercise's rubber dam;
// --size=WxH is the window's; --eye moves the camera, by notches of the wheel and drags of the mouse.

namespace {

using namespace enamel;

constexpr double kDepth_m = 2.0e-3, kHalfLength_m = 1.7e-3, kHalfWidth_m = 0.9e-3;

// A cavity in layers, its last layer left half done.
template <typename Step>
void Visit(const dvec3& centre, Step&& step) {
  constexpr double kPass_m = 0.3e-3, kStride_m = 0.02e-3;
  for (double z = -0.25e-3; z >= -kDepth_m; z -= 0.25e-3) {
    bool last = z - 0.25e-3 < -kDepth_m;
    bool forward = true;
    for (double y = -kHalfWidth_m; y <= (last ? 0.0 : kHalfWidth_m);
         y += kPass_m, forward = !forward) {
      for (double x = -kHalfLength_m; x <= kHalfLength_m; x += kStride_m) {
        step(centre + dvec3(forward ? x : -x, y, z));
      }
    }
  }
}

station::render::View ViewOf(std::string_view name) {
  using station::render::View;
  if (name == "occlusal") return View::kOcclusal;
  if (name == "buccal") return View::kBuccal;
  return name == "mesial" ? View::kMesial : View::kOblique;
}

}  // namespace

int main(int argc, char** argv) {
  station::render::WindowOptions options;
  bool mirror = false, mouth = false, dam = false;
  float zoom = 0, turn = 0, tilt = 0;
  // Options come last.
  for (; argc > 2 && std::string_view(argv[argc - 1]).starts_with("--"); --argc) {
    const std::string_view last = argv[argc - 1];
    if (last == "--mirror") mirror = true;
    if (last == "--mouth" || last == "--dam") mouth = true;
    if (last == "--dam") dam = true;
    std::sscanf(argv[argc - 1], "--eye=%f,%f,%f", &zoom, &turn, &tilt);
    std::sscanf(argv[argc - 1], "--size=%dx%d", &options.screen.width_px,
                &options.screen.height_px);
  }
  if (argc < 2) {
    std::fprintf(
        stderr,
        "usage: cut_screenshot OUT.png [voxel_um [oblique|occlusal|buccal|mesial "
        "[EXERCISE [SCENE]]]] [--mirror] [--mouth|--dam] [--size=WxH] [--eye=ZOOM,TURN,TILT]\n");
    return 2;
  }
  int32_t voxel_nm = argc > 2 ? std::atoi(argv[2]) * 1000 : 50'000;
  auto built = scene::BuildBuiltinScene(argc > 5 ? argv[5] : "molar", voxel_nm);
  if (!built.ok()) {
    std::fprintf(stderr, "%s\n", built.status().message().c_str());
    return 1;
  }
  station::render::VirtualDisplay display;
  cutting::Volume volume = built->volume;
  options.uncut = &built->volume;
  volume.Reserve();
  options.view.burs = {{cutting::BurShape::kCylinder, 0.6e-3, 4e-3}};
  options.heading = "Class I cavity, molar 46";
  options.time_limit_s = 600;
  options.view.crown_aside = built->scene.up == scene::Up::kBuccal;
  options.view.view = ViewOf(argc > 3 ? argv[3] : "oblique");
  auto window = station::render::Window::Create(options, volume);
  if (!window.ok()) {
    std::fprintf(stderr, "%s\n", window.status().message().c_str());
    return 1;
  }
  auto& view = (*window)->tooth();
  view.camera().Zoom(zoom);
  view.camera().Orbit(turn, tilt);
  if (mirror) view.mirror().Show(true, view.camera());
  const std::string_view exercise = argc > 4 ? argv[4] : "class-1";
  for (const scene::Exercise& e : scene::BuiltinExercises(built->scene, Sha256{})) {
    if (!e.name.starts_with(exercise)) continue;
    const auto outline = station::desk::OutlineOf(built->scene, e.target, built->volume);
    (*window)->tooth().SetOutline(outline);
    if (mouth) {
      const auto began = std::chrono::steady_clock::now();
      const auto around = station::mouth::MakeMouth(built->scene, built->volume, outline,
                                                    {dam ? e.isolation : scene::Isolation::kNone});
      std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
      std::printf("mouth: %zu triangles, %.2f MB, %.0f ms\n", around.triangle_count(),
                  static_cast<double>(around.bytes()) * 1e-6, 1e3 * took.count());
      (*window)->tooth().SetScenery(around);
    }
    (*window)->tooth().ShowOutline(true);
    break;
  }
  if (argc > 4) {
    Status status = (*window)->WriteScreenshot(argv[1]);
    if (!status.ok()) std::fprintf(stderr, "%s\n", status.message().c_str());
    return status.ok() ? 0 : 1;
  }
  auto landmark = built->scene.landmarks.at("occlusal_centre");
  cutting::Cutter cutter(volume, options.view.burs[0]);
  cutting::RemovedUnits removed{};
  station::render::FrameState state;
  state.bur_on = true;
  Visit(dvec3(landmark[0], landmark[1], landmark[2]) * 1e-6, [&](const dvec3& tip) {
    state.anchor.tip_m = tip;
    cutter.Cut(state.anchor, removed);
    (*window)->tooth().PublishBricks(volume, cutter.touched());
    ++state.tick;
  });
  state.time_s = 187;
  state.device.tip_m = state.anchor.tip_m + dvec3(0.3e-3, 0, -0.35e-3);
  state.pressed_n = {-0.6, 0.15, 1.1};
  for (size_t t = 0; t < removed.size(); ++t) {
    state.removed_mm3[t] = cutting::RemovedUnitsToM3(removed[t], voxel_nm * 1e-9) * 1e9;
  }
  (*window)->tooth().Publish(state);
  (*window)->tooth().FlushBricks(volume);
  Status status = (*window)->WriteScreenshot(argv[1]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.message().c_str());
  return status.ok() ? 0 : 1;
}
