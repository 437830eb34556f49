#include "common/import/import_tooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>

#include "common/base/file.h"
#include "common/import/child_process.h"
#include "common/import/mesh_repair.h"
#include "common/import/orient.h"
#include "common/import/tissues.h"
#include "common/import/triangle_tree.h"
#include "common/scene/builder.h"
#include "common/scene/builtin.h"
#include "common/scene/volume_blob.h"

namespace enamel::import {
namespace {

using cutting::Tissue;

constexpr double kSmallest_mm = 3, kLargest_mm = 40;
constexpr int32_t kFinestVoxel_nm = 10'000, kCoarsestVoxel_nm = 500'000;
constexpr size_t kMaxGridBytes = size_t{3} << 30;
constexpr double kPulpBelowFossa_mm =
    2.9;                               // roof of the chamber below the central fossa, assumption
constexpr double kFossaSearch = 0.25;  // half a side of the searched square, of the smaller width
constexpr int kFossaSteps = 20;

struct Unit {
  const char* name;
  double mm;
};
constexpr std::array<Unit, 5> kUnits = {
    {{"mm", 1}, {"um", 1e-3}, {"cm", 10}, {"m", 1000}, {"inch", 25.4}}};

Status Invalid(std::string message, std::string field = {}) {
  return Status(Code::kInvalidInput, std::move(message), std::move(field));
}

std::string Fixed(double value, int digits = 2) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

Result<double> UnitInMm(const std::string& name) {
  for (const Unit& u : kUnits) {
    if (name == u.name) return u.mm;
  }
  return Invalid("expected the unit mm, um, cm, m or inch, found '" + name + "'", "unit");
}

struct Box {
  dvec3 lo{std::numeric_limits<double>::max()}, hi{std::numeric_limits<double>::lowest()};
};

Box BoxOf(const Triangles& mesh) {
  Box box;
  for (const auto& t : mesh.indices) {
    for (uint32_t i : t)
      box.lo = glm::min(box.lo, mesh.vertices[i]), box.hi = glm::max(box.hi, mesh.vertices[i]);
  }
  return box;
}

bool IsToothSize(double extent_mm) { return extent_mm >= kSmallest_mm && extent_mm <= kLargest_mm; }

Status CheckSize(const Triangles& mesh_mm, const std::string& unit, double unit_mm) {
  Box box = BoxOf(mesh_mm);
  dvec3 size = box.hi - box.lo;
  double extent = std::max({size.x, size.y, size.z});
  if (IsToothSize(extent)) return Status::Ok();
  std::string fits;
  for (const Unit& u : kUnits) {
    if (IsToothSize(extent / unit_mm * u.mm))
      fits += (fits.empty() ? "" : " or ") + std::string(u.name);
  }
  return Invalid(
      "expected a tooth of 3 to 40 mm, found one of " + Fixed(extent, extent < 1 ? 4 : 2) +
          " mm with the unit '" + unit + "': " +
          (fits.empty() ? "no known unit makes it a tooth" : "its numbers look like " + fits),
      "unit");
}

Triangles Scaled(const Triangles& mesh, double factor) {
  Triangles out = mesh;
  for (dvec3& v : out.vertices) v *= factor;
  return out;
}

// The occlusal surface seen from above.
class TopView {
 public:
  TopView(const TriangleTree& tree, const Box& box) : tree_(tree), box_(box) {}
  // Height of the first surface under (x, y), mm; nothing where there is none.
  std::optional<double> Height(double x, double y) const {
    double z = box_.hi.z + 0.1;
    for (int i = 0; i < 300 && z > box_.lo.z; ++i) {
      double d = tree_.Distance({x, y, z}, 100);
      if (d < 1e-4) return z;
      z -= d;
    }
    return std::nullopt;
  }

