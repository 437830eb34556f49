#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/import/triangles.h"
#include "common/scene/types.h"

// Real teeth: a mesh file becomes a scene. Not real-time; runs on station or by hand, never in the
// server.
namespace enamel::import {

struct ImportOptions {
  std::string unit = "mm";    // of the file's coordinates: mm, um, cm, m, inch
  int32_t voxel_nm = 50'000;  // 10'000 to 500'000
  // Occlusal direction in the file: "+x" ... "-z", or "auto" (found from the shape; orient.h).
  std::string up = "auto";
  std::string name;                      // of the scene; empty: made from the file's name
  int threads = 0;                       // 0: as many as the machine has
  std::filesystem::path child;           // empty: enamel-import-child beside the running program
  std::function<void(double)> progress;  // 0..1 while the volume is filled; may be empty
};

struct ImportedScene {
  scene::Scene scene;  // volume hash filled in
  cutting::Volume volume;
  std::vector<std::string> report;  // for people: what was found, repaired, assumed
  double mesh_volume_mm3 = 0;       // of the closed mesh, by the divergence theorem
};

// Reads FILE (STL, PLY, OBJ, OFF) in a child process, repairs what can be repaired, turns it into
// the scene's frame, fills it (generalised winding number, distance to the mesh) and assumes
// tissues by depth. One surface: the outside of a crown or tooth. Errors: kNotFound; kInvalidInput
// when it is no solid, of no tooth's size (3 to 40 mm; the message names the unit that would fit)
// or an option is wrong; kTooLarge; kUnavailable (the reader was stopped).
Result<ImportedScene> ImportTooth(const std::filesystem::path& file,
                                  const ImportOptions& options = {});
// The same from triangles in the given unit, without a file; `source` is what the provenance says.
Result<ImportedScene> ImportTriangles(const Triangles& mesh, const std::string& source,
                                      const ImportOptions& options);

}  // namespace enamel::import
