#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/cutting/cutter.h"
#include "common/program/example.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/tooth_number.h"
#include "station/lab/bench/bench.h"
#include "station/mouth/mouth.h"
#include "station/render/panel.h"
#include "station/render/window.h"

namespace enamel::station::lab::bench {
namespace {

using render::Quality;
using Clock = std::chrono::steady_clock;

struct FrameBenchOptions {
  int width_px = 1280, height_px = 720;
  int frames = 120;  // of each kind
  int voxel_um = 50;
  std::string quality;  // empty: as it begins on this computer
  bool mouth = true, parts = false;
  std::filesystem::path json;
};

constexpr int kTicksPerFrame = 16;                          // at 60 frames a second
constexpr double kTick_s = 1e-3, kFeed_m = 5e-3 * kTick_s;  // 5 mm/s
constexpr auto kCoarseLimit = std::chrono::seconds(2);
constexpr double kSlotHalf_m = 1.5e-3, kSlotStep_m = 0.3e-3, kSlotDepth_m = 1.2e-3;

struct FramesFigures {
  const char* kind;
  double p50_ms = 0, p95_ms = 0, p99_ms = 0, max_ms = 0, cpu_ms = 0, triangles = 0;
};

struct Times {
  const char* kind;
  std::vector<double> ms, cpu_ms;
  double triangles = 0;

  FramesFigures Of() {
    std::sort(ms.begin(), ms.end());
    std::sort(cpu_ms.begin(), cpu_ms.end());
    auto count = static_cast<double>(ms.size());
    auto at = [&](double share) {
      return ms[std::min(ms.size() - 1, static_cast<size_t>(share * count))];
    };
    return {
        kind, at(0.5), at(0.95), at(0.99), ms.back(), cpu_ms[cpu_ms.size() / 2], triangles / count};
  }
};

// A molar, a bur that cuts slots into it, and its window.
class FrameBench {
 public:
  FrameBench(const FrameBenchOptions& options, const Quality& quality, render::Screen& screen,
             const scene::BuiltScene& built)
      : options_(options),
        quality_(quality),
        screen_(screen),
        volume_(built.volume),
        view_(View(built.scene), built.volume, {}, &built.volume),
        // Reserved first: a cutter never grows its volume, and the comma keeps both in the
        // initialiser.
        cutter_((volume_.Reserve(), volume_), View(built.scene).burs.front()) {
    auto at = built.scene.landmarks.at("occlusal_centre");
    centre_ = dvec3(at[0], at[1], at[2]) * 1e-6;
    auto began = Clock::now();
    view_.WaitIdle(std::chrono::seconds(60));
    first_s_ = std::chrono::duration<double>(Clock::now() - began).count();
    if (!options.mouth) return;
    began = Clock::now();
    whole_ = mouth::MakeMouth(built.scene, built.volume, {});
    mouth_s_ = std::chrono::duration<double>(Clock::now() - began).count();
    view_.SetScenery(whole_);
    if (!options.parts) return;
    without_ = mouth::MakeMouth(built.scene, built.volume, {}, {.antagonist = false});
    dam_ = mouth::MakeMouth(built.scene, built.volume, {}, {scene::Isolation::kRubberDam, true});
  }

  FramesFigures Rest(const char* kind = "at rest") {
    Times times{kind, {}, {}};
    for (int i = 0; i < options_.frames; ++i) {
      Show(centre_ + dvec3(Wave(), 0, 1e-3));
      Frame(quality_, times);
    }
    return times.Of();
  }

  FramesFigures Cut(const char* kind = "cutting") {
    Times times{kind, {}, {}};
    for (int i = 0; i < options_.frames; ++i) {
      // As many ticks as pass between two pictures, so that a picture has an attempt's work.
      for (int k = 0; k < kTicksPerFrame; ++k) Step();
      Frame(quality_, times);
    }
    return times.Of();
  }

  // Two ways alternately, so that a busy computer affects both alike: turning as in an attempt, and
  // with full detail.
  std::array<FramesFigures, 2> Turn(const char* kind = "turning") {
    Times turning{kind, {}, {}}, all{"in full", {}, {}};
    // Turning is drawn lighter in an attempt; otherwise it costs as much as a still picture.
    Quality full = quality_;
    full.lighter_turning = false;
    // The cut has its coarse triangles by then.
    for (auto until = Clock::now() + kCoarseLimit; Clock::now() < until;) {
      Times unused{"", {}, {}};
      Frame(quality_, unused);
    }
    for (int i = 0; i < options_.frames; ++i) {
      view_.camera().Orbit(0.004f, 0);
      Frame(quality_, turning);
      view_.camera().Orbit(0.004f, 0);
      Frame(full, all);
    }
    return {turning.Of(), all.Of()};
  }

