#include "common/import/import_tooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/cutting/voxel_limit.h"
#include "common/import/band_sampler.h"
#include "common/import/fossa.h"
#include "common/import/printable.h"
#include "common/import/sources.h"
#include "common/import/thin_walls.h"
#include "common/import/tissues.h"
#include "common/mesh/mesh_repair.h"
#include "common/mesh/triangle_tree.h"
#include "common/mesh/units.h"
#include "common/scene/builder.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/tooth_number.h"
#include "common/scene/volume_blob.h"

namespace enamel::import {
namespace {

using cutting::Tissue;

constexpr int32_t kFinestVoxel_nm = 10'000, kCoarsestVoxel_nm = 500'000;
// For a grid with every brick stored; a tooth stores only those at its surface or between tissues.
constexpr size_t kMaxGridBytes = size_t{3} << 30;
// Farther than any point of a tooth is from its surface (units.h: 40 mm at most).
constexpr double kFar_mm = 100;
constexpr double kWidestBridge_mm = 0.5;
// A fifth of a voxel: crossings left uncut at this size are finer than the voxels show.
constexpr double kFinestOfVoxel = 0.2;  // pieces where surfaces cross

Status Invalid(std::string message, std::string field = {}) {
  return Status(Code::kInvalidInput, std::move(message), std::move(field));
}

void Append(const mesh::Triangles& from, mesh::Triangles& to) {
  const auto shift = static_cast<uint32_t>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), from.vertices.begin(), from.vertices.end());
  for (const auto& t : from.indices)
    to.indices.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
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

// One surface, tissues by depth. Metres outside, millimetres within.
class DepthField : public scene::BrickField {
 public:
  DepthField(const mesh::TriangleTree& boundary, const mesh::TriangleTree& whole,
             const TissueModel& tissues)
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
    // Beyond the band nobody asks for a tissue.
    if (d_m >= reach_m) return {d_m, Tissue::kAir, 0};
    const TissueModel::Sample t = tissues_.At(p);
    return {d_m, t.tissue, t.margin_mm * 1e-3};
  }

  mesh::SignedProbe probe_;
  BandSampler band_;
  const mesh::TriangleTree& whole_;
  const TissueModel& tissues_;
  BandSampler::Samples distance_;
  std::array<bool, cutting::kBrickVoxels> inside_;
};

std::vector<Tissue> TissuesIn(const std::array<double, cutting::kTissueCount>& volumes) {
  std::vector<Tissue> present;
  for (size_t t = 1; t < cutting::kTissueCount; ++t) {
    if (volumes[t] > 0) present.push_back(static_cast<Tissue>(t));
  }
  return present;
}

std::string Words(const std::array<double, cutting::kTissueCount>& volumes) {
  double sum = 0;
  std::string tissues;
  for (size_t t = 1; t < cutting::kTissueCount; ++t) {
    sum += volumes[t] * 1e9;
    if (volumes[t] > 0) {
      tissues += (tissues.empty() ? "" : ", ") + std::string(cutting::kTissueNames[t]) + " " +
                 mesh::Fixed(volumes[t] * 1e9, 1);
    }
  }
  return "volume " + mesh::Fixed(sum, 1) + " mm3 in voxels: " + tissues + " mm3";
}

Status CheckOptions(const ImportOptions& options) {
  if (!scene::IsToothNumber(options.tooth)) {
    return Invalid("expected the tooth's FDI number (ISO 3950), 11 to 48 or 51 to 85, found " +
                       (options.tooth == 0 ? "none" : std::to_string(options.tooth)),
                   "tooth");
  }
  if (options.voxel_nm < kFinestVoxel_nm || options.voxel_nm > kCoarsestVoxel_nm) {
    return Invalid(
        "expected a voxel from 10000 to 500000 nm, found " + std::to_string(options.voxel_nm),
        "voxel_nm");
  }
  if (!(options.bridge_mm >= 0 && options.bridge_mm <= kWidestBridge_mm)) {
    return Invalid(
        "expected gaps of 0 to 0.5 mm to bridge, found " + mesh::Fixed(options.bridge_mm),
        "bridge_um");
  }
  ENAMEL_RETURN_IF_ERROR(CheckFacing({options.tooth, options.up, options.buccal}));
  return mesh::CheckScale(options.scale);
}

