#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/uuid.h"
#include "common/import/child_process.h"
#include "common/import/import_tooth.h"
#include "common/program/example.h"
#include "common/program/log.h"
#include "station/lab/bench/bench.h"

namespace enamel::station::lab::bench {
namespace {

namespace fs = std::filesystem;
using mesh::Triangles;

struct ImportOptions {
  std::string json, tooth, unit = "mm";
  std::vector<int> voxels_um = {100, 50};
};

constexpr size_t kMinTriangles = 150'000;
constexpr double kGoal_s = 5;  // of them, to 0.05 mm

double Seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// Processor time of all threads and of the finished reader, user and system.
double Cpu_s() {
  double sum = 0;
  // The reader is a child process (import/child_process.h); its time counts as well.
  for (int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    getrusage(who, &used);
    sum += Seconds(used.ru_utime) + Seconds(used.ru_stime);
  }
  return sum;
}

double Wall_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Divides each triangle into n x n, so that there are at least `least`.
Triangles Subdivided(const Triangles& mesh, size_t least) {
  size_t n = 1;
  // Flat ones keep the shape: only the number of triangles changes.
  while (n * n * mesh.indices.size() < least) ++n;
  Triangles out;
  for (const auto& t : mesh.indices) {
    const dvec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    auto corner = [&](size_t i, size_t k) {
      const double u = static_cast<double>(i) / static_cast<double>(n),
                   v = static_cast<double>(k) / static_cast<double>(n);
      out.vertices.push_back(a + u * (b - a) + v * (c - a));
      return static_cast<uint32_t>(out.vertices.size() - 1);
    };
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; i + k < n; ++k) {
        out.indices.push_back({corner(i, k), corner(i + 1, k), corner(i, k + 1)});
        if (i + k + 1 < n)
          out.indices.push_back({corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)});
      }
  }
  return out;
}

