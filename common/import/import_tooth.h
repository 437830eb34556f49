#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/import/jaw_scan.h"
#include "common/import/layers.h"
#include "common/import/place.h"
#include "common/mesh/triangles.h"
#include "common/mesh/units.h"
#include "common/scene/types.h"

// Real teeth: mesh files become a scene. Not real-time; runs on the station, by hand, and in the
// server for what an admin uploads (server/jobs/tooth_import.h). The file's bytes are read in the
// child only.
namespace enamel::import {

struct ImportOptions {
  int tooth = 0;               // its FDI number (common/scene/tooth_number.h); needed
  mesh::FileScale scale = {};  // of the files' coordinates
  int32_t voxel_nm = 50'000;   // 10'000 to 500'000
  // Occlusal and buccal direction in the file: "+x" ... "-z", "x,y,z", or "auto" (place.h).
  std::string up = "auto", buccal = "auto";
  // With one surface per tissue: gaps and crossings that are mended (layers.h), 0 to 0.5.
  double bridge_mm = 0.1;
  // Where the file is a scan of several teeth: the crown within the first curve is the tooth, those within the others are
  // its neighbours. Empty: the file is one tooth.
  GumCurves around = {};
  std::string name = {};             // of the scene; empty: made from the file's name
  int threads = 0;                   // 0: as many as the machine has
  std::filesystem::path child = {};  // empty: enamel-import-child beside the running program
  std::function<void(double)> progress = {};  // 0..1 while the volume is filled; may be empty
  // Called as each phase begins, in this order: reading, repairing, placing, tissues, filling,
  // storing; may be empty.
  std::function<void(std::string_view)> phase = {};
};

struct ImportedScene {
  scene::Scene scene;  // volume hash filled in
  cutting::Volume volume;
  std::vector<std::string> report;  // for people: what was found, repaired, assumed
  // Not in the report: the command and the page word these.
  Placement placement;
  dvec3 size_mm{0};  // mesiodistal, buccolingual, height
  // Volume of the closed mesh, by the divergence theorem; solid that parts share counts twice. 0
  // with one surface per tissue.
  double mesh_volume_mm3 = 0;
};

// The sources of the surfaces. `file`: one file of everything; may be empty when all tissues name
// files; where tissues name other files only, it is the enamel. Each tissue: FILE, FILE#PART, or a
// PART of `file`; empty where there is none. A part is an OBJ object, group or material, or an STL
// solid, by its name in capitals or small letters, or by a piece of the name that only one has.
struct ImportSources {
  std::filesystem::path file;
  std::array<std::string, kLayers> tissues;  // by Layer
};

// Reads files (STL, PLY, OBJ, OFF) in a child process, repairs what can be repaired, turns them
// into the scene's frame and fills the volume (generalised winding number, distance to the mesh).
// - One surface, the outside of a crown or tooth: tissues are assumed by depth (tissues.h).
// - One surface per tissue: layers.h. Also when `file` alone is given and has parts whose names
//   hold "enamel", "dentin" (or "root", "cement") and "pulp", with dentin and another among them.
// Errors: kNotFound; kInvalidInput when something is no solid, of no tooth's size (3 to 40 mm; the
// message names the unit that would fit), tissues do not fit together, or an option is wrong;
// kTooLarge; kUnavailable (the reader was stopped).
Result<ImportedScene> ImportTooth(const ImportSources& sources, const ImportOptions& options = {});
inline Result<ImportedScene> ImportTooth(const std::filesystem::path& file,
                                         const ImportOptions& options = {}) {
  return ImportTooth(ImportSources{file, {}}, options);
}
// The same from triangles in the given unit, without a file; `source` is what the provenance says.
Result<ImportedScene> ImportTriangles(const mesh::Triangles& mesh, const std::string& source,
                                      const ImportOptions& options);
Result<ImportedScene> ImportLayers(
    const std::array<std::optional<mesh::Triangles>, kLayers>& surfaces, const std::string& source,
    const ImportOptions& options);

}  // namespace enamel::import