double FinestPiece_mm(const ImportOptions& options) {
  return kFinestOfVoxel * options.voxel_nm * 1e-6;
}

// A scan of a jaw, or two teeth in one file, would be cut as one tooth. Crumbs beside the tooth are
// none, and neither are parts that cross, whose boxes overlap.
Status CheckOneBody(const mesh::Solid& solid) {
  constexpr double kCrumb = 0.05;  // of the largest, by area
  const mesh::Triangles& mesh = solid.mesh;
  std::vector<uint32_t> first(mesh.vertices.size());
  std::iota(first.begin(), first.end(), 0u);
  auto root = [&](uint32_t v) {
    while (first[v] != v) v = first[v] = first[first[v]];
    return v;
  };
  for (const auto& t : mesh.indices) {
    first[root(t[1])] = root(t[0]);
    first[root(t[2])] = root(t[0]);
  }
  struct Body {
    double area_mm2 = 0;
    mesh::Box box{dvec3(1e300), dvec3(-1e300)};
  };
  std::map<uint32_t, Body> all;
  double largest = 0;
  for (const auto& t : mesh.indices) {
    const dvec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    Body& body = all[root(t[0])];
    body.area_mm2 += glm::length(glm::cross(b - a, c - a)) / 2;
    body.box.lo = glm::min(body.box.lo, glm::min(a, glm::min(b, c)));
    body.box.hi = glm::max(body.box.hi, glm::max(a, glm::max(b, c)));
    largest = std::max(largest, body.area_mm2);
  }
  const bool parts_cross = solid.report.crossing + solid.report.buried > 0;
  std::vector<Body> apart;
  for (const auto& entry : all) {
    const Body& body = entry.second;
    const bool joins =
        parts_cross && std::ranges::any_of(apart, [&](const Body& other) {
          return body.box.lo.x <= other.box.hi.x && other.box.lo.x <= body.box.hi.x &&
                 body.box.lo.y <= other.box.hi.y && other.box.lo.y <= body.box.hi.y &&
                 body.box.lo.z <= other.box.hi.z && other.box.lo.z <= body.box.hi.z;
        });
    if (body.area_mm2 > kCrumb * largest && !joins) apart.push_back(body);
  }
  if (apart.size() <= 1) return Status::Ok();
  return Invalid(
      "expected one tooth, found " + std::to_string(apart.size()) +
      " bodies apart from each other: cut one out on the server's page, export the tooth alone, or "
      "join its parts");
}

void Enter(const ImportOptions& options, std::string_view phase) {
  if (options.phase) options.phase(phase);
}

void WarnOfThinWalls(const mesh::TriangleTree& surface,
                     const std::function<bool(const dvec3&)>& inside, const ImportOptions& options,
                     ImportedScene& out) {
  const double limit_mm = cutting::kThinnestWall_voxels * options.voxel_nm * 1e-6;
  if (const auto thin = FindThinWalls(surface, inside, limit_mm))
    out.report.push_back(Words(*thin, options.voxel_nm));
}

using MakeField = std::function<std::unique_ptr<scene::BrickField>()>;

// The grid, filled; refused before that where it would be too large.
Status Fill(const mesh::Box& box, const MakeField& field, const ImportOptions& options,
            ImportedScene& out) {
  const auto spec = scene::GridAround(box.lo * 1e-3, box.hi * 1e-3, options.voxel_nm);
  ENAMEL_RETURN_IF_ERROR(cutting::ValidateGrid(spec, kMaxGridBytes));
  Enter(options, "filling");
  const int threads = options.threads > 0 ? options.threads : scene::BuildThreads();
  out.volume = scene::BuildVolume(spec, field, threads, options.progress);
  return Status::Ok();
}

void ReportPlace(const mesh::Box& box, Placement placement, const Fossa& fossa,
                 ImportedScene& out) {
  out.size_mm = box.size();
  out.placement = std::move(placement);
  out.report.push_back(std::string("occlusal centre: ") + Words(fossa.kind));
}