// A round block of 11 mm with four cusps and a hollow between them, if no real crown is given.
Triangles CrownLike(size_t least) {
  // n rings of 2 n places, two triangles each: some 4 n^2.
  const auto n = static_cast<uint32_t>(std::sqrt(static_cast<double>(least) / 4)) + 2;
  const uint32_t around = 2 * n;
  Triangles m;
  for (uint32_t j = 0; j <= n; ++j)
    for (uint32_t i = 0; i < around; ++i) {
      const double polar = std::numbers::pi * j / n, turn = std::numbers::pi * 2 * i / around;
      const double side = j == 0 || j == n ? 0 : std::sin(polar), up = std::cos(polar);
      const double cusps =
          up > 0 ? up * side * side * (0.5 + std::cos(4 * turn)) - up * up * up : 0;
      m.vertices.push_back((5.5 + cusps) *
                           dvec3(side * std::cos(turn), 0.8 * up, 0.9 * side * std::sin(turn)));
    }
  auto at = [&](uint32_t i, uint32_t j) { return j * around + i % around; };
  for (uint32_t j = 0; j < n; ++j)
    for (uint32_t i = 0; i < around; ++i) {
      if (j > 0) m.indices.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (j < n - 1) m.indices.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return m;
}

Bytes BinaryStl(const Triangles& mesh) {
  ByteWriter out;
  out.Raw(Bytes(80, 0));
  out.U32(static_cast<uint32_t>(mesh.indices.size()));
  for (const auto& t : mesh.indices) {
    for (int i = 0; i < 3; ++i) out.U32(0);  // the normal, which no reader needs
    for (uint32_t v : t)
      for (int k = 0; k < 3; ++k)
        out.U32(std::bit_cast<uint32_t>(static_cast<float>(mesh.vertices[v][k])));
    out.U8(0);
    out.U8(0);
  }
  return out.Take();
}

// Deletes its file.
struct TempStl {
  fs::path path = fs::temp_directory_path() / ("enamel-lab-" + Uuid::New().Text() + ".stl");
  ~TempStl() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
};

int Fail(const std::string& why) {
  program::SayError(why);
  return 1;
}

struct Phase {
  std::string name;
  double cpu_s;
};

struct Measured {
  std::vector<Phase> phases;
  double cpu_s = 0, wall_s = 0, solid_mm3 = 0;
};

Result<Measured> MeasureImport(const fs::path& file, const ImportOptions& options, int voxel_um) {
  Measured m;
  Progress progress;
  const double cpu = Cpu_s(), wall = Wall_s();
  double entered = cpu;
  auto close = [&] {
    const double now = Cpu_s();
    // A phase ends when the next one begins, which is all the import reports.
    if (!m.phases.empty()) m.phases.back().cpu_s = now - entered;
    entered = now;
  };
  import::ImportOptions import_options;
  import_options.tooth = 46;  // whichever: the work is the same
  import_options.scale.unit = options.unit;
  import_options.voxel_nm = voxel_um * 1000;
  import_options.phase = [&](std::string_view name) {
    close();
    m.phases.push_back({std::string(name), 0});
    progress.Show(std::string(name) + " at " + std::to_string(voxel_um) + " um", 0);
  };
  ENAMEL_ASSIGN_OR_RETURN(auto imported, import::ImportTooth(file, import_options));
  close();
  m.cpu_s = Cpu_s() - cpu;
  m.wall_s = Wall_s() - wall;
  for (double v : cutting::SolidVolume_m3(imported.volume)) m.solid_mm3 += v * 1e9;
  return m;
}

int RunImport(const ImportOptions& options) {
  if (!CanWrite(options.json)) return 1;
  Triangles mesh;
  if (options.tooth.empty()) {
    mesh = CrownLike(kMinTriangles);
  } else {
    auto read = import::ReadMeshInChild(options.tooth);
    if (!read.ok()) return Fail(read.status().message());
    // Scans have any number of triangles; figures are compared at the same number.
    mesh = Subdivided(read->mesh.mesh, kMinTriangles);
  }
  const TempStl stl;
  if (Status written = WriteFileDurably(stl.path, BinaryStl(mesh)); !written.ok())
    return Fail(written.message());
  const std::string name =
      options.tooth.empty() ? "crown-like" : fs::path(options.tooth).filename().string();
  const std::string method =
      "a crown's mesh, each triangle cut into n x n flat ones, as a binary STL file, imported as "
      "'enamel-station import' does; processor seconds of all threads and of the reader";
  std::printf("Method: %s.\n\n%s: %zu triangles\n", method.c_str(), name.c_str(),
              mesh.indices.size());
  Rows rows("import", method);
  for (int voxel_um : options.voxels_um) {
    auto m = MeasureImport(stl.path, options, voxel_um);
    if (!m.ok()) return Fail(m.status().message());
    boost::json::object phases;
    std::printf("voxel %.3f mm: %s s of processor, %.2f s on the clock, %.1f mm3\n",
                voxel_um * 1e-3,
                voxel_um == 50 ? AgainstGoal(m->cpu_s, kGoal_s).c_str()
                               : std::to_string(m->cpu_s).substr(0, 5).c_str(),
                m->wall_s, m->solid_mm3);
    for (const Phase& phase : m->phases) {
      std::printf("  %-10s %6.2f s\n", phase.name.c_str(), phase.cpu_s);
      phases[phase.name] = phase.cpu_s;
    }
    rows.Add({{"mesh", name},
              {"triangles", mesh.indices.size()},
              {"voxel_mm", voxel_um * 1e-3},
              {"cpu_s", m->cpu_s},
              {"wall_s", m->wall_s},
              {"phases_cpu_s", phases},
              {"solid_mm3", m->solid_mm3}});
  }
  return rows.Write(options.json);
}

}  // namespace

void RegisterImport(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* command =
      app.add_subcommand("import", "Seconds to make a scene of a crown's mesh, by phases");
  command->add_option("--tooth", options->tooth,
                      "A real crown (STL, PLY, OBJ); a block with four cusps, unless named");
  command->add_option("--unit", options->unit, "Of its coordinates")->capture_default_str();
  command->add_option("--voxel-um", options->voxels_um, "Voxel sizes")
      ->delimiter(',')
      ->check(CLI::Range(10, 500))
      ->capture_default_str();
  command->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*command, {"--voxel-um 50"});
  command->callback([options, exit_code] { *exit_code = RunImport(*options); });
}

}  // namespace enamel::station::lab::bench
