#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/volume_blob.h"
#include "station/lab/bench/bench.h"

namespace enamel::station::lab::bench {
namespace {

struct MemoryOptions {
  std::string json;
  std::vector<std::string> scenes;
  std::vector<int> voxels_um = {100, 50, 25};
};

constexpr double kGoal_mb = 60;  // whole molar with roots at 0.025 mm

double Resident_mb() {
  long pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

struct MemoryFigures {
  double mb = 0, resident_mb = 0, blob_mb = 0;
  size_t bricks = 0, stored = 0, labelled = 0;
};

// The scene as a station receives it: from its blob, after everything that built it was freed.
Result<MemoryFigures> MeasureMemory(const std::string& name, int voxel_um) {
  Result<Bytes> blob = [&]() -> Result<Bytes> {
    ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene(name, voxel_um * 1000));
    return scene::EncodeVolume(built.volume);
  }();
  ENAMEL_RETURN_IF_ERROR(blob.status());
  malloc_trim(0);
  // First returns the allocator's leftovers from building, which the volume would use, hiding its
  // size.
  double before = Resident_mb();
  ENAMEL_ASSIGN_OR_RETURN(auto volume, scene::DecodeVolume(*blob));
  malloc_trim(0);
  MemoryFigures f;
  f.resident_mb = Resident_mb() - before;
  f.mb = static_cast<double>(volume.MemoryBytes()) * 1e-6;
  f.blob_mb = static_cast<double>(blob->size()) * 1e-6;
  f.bricks = static_cast<size_t>(volume.spec().brick_count());
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    f.stored += volume.IsStored(b);
    f.labelled += volume.HasLabels(b);
  }
  return f;
}

int RunMemory(MemoryOptions& options) {
  if (!CanWrite(options.json)) return 1;
  if (options.scenes.empty()) options.scenes = scene::BuiltinSceneNames();
  std::string method =
      "the volume as a station loads it from its blob; mb: what its arrays hold, 10^6 bytes; "
      "resident: growth of "
      "the process over the loading";
  std::printf("Method: %s.\n\n%-12s %7s %9s %9s %9s %9s %10s %10s\n", method.c_str(), "scene",
              "voxel", "mb", "resident", "blob", "bricks", "stored", "labelled");
  Rows rows("memory", method);
  std::string goals;
  size_t done = 0;
  for (const std::string& name : options.scenes) {
    double coarser = 0;
    // Coarse to fine: the growth of memory with each halving characterises a sparse volume (4, not
    // 8).
    for (int voxel_um : options.voxels_um) {
      Result<MemoryFigures> f = [&] {
        Progress progress;
        progress.Show("building " + name + " at " + std::to_string(voxel_um) + " um",
                      static_cast<double>(done++) /
                          static_cast<double>(options.scenes.size() * options.voxels_um.size()));
        return MeasureMemory(name, voxel_um);
      }();
      if (!f.ok()) {
        program::SayError(f.status().message());
        return 1;
      }
      std::printf("%-12s %7.3f %9.1f %9.1f %9.1f %9zu %10zu %10zu", name.c_str(), voxel_um * 1e-3,
                  f->mb, f->resident_mb, f->blob_mb, f->bricks, f->stored, f->labelled);
      if (coarser > 0) std::printf("  x%.1f", f->mb / coarser);
      std::printf("\n");
      // By the sum of the arrays: the process's growth includes the allocator's behaviour.
      if (name == "molar" && voxel_um == 25) goals = AgainstGoal(f->mb, kGoal_mb);
      boost::json::object row{{"scene", name},
                              {"voxel_mm", voxel_um * 1e-3},
                              {"mb", f->mb},
                              {"resident_mb", f->resident_mb},
                              {"blob_mb", f->blob_mb},
                              {"stored_bricks", f->stored},
                              {"labelled_bricks", f->labelled}};
      if (coarser > 0) row["growth_per_halving"] = f->mb / coarser;
      rows.Add(std::move(row));
      coarser = f->mb;
    }
  }
  if (!goals.empty())
    std::printf("\nGoal: whole molar with roots at 0.025 mm: %s MB\n", goals.c_str());
  return rows.Write(options.json);
}

}  // namespace

void RegisterMemory(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<MemoryOptions>();
  CLI::App* memory = app.add_subcommand("memory", "Megabytes a whole tooth takes, roots included");
  memory->add_option("--scene", options->scenes, "Built-in scenes (all, unless named)")
      ->delimiter(',');
  memory->add_option("--voxel-um", options->voxels_um, "Voxel sizes, coarse to fine")
      ->delimiter(',')
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  memory->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*memory, {"--scene molar"});
  memory->callback([options, exit_code] { *exit_code = RunMemory(*options); });
}

}  // namespace enamel::station::lab::bench