 private:
  const TriangleTree& tree_;
  Box box_;
};

struct Fossa {
  dvec3 point;
  bool is_pit;
};

// The pit of the occlusal surface nearest its middle, or its middle where there is no pit.
Fossa FindFossa(const TriangleTree& tree, const Box& box) {
  const TopView top(tree, box);
  const dvec3 middle = 0.5 * (box.lo + box.hi), size = box.hi - box.lo;
  const double step = kFossaSearch * std::min(size.x, size.y) / kFossaSteps;
  constexpr int kSide = 2 * kFossaSteps + 1;
  std::array<double, kSide * kSide> height;
  auto at = [&](int i, int j) -> double& { return height[static_cast<size_t>(j * kSide + i)]; };
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      at(i, j) =
          top.Height(middle.x + (i - kFossaSteps) * step, middle.y + (j - kFossaSteps) * step)
              .value_or(box.hi.z);
    }
  int nearest = kSide * kSide;
  Fossa best{dvec3(middle.x, middle.y, at(kFossaSteps, kFossaSteps)), false};
  for (int j = 2; j < kSide - 2; ++j)
    for (int i = 2; i < kSide - 2; ++i) {
      bool pit = true;
      for (int k = 0; k < 25 && pit; ++k) pit = at(i + k % 5 - 2, j + k / 5 - 2) >= at(i, j);
      const int away =
          (i - kFossaSteps) * (i - kFossaSteps) + (j - kFossaSteps) * (j - kFossaSteps);
      if (!pit || away >= nearest) continue;
      nearest = away;
      best = {
          dvec3(middle.x + (i - kFossaSteps) * step, middle.y + (j - kFossaSteps) * step, at(i, j)),
          true};
    }
  return best;
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
  } else if (stance.certain) {
    placed.words +=
        " (found: a smooth gum side faces the other way; give the direction if it is wrong)";
  } else {
    placed.words += " (a guess, no smooth gum side stands out: give the direction if it is wrong)";
  }
  return placed;
}

cutting::Volume Fill(const Placed& placed, const TriangleTree& boundary, const TissueModel& tissues,
                     const cutting::GridSpec& spec, const ImportOptions& options) {
  const TriangleTree whole(placed.solid.mesh);
  auto make_field = [&]() -> scene::ReachField {
    auto probe = std::make_shared<SignedProbe>(boundary, whole);
    return [probe, &tissues](const dvec3& p_m, double reach_m) {
      const dvec3 p = p_m * 1e3;
      double d_m = probe->Distance(p, reach_m * 1e3) * 1e-3;
      if (d_m >= reach_m) return scene::FieldSample{d_m, Tissue::kAir, 0};
      TissueModel::Sample t = tissues.At(p);
      return scene::FieldSample{d_m, t.tissue, t.margin_mm * 1e-3};
    };
  };
  int threads = options.threads > 0 ? options.threads : scene::BuildThreads();
  return scene::BuildVolume(spec, std::function<scene::ReachField()>(make_field), threads,
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
  out.report.push_back(
      fossa.is_pit ? "occlusal centre: bottom of the pit nearest the middle"
                   : "occlusal centre: middle of the occlusal surface, there is no pit near it");
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
  Result<Solid> solid = MakeSolid(mesh_mm);
  if (!solid.ok()) return solid.status();
  Result<Placed> placed = Place(std::move(*solid), options.up);
  if (!placed.ok()) return placed.status();
  const Box box = BoxOf(placed->solid.mesh);
  auto spec = scene::GridAround(box.lo * 1e-3, box.hi * 1e-3, options.voxel_nm);
  ENAMEL_RETURN_IF_ERROR(cutting::ValidateGrid(spec, kMaxGridBytes));
  const TriangleTree boundary(placed->solid.boundary);
  const Fossa fossa = FindFossa(boundary, box);
  const TissueModel tissues(placed->solid.boundary, placed->gum ? &*placed->gum : nullptr, box.lo,
                            box.hi, fossa.point.z - kPulpBelowFossa_mm);
  ImportedScene out = Describe(*placed, fossa, box, tissues);
  out.volume = Fill(*placed, boundary, tissues, spec, options);
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
  Result<Triangles> mesh = ReadMeshInChild(file, options.child);
  if (!mesh.ok()) return mesh.status();
  Result<Bytes> bytes = ReadFile(file, kMaxMeshFile);
  if (!bytes.ok()) return bytes.status();
  ImportOptions named = options;
  if (named.name.empty()) named.name = file.stem().string();
  std::string source = "imported from " + Printable(file.filename().string()) + " (SHA-256 " +
                       HashSha256(*bytes).Hex() + "), unit " + options.unit;
  Result<ImportedScene> out = ImportTriangles(*mesh, source, named);
  if (out.ok()) return out;
  const Status& why = out.status();
  return Status(why.code(), file.filename().string() + ": " + why.message(), why.field());
}

}  // namespace enamel::import
