#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/scene/builtin/builtin.h"
#include "common/surface/brick_meshes.h"
#include "station/lab/bench/bench.h"
#include "station/lab/cutting/tick_cost.h"

namespace enamel::station::lab::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct SurfaceOptions {
  std::string json;
  int replays = 5;
  size_t ticks = 400;
};

constexpr double kGoal_ms = 1;

double Milliseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

struct UpdateCost {
  Spread least_ms, raw_ms;
  double looked_at = 0, renewed = 0;  // bricks, mean
};

// The headline path; after each measured tick, the meshes of the region it touched.
UpdateCost MeasureUpdates(const CutPath& path, int replays, Progress& progress) {
  std::vector<double> least, raw;
  UpdateCost out;
  double updates = 0;
  for (int r = 0; r < replays; ++r) {
    core::Core core(path.params, path.block);
    surface::BrickMeshes meshes(path.block.spec());
    size_t measured = 0;
    for (size_t i = 0; i < path.inputs.size(); ++i) {
      core.Step(path.inputs[i]);
      // Complete once, then kept up to date: only a tick's changes are measured.
      if (i + 1 == path.first_measured) meshes.ExtractAll(core.volume());
      if (i < path.first_measured) continue;
      if (i % 50 == 0) {
        progress.Show("surface, replay " + std::to_string(r + 1), static_cast<double>(r) / replays);
      }
      auto from = Clock::now();
      // Without the tick itself, which has its own bench.
      size_t renewed = meshes.Update(core.volume(), core.touched()).size();
      double ms = Milliseconds(from);
      raw.push_back(ms);
      if (r == 0) least.push_back(ms);
      least[measured] = std::min(least[measured], ms);
      ++measured;
      out.looked_at += static_cast<double>(meshes.looked_at());
      out.renewed += static_cast<double>(renewed);
      ++updates;
    }
  }
  out.looked_at /= updates;
  out.renewed /= updates;
  out.least_ms = SpreadOf(least);
  out.raw_ms = SpreadOf(raw);
  return out;
}

int RunSurface(const SurfaceOptions& options) {
  if (!CanWrite(options.json)) return 1;
  std::string method =
      "update: after each tick of the headline path (cylinder r 0.6 x 4 mm, half embedded, 5 mm/s) "
      "the meshes of the "
      "bricks it touched and of their neighbours, where they changed; per tick the least of " +
      std::to_string(options.replays) +
      " identical replays, then mean and 99th percentile. whole: all of the built-in molar, roots "
      "included, least of " +
      std::to_string(options.replays) + ". One thread";
  std::printf("Method: %s.\n\n%6s %10s %10s %10s %10s %10s %9s %10s %10s\n", method.c_str(),
              "voxel", "update ms", "p99 ms", "raw mean", "raw p99", "looked at", "made anew",
              "whole ms", "triangles");
  Rows rows("surface", method);
  std::string goal;
  for (int32_t voxel_nm : {100'000, 50'000, 25'000}) {
    Progress progress;
    progress.Show("building, voxel " + std::to_string(voxel_nm / 1000) + " um", 0);
    CutCase c;
    c.voxel_nm = voxel_nm;
    UpdateCost update = MeasureUpdates(MakeCutPath(c, options.ticks), options.replays, progress);
    auto built = scene::BuildBuiltinScene("molar", voxel_nm);
    if (!built.ok()) {
      program::SayError(built.status().message());
      return 1;
    }
    double whole_ms = 1e300;
    size_t triangles = 0;
    for (int i = 0; i < options.replays; ++i) {
      auto from = Clock::now();
      // Uses the count, so that no compiler omits the work.
      triangles = surface::ExtractSurface(built->volume).triangles.size();
      whole_ms = std::min(whole_ms, Milliseconds(from));
    }
    progress.Clear();
    std::printf("%6.3f %10.3f %10.3f %10.3f %10.3f %10.1f %9.1f %10.1f %10zu\n", voxel_nm * 1e-6,
                update.least_ms.mean, update.least_ms.p99, update.raw_ms.mean, update.raw_ms.p99,
                update.looked_at, update.renewed, whole_ms, triangles);
    if (voxel_nm == 50'000) goal = AgainstGoal(update.least_ms.mean, kGoal_ms);
    rows.Add({{"voxel_mm", voxel_nm * 1e-6},
              {"update_mean_ms", update.least_ms.mean},
              {"update_p99_ms", update.least_ms.p99},
              {"update_raw_mean_ms", update.raw_ms.mean},
              {"update_raw_p99_ms", update.raw_ms.p99},
              {"bricks_looked_at", update.looked_at},
              {"bricks_made_anew", update.renewed},
              {"whole_molar_ms", whole_ms},
              {"whole_molar_triangles", triangles}});
  }
  std::printf("\nGoal: update at 0.05 mm, mean: %s ms\n", goal.c_str());
  return rows.Write(options.json);
}

}  // namespace

void RegisterSurface(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<SurfaceOptions>();
  CLI::App* surface = app.add_subcommand(
      "surface", "Milliseconds to mesh what one tick touched, and a whole tooth");
  surface->add_option("--replays", options->replays, "Identical replays")
      ->check(CLI::Range(5, 100))
      ->capture_default_str();
  surface->add_option("--ticks", options->ticks, "Ticks measured")
      ->check(CLI::Range(50, 10'000))
      ->capture_default_str();
  surface->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*surface, {""});
  surface->callback([options, exit_code] { *exit_code = RunSurface(*options); });
}

}  // namespace enamel::station::lab::bench