  // At rest, cutting and turning as before, with the mirror held.
  std::vector<FramesFigures> WithMirror() {
    view_.mirror().Show(true, view_.camera());
    std::vector<FramesFigures> out{Rest("mirror, at rest"), Cut("mirror, cutting")};
    out.push_back(Turn("mirror, turning")[0]);
    view_.mirror().Show(false, view_.camera());
    return out;
  }

  // Turning, with parts of the mouth, picture by picture in turn: as an attempt begins, and from so
  // far that the antagonist is in the picture.
  std::vector<FramesFigures> Parts() {
    std::array<Times, 6> times{{{"mouth", {}, {}},
                                {"no antagonist", {}, {}},
                                {"rubber dam", {}, {}},
                                {"far", {}, {}},
                                {"far, none", {}, {}},
                                {"far, dam", {}, {}}}};
    constexpr float kFar = 14, kLevel = -0.2f;
    for (const bool far : {false, true}) {
      if (far) view_.camera().Zoom(-kFar), view_.camera().Orbit(0, kLevel);
      for (int i = 0; i < options_.frames; ++i) {
        size_t row = far ? 3 : 0;
        for (const render::Scenery* scenery : {&whole_, &without_, &dam_}) {
          view_.SetScenery(*scenery);
          view_.camera().Orbit(0.004f, 0);
          Frame(quality_, times[row++]);
        }
      }
    }
    std::vector<FramesFigures> out;
    for (Times& t : times) out.push_back(t.Of());
    return out;
  }

  // From the volume to its first picture; and to the mouth.
  double first_s() const { return first_s_; }
  double mouth_s() const { return mouth_s_; }
  size_t mouth_triangles() const { return whole_.triangle_count(); }
  size_t triangles() const { return view_.work().triangles; }

 private:
  // As an attempt shows it (desk_attempt.cpp): aside of the panel.
  static render::ViewOptions View(const scene::Scene& scene) {
    render::ViewOptions view;
    view.aside = 0.16f;
    view.mesial_x = scene::MesialX(scene.tooth);
    view.burs = {{cutting::BurShape::kCylinder, 0.6e-3, 4e-3}};
    return view;
  }

  double Wave() { return 1e-3 * std::sin(0.1 * static_cast<double>(++waves_)); }

  void Show(const dvec3& tip) {
    state_.anchor.tip_m = state_.device.tip_m = tip;
    state_.pressed_n = {0.2, 0, 0.8};
    state_.bur_on = true;
    view_.Publish(state_);
  }

  // Slots side by side, to and fro, deeper each time.
  void Step() {
    along_ += kFeed_m;
    double length = 2 * kSlotHalf_m;
    auto slot = static_cast<int>(along_ / length);
    double x = along_ - slot * length - kSlotHalf_m;
    int across = slot % 5 - 2, layer = slot / 5;
    double z = std::max(-0.2e-3 * (layer + 1), -kSlotDepth_m);
    Show(centre_ + dvec3(slot % 2 == 0 ? x : -x, across * kSlotStep_m, z));
    cutter_.Cut(state_.anchor, removed_);
    state_.time_s += kTick_s;
    for (size_t t = 0; t < removed_.size(); ++t) {
      state_.removed_mm3[t] =
          cutting::RemovedUnitsToM3(removed_[t], volume_.spec().voxel_m()) * 1e9;
    }
    view_.PublishBricks(volume_, cutter_.touched());
  }

  void Frame(const Quality& quality, Times& times) {
    // Of all threads: those of a software driver, and the mesher's.
    const std::clock_t began = std::clock();
    screen_.Begin();
    view_.Draw(screen_.width(), screen_.height(), quality);
    render::PanelContent content;
    content.heading = "Class I, molar";
    content.state = view_.state();
    content.has_state = view_.has_state();
    render::DrawPanel(content, words_, screen_.fonts(), {screen_.width(), screen_.height()});
    screen_.Show(view_.result());
    screen_.End();
    times.ms.push_back(1e3 * screen_.drawing_s());
    times.cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
    times.triangles += static_cast<double>(view_.work().triangles_drawn);
  }

