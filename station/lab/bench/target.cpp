#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/import/prepared_tooth.h"
#include "common/program/example.h"
#include "common/program/log.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"
#include "station/lab/bench/bench.h"

namespace enamel::station::lab::bench {
namespace {

struct TargetOptions {
  std::string json, scene = "molar";
  std::vector<int> voxels_um = {200, 100, 50};
};

constexpr const char* kTargetExercises[] = {"class-1", "crown"};
constexpr int kNoises_um[] = {0, 20, 50};  // of each vertex, along each axis
constexpr int kTurns = 3;                  // different ones, for each row

// For the scan, so that it shares no sample with the tooth it is aligned to.
constexpr int32_t kScanVoxel_nm = 60'000;
constexpr int kUsualNoise_um = 20, kUsualVoxel_um = 100;

double TargetClock_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Result<scene::Preparation> ShapeOf(const scene::BuiltScene& tooth, const std::string& exercise) {
  std::string known;
  for (const scene::Exercise& e : scene::BuiltinExercises(tooth.scene, Sha256{})) {
    if (e.name.starts_with(exercise)) return scene::TargetShape(tooth.scene, e.target);
    known += (known.empty() ? "" : ", ") + e.name;
  }
  return Status(Code::kNotFound,
                tooth.scene.name + " has no exercise " + exercise + ", it has " + known);
}

// Turned and moved away, like a scanner's file.
mesh::Rigid Somewhere(std::mt19937& random) {
  std::normal_distribution<double> normal;
  auto any = [&] { return dvec3(normal(random), normal(random), normal(random)); };
  const dvec3 z = glm::normalize(any()), x = glm::normalize(glm::cross(any(), z));
  return {dmat3(x, glm::cross(z, x), z), 30.0 * any()};
}

mesh::Triangles WithNoise(mesh::Triangles mesh, double mm, std::mt19937& random) {
  std::normal_distribution<double> normal;  // which takes no deviation of 0
  for (dvec3& v : mesh.vertices) v += mm * dvec3(normal(random), normal(random), normal(random));
  return mesh;
}

struct Error {
  double off_um = 0, turn_deg = 0;  // farthest corner of the tooth; angle
  double differs_mm3 = 0;           // solid in just one of found and known tooth
  double target_mm3 = 0, run_s = 0;
};

double Differs_mm3(const cutting::Volume& a, const cutting::Volume& b) {
  const ivec3 n = a.spec().voxels();
  int64_t sum = 0;
  for (int z = 0; z < n.z; ++z)
    for (int y = 0; y < n.y; ++y)
      for (int x = 0; x < n.x; ++x)
        sum += std::abs(cutting::SolidFraction(a.PhiAt({x, y, z})) -
                        cutting::SolidFraction(b.PhiAt({x, y, z})));
  const double h = a.spec().voxel_m() * 1e3;
  return static_cast<double>(sum) / 65536 * h * h * h;
}

Result<Error> MeasureTarget(const scene::BuiltScene& tooth, const scene::Preparation& shape,
                            const mesh::Triangles& scan, const mesh::Rigid& moved) {
  Error out;
  const double begun = TargetClock_s();
  ENAMEL_ASSIGN_OR_RETURN(const auto taken,
                          import::TakePrepared(tooth.scene, tooth.volume, scan, "a known scan"));
  out.run_s = TargetClock_s() - begun;
  const mesh::Rigid both = taken.fit.fixed_from_moving.After(moved);
  out.turn_deg = mesh::TurnOf_deg(both.rotation);
  const cutting::GridSpec& spec = tooth.volume.spec();
  const dvec3 lo = spec.origin_m() * 1e3, size = dvec3(spec.voxels()) * spec.voxel_m() * 1e3;
  for (int i = 0; i < 8; ++i) {
    const dvec3 p = lo + size * dvec3(i & 1, i >> 1 & 1, i >> 2);
    out.off_um = std::max(out.off_um, 1e3 * glm::length(both.At(p) - p));
  }
  const cutting::Volume known = scene::Prepared(tooth.volume, shape);
  out.differs_mm3 = Differs_mm3(taken.prepared.volume, known);
  out.target_mm3 = Differs_mm3(tooth.volume, known);
  return out;
}

// The worst of several turns; the time is the mean.
Result<Error> Worst(const scene::BuiltScene& tooth, const std::string& exercise,
                    const mesh::Triangles& scan, int noise_um) {
  ENAMEL_ASSIGN_OR_RETURN(const auto shape, ShapeOf(tooth, exercise));
  Error out;
  for (int i = 0; i < kTurns; ++i) {
    std::mt19937 random(static_cast<unsigned>(1 + i));
    const mesh::Rigid moved = Somewhere(random);
    ENAMEL_ASSIGN_OR_RETURN(
        const Error error,
        MeasureTarget(tooth, shape, mesh::Moved(WithNoise(scan, noise_um * 1e-3, random), moved),
                      moved));
    out.off_um = std::max(out.off_um, error.off_um);
    out.turn_deg = std::max(out.turn_deg, error.turn_deg);
    out.differs_mm3 = std::max(out.differs_mm3, error.differs_mm3);
    out.target_mm3 = error.target_mm3;
    out.run_s += error.run_s / kTurns;
  }
  return out;
}

Status MeasureAll(const TargetOptions& options, Rows& rows) {
  ENAMEL_ASSIGN_OR_RETURN(const auto fine, scene::BuildBuiltinScene(options.scene, kScanVoxel_nm));
  std::printf("%-10s %8s %9s %10s %10s %22s %8s\n", "exercise", "voxel um", "noise um", "off um",
              "turned deg", "differs of target mm3", "s");
  for (const std::string exercise : kTargetExercises) {
    ENAMEL_ASSIGN_OR_RETURN(const auto shape, ShapeOf(fine, exercise));
    const mesh::Triangles scan = import::ToothSurface_mm(scene::Prepared(fine.volume, shape));
    auto row = [&](int voxel_um, int noise_um) -> Status {
      ENAMEL_ASSIGN_OR_RETURN(const auto tooth,
                              scene::BuildBuiltinScene(options.scene, voxel_um * 1000));
      ENAMEL_ASSIGN_OR_RETURN(const Error e, Worst(tooth, exercise, scan, noise_um));
      std::printf("%-10s %8d %9d %10.2f %10.4f %10.3f of %8.2f %8.2f\n", exercise.c_str(), voxel_um,
                  noise_um, e.off_um, e.turn_deg, e.differs_mm3, e.target_mm3, e.run_s);
      rows.Add({{"exercise", exercise},
                {"voxel_um", voxel_um},
                {"noise_um", noise_um},
                {"turns", kTurns},
                {"off_um", e.off_um},
                {"turned_deg", e.turn_deg},
                {"differs_mm3", e.differs_mm3},
                {"target_mm3", e.target_mm3},
                {"wall_s", e.run_s}});
      return Status::Ok();
    };
    for (int noise_um : kNoises_um) ENAMEL_RETURN_IF_ERROR(row(kUsualVoxel_um, noise_um));
    for (int voxel_um : options.voxels_um) {
      if (voxel_um != kUsualVoxel_um) ENAMEL_RETURN_IF_ERROR(row(voxel_um, kUsualNoise_um));
    }
  }
  return Status::Ok();
}

int RunTarget(const TargetOptions& options) {
  if (!CanWrite(options.json)) return 1;
  const std::string method =
      "a built-in tooth prepared as its exercise asks, its surface at 0.06 mm moved by known turns "
      "and given normal noise at each vertex, laid on the tooth as 'enamel-station target' does; "
      "the worst of the turns: how far a corner of the tooth's grid lies off, the angle, and the "
      "volume that is solid in just one of the found and the known preparation";
  std::printf("Method: %s.\n\n", method.c_str());
  Rows rows("target", method);
  if (Status status = MeasureAll(options, rows); !status.ok()) {
    program::SayError(status.message());
    return 1;
  }
  return rows.Write(options.json);
}

}  // namespace

void RegisterTarget(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<TargetOptions>();
  CLI::App* command = app.add_subcommand(
      "target", "How far a scan of a known preparation is laid beside where it belongs");
  command->add_option("--scene", options->scene, "A built-in tooth")->capture_default_str();
  command->add_option("--voxel-um", options->voxels_um, "Of the tooth")
      ->delimiter(',')
      ->check(CLI::Range(25, 500))
      ->capture_default_str();
  command->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*command, {"--voxel-um 100"});
  command->callback([options, exit_code] { *exit_code = RunTarget(*options); });
}

}  // namespace enamel::station::lab::bench
