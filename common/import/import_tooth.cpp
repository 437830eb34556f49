#include "common/import/import_tooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>

#include "common/base/file.h"
#include "common/import/band_sampler.h"
#include "common/import/child_process.h"
#include "common/import/fossa.h"
#include "common/import/mesh_repair.h"
#include "common/import/orient.h"
#include "common/import/tissues.h"
#include "common/import/triangle_tree.h"
#include "common/import/units.h"
#include "common/scene/builder.h"
#include "common/scene/builtin.h"
#include "common/scene/volume_blob.h"

namespace enamel::import {
namespace {

using cutting::Tissue;

constexpr int32_t kFinestVoxel_nm = 10'000, kCoarsestVoxel_nm = 500'000;
constexpr size_t kMaxGridBytes = size_t{3} << 30;
constexpr double kPulpBelowFossa_mm =
    2.9;  // roof of the chamber below the central fossa, assumption
constexpr double kFar_mm = 100;
constexpr double kFinestOfVoxel = 0.2;  // pieces where surfaces cross

Status Invalid(std::string message, std::string field = {}) {
  return Status(Code::kInvalidInput, std::move(message), std::move(field));
}

Triangles Scaled(const Triangles& mesh, double factor) {
  Triangles out = mesh;
  for (dvec3& v : out.vertices) v *= factor;
  return out;
}

scene::PointUm ToUm(const dvec3& p_mm) {
  return {static_cast<int32_t>(std::lround(p_mm.x * 1e3)),
          static_cast<int32_t>(std::lround(p_mm.y * 1e3)),
          static_cast<int32_t>(std::lround(p_mm.z * 1e3))};
}

std::string PlainName(const std::string& text) {
  std::string out;
  for (unsigned char c : text) {
    if (out.size() == 64) break;
    bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    out += plain                  ? static_cast<char>(c)
           : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a')
                                  : '-';
  }
  return out.empty() ? "tooth" : out;
}

// Printable ASCII of at most 200 characters, so that documents stay valid whatever a file is
// called.
std::string Printable(const std::string& text) {
  std::string out = text.substr(0, 200);
  for (char& c : out) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return out;
}

// Stance, and the mesh turned into the scene's frame, its bounding box around the origin.
struct Placed {
  Solid solid;
  std::optional<dvec3> gum;  // scene frame
  std::string words;         // for the report
};

// "+y of the file, 12 degrees off".
std::string AxisName(const dvec3& up) {
  dvec3 a = glm::abs(up);
  int k = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  std::string name = std::string(up[k] > 0 ? "+" : "-") + "xyz"[k] + " of the file";
  int degrees = static_cast<int>(std::lround(std::acos(std::min(a[k], 1.0)) * 57.29577951308232));
  return degrees == 0 ? name : name + ", " + std::to_string(degrees) + " degrees off";
}

Result<Placed> Place(Solid solid, const std::string& up) {
  Stance stance;
  if (up == "auto") {
    stance = FindStance(solid.mesh);
  } else {
    Result<dvec3> axis = ParseAxis(up);
    if (!axis.ok()) return axis.status();
    stance = StanceWithUp(solid.mesh, *axis);
  }
  dmat3 turn = SceneFromFile(solid.mesh, stance.up);
  for (Triangles* mesh : {&solid.mesh, &solid.boundary}) {
    for (dvec3& v : mesh->vertices) v = turn * v;
  }
  Box box = BoxOf(solid.mesh);
  dvec3 middle = 0.5 * (box.lo + box.hi);
  for (Triangles* mesh : {&solid.mesh, &solid.boundary}) {
    for (dvec3& v : mesh->vertices) v -= middle;
  }
  Placed placed{std::move(solid), std::nullopt, "occlusal direction " + AxisName(stance.up)};
  if (stance.gum) placed.gum = turn * *stance.gum;
  if (up != "auto") {
    placed.words += " (as given)";
  } else {
    const std::string margin = "margin " + Fixed(stance.margin);
    placed.words += stance.certain ? " (found by its hollows, " + margin +
                                         "; if it is wrong, give another with --up)"
                                   : " (a guess, " + margin +
                                         ": look at the tooth, and give the direction with --up, "
                                         "for example --up=-y)";
  }
  return placed;
}

// One surface, tissues by depth. Metres outside, millimetres within.
class DepthField : public scene::BrickField {
 public:
  DepthField(const TriangleTree& boundary, const TriangleTree& whole, const TissueModel& tissues)
      : probe_(boundary, whole), band_(boundary), whole_(whole), tissues_(tissues) {}