  const FrameBenchOptions& options_;
  const Quality& quality_;
  render::Screen& screen_;
  const language::Words words_{language::Language::kEnglish};
  cutting::Volume volume_;
  render::ToothView view_;
  cutting::Cutter cutter_;
  cutting::RemovedUnits removed_{};
  render::FrameState state_;
  dvec3 centre_{0};
  double along_ = 0, first_s_ = 0, mouth_s_ = 0;
  render::Scenery whole_, without_, dam_;
  uint64_t waves_ = 0;
};

Status Print(const FrameBenchOptions& options, const FrameBench& bench,
             const render::Screen& screen, const Quality& quality,
             const std::vector<FramesFigures>& all) {
  std::printf("renderer   %s\n", screen.renderer().c_str());
  std::printf("picture    %d x %d, quality %s, tooth of %zu triangles at %d um, made in %.1f s\n",
              screen.width(), screen.height(), std::string(quality.name).c_str(), bench.triangles(),
              options.voxel_um, bench.first_s());
  if (options.mouth) {
    std::printf("mouth      %zu triangles, made in %.1f s\n", bench.mouth_triangles(),
                bench.mouth_s());
  }
  std::printf(
      "method     %d frames each, tooth, bur, panel; from the beginning of a frame to "
      "glFinish, no waiting for the display; cpu: processor time of all threads, p50\n",
      options.frames);
  std::printf(
      "turning    as an attempt turns; in full: the same with all that is drawn at rest, picture "
      "by "
      "picture in turn\n\n");
  std::printf("%-15s %8s %8s %8s %8s %8s %9s %12s\n", "ms", "p50", "p95", "p99", "max", "cpu",
              "fps (p50)", "triangles");
  boost::json::object json{{"renderer", screen.renderer()},
                           {"quality", quality.name},
                           {"width_px", screen.width()},
                           {"height_px", screen.height()},
                           {"first_picture_s", bench.first_s()},
                           {"triangles", bench.triangles()},
                           {"mouth_triangles", bench.mouth_triangles()},
                           {"mouth_s", bench.mouth_s()}};
  for (const FramesFigures& f : all) {
    std::printf("%-15s %8.1f %8.1f %8.1f %8.1f %8.1f %9.0f %12.0f\n", f.kind, f.p50_ms, f.p95_ms,
                f.p99_ms, f.max_ms, f.cpu_ms, 1e3 / std::max(f.p50_ms, 1e-3), f.triangles);
    json[f.kind] = {{"p50_ms", f.p50_ms},     {"p95_ms", f.p95_ms},
                    {"p99_ms", f.p99_ms},     {"max_ms", f.max_ms},
                    {"cpu_p50_ms", f.cpu_ms}, {"triangles_drawn", f.triangles}};
  }
  return program::WriteJsonFile(options.json, json);
}

// Draws the built-in molar with panel, as an attempt does, and prints the time of frames on this
// machine: at rest (the bur moves in the air), while cutting, and while the camera turns, lighter
// as in an attempt and in full. Each frame is drawn to its end (glFinish), without waiting for the
// display. Errors: kUnavailable without a display or OpenGL 3.3; kInvalidInput for an unknown
// quality.
Status BenchFrames(const FrameBenchOptions& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  if (options.frames < 1 || options.width_px < 64 || options.height_px < 64) {
    return Status(Code::kInvalidInput, "expected at least one frame of at least 64 x 64 pixels",
                  "frames");
  }
  const Quality* wanted = options.quality.empty() ? nullptr : render::FindQuality(options.quality);
  if (wanted == nullptr && !options.quality.empty()) {
    return Status(Code::kInvalidInput,
                  "no quality '" + options.quality + "': there are best, good, fair, low",
                  "quality");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene("molar", options.voxel_um * 1000));
  try {
    render::ScreenOptions window;
    window.width_px = options.width_px;
    window.height_px = options.height_px;
    // As fast as possible: paced pictures would all take a display's 16.7 ms.
    window.paced = false;
    render::Screen screen(window);
    const Quality& quality =
        wanted != nullptr ? *wanted : render::kQualities[render::GovernorFor(screen).level()];
    FrameBench bench(options, quality, screen, built);
    std::vector<FramesFigures> all{bench.Rest(), bench.Cut()};
    for (const FramesFigures& f : bench.Turn()) all.push_back(f);
    for (const FramesFigures& f : bench.WithMirror()) all.push_back(f);
    if (options.mouth && options.parts) {
      for (const FramesFigures& f : bench.Parts()) all.push_back(f);
    }
    return Print(options, bench, screen, quality, all);
  } catch (const std::exception& e) {
    // Windows and drivers throw; the error gets a remedy here.
    return render::NoDisplay(e.what());
  }
}

}  // namespace

void RegisterFrames(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<FrameBenchOptions>();
  CLI::App* frames =
      app.add_subcommand("frames", "How long pictures of a tooth being cut take on this computer");
  frames->add_option("--width", options->width_px, "Of the picture, pixels")->capture_default_str();
  frames->add_option("--height", options->height_px, "Of the picture, pixels")
      ->capture_default_str();
  frames->add_option("--frames", options->frames, "Of each kind")->capture_default_str();
  frames->add_option("--voxel-um", options->voxel_um, "Voxel of the built-in molar")
      ->capture_default_str();
  frames->add_option("--quality", options->quality,
                     "best, good, fair or low; else what this computer begins with");
  frames->add_flag("!--no-mouth", options->mouth, "Draw the tooth alone, as open --no-mouth");
  frames->add_flag("--parts", options->parts,
                   "Also turning without the antagonist and with a rubber dam, in turn");
  frames->add_option("--json", options->json, "Write the figures to this file");
  program::AddExamples(*frames, {"--frames 60 --quality good"});
  frames->callback([options, exit_code] {
    Status status = BenchFrames(*options);
    if (!status.ok()) program::SayError(status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

}  // namespace enamel::station::lab::bench