// The scene's document around the filled volume.
void Finish(const Fossa& fossa, const std::string& source, const ImportOptions& options,
            ImportedScene& out) {
  Enter(options, "storing");
  const auto volumes = cutting::SolidVolume_m3(out.volume);
  out.report.push_back(Words(volumes));
  if (out.mesh_volume_mm3 > 0)
    out.report.push_back("volume " + mesh::Fixed(out.mesh_volume_mm3, 1) + " mm3 by the mesh");
  out.scene.name = PlainName(options.name.empty() ? "imported" : options.name);
  out.scene.title = options.name.empty() ? "Imported tooth" : Printable(options.name);
  out.scene.tooth = options.tooth;
  out.scene.voxel_nm = options.voxel_nm;
  out.scene.tissues = scene::DefaultTissues(TissuesIn(volumes));
  out.scene.landmarks["occlusal_centre"] = ToUm(fossa.point);
  out.scene.provenance = source;
  // The address of what is stored, so of the encoded bytes and not of the samples.
  out.scene.volume = HashSha256(scene::EncodeVolume(out.volume));
}

}  // namespace

Result<ImportedScene> ImportTriangles(const mesh::Triangles& mesh, const std::string& source,
                                      const ImportOptions& options) {
  ENAMEL_RETURN_IF_ERROR(CheckOptions(options));
  if (mesh.indices.empty()) return Invalid("the mesh holds no triangles");
  Enter(options, "repairing");
  CutCrowns crowns;
  if (options.around.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(crowns.tooth, mesh::InMm(mesh, options.scale));
  } else {
    ENAMEL_ASSIGN_OR_RETURN(crowns, CutOut(mesh, options.scale, options.around));
  }
  mesh::RepairOptions repair;
  repair.finest_mm = FinestPiece_mm(options);
  ENAMEL_ASSIGN_OR_RETURN(mesh::Solid solid, mesh::MakeSolid(crowns.tooth, repair));
  ENAMEL_RETURN_IF_ERROR(CheckOneBody(solid));
  Enter(options, "placing");
  ENAMEL_ASSIGN_OR_RETURN(PlacedSolid placed,
                          Place(std::move(solid), {options.tooth, options.up, options.buccal}));
  NeighbourTeeth neighbours;
  for (const mesh::Triangles& crown : crowns.neighbours) {
    auto made = NeighbourTooth::Make(crown, placed);
    if (!made.ok()) return Invalid("the neighbour: " + made.status().message(), "around");
    neighbours.push_back(*std::move(made));
  }
  const mesh::Box box = mesh::BoxOf(placed.solid.mesh);
  const mesh::TriangleTree boundary(placed.solid.boundary), whole(placed.solid.mesh);
  mesh::SignedProbe probe(boundary, whole);
  const Fossa fossa = FindFossa(
      boundary, [&](const dvec3& p) { return probe.Distance(p, kFar_mm); }, box.lo, box.hi);
  Enter(options, "tissues");
  const TissueModel tissues(placed.solid, placed.gum ? &*placed.gum : nullptr, box.lo, box.hi,
                            fossa.point.z, options.tooth);
  ImportedScene out;
  out.mesh_volume_mm3 = mesh::SignedVolume(placed.solid.mesh);
  out.report = Describe(placed.solid.report);
  ReportPlace(box, std::move(placed.placement), fossa, out);
  out.report.push_back("tissues assumed by depth from the surface: enamel up to " +
                       mesh::Fixed(tissues.enamel_max_mm(), 1) +
                       " mm, none at the gum; the pulp's size by the crown's");
  if (!options.around.empty())
    out.report.push_back("cut out of a scan of several teeth, with " +
                         Counted(neighbours.size(), "neighbour"));
  WarnOfThinWalls(
      boundary, [&](const dvec3& p) { return whole.Inside(p); }, options, out);
  const mesh::Box kept = BoxWith(box, neighbours);
  ENAMEL_RETURN_IF_ERROR(Fill(
      kept,
      [&] {
        return FieldWith(std::make_unique<DepthField>(boundary, whole, tissues), neighbours, kept);
      },
      options, out));
  Finish(fossa, source + "; tissues by depth from the surface are an assumption", options, out);
  if (cutting::SolidVolume_m3(out.volume)[static_cast<size_t>(Tissue::kPulp)] <= 0)
    out.report.push_back("no pulp has room in this crown: no cut can expose one");
  return out;
}