  scene::FieldSample At(const dvec3& point_m, double reach_m) override {
    const dvec3 p = point_m * 1e3;
    return Sample(p, probe_.Distance(p, reach_m * 1e3), reach_m);
  }
  void Brick(const dvec3& corner_m, double voxel_m, double reach_m, Samples& out) override {
    const dvec3 corner = corner_m * 1e3;
    const double h = voxel_m * 1e3;
    band_.Distances(corner, h, reach_m * 1e3, distance_);
    SidesOf(
        corner, h, distance_, [&](const dvec3& p) { return whole_.Inside(p); }, inside_);
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const auto k = static_cast<size_t>(i);
      const double d = static_cast<double>(distance_[k]);
      out[k] = Sample(corner + h * dvec3(i % 8, i / 8 % 8, i / 64), inside_[k] ? -d : d, reach_m);
    }
  }

 private:
  scene::FieldSample Sample(const dvec3& p, double distance, double reach_m) const {
    const double d_m = distance * 1e-3;
    if (d_m >= reach_m) return {d_m, Tissue::kAir, 0};
    const TissueModel::Sample t = tissues_.At(p);
    return {d_m, t.tissue, t.margin_mm * 1e-3};
  }

  SignedProbe probe_;
  BandSampler band_;
  const TriangleTree& whole_;
  const TissueModel& tissues_;
  BandSampler::Samples distance_;
  std::array<bool, cutting::kBrickVoxels> inside_;
};

cutting::Volume Fill(const TriangleTree& whole, const TriangleTree& boundary,
                     const TissueModel& tissues, const cutting::GridSpec& spec,
                     const ImportOptions& options) {
  const int threads = options.threads > 0 ? options.threads : scene::BuildThreads();
  return scene::BuildVolume(
      spec, [&] { return std::make_unique<DepthField>(boundary, whole, tissues); }, threads,
      options.progress);
}

std::vector<Tissue> TissuesIn(const std::array<double, cutting::kTissueCount>& volumes) {
  std::vector<Tissue> present;
  for (size_t t = 1; t < cutting::kTissueCount; ++t) {
    if (volumes[t] > 0) present.push_back(static_cast<Tissue>(t));
  }
  return present;
}

void ReportVolume(const std::array<double, cutting::kTissueCount>& volumes, ImportedScene& out) {
  double sum = 0;
  std::string tissues;
  for (size_t t = 1; t < cutting::kTissueCount; ++t) {
    sum += volumes[t] * 1e9;
    if (volumes[t] > 0) {
      tissues += (tissues.empty() ? "" : ", ") + std::string(cutting::kTissueNames[t]) + " " +
                 Fixed(volumes[t] * 1e9, 1);
    }
  }
  out.report.push_back("volume " + Fixed(sum, 1) + " mm3 in voxels, " +
                       Fixed(out.mesh_volume_mm3, 1) + " mm3 by the mesh; " + tissues + " mm3");
}

Status CheckOptions(const ImportOptions& options) {
  if (options.voxel_nm >= kFinestVoxel_nm && options.voxel_nm <= kCoarsestVoxel_nm)
    return Status::Ok();
  return Invalid(
      "expected a voxel from 10000 to 500000 nm, found " + std::to_string(options.voxel_nm),
      "voxel_nm");
}

ImportedScene Describe(const Placed& placed, const Fossa& fossa, const Box& box,
                       const TissueModel& tissues) {
  ImportedScene out;
  dvec3 size = box.hi - box.lo;
  out.mesh_volume_mm3 = SignedVolume(placed.solid.mesh);
  out.report = import::Describe(placed.solid.report);
  out.report.push_back("size " + Fixed(size.x) + " x " + Fixed(size.y) + " x " + Fixed(size.z) +
                       " mm");
  out.report.push_back(placed.words);
  out.report.push_back(
      "the longer side lies along x; what is mesial and buccal is not known from a mesh");
  out.report.push_back(std::string("occlusal centre: ") + Words(fossa.kind));
  out.report.push_back("tissues assumed by depth from the surface: enamel up to " +
                       Fixed(tissues.enamel_max_mm(), 1) +
                       " mm, none at the gum; pulp low in the middle");
  return out;
}

}  // namespace