Result<ImportedScene> ImportLayers(
    const std::array<std::optional<mesh::Triangles>, kLayers>& surfaces, const std::string& source,
    const ImportOptions& options) {
  ENAMEL_RETURN_IF_ERROR(CheckOptions(options));
  auto surfaces_mm = surfaces;
  mesh::Triangles all;
  for (const auto& surface : surfaces) {
    if (surface) Append(*surface, all);
  }
  if (!all.indices.empty()) {
    ENAMEL_RETURN_IF_ERROR(mesh::CheckSize(all, options.scale));
    const double scale_mm = *mesh::ScaleInMm(all, options.scale);
    for (auto& surface : surfaces_mm) {
      if (!surface) continue;
      for (dvec3& v : surface->vertices) v *= scale_mm;
    }
  }
  const LayerOptions layer_options{options.bridge_mm, FinestPiece_mm(options)};
  Enter(options, "repairing");
  ENAMEL_ASSIGN_OR_RETURN(LayerSolids solids, RepairLayers(surfaces_mm, layer_options));
  Enter(options, "placing");
  ENAMEL_ASSIGN_OR_RETURN(PlacedLayers placed,
                          Place(std::move(solids), {options.tooth, options.up, options.buccal}));
  Enter(options, "tissues");
  ENAMEL_ASSIGN_OR_RETURN(LayeredTooth tooth,
                          LayeredTooth::Make(std::move(placed.layers), layer_options));
  mesh::Box box{dvec3(1e300), dvec3(-1e300)}, crown = box;
  std::string alone;
  // Downwards, so that the last crown kept is the enamel's.
  for (size_t i = kLayers; i-- > 0;) {
    if (tooth.surface(i) == nullptr) continue;
    const mesh::Triangles& mesh = tooth.surface(i)->solid.mesh;
    crown = mesh::BoxOf(mesh);  // the enamel's where there is one
    box.lo = glm::min(box.lo, crown.lo), box.hi = glm::max(box.hi, crown.hi);
    alone = std::string(cutting::TissueName(kLayerTissues[i])) + " " +
            mesh::Fixed(mesh::SignedVolume(mesh), 1) + (alone.empty() ? "" : ", ") + alone;
  }
  LayerProbe probe(tooth);
  const Fossa fossa = FindFossa(
      tooth.boundary(), [&](const dvec3& p) { return probe.Distance(p, kFar_mm); }, crown.lo,
      crown.hi);
  ImportedScene out;
  out.report = tooth.report();
  ReportPlace(box, std::move(placed.placement), fossa, out);
  out.report.push_back("volume of each surface alone: " + alone + " mm3");
  WarnOfThinWalls(
      tooth.boundary(), [&](const dvec3& p) { return probe.Distance(p, kFar_mm) < 0; }, options,
      out);
  ENAMEL_RETURN_IF_ERROR(Fill(
      box, [&] { return MakeLayerField(tooth); }, options, out));
  Finish(fossa, source + "; one surface per tissue", options, out);
  return out;
}

Result<ImportedScene> ImportTooth(const ImportSources& sources, const ImportOptions& options) {
  ENAMEL_RETURN_IF_ERROR(CheckOptions(options));
  Enter(options, "reading");
  ENAMEL_ASSIGN_OR_RETURN(ReadSources read, Read(sources, options.child));
  ImportOptions named = options;
  if (named.name.empty()) named.name = read.name;
  const std::string source = "imported from " + read.provenance + ", " + mesh::Words(options.scale);
  if (!read.whole && !options.around.empty()) {
    return Invalid("expected one surface to cut a tooth out of, found one surface per tissue",
                   "around");
  }
  Result<ImportedScene> out = read.whole ? ImportTriangles(*read.whole, source, named)
                                         : ImportLayers(read.surfaces, source, named);
  if (!out.ok()) {
    const Status& why = out.status();
    return Status(why.code(), Printable(read.name) + ": " + why.message(), why.field());
  }
  out->report.insert(out->report.begin(), read.report.begin(), read.report.end());
  return out;
}

}  // namespace enamel::import