Result<ImportedScene> ImportTriangles(const Triangles& mesh, const std::string& source,
                                      const ImportOptions& options) {
  ENAMEL_RETURN_IF_ERROR(CheckOptions(options));
  Result<double> unit = UnitInMm(options.unit);
  if (!unit.ok()) return unit.status();
  if (mesh.indices.empty()) return Invalid("the mesh holds no triangles");
  Triangles mesh_mm = Scaled(mesh, *unit);
  ENAMEL_RETURN_IF_ERROR(CheckSize(mesh_mm, options.unit, *unit));
  RepairOptions repair;
  repair.finest_mm = kFinestOfVoxel * options.voxel_nm * 1e-6;
  Result<Solid> solid = MakeSolid(mesh_mm, repair);
  if (!solid.ok()) return solid.status();
  Result<Placed> placed = Place(std::move(*solid), options.up);
  if (!placed.ok()) return placed.status();
  const Box box = BoxOf(placed->solid.mesh);
  auto spec = scene::GridAround(box.lo * 1e-3, box.hi * 1e-3, options.voxel_nm);
  ENAMEL_RETURN_IF_ERROR(cutting::ValidateGrid(spec, kMaxGridBytes));
  const TriangleTree boundary(placed->solid.boundary), whole(placed->solid.mesh);
  SignedProbe probe(boundary, whole);
  const Fossa fossa = FindFossa(
      boundary, [&](const dvec3& p) { return probe.Distance(p, kFar_mm); }, box.lo, box.hi);
  const TissueModel tissues(placed->solid.boundary, placed->gum ? &*placed->gum : nullptr, box.lo,
                            box.hi, fossa.point.z - kPulpBelowFossa_mm);
  ImportedScene out = Describe(*placed, fossa, box, tissues);
  out.volume = Fill(whole, boundary, tissues, spec, options);
  auto volumes = cutting::SolidVolume_m3(out.volume);
  ReportVolume(volumes, out);
  out.scene.name = PlainName(options.name.empty() ? "imported" : options.name);
  out.scene.title = options.name.empty() ? "Imported tooth" : Printable(options.name);
  out.scene.voxel_nm = options.voxel_nm;
  out.scene.tissues = scene::DefaultTissues(TissuesIn(volumes));
  out.scene.landmarks["occlusal_centre"] = ToUm(fossa.point);
  out.scene.provenance = source + "; tissues by depth from the surface are an assumption";
  out.scene.volume = HashSha256(scene::EncodeVolume(out.volume));
  return out;
}

Result<ImportedScene> ImportTooth(const std::filesystem::path& file, const ImportOptions& options) {
  ENAMEL_RETURN_IF_ERROR(CheckOptions(options));
  Result<NamedMesh> mesh = ReadMeshInChild(file, options.child);
  if (!mesh.ok()) return mesh.status();
  Result<Bytes> bytes = ReadFile(file, kMaxMeshFile);
  if (!bytes.ok()) return bytes.status();
  ImportOptions named = options;
  if (named.name.empty()) named.name = file.stem().string();
  std::string source = "imported from " + Printable(file.filename().string()) + " (SHA-256 " +
                       HashSha256(*bytes).Hex() + "), unit " + options.unit;
  Result<ImportedScene> out = ImportTriangles(mesh->mesh, source, named);
  if (out.ok()) return out;
  const Status& why = out.status();
  return Status(why.code(), file.filename().string() + ": " + why.message(), why.field());
}

}  // namespace enamel::import
